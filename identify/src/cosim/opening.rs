//! From what was typed to what FMUs start with.

use super::PLANT;
use super::setup::{Setup, Typed};
use crate::bicycles::{Bicycle, Changes};
use crate::error::{Error, Result};
use crate::variable;
use fmi_import::{Archive, Value, VariableRow};

/// An assignment and the participant it is for.
pub type Assigned = (String, String);

/// Sorts `[participant.]name=value` into those of participants and those of the plant.
pub fn sort(set: &[String], fmus: &[Typed]) -> (Vec<Assigned>, Vec<String>) {
    let mut of_members = Vec::new();
    let mut of_plant = Vec::new();
    for text in set {
        let member = text
            .split_once('.')
            .filter(|(name, rest)| rest.contains('=') && fmus.iter().any(|fmu| fmu.name == *name));
        match member {
            Some((PLANT, rest)) => of_plant.push(rest.to_owned()),
            Some((name, rest)) => of_members.push((name.to_owned(), rest.to_owned())),
            None => of_plant.push(text.clone()),
        }
    }
    (of_members, of_plant)
}

/// The bicycle to ride: what the FMU starts with, or the one called `name`, with changes.
pub fn ridden(of_fmu: Bicycle, name: Option<&str>, changes: &Changes) -> Result<Bicycle> {
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
pub fn refuse_bicycle(setup: &Setup, model: &str) -> Result<()> {
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
pub fn starts(
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
pub fn member_step(member: &str, own: f64, step: f64, is_typed: bool) -> Result<f64> {
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
