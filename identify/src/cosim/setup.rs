//! What is to be coupled, as typed: on the command line, in an SSP archive, or in a TOML file.
//!
//! ```toml
//! step = "5ms"
//! stop = "20s"
//! algorithm = "gauss-seidel"             # or "jacobi", the default
//! connect = ["plant.steer = controller.steer_angle"]
//!
//! [[fmu]]
//! name = "controller"
//! file = "RollAssist.fmu"                # beside this file
//! step = "5ms"
//! set = { roll_gain = 40 }
//!
//! [[fmu]]
//! name = "plant"
//! file = "RearLoadBicycle.fmu"
//! set = { rear_load = "20kg", remnant_intensity = 1.2 }
//!
//! [rider]
//! course = "slalom"
//! set = { cone_spacing = "2.5m" }
//! seed = 1
//! ```

use crate::bicycles::Changes;
use crate::error::{self, Error, Result};
use crate::file;
use crate::unit;
use bicycle::quantity::S;
use fmi_import::master::{Algorithm, Connection};
use fmi_import::{Archive, VariableRow, ssp};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An FMU that takes part.
#[derive(Debug, Clone, PartialEq)]
pub struct Typed {
    /// Its name.
    pub name: String,
    /// Its file.
    pub file: PathBuf,
    /// Values of variables, `name=value`.
    pub set: Vec<String>,
    /// Its own communication step [s].
    pub step: Option<f64>,
}

/// What is to be coupled and how it is to be run.
#[derive(Debug, Clone)]
pub struct Setup {
    /// FMUs, in the order in which Gauss–Seidel steps them.
    pub fmus: Vec<Typed>,
    /// Connections, `source=target`.
    pub connect: Vec<String>,
    /// Another bicycle in the plant than the one its FMU starts with, by name or file.
    pub bicycle: Option<String>,
    /// Changes of the bicycle.
    pub changes: Changes,
    /// The course to follow in place of the rider law.
    pub course: Option<String>,
    /// Rows of the course and of the rider's manner, `name=value`.
    pub course_set: Vec<String>,
    /// Seed of the remnant.
    pub seed: u64,
    /// Communication step [s].
    pub step: f64,
    /// Stop [s]; the end of the course, or 20 s.
    pub stop: Option<f64>,
    /// In which order members step.
    pub algorithm: Algorithm,
    /// How far exchanged values may be off.
    pub tolerance: Option<f64>,
    /// Whether initial values travel before the first step.
    pub initial_exchange: bool,
    /// The SSP archive whose FMUs these are: they are gone with it.
    pub archive: Option<Arc<ssp::Package>>,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            fmus: Vec::new(),
            connect: Vec::new(),
            bicycle: None,
            changes: Changes::default(),
            course: None,
            course_set: Vec::new(),
            seed: 1,
            step: 0.005,
            stop: None,
            algorithm: Algorithm::default(),
            tolerance: None,
            initial_exchange: true,
            archive: None,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    step: Option<Value>,
    stop: Option<Value>,
    algorithm: Option<String>,
    tolerance: Option<f64>,
    initial_exchange: Option<bool>,
    bicycle: Option<String>,
    #[serde(default)]
    connect: Vec<String>,
    fmu: Vec<WrittenFmu>,
    rider: Option<WrittenRider>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenFmu {
    name: String,
    file: PathBuf,
    step: Option<Value>,
    #[serde(default)]
    set: BTreeMap<String, Value>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenRider {
    course: Option<String>,
    #[serde(default)]
    set: BTreeMap<String, Value>,
    seed: Option<u64>,
}

/// A value as typed: with a unit it is a text.
#[derive(Deserialize)]
#[serde(untagged)]
enum Value {
    Integer(i64),
    Number(f64),
    Boolean(bool),
    Text(String),
}

impl Value {
    fn text(&self) -> String {
        match self {
            Self::Integer(value) => value.to_string(),
            Self::Number(value) => value.to_string(),
            Self::Boolean(value) => value.to_string(),
            Self::Text(text) => text.clone(),
        }
    }

    fn seconds(&self, name: &'static str) -> Result<f64> {
        let value = unit::parse(&self.text(), S, name)?;
        if value > 0.0 && value.is_finite() {
            return Ok(value);
        }
        Err(Error::Form {
            expected: "a time above 0 s",
            found: format!("{name} = {}", self.text()),
        })
    }
}

/// The algorithm called `name`.
pub fn algorithm(name: &str) -> Result<Algorithm> {
    const NAMES: [(&str, Algorithm); 2] = [
        ("jacobi", Algorithm::Jacobi),
        ("gauss-seidel", Algorithm::GaussSeidel),
    ];
    let found = NAMES.iter().find(|(known, _)| *known == name);
    found
        .map(|(_, algorithm)| *algorithm)
        .ok_or_else(|| Error::unknown("algorithm", name, NAMES.iter().map(|(known, _)| *known)))
}

fn assignments(set: &BTreeMap<String, Value>) -> Vec<String> {
    let assignment = |(name, value): (&String, &Value)| format!("{name}={}", value.text());
    set.iter().map(assignment).collect()
}

impl Setup {
    /// What is written in the file at `path`: an SSP archive by its suffix, else TOML, with files of
    /// FMUs beside it.
    pub fn read(path: &Path) -> Result<Self> {
        if path
            .extension()
            .is_some_and(|suffix| suffix.eq_ignore_ascii_case("ssp"))
        {
            return Self::of(ssp::read(path)?);
        }
        let text = file::read_text(path)?;
        let name = path.display().to_string();
        let written: Written =
            ::toml::from_str(&text).map_err(|cause| error::toml(&name, &text, &cause))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        written.setup(folder).map_err(|cause| cause.in_file(name))
    }
}

impl Setup {
    fn of(package: ssp::Package) -> Result<Self> {
        let system = package.system();
        let fmu = |component: &ssp::Component| {
            let rows = Archive::open(&component.fmu)?.inspect().variables;
            let starts = component.start_values.iter();
            Ok(Typed {
                name: component.name.clone(),
                file: component.fmu.clone(),
                set: starts
                    .map(|(name, value)| assignment(&rows, name, value))
                    .collect(),
                step: None,
            })
        };
        let connect = |c: &Connection| format!("{}={}", c.source, c.target);
        Ok(Self {
            fmus: system.components.iter().map(fmu).collect::<Result<_>>()?,
            connect: system.connections.iter().map(connect).collect(),
            stop: system.stop_time,
            archive: Some(Arc::new(package)),
            ..Self::default()
        })
    }
}

/// A start value as it is typed: of an enumeration the choice.
fn assignment(rows: &[VariableRow], name: &str, value: &fmi_import::Value) -> String {
    let row = rows.iter().find(|row| row.name == name);
    let choice = row.and_then(|row| {
        let is_it = |(_, number): &&(String, i32)| *value == fmi_import::Value::Integer(*number);
        row.choices.iter().find(is_it)
    });
    match choice {
        Some((choice, _)) => format!("{name}={choice}"),
        None => format!("{name}={value}"),
    }
}

impl Written {
    fn setup(self, folder: &Path) -> Result<Setup> {
        let Setup {
            step,
            seed,
            initial_exchange,
            ..
        } = Setup::default();
        let rider = self.rider.unwrap_or_default();
        let seconds =
            |value: Option<Value>, name| value.map(|value| value.seconds(name)).transpose();
        let fmu = |written: WrittenFmu| {
            Ok(Typed {
                file: folder.join(&written.file),
                set: assignments(&written.set),
                step: seconds(written.step, "step")?,
                name: written.name,
            })
        };
        Ok(Setup {
            step: seconds(self.step, "step")?.unwrap_or(step),
            stop: seconds(self.stop, "stop")?,
            algorithm: self
                .algorithm
                .as_deref()
                .map_or(Ok(Algorithm::default()), algorithm)?,
            tolerance: self.tolerance,
            initial_exchange: self.initial_exchange.unwrap_or(initial_exchange),
            bicycle: self.bicycle,
            connect: self.connect,
            fmus: self.fmu.into_iter().map(fmu).collect::<Result<_>>()?,
            course: rider.course,
            course_set: assignments(&rider.set),
            seed: rider.seed.unwrap_or(seed),
            changes: Changes::default(),
            archive: None,
        })
    }
}
