//! From start to stop.

use super::exchange;
use super::{Master, Terminal};
use crate::simulate::{NEGLIGIBLE, whole_steps};
use crate::{Error, LogLine};

/// In which order participants step and values travel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Algorithm {
    /// All at once, from the values at the communication point; the order of the members does not
    /// matter.
    #[default]
    Jacobi,
    /// One after the other in the order of the members, each from the newest values.
    GaussSeidel,
}

/// What to run.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Start [s].
    pub start_time: f64,
    /// Stop [s], after the start.
    pub stop_time: f64,
    /// Communication step [s], and from row to row of the record.
    pub step: f64,
    /// In which order.
    pub algorithm: Algorithm,
    /// How far steps may put exchanged values off within a second, in multiples of their nominal
    /// sizes: steps are then cut as far as that needs. Every participant must be able to go back to
    /// a state.
    pub tolerance: Option<f64>,
    /// Whether initial values travel before the first step; else that is made with the inputs'
    /// own start values, as some tools do.
    pub initial_exchange: bool,
    /// What to record.
    pub record: Vec<Terminal>,
}

/// How a run ended.
#[derive(Debug)]
pub enum End {
    /// At the stop; before it, at the last whole step, where a participant takes steps of one length
    /// only.
    Complete,
    /// [`super::Watch::stop`] was called.
    Stopped,
    /// A participant ended before the stop.
    Early {
        /// Its name.
        member: String,
        /// When, where it can tell [s]; else the last communication point.
        time: f64,
        /// What it said.
        log: Vec<LogLine>,
    },
    /// A participant failed.
    Failed(Error),
}

/// What a run left.
#[derive(Debug)]
pub struct Run {
    /// `time`, then what was recorded, as `participant.variable`.
    pub names: Vec<String>,
    /// For each name its values, all of one length; whatever the end, all that was reached.
    pub columns: Vec<Vec<f64>>,
    /// How it ended.
    pub end: End,
    /// Communication steps made.
    pub steps: u64,
    /// Of these, steps that were taken back because their error was too large.
    pub taken_back: u64,
    /// Steps accepted though their error was too large: they could not be cut further.
    pub forced: u64,
    /// Whether initial values settled; around a loop they need not.
    pub settled: bool,
}

/// Passes of the initial exchange; without a loop values settle within one for each member.
const MOST_PASSES: usize = 50;

/// Communication points of a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Points {
    start: f64,
    stop: f64,
    step: f64,
    /// Steps of full length.
    whole: u64,
    /// Steps in all.
    pub count: u64,
}

impl Points {
    /// The `n`th point [s], n no more than the count.
    pub fn at(&self, n: u64) -> f64 {
        // the last whole step ends at the stop, whatever the rounding, or a shorter one follows
        if n >= self.count && self.whole < self.count || n == self.whole && self.ends_at_stop() {
            self.stop
        } else {
            self.start + n as f64 * self.step
        }
    }

    fn ends_at_stop(&self) -> bool {
        let end = self.start + self.whole as f64 * self.step;
        (self.stop - end).abs() <= NEGLIGIBLE * self.step
    }
}

/// What a run keeps account of.
pub(super) struct Account {
    /// What was published last.
    pub board: Vec<f64>,
    /// What is recorded: of each member what it published when it had arrived.
    pub shown: Vec<f64>,
    pub slots: Vec<usize>,
    pub steps: u64,
    pub taken_back: u64,
    pub forced: u64,
}

impl Master<'_> {
    /// Runs as planned, from the start values of the participants. A plan that cannot be carried
    /// out is an error; a participant that ends or fails ends the run.
    pub fn run(&mut self, plan: &Plan) -> Result<Run, Error> {
        let whole = whole_steps(plan.start_time, plan.stop_time, plan.step)?;
        let every = self.every(plan)?;
        if let Some(tolerance) = plan.tolerance {
            self.check_tolerance(plan, tolerance)?;
        }
        let mut points = Points {
            start: plan.start_time,
            stop: plan.stop_time,
            step: plan.step,
            whole,
            count: whole,
        };
        let can_vary = |seat: &exchange::Seat| seat.participant.can_vary_step();
        if !points.ends_at_stop() && self.seats.iter().all(can_vary) {
            points.count += 1;
        }
        let (slots, count) = exchange::lay_out(&mut self.seats, &plan.record)?;
        let mut account = Account {
            board: vec![0.0; count],
            shown: vec![0.0; count],
            slots,
            steps: 0,
            taken_back: 0,
            forced: 0,
        };
        self.watch.take_rows();
        self.watch.is_running(true);
        let (end, settled) = match self.initialize(plan, &mut account) {
            Ok(settled) => {
                let end = match plan.tolerance {
                    Some(tolerance) => self.go_within(plan, points, tolerance, &mut account),
                    None => self.go(plan, points, &every, &mut account),
                };
                (end, settled)
            }
            Err(error) => (Err(error), false),
        };
        let mut end = end.unwrap_or_else(End::Failed);
        let terminated = self.terminate(plan.stop_time, &end);
        if matches!(end, End::Complete | End::Stopped)
            && let Err(error) = terminated
        {
            end = End::Failed(error);
        }
        self.watch.is_running(false);
        let mut names = vec!["time".to_owned()];
        names.extend(plan.record.iter().map(ToString::to_string));
        let rows = self.watch.take_rows();
        let column = |c| rows.iter().skip(c).step_by(names.len()).copied().collect();
        Ok(Run {
            columns: (0..names.len()).map(column).collect(),
            names,
            end,
            steps: account.steps,
            taken_back: account.taken_back,
            forced: account.forced,
            settled,
        })
    }

    /// How many of the plan's steps one of each member takes.
    fn every(&self, plan: &Plan) -> Result<Vec<u64>, Error> {
        let every = |seat: &exchange::Seat| {
            let Some(own) = seat.step else { return Ok(1) };
            let ratio = own / plan.step;
            let whole = ratio.round();
            if whole >= 1.0 && (ratio - whole).abs() <= NEGLIGIBLE * whole && whole < 1e9 {
                Ok(whole as u64)
            } else {
                Err(Error::OwnStep {
                    member: seat.name.clone(),
                    step: plan.step,
                    found: own,
                })
            }
        };
        self.seats.iter().map(every).collect()
    }

    /// Enters and leaves initialization mode; whether the values exchanged there settled.
    fn initialize(&mut self, plan: &Plan, account: &mut Account) -> Result<bool, Error> {
        let Account {
            board,
            shown,
            slots,
            ..
        } = account;
        let time = plan.start_time;
        for n in 0..self.seats.len() {
            self.call(n, time, |seat| {
                let participant = &mut seat.participant;
                participant.enter_initialization(plan.start_time, plan.stop_time)
            })?;
        }
        let mut settled = true;
        if plan.initial_exchange {
            settled = false;
            for _ in 0..MOST_PASSES {
                for n in 0..self.seats.len() {
                    self.call(n, time, |seat| seat.publish_exchanged(board))?;
                }
                let mut changed = false;
                for n in 0..self.seats.len() {
                    changed |= self.call(n, time, |seat| seat.set_inputs(board))?;
                }
                if !changed {
                    settled = true;
                    break;
                }
            }
        }
        for n in 0..self.seats.len() {
            self.call(n, time, |seat| seat.participant.exit_initialization())?;
        }
        for n in 0..self.seats.len() {
            self.call(n, time, |seat| seat.publish(board))?;
        }
        shown.copy_from_slice(board);
        self.watch.record(time, shown, slots);
        Ok(settled)
    }

    /// Terminates all but the one that ended or failed; the first that refuses is told.
    fn terminate(&mut self, time: f64, end: &End) -> Result<(), Error> {
        let gone = match end {
            End::Early { member, .. } | End::Failed(Error::Member { member, .. }) => Some(member),
            _ => None,
        };
        let mut outcome = Ok(());
        for n in 0..self.seats.len() {
            if gone != Some(&self.seats[n].name) {
                let terminated = self.call(n, time, |seat| seat.participant.terminate());
                outcome = outcome.and(terminated);
            }
        }
        outcome
    }

    /// Calls a seat and says who it was if that fails.
    pub(super) fn call<T>(
        &mut self,
        n: usize,
        time: f64,
        call: impl FnOnce(&mut exchange::Seat) -> Result<T, Error>,
    ) -> Result<T, Error> {
        self.watch.begin(n, time);
        call(&mut self.seats[n]).map_err(|cause| self.failed(n, time, cause))
    }

    #[cold]
    pub(super) fn failed(&self, n: usize, time: f64, cause: Error) -> Error {
        let seat = &self.seats[n];
        let sets =
            matches!(&cause, Error::Refused { function, .. } if function.starts_with("fmi2Set"));
        Error::Member {
            member: seat.name.clone(),
            time,
            doing: if sets {
                format!(" {}", seat.inputs_set())
            } else {
                String::new()
            },
            cause: Box::new(cause),
        }
    }
}
