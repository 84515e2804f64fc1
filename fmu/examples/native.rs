//! The trajectory without FMI, for comparing an FMU with it from outside:
//! `native STEP STOP [NAME=VALUE]… [@TIME NAME=VALUE…]…` prints CSV, SI, every digit.
//!
//! `NAME=VALUE` sets a parameter, the formulation or the start value of an input; after `@TIME`,
//! from that time on. A row at `TIME` shows the outputs before the change. When the ride ends
//! early, the last row is at its end.

use bicycle::simulate::Simulation;
use bicycle::{Formulation, Input, Output, Parameters};
use std::io::Write;

type Failure = Box<dyn std::error::Error>;

/// What may be set.
#[derive(Clone, Default)]
struct Setup {
    parameters: Parameters,
    formulation: Formulation,
    input: Input,
}

impl Setup {
    fn set(&mut self, assignment: &str) -> Result<(), Failure> {
        let (name, value) = assignment
            .split_once('=')
            .ok_or_else(|| format!("expected NAME=VALUE, found {assignment}"))?;
        if let Some(row) = Parameters::index(name) {
            self.parameters.set(row, value.parse()?);
        } else if let Some(row) = Input::index(name) {
            self.input.set(row, value.parse()?);
        } else if name == "formulation" {
            self.formulation = value.parse()?;
        } else {
            return Err(format!("expected a parameter or input, found {name}").into());
        }
        Ok(())
    }
}

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [step, stop, assignments @ ..] = &arguments[..] else {
        return Err("expected STEP STOP [NAME=VALUE]… [@TIME NAME=VALUE…]…".into());
    };
    let (step, stop): (f64, f64) = (step.parse()?, stop.parse()?);
    let mut setups = vec![(0.0, Setup::default())];
    for argument in assignments {
        if let Some(time) = argument.strip_prefix('@') {
            let setup = setups.last().map(|(_, setup)| setup.clone());
            setups.push((time.parse()?, setup.unwrap_or_default()));
        } else if let Some((_, setup)) = setups.last_mut() {
            setup.set(argument)?;
        }
    }
    let mut setups = setups.into_iter().peekable();
    let (start, first) = setups.next().unwrap_or_default();
    let mut ride = Simulation::new(&first.parameters, first.formulation, first.input, start)?;

    let mut out = std::io::stdout().lock();
    let names: Vec<&str> = Output::TABLE.iter().map(|row| row.name).collect();
    writeln!(out, "time,{}", names.join(","))?;
    let mut write = |ride: &Simulation| {
        let values = ride.output().to_array().map(|value| value.to_string());
        writeln!(out, "{},{}", ride.time(), values.join(","))
    };
    write(&ride)?;
    for n in 1_u32.. {
        let time = f64::from(n) * step;
        if time > stop + 1e-9 {
            break;
        }
        let arrived = ride.advance(time);
        write(&ride)?;
        if arrived.is_err() {
            break;
        }
        if let Some((_, setup)) = setups.next_if(|(change, _)| (change - time).abs() < 1e-9) {
            ride.set_parameters(&setup.parameters)?;
            ride.set_input(setup.input)?;
        }
    }
    Ok(())
}
