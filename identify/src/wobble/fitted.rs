//! The bicycle that a fit found, for the commands that hand it on.

use crate::arguments::BicycleArguments;
use anyhow::Result;
use bicycle::{Excitation, Input};
use fmu::Starts;
use identify::bicycles::{Bicycle, formulation};
use identify::run::{Recorded, Run};
use identify::verdict::Verdict;
use std::path::Path;

/// The bicycle of the fit on record in the file `fit`, else that of the arguments; with the
/// arguments' changes.
pub fn open(fit: Option<&Path>, arguments: &BicycleArguments) -> Result<Bicycle> {
    let Some(path) = fit else {
        return arguments.open();
    };
    let mut bicycle = fitted(&Run::read(path)?)?;
    arguments.change(&mut bicycle)?;
    Ok(bicycle)
}

/// What an FMU of the bicycle starts from.
pub fn starts(bicycle: &Bicycle) -> Starts {
    Starts {
        parameters: bicycle.parameters,
        formulation: bicycle.formulation,
        input: bicycle.input,
    }
}

/// Says what of the excitation is lost where only the bicycle travels, and why.
pub fn tell_excitation(bicycle: &Bicycle, why: &str) {
    let excitation = Excitation::TABLE.iter().zip(bicycle.excitation.to_array());
    for (row, value) in excitation.filter(|(row, value)| row.nominal != *value) {
        eprintln!(
            "note: {} = {value} {} does not travel: {why}",
            row.name, row.unit.symbol
        );
    }
}

fn fitted(run: &Run) -> Result<Bicycle> {
    let found = run.fitted(0)?;
    let Recorded { source, start, .. } = &run.rides[0];
    if run.rides.len() > 1 {
        eprintln!(
            "note: the bicycle of {}, the first of {} rides",
            source.file,
            run.rides.len()
        );
    }
    for estimate in &run.fit.parameters {
        if estimate.verdict == Verdict::NotDetermined {
            eprintln!(
                "warning: {} = {} was not determined by the fit, and travels all the same",
                estimate.label(),
                estimate.value
            );
        }
    }
    if run.fit.estimate("effective_damping").is_some() {
        eprintln!("note: effective_damping travels as viscous_friction, coulomb_friction is 0");
    }
    Ok(Bicycle {
        name: start.bicycle.clone(),
        description: String::new(),
        source: format!("fitted to {} by {}", source.file, run.program),
        parameters: run.as_simulated(&found),
        excitation: Excitation {
            effective_damping: Excitation::default().effective_damping,
            ..found.excitation
        },
        input: Input {
            speed: start.speed,
            ..Input::default()
        },
        formulation: formulation(&start.formulation)?,
        law_in_loop: start.law_in_loop,
        notes: Vec::new(),
    })
}
