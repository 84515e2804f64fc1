//! FMUs of any maker: what is in one, and one simulated.

mod look;

pub use look::inspect;

use crate::arguments::{assignment, quantity};
use crate::model::positive;
use crate::output::{Output, Progress};
use anyhow::Result;
use bicycle::quantity::S;
use clap::Args;
use fmi_import::{Archive, Fmu, Plan, Trajectory, VariableRow};
use identify::error::{Error, Result as Typed};
use identify::{trajectory, variable};
use serde_json::json;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Whether the file is an FMU, by its suffix or because it is a zip archive.
pub fn is_fmu(path: &Path) -> bool {
    const ZIP: [u8; 4] = *b"PK\x03\x04";
    let mut start = [0; 4];
    path.extension()
        .is_some_and(|suffix| suffix.eq_ignore_ascii_case("fmu"))
        || File::open(path)
            .and_then(|mut file| file.read_exact(&mut start))
            .is_ok_and(|()| start == ZIP)
}

/// An FMU in place of the bicycle.
#[derive(Args)]
pub struct Arguments {
    /// Simulate this FMU, of whatever maker, in place of the bicycle; --set names its variables
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with_all = [
            "bicycle", "load", "rider", "formulation", "at", "ride", "line", "torque", "seed"
        ]
    )]
    fmu: Option<PathBuf>,
    /// Time at which the FMU starts [default: that of its default experiment]
    #[arg(
        long,
        value_name = "TIME",
        requires = "fmu",
        allow_hyphen_values = true
    )]
    start: Option<String>,
    /// Variable of the FMU to record [default: its outputs]
    #[arg(long, value_name = "NAME", requires = "fmu")]
    record: Vec<String>,
}

/// What a simulation of an FMU is made of.
pub struct Call<'a> {
    pub path: &'a Path,
    /// Assignments to variables of the FMU.
    pub set: &'a [String],
    pub duration: Option<&'a str>,
    pub step: Option<&'a str>,
    pub output: &'a Output,
}

impl Arguments {
    /// The FMU, if there is one.
    pub fn fmu(&self) -> Option<&Path> {
        self.fmu.as_deref()
    }

    /// Simulates the FMU and writes what was recorded.
    pub fn run(&self, call: &Call) -> Result<()> {
        let archive = Archive::open(call.path)?;
        let variables = archive.inspect().variables;
        let plan = self.plan(call, &archive, &variables)?;
        let fmu = Fmu::load(archive)?;
        let progress = Progress::new();
        let mut steps = 0_u32;
        let simulated = fmi_import::simulate_with(&fmu, &plan, |_, time| {
            // now and then: a step may be shorter than saying so
            if steps.is_multiple_of(256) {
                progress.say(&format!("simulating, {time:.3} of {} s", plan.stop_time));
            }
            steps = steps.wrapping_add(1);
            Ok(())
        });
        drop(progress);
        let trajectory = simulated.map_err(|error| typed(call.path, error))?;
        tell_end(&plan, &trajectory);
        let stop = if trajectory.ended.is_some() {
            "early"
        } else {
            "end"
        };
        let columns = || trajectory.names.iter().zip(&trajectory.columns);
        let outputs: serde_json::Map<_, _> = columns()
            .skip(1)
            .map(|(name, column)| (name.clone(), json!(column)))
            .collect();
        let json = json!({ "stop": stop, "time": trajectory.columns[0], "outputs": outputs });
        call.output
            .json_or(&json, || to_csv(&trajectory, &variables))
    }

    fn plan(&self, call: &Call, archive: &Archive, variables: &[VariableRow]) -> Result<Plan> {
        let description = archive.description();
        let experiment = description.default_experiment.unwrap_or_default();
        let start_time = match &self.start {
            Some(text) => quantity("--start", text, S)?,
            None => experiment.start_time.unwrap_or(0.0),
        };
        let duration = match (call.duration, experiment.stop_time) {
            (Some(text), _) => positive("--duration", text)?,
            (None, Some(stop)) => stop - experiment.start_time.unwrap_or(0.0),
            (None, None) => {
                eprintln!("note: the FMU gives no duration of its own: 1 s is taken");
                1.0
            }
        };
        let step = match (call.step, experiment.step_size) {
            (Some(text), _) => positive("--step", text)?,
            (None, Some(step)) => step,
            (None, None) => {
                let step = duration / 500.0;
                eprintln!("note: the FMU gives no step of its own: {step} s is taken");
                step
            }
        };
        let start_values = call.set.iter().map(|text| {
            let (name, value) = assignment("--set", text)?;
            let argument = || format!("--set {text}");
            let value = variable::value(&description.units, variables, name, value)
                .map_err(|cause| cause.typed(argument()))?;
            Ok((name.to_owned(), value))
        });
        Ok(Plan {
            start_values: start_values.collect::<Typed<_>>()?,
            record: self.recorded(variables)?,
            start_time,
            stop_time: start_time + duration,
            step,
            tolerance: experiment.tolerance,
        })
    }

    /// Names of what to record: those asked for, else the outputs that are numbers.
    fn recorded(&self, variables: &[VariableRow]) -> Typed<Vec<String>> {
        let is_text = |row: &VariableRow| row.type_name == "String";
        if self.record.is_empty() {
            let outputs = variables.iter().filter(|row| row.causality == "output");
            let (texts, numbers): (Vec<_>, Vec<_>) = outputs.partition(|row| is_text(row));
            for row in texts {
                eprintln!("note: {} is a text and not recorded", row.name);
            }
            return Ok(numbers.iter().map(|row| row.name.clone()).collect());
        }
        for name in &self.record {
            let argument = || format!("--record {name}");
            let row = variable::row(variables, name).map_err(|cause| cause.typed(argument()))?;
            if is_text(row) {
                let form = Error::Form {
                    expected: "a variable that can be recorded as a number",
                    found: "a String".into(),
                };
                return Err(form.typed(argument()));
            }
        }
        Ok(self.record.clone())
    }
}

/// An error that only what was typed can have caused as such, any other as the FMU's at `path`.
fn typed(path: &Path, error: fmi_import::Error) -> anyhow::Error {
    match error {
        fmi_import::Error::Plan {
            what,
            expected,
            found,
        } => Error::Form {
            expected,
            found: found.to_string(),
        }
        .typed(what)
        .into(),
        fmi_import::Error::NotSettable { name, found } => Error::Form {
            expected: "a variable that can be set before the start",
            found: found.to_owned(),
        }
        .typed(format!("--set {name}"))
        .into(),
        other => anyhow::Error::from(other).context(path.display().to_string()),
    }
}

/// Says on stderr why the last row is not at the stop.
fn tell_end(plan: &Plan, trajectory: &Trajectory) {
    let last = trajectory.columns[0]
        .last()
        .copied()
        .unwrap_or(plan.start_time);
    if let Some(log) = &trajectory.ended {
        eprintln!("note: the FMU ended early, at {last} s");
        for line in log {
            eprintln!("note: {line}");
        }
    } else if plan.stop_time - last > 1e-9 * plan.step {
        eprintln!(
            "note: the FMU takes steps of one length only: the last one ends at {last} s, before {} s",
            plan.stop_time
        );
    }
}

/// As CSV, `time[s],name[unit],…`.
fn to_csv(trajectory: &Trajectory, variables: &[VariableRow]) -> String {
    let unit = |name: &String| match name.as_str() {
        "time" => Some("s"),
        name => variable::row(variables, name).ok()?.unit.as_deref(),
    };
    let heads = trajectory
        .names
        .iter()
        .map(|name| (name.as_str(), unit(name)));
    trajectory::to_csv(heads, &trajectory.columns)
}

#[cfg(test)]
mod tests;
