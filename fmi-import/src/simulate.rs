//! One FMU from start to end with a fixed communication step.

use crate::{Error, Fmu, Instance, LogLine, Step, Value};
use model_description::{Causality, Initial, ScalarVariable, Variability, VariableType};

/// What to simulate.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Names of variables and the values to set before the start.
    pub start_values: Vec<(String, Value)>,
    /// Names of the variables to record; `String` variables cannot be.
    pub record: Vec<String>,
    /// Start [s].
    pub start_time: f64,
    /// Stop [s], after the start.
    pub stop_time: f64,
    /// Communication step [s], positive; the last one is shortened to end at the stop.
    pub step: f64,
    /// Relative tolerance, if the FMU is to be given one.
    pub tolerance: Option<f64>,
}

/// What was recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    /// `time`, then the recorded variables.
    pub names: Vec<String>,
    /// For each name its values, all of one length.
    pub columns: Vec<Vec<f64>>,
    /// What the FMU said when it ended before the stop time.
    pub ended: Option<Vec<LogLine>>,
}

/// More communication points than a record of them could hold.
const MOST_STEPS: f64 = 1e8;
/// What remains before the stop may be round-off, which is no step; in steps.
pub(crate) const NEGLIGIBLE: f64 = 1e-9;

/// Runs an instance of `fmu` as planned. When the FMU ends early, the last row is at its last
/// successful time. Where it cannot step by less than the plan's step, the last row may be that
/// much before the stop.
pub fn simulate(fmu: &Fmu, plan: &Plan) -> Result<Trajectory, Error> {
    simulate_with(fmu, plan, |_, _| Ok(()))
}

/// As [`simulate()`]; before each step `at` gets the instance, to set inputs or tunable parameters,
/// and the time [s].
pub fn simulate_with(
    fmu: &Fmu,
    plan: &Plan,
    mut at: impl FnMut(&mut Instance, f64) -> Result<(), Error>,
) -> Result<Trajectory, Error> {
    whole_steps(plan.start_time, plan.stop_time, plan.step)?;
    let recorder = Recorder::new(fmu, &plan.record)?;
    let starts = start_values(fmu, &plan.start_values)?;
    let can_vary = fmu
        .description()
        .co_simulation
        .as_ref()
        .is_some_and(|c| c.can_handle_variable_communication_step_size);
    let mut instance = fmu.instantiate(&fmu.description().model_name)?;
    initialize(&mut instance, plan, &starts)?;

    let mut names = vec!["time".to_owned()];
    names.extend(plan.record.iter().cloned());
    let mut trajectory = Trajectory {
        columns: vec![Vec::new(); names.len()],
        names,
        ended: None,
    };
    let mut time = plan.start_time;
    recorder.record(&mut instance, time, &mut trajectory.columns)?;
    let negligible = NEGLIGIBLE * plan.step;
    for n in 1_u64.. {
        if plan.stop_time - time <= negligible {
            break;
        }
        let mut next = plan.start_time + n as f64 * plan.step;
        let mut h = plan.step;
        if can_vary {
            if next > plan.stop_time - negligible {
                next = plan.stop_time;
            }
            h = next - time;
        } else if next > plan.stop_time + negligible {
            break;
        }
        at(&mut instance, time)?;
        match instance.do_step(time, h)? {
            Step::Complete => {
                time = next;
                recorder.record(&mut instance, time, &mut trajectory.columns)?;
            }
            Step::Discarded {
                last_successful_time,
                log,
                ..
            } => {
                // Reading after a discard is for debugging only, unless the FMU can tell the time
                // its values are of (FMI 2.0 §4.2.4); where it does not allow it, the last row is
                // that of the last communication point.
                if let Some(at) = last_successful_time.filter(|at| at.is_finite() && *at > time) {
                    let rows = trajectory.columns[0].len();
                    if recorder
                        .record(&mut instance, at, &mut trajectory.columns)
                        .is_err()
                    {
                        for column in &mut trajectory.columns {
                            column.truncate(rows);
                        }
                    }
                }
                trajectory.ended = Some(log);
                return Ok(trajectory);
            }
        }
    }
    instance.terminate()?;
    Ok(trajectory)
}

/// How many steps of full length there are from start to stop, if these make sense.
pub(crate) fn whole_steps(start: f64, stop: f64, step: f64) -> Result<u64, Error> {
    let refuse = |what, expected, found| {
        Err(Error::Plan {
            what,
            expected,
            found,
        })
    };
    if !start.is_finite() {
        return refuse("start time", "a finite time", start);
    }
    if !stop.is_finite() || stop <= start {
        return refuse("stop time", "a finite time after the start", stop);
    }
    if !step.is_finite() || step <= 0.0 {
        return refuse("communication step", "a positive time", step);
    }
    let steps = (stop - start) / step;
    if steps > MOST_STEPS {
        return refuse("number of steps", "at most 1e8", steps);
    }
    // what is left may be round-off
    Ok((steps + NEGLIGIBLE).floor() as u64)
}

fn variable<'a>(fmu: &'a Fmu, name: &str) -> Result<&'a ScalarVariable, Error> {
    let d = fmu.description();
    d.variable(name).ok_or_else(|| {
        let known = d.variables.iter().map(|v| v.name.as_str());
        Error::unknown_variable(&d.model_name, name, known)
    })
}

/// The variables to set before the start, each with its value, found to be such.
pub(crate) fn start_values<'a, 'v>(
    fmu: &'a Fmu,
    values: &'v [(String, Value)],
) -> Result<Vec<(&'a ScalarVariable, &'v Value)>, Error> {
    let check = |(name, value): &'v (String, Value)| {
        let variable = variable(fmu, name)?;
        value.check_type(variable)?;
        check_settable(variable)?;
        Ok((variable, value))
    };
    values.iter().map(check).collect()
}

/// Whether a variable has a start value of its own (FMI 2.0 §2.2.7): inputs, and what is not
/// calculated, unless it is constant.
fn check_settable(variable: &ScalarVariable) -> Result<(), Error> {
    let is_settable = variable.variability != Variability::Constant
        && (variable.causality == Causality::Input
            || matches!(variable.initial(), Some(Initial::Exact | Initial::Approx)));
    if is_settable {
        return Ok(());
    }
    let found = match (variable.variability, variable.causality) {
        (Variability::Constant, _) => "a constant",
        (_, Causality::Independent) => "the independent variable",
        _ => "one that the FMU calculates",
    };
    Err(Error::NotSettable {
        name: variable.name.clone(),
        found,
    })
}

fn initialize(
    instance: &mut Instance,
    plan: &Plan,
    starts: &[(&ScalarVariable, &Value)],
) -> Result<(), Error> {
    let set = |instance: &mut Instance, inputs: bool| {
        starts
            .iter()
            .filter(|(variable, _)| (variable.causality == Causality::Input) == inputs)
            .try_for_each(|(variable, value)| instance.set(variable, value))
    };
    instance.setup_experiment(plan.tolerance, plan.start_time, Some(plan.stop_time))?;
    set(instance, false)?;
    instance.enter_initialization_mode()?;
    set(instance, true)?;
    instance.exit_initialization_mode()
}

/// Value references of what is recorded, by type, each with its column.
#[derive(Default)]
struct Recorder {
    reals: (Vec<u32>, Vec<usize>),
    integers: (Vec<u32>, Vec<usize>),
    booleans: (Vec<u32>, Vec<usize>),
}

impl Recorder {
    fn new(fmu: &Fmu, names: &[String]) -> Result<Self, Error> {
        let mut recorder = Self::default();
        for (name, column) in names.iter().zip(1..) {
            let variable = variable(fmu, name)?;
            let (references, columns) = match variable.variable_type {
                VariableType::Real(_) => &mut recorder.reals,
                VariableType::Integer(_) | VariableType::Enumeration(_) => &mut recorder.integers,
                VariableType::Boolean(_) => &mut recorder.booleans,
                VariableType::String(_) => {
                    return Err(Error::WrongType {
                        name: name.clone(),
                        expected: "a variable that can be recorded as a number",
                        found: "String",
                    });
                }
            };
            references.push(variable.value_reference);
            columns.push(column);
        }
        Ok(recorder)
    }

    fn record(
        &self,
        instance: &mut Instance,
        time: f64,
        columns: &mut [Vec<f64>],
    ) -> Result<(), Error> {
        columns[0].push(time);
        let (references, places) = &self.reals;
        let mut values = vec![0.0; references.len()];
        instance.get_real(references, &mut values)?;
        for (&place, value) in places.iter().zip(values) {
            columns[place].push(value);
        }
        let (references, places) = &self.integers;
        let mut values = vec![0; references.len()];
        instance.get_integer(references, &mut values)?;
        for (&place, value) in places.iter().zip(values) {
            columns[place].push(f64::from(value));
        }
        let (references, places) = &self.booleans;
        let mut values = vec![false; references.len()];
        instance.get_boolean(references, &mut values)?;
        for (&place, value) in places.iter().zip(values) {
            columns[place].push(f64::from(u8::from(value)));
        }
        Ok(())
    }
}
