//! A rider who sees the course ahead and steers the bicycle along it.

use super::design::{Gains, Manner, Sampled, Unridable};
use crate::course::{Course, Place};
use crate::dynamics::Formulation;
use crate::parameters::Parameters;
use crate::real::Real;
use crate::simulate::{Refusal, Simulation, Stop};
use crate::state::{Input, Output, State};
use nalgebra::DVector;
use std::collections::VecDeque;

/// Gains over speed: designs on a grid, straight lines between, the outermost beyond.
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    manner: Manner,
    /// In the order of their speeds, at least one.
    designs: Vec<Gains>,
}

/// Distance between the speeds of a schedule [m/s]; straight lines between designs that far apart
/// are within a few per cent of the design in between, from .5 m/s on. (Below, where a bicycle is
/// hardly ridden, gains may change sign from one design to the next.)
const SPEED_STEP: f64 = 0.1;

impl Schedule {
    /// The gains for `speed` [m/s], whatever the speed turns out to be.
    pub fn at(
        parameters: &Parameters,
        formulation: Formulation,
        manner: Manner,
        speed: f64,
    ) -> Result<Self, Unridable> {
        Self::over(parameters, formulation, manner, speed, speed)
    }

    /// The gains for speeds from `slowest` to `fastest` [m/s].
    pub fn over(
        parameters: &Parameters,
        formulation: Formulation,
        manner: Manner,
        slowest: f64,
        fastest: f64,
    ) -> Result<Self, Unridable> {
        let spaces = ((fastest - slowest) / SPEED_STEP).ceil().max(0.0);
        let design = |n| {
            let speed = slowest + (fastest - slowest) * (n as f64 / spaces.max(1.0));
            Gains::new(parameters, formulation, &manner, speed)
        };
        Ok(Self {
            manner,
            designs: (0..=spaces as usize)
                .map(design)
                .collect::<Result<_, _>>()?,
        })
    }

    /// The designs on either side of `speed` [m/s] and how far it lies from the first to the
    /// second; the same one twice where there is none beyond.
    fn around(&self, speed: f64) -> (&Gains, &Gains, f64) {
        let last = self.designs.len() - 1;
        let above = self.designs.partition_point(|g| g.speed <= speed);
        let (a, b) = (
            &self.designs[above.saturating_sub(1)],
            &self.designs[above.min(last)],
        );
        let part = if a.speed < b.speed {
            (speed - a.speed) / (b.speed - a.speed)
        } else {
            0.0
        };
        (a, b, part)
    }
}

/// A rider following a course. Outside of any stepper: whatever simulates the bicycle asks for the
/// torque with what is seen of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Preview {
    course: Course,
    schedule: Schedule,
    place: Place,
    torque: f64,
    /// Torques decided on that act later [N m], the next one first.
    pending: VecDeque<f64>,
    /// When the rider looks next [s].
    next: f64,
}

impl Preview {
    /// A rider at the start of `course`.
    pub fn new(course: Course, schedule: Schedule) -> Self {
        let Manner {
            reaction_delay,
            sample_time,
            ..
        } = schedule.manner;
        let late = (reaction_delay / sample_time).round() as usize;
        Self {
            course,
            schedule,
            place: Place {
                arc_length: 0.0,
                offset: 0.0,
                heading: 0.0,
            },
            torque: 0.0,
            pending: VecDeque::from(vec![0.0; late]),
            next: f64::NEG_INFINITY,
        }
    }

    /// Steer torque [N m], left positive, to be held until the next call, from what is `seen` of
    /// the bicycle at `time` [s]. Of the outputs the rider uses those called as the states that the
    /// formulation moves, heading, and place with its rate. Asked more often than every
    /// `sample_time`, the rider does not look again, nor ever at what is not finite.
    pub fn torque(&mut self, time: f64, seen: &Output) -> f64 {
        let sample_time = self.schedule.manner.sample_time;
        let too_early = time < self.next - 1e-6 * sample_time;
        if too_early || !seen.to_array().iter().all(|value| value.is_finite()) {
            return self.torque;
        }
        // on the grid of the looks, which starts anew where a call comes late by a whole one
        self.next += sample_time;
        if self.next <= time {
            self.next = time + sample_time;
        }
        self.place = self.course.locate(seen.x, seen.y, self.place.arc_length);
        let (sin, cos) = Real::sin_cos(seen.heading);
        let speed = seen.x_rate * cos + seen.y_rate * sin;
        let (a, b, part) = self.schedule.around(speed);
        let mut wanted = self.demand(a, speed, seen);
        if part > 0.0 {
            wanted += part * (self.demand(b, speed, seen) - wanted);
        }
        let limit = self.schedule.manner.torque_limit;
        self.pending.push_back(wanted.min(limit).max(-limit));
        self.torque = self.pending.pop_front().unwrap_or_default();
        self.torque
    }

    /// The torque that `gains` ask for, to act after those that are on their way.
    fn demand(&self, gains: &Gains, speed: f64, seen: &Output) -> f64 {
        let Place {
            arc_length,
            offset,
            heading,
        } = self.place;
        let ahead = speed * self.schedule.manner.sample_time;
        let curvature = |k: usize| self.course.curvature(arc_length + (k as f64 + 0.5) * ahead);
        let n = gains.state.len() - 2;
        let mut state = DVector::from_fn(n + 2, |i, _| match i {
            i if i < n => seen.get(STATES[i]),
            i if i == n => offset,
            _ => seen.heading - heading,
        });
        let Sampled { problem, course } = &gains.sampled;
        for (k, torque) in self.pending.iter().enumerate() {
            state = &problem.transition * state + &problem.input * *torque + course * curvature(k);
        }
        let late = self.pending.len();
        let previewed: f64 = (gains.preview.iter().enumerate())
            .map(|(k, gain)| gain * curvature(late + k))
            .sum();
        let beyond = gains.beyond * curvature(late + gains.preview.len());
        -(gains.state.dot(&state) + previewed + beyond)
    }

    /// Where the rider last saw the bicycle.
    pub fn place(&self) -> Place {
        self.place
    }

    /// The course being followed.
    pub fn course(&self) -> &Course {
        &self.course
    }
}

/// Where the rows of [`State`] are seen.
const STATES: [usize; State::LEN] = {
    let mut rows = [0; State::LEN];
    let mut i = 0;
    while i < State::LEN {
        rows[i] = Output::index(State::TABLE[i].name).expect("each state is an output");
        i += 1;
    }
    rows
};

/// One look of the rider.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// When [s].
    pub time: f64,
    /// What was seen.
    pub output: Output,
    /// Where that is on the course.
    pub place: Place,
    /// The steer torque from there on [N m], left positive.
    pub torque: f64,
}

/// A course ridden.
#[derive(Debug, Clone, PartialEq)]
pub struct Followed {
    /// Every sample from the start to the end, at least one.
    pub samples: Vec<Sample>,
    /// Why it ended early, if it did; the last sample is then at that time.
    pub stop: Option<Stop>,
}

/// Rides to the end of the rider's course, or until twice the time that it takes at the speed of
/// `input`. The rider's torque takes the place of the rider law of `parameters` and adds to the
/// steer torque of `input`.
pub fn follow(
    parameters: &Parameters,
    formulation: Formulation,
    input: Input,
    mut rider: Preview,
) -> Result<Followed, Refusal> {
    let mut bicycle = Simulation::new(&parameters.riderless(), formulation, input, 0.0)?;
    let sample_time = rider.schedule.manner.sample_time;
    let time = 2.0 * rider.course.length() / input.speed;
    let looks = if input.speed > 0.0 {
        (time / sample_time).ceil() as u64
    } else {
        0
    };
    let mut followed = Followed {
        samples: Vec::new(),
        stop: None,
    };
    for n in 0..=looks {
        let time = n as f64 * sample_time;
        followed.stop = bicycle.advance(time).err();
        let output = bicycle.output();
        let torque = rider.torque(bicycle.time(), &output);
        followed.samples.push(Sample {
            time: bicycle.time(),
            output,
            place: rider
                .course
                .locate(output.x, output.y, rider.place().arc_length),
            torque,
        });
        if followed.stop.is_some() || rider.place().arc_length >= rider.course.length() {
            break;
        }
        bicycle.set_input(Input {
            steer_torque: input.steer_torque + torque,
            ..input
        })?;
    }
    Ok(followed)
}
