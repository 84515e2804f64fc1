//! From what was typed to what FMUs start with.

use super::setup::{Setup, Typed};
use super::{PLANT, plant};
use crate::bicycles::{Bicycle, Changes};
use crate::error::{Error, Result};
use crate::variable;
use fmi_import::{Archive, Fmu, Value, VariableRow};
use std::path::PathBuf;

/// An FMU loaded, with its start values.
pub struct Opened {
    pub name: String,
    pub file: PathBuf,
    pub fmu: Fmu,
    pub rows: Vec<VariableRow>,
    pub starts: Vec<(String, Value)>,
    /// Its own communication step [s].
    pub step: Option<f64>,
    /// The step it suggests [s]: of a controller its sample time.
    pub suggested: Option<f64>,
}

/// Loads what was typed; the bicycle besides, where it is one of ours.
pub fn open(typed: &Typed, setup: &Setup) -> Result<(Opened, Option<Bicycle>)> {
    let archive = Archive::open(&typed.file)?;
    let rows = archive.inspect().variables;
    let description = archive.description();
    let is_plant = typed.name == PLANT;
    let on_top = setup.changes.set.iter().filter_map(|text| {
        let (member, assignment) = addressed(text, &setup.fmus);
        (member == typed.name).then(|| assignment.to_owned())
    });
    let set = typed.set.iter().cloned().chain(on_top).collect();
    let ours = if is_plant {
        plant::bicycle(&description.model_name, &rows)?
    } else {
        None
    };
    let (starts, bicycle) = if let Some(of_fmu) = ours {
        let changes = Changes {
            set,
            ..setup.changes.clone()
        };
        let ridden = ridden(of_fmu, setup.bicycle.as_deref(), &changes)?;
        (Vec::new(), Some(ridden))
    } else {
        if is_plant {
            refuse_bicycle(setup, &description.model_name)?;
        }
        (starts(&typed.name, &archive, &rows, &set)?, None)
    };
    // a plant is stepped as the plan has it, and so is everything where steps are cut
    let suggested = description.default_experiment.and_then(|e| e.step_size);
    let suggested = suggested.filter(|step| !is_plant && *step > 0.0);
    let own = typed
        .step
        .or(suggested.filter(|_| setup.tolerance.is_none()));
    let step = own.map(|own| member_step(&typed.name, own, setup.step, typed.step.is_some()));
    let opened = Opened {
        name: typed.name.clone(),
        file: typed.file.clone(),
        step: step.transpose()?,
        suggested,
        fmu: Fmu::load(archive)
            .map_err(|cause| Error::from(cause).in_file(typed.file.display().to_string()))?,
        rows,
        starts,
    };
    Ok((opened, bicycle))
}

/// For whom `[participant.]name=value` is, and the rest; without a participant for the plant.
fn addressed<'a>(text: &'a str, fmus: &[Typed]) -> (&'a str, &'a str) {
    let is_member = |(name, rest): &(&str, &str)| {
        rest.contains('=') && fmus.iter().any(|fmu| fmu.name == *name)
    };
    text.split_once('.')
        .filter(is_member)
        .unwrap_or((PLANT, text))
}

/// What is typed of a plant is for one that is there.
pub fn check(setup: &Setup) -> Result<()> {
    if setup.fmus.is_empty() {
        return Err(Error::Form {
            expected: "at least one FMU",
            found: "none".into(),
        });
    }
    if setup.fmus.iter().any(|fmu| fmu.name == PLANT) {
        return Ok(());
    }
    refuse_bicycle(setup, "none")?;
    let mut set = setup.changes.set.iter();
    match set.find(|text| addressed(text, &setup.fmus).0 == PLANT) {
        Some(text) => Err(not_ours("none").typed(format!("--set {text}"))),
        None => Ok(()),
    }
}

/// The bicycle to ride: what the FMU starts with, or the one called `name`, with changes.
fn ridden(of_fmu: Bicycle, name: Option<&str>, changes: &Changes) -> Result<Bicycle> {
    if let Some(name) = name {
        return Bicycle::open(name, changes).map_err(|cause| match cause {
            Error::Unknown { .. } => cause.typed(format!("--bicycle {name}")),
            cause => cause,
        });
    }
    let mut bicycle = of_fmu;
    bicycle.change(changes)?;
    Ok(bicycle)
}

pub fn not_ours(found: &str) -> Error {
    Error::Form {
        expected: "a participant `plant` with the rows of the bicycle's table",
        found: found.to_owned(),
    }
}

/// What is typed of a bicycle is for a plant that is one.
fn refuse_bicycle(setup: &Setup, model: &str) -> Result<()> {
    let Changes {
        rider,
        load,
        formulation,
        ..
    } = &setup.changes;
    let typed = [
        ("--bicycle", &setup.bicycle),
        ("--rider", rider),
        ("--load", load),
        ("--formulation", formulation),
        ("--course", &setup.course),
    ];
    for (flag, value) in typed {
        if let Some(value) = value {
            return Err(not_ours(model).typed(format!("{flag} {value}")));
        }
    }
    Ok(())
}

/// Start values of an FMU, from assignments to its variables.
fn starts(
    member: &str,
    archive: &Archive,
    rows: &[VariableRow],
    set: &[String],
) -> Result<Vec<(String, Value)>> {
    let units = &archive.description().units;
    let value = |text: &String| {
        let typed = |cause: Error| cause.typed(format!("--set {member}.{text}"));
        let (name, value) = text.split_once('=').ok_or_else(|| {
            typed(Error::Form {
                expected: "NAME=VALUE",
                found: text.clone(),
            })
        })?;
        let value = variable::value(units, rows, name.trim(), value.trim()).map_err(typed)?;
        Ok((name.trim().to_owned(), value))
    };
    set.iter().map(value).collect()
}

/// The communication step of a participant with a sample time of its own: that, or the plan's where
/// that is a multiple.
fn member_step(member: &str, own: f64, step: f64, is_typed: bool) -> Result<f64> {
    let divides = |a: f64, b: f64| {
        let ratio = (b / a).round();
        ratio >= 1.0 && (ratio * a - b).abs() <= 1e-9 * b
    };
    if divides(step, own) {
        Ok(own)
    } else if !is_typed && divides(own, step) {
        Ok(step)
    } else {
        Err(Error::SampleTime {
            member: member.to_owned(),
            own,
            step,
        })
    }
}
