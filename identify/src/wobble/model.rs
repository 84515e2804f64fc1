//! Commands about the model: parameters, simulate.

use crate::arguments::{BicycleArguments, RideArguments, quantity};
use crate::course::CourseArguments;
use crate::fitted;
use crate::foreign;
use crate::output::{Output, Progress};
use anyhow::Result;
use bicycle::quantity::{HZ, N_M, S, Variability};
use bicycle::{Excitation, Formulation, Input, Parameters, Quantity};
use clap::Args;
use fmi_import::model_description::ssp::ParameterSet;
use identify::bicycles::{Bicycle, Changes};
use identify::error::Error;
use identify::file;
use identify::speed::SpeedTrace;
use identify::synthesis::{SensorNoise, Synthesis, TorqueLine};
use identify::trajectory::{self, Settings, Trajectory};
use serde_json::json;
use std::fmt::Write as _;
use std::path::PathBuf;

#[derive(Args)]
pub struct ListParameters {
    #[command(flatten)]
    bicycle: BicycleArguments,
    /// Fitted values: the fit.json of a fit, on top of the bicycle it was made with
    #[arg(long, value_name = "FILE", conflicts_with_all = ["bicycle", "rider"])]
    fit: Option<PathBuf>,
    /// Write the start values of the FMU as a parameter set of SSP, not the table
    #[arg(long, value_name = "FILE", conflicts_with_all = ["json", "out"])]
    ssv: Option<PathBuf>,
    /// Write a file for --bicycle, not the table
    #[arg(long, value_name = "FILE", conflicts_with_all = ["json", "out"])]
    toml: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

impl ListParameters {
    pub fn run(&self) -> Result<()> {
        let bicycle = fitted::open(self.fit.as_deref(), &self.bicycle)?;
        if self.ssv.is_some() || self.toml.is_some() {
            return self.export(&bicycle);
        }
        self.list(&bicycle)
    }

    fn export(&self, bicycle: &Bicycle) -> Result<()> {
        fitted::tell_excitation(bicycle, "it is no part of the bicycle");
        if let Some(path) = &self.ssv {
            let description = fmu::package(&fitted::starts(bicycle))?.description;
            let set = ParameterSet {
                name: bicycle.name.clone(),
                generation_tool: Some(concat!("wobble ", env!("CARGO_PKG_VERSION")).to_owned()),
                ..ParameterSet::of_starts(&description)
            };
            file::write(path, set.to_xml()?)?;
            eprintln!("wrote {}", path.display());
        }
        if let Some(path) = &self.toml {
            let text = bicycle.to_toml();
            // a fit may end where no bicycle file may go
            Bicycle::parse(&path.display().to_string(), &text, &Changes::default())?;
            file::write(path, text)?;
            eprintln!("wrote {}", path.display());
        }
        Ok(())
    }

    fn list(&self, bicycle: &Bicycle) -> Result<()> {
        let rows = rows(bicycle);
        let mut json: Vec<_> = rows
            .iter()
            .map(|(kind, row, value)| describe(kind, row, *value, bicycle))
            .collect();
        json.push(json!({
            "name": "formulation", "kind": "fixed parameter", "value": bicycle.formulation.name(),
            "nominal": Formulation::default().name(), "choices": Formulation::ALL.map(Formulation::name),
            "description": bicycle.formulation.what(),
        }));
        self.output.json_or(&json, || {
            let mut text = format!(
                "{:28} {:6} {:>12} {:10} fixed parameter\n    {}.\n",
                "formulation", "", bicycle.formulation.name(), "", bicycle.formulation.what()
            );
            for (kind, row, value) in &rows {
                let Quantity { name, symbol, unit, min, max, what, .. } = row;
                let source = source(row, *value, bicycle);
                let measured = row.measured.map_or(String::new(), |(a, b)| format!(", measured {a}–{b}"));
                let _ = writeln!(
                    text,
                    "{name:28} {symbol:6} {value:>12} {:10} {kind}, {min} to {max}{measured}\n    {what}. {source}.",
                    unit.symbol
                );
            }
            text
        })
    }
}

/// All rows that have a value in a bicycle.
fn rows(b: &Bicycle) -> Vec<(&'static str, &'static Quantity, f64)> {
    let kind = |row: &Quantity| match row.variability {
        Variability::Fixed => "fixed parameter",
        Variability::Tunable => "parameter",
        Variability::Continuous => "input",
    };
    let parameters = Parameters::TABLE.iter().zip(b.parameters.to_array());
    let inputs = Input::TABLE.iter().zip(b.input.to_array());
    let mut all: Vec<_> = parameters
        .chain(inputs)
        .map(|(row, value)| (kind(row), row, value))
        .collect();
    let excitation = Excitation::TABLE.iter().zip(b.excitation.to_array());
    all.extend(excitation.map(|(row, value)| ("excitation", row, value)));
    all
}

/// Where a row's value comes from: the table, where it is nominal, else the set.
fn source(row: &Quantity, value: f64, bicycle: &Bicycle) -> String {
    if value == row.nominal {
        return row.source.into();
    }
    format!("{}: {}", bicycle.name, bicycle.source)
}

fn describe(kind: &str, row: &Quantity, value: f64, bicycle: &Bicycle) -> serde_json::Value {
    json!({
        "name": row.name, "symbol": row.symbol, "unit": row.unit.symbol, "kind": kind,
        "value": value, "nominal": row.nominal, "min": row.min, "max": row.max,
        "measured": row.measured, "description": row.what, "source": source(row, value, bicycle),
    })
}

#[derive(Args)]
pub struct Simulate {
    #[command(flatten)]
    bicycle: BicycleArguments,
    /// How long [default: 24s, or as the FMU has it]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    duration: Option<String>,
    /// From row to row [default: 5ms, or as the FMU has it]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    step: Option<String>,
    /// Change a parameter or an input under way, e.g. 5s:speed=3m/s
    #[arg(long, value_name = "TIME:NAME=VALUE", conflicts_with = "ride")]
    at: Vec<String>,
    /// Make a ride file as instruments would record it: sensor noise, remnant and line by --seed
    #[arg(long)]
    ride: bool,
    /// Sine of steer torque in the ride, e.g. 1.11Hz,4N.m: the slalom
    #[arg(
        long,
        value_name = "FREQUENCY,TORQUE",
        requires = "ride",
        conflicts_with = "course"
    )]
    line: Option<String>,
    /// Record the whole steer torque in the ride
    #[arg(long, requires = "ride", conflicts_with = "course")]
    torque: bool,
    /// Seed of the ride
    #[arg(
        long,
        default_value_t = 1,
        requires = "ride",
        conflicts_with = "course"
    )]
    seed: u64,
    /// Ride file whose recorded speed is ridden, for as long as it lasts
    #[arg(long, value_name = "RIDE", conflicts_with_all = ["course", "fmu"])]
    speed_from: Option<PathBuf>,
    #[command(flatten)]
    reading: RideArguments,
    #[command(flatten)]
    course: CourseArguments,
    #[command(flatten)]
    foreign: foreign::Arguments,
    #[command(flatten)]
    output: Output,
}

impl Simulate {
    pub fn run(&self) -> Result<()> {
        if let Some(path) = self.foreign.fmu() {
            return self.foreign.run(&foreign::Call {
                path,
                set: self.bicycle.assignments(),
                duration: self.duration.as_deref(),
                step: self.step.as_deref(),
                output: &self.output,
            });
        }
        let bicycle = self.bicycle.open()?;
        if let Some(name) = self.course.name() {
            return self.course.run(name, &bicycle, &self.output);
        }
        let speed = self.speed()?;
        let step = positive("--step", self.step.as_deref().unwrap_or("5ms"))?;
        let duration = match (&self.duration, &speed) {
            (Some(text), _) => positive("--duration", text)?,
            // of a ride its last sample as well
            (None, Some(trace)) if self.ride => trace.duration() + step,
            (None, Some(trace)) => trace.duration(),
            (None, None) => 24.0,
        };
        if self.ride {
            return self.ride(&bicycle, speed, duration, step);
        }
        if bicycle.excitation != Excitation::default() {
            eprintln!("note: the rider's remnant acts in rides only: --ride");
        }
        let settings = self.settings(&bicycle, duration)?;
        let progress = Progress::new();
        progress.say("simulating");
        let trajectory = trajectory::simulate(
            &settings,
            bicycle.formulation,
            speed.as_ref(),
            duration,
            step,
        )?;
        drop(progress);
        if let Some(stop) = trajectory.stop {
            eprintln!("note: {stop}");
        }
        let stop = trajectory.stop.map_or("end", |stop| stop.name());
        let json =
            json!({ "stop": stop, "time": trajectory.time, "outputs": outputs(&trajectory) });
        self.output.json_or(&json, || trajectory.to_csv())
    }

    /// The speed recorded in `--speed-from`.
    fn speed(&self) -> Result<Option<SpeedTrace>> {
        let Some(path) = &self.speed_from else {
            return Ok(None);
        };
        let trace = SpeedTrace::of(&self.reading.read(path)?)?;
        if self.bicycle.sets("speed") {
            eprintln!(
                "note: the speed is that of {}; --set speed has no say",
                path.display()
            );
        }
        Ok(Some(trace))
    }

    fn settings(&self, bicycle: &Bicycle, duration: f64) -> Result<Vec<Settings>> {
        let mut changed = bicycle.clone();
        let settings = |from, b: &Bicycle| Settings {
            from,
            parameters: b.parameters,
            input: b.input,
        };
        let mut changes = Vec::new();
        for text in &self.at {
            let typed = |expected| {
                Error::Form {
                    expected,
                    found: text.clone(),
                }
                .typed(format!("--at {text}"))
            };
            let (time, assignment) = text
                .split_once(':')
                .ok_or_else(|| typed("TIME:NAME=VALUE"))?;
            let from = quantity("--at", time, S)?;
            let name = assignment.split('=').next().unwrap_or_default();
            let fixed = Parameters::index(name)
                .is_some_and(|i| Parameters::TABLE[i].variability == Variability::Fixed);
            if fixed || name == "formulation" || Excitation::index(name).is_some() {
                return Err(typed("a row that may change under way").into());
            }
            if !(0.0..duration).contains(&from) {
                return Err(typed("a time within the simulation").into());
            }
            changes.push((from, assignment, text));
        }
        changes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut all = vec![settings(0.0, bicycle)];
        for (from, assignment, text) in changes {
            changed
                .set(assignment)
                .map_err(|cause| cause.typed(format!("--at {text}")))?;
            all.push(settings(from, &changed));
        }
        Ok(all)
    }

    fn ride(
        &self,
        bicycle: &Bicycle,
        speed: Option<SpeedTrace>,
        duration: f64,
        step: f64,
    ) -> Result<()> {
        let line = self.line.as_deref().map(torque_line).transpose()?;
        let synthesis = Synthesis {
            parameters: bicycle.parameters,
            formulation: bicycle.formulation,
            input: bicycle.input,
            speed,
            excitation: bicycle.excitation,
            line,
            duration,
            rate: 1.0 / step,
            noise: SensorNoise::INSTRUMENTED,
            torque_recorded: self.torque,
            seed: self.seed,
        };
        let progress = Progress::new();
        progress.say("riding");
        let ride = synthesis.ride()?;
        drop(progress);
        let channels: serde_json::Map<_, _> = ride
            .channels()
            .map(|(row, samples)| (row.name.to_owned(), json!(samples)))
            .collect();
        let json = json!({ "step": ride.step(), "samples": ride.len(), "channels": channels });
        self.output.json_or(&json, || ride.to_csv())
    }
}

/// The outputs of a simulation by name.
pub fn outputs(trajectory: &Trajectory) -> serde_json::Value {
    let columns = bicycle::Output::TABLE.iter().enumerate().map(|(i, row)| {
        let column: Vec<f64> = trajectory.output.iter().map(|o| o.get(i)).collect();
        (row.name.to_owned(), json!(column))
    });
    columns.collect::<serde_json::Map<_, _>>().into()
}

fn torque_line(text: &str) -> Result<TorqueLine> {
    let Some((frequency, amplitude)) = text.split_once(',') else {
        let form = Error::Form {
            expected: "FREQUENCY,TORQUE",
            found: text.into(),
        };
        return Err(form.typed(format!("--line {text}")).into());
    };
    Ok(TorqueLine {
        frequency: quantity("--line", frequency, HZ)?,
        amplitude: quantity("--line", amplitude, N_M)?,
    })
}

/// A time behind `flag`, which must be positive.
pub fn positive(flag: &str, text: &str) -> Result<f64> {
    let value = quantity(flag, text, S)?;
    if value > 0.0 && value.is_finite() {
        return Ok(value);
    }
    let form = Error::Form {
        expected: "a time above 0 s",
        found: text.into(),
    };
    Err(form.typed(format!("{flag} {text}")).into())
}
