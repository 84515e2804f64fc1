//! The bicycle on its own: everything that can be seen of it, over time.

use crate::error::Result;
use bicycle::simulate::{Simulation, Stop};
use bicycle::{Formulation, Input, Output, Parameters};
use std::fmt::Write as _;

/// The settings in force from a time on.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Time from which they hold [s].
    pub from: f64,
    /// The parameters; the `*_start` rows and `internal_step` act at the start only.
    pub parameters: Parameters,
    /// The inputs.
    pub input: Input,
}

/// A native simulation: what the FMU gives, without FMI.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// Times [s].
    pub time: Vec<f64>,
    /// What was seen there.
    pub output: Vec<Output>,
    /// Why it ended early, if it did; the last row is then at that time.
    pub stop: Option<Stop>,
}

/// Simulates from 0 to `duration` [s], a row every `step` [s]. `settings` hold in the order of
/// their times, the first from the start; a row at the time of a change shows the outputs before.
pub fn simulate(
    settings: &[Settings],
    formulation: Formulation,
    duration: f64,
    step: f64,
) -> Result<Trajectory> {
    let [first, later @ ..] = settings else {
        return Ok(Trajectory {
            time: vec![],
            output: vec![],
            stop: None,
        });
    };
    let mut simulation = Simulation::new(&first.parameters, formulation, first.input, 0.0)?;
    let mut later = later.iter().peekable();
    let mut trajectory = Trajectory {
        time: vec![0.0],
        output: vec![simulation.output()],
        stop: None,
    };
    // a duration of 24 s in steps of .005 s has 4800 of them, whatever the rounding; where it has a
    // part of one besides, the last row is at its end
    let rows = (duration / step - 1e-9).ceil() as u64;
    for n in 1..=rows {
        let to = n as f64 * step;
        let to = if to > duration - 1e-9 * step {
            duration
        } else {
            to
        };
        while let Some(change) = later.next_if(|change| change.from < to - 1e-9 * step) {
            if let Err(stop) = simulation.advance(change.from) {
                trajectory.stop = Some(stop);
                break;
            }
            simulation.set(&change.parameters, change.input, Input::ZERO)?;
        }
        let outcome = simulation.advance(to);
        trajectory.time.push(simulation.time());
        trajectory.output.push(simulation.output());
        if let Err(stop) = outcome {
            trajectory.stop = Some(stop);
            break;
        }
    }
    Ok(trajectory)
}

impl Trajectory {
    /// As CSV, `time[s],roll[rad],…`, every digit.
    pub fn to_csv(&self) -> String {
        let names = Output::TABLE
            .iter()
            .map(|row| (row.name, Some(row.unit.symbol)));
        let column = |index| self.output.iter().map(|seen| seen.get(index)).collect();
        let mut columns = vec![self.time.clone()];
        columns.extend((0..Output::LEN).map(column));
        to_csv([("time", Some("s"))].into_iter().chain(names), &columns)
    }
}

/// Columns as CSV, `name[unit],…`, every digit.
pub fn to_csv<'a>(
    heads: impl Iterator<Item = (&'a str, Option<&'a str>)>,
    columns: &[Vec<f64>],
) -> String {
    let mut text = String::new();
    for (n, (name, unit)) in heads.enumerate() {
        let head = unit.map_or_else(|| name.to_owned(), |unit| format!("{name}[{unit}]"));
        text.push_str(if n == 0 { "" } else { "," });
        // names such as a[1,2] or 'a "b"' (RFC 4180)
        if head.contains([',', '"', '\n', '\r']) {
            write!(text, "\"{}\"", head.replace('"', "\"\"")).expect("a string takes all");
        } else {
            text.push_str(&head);
        }
    }
    for row in 0..columns.first().map_or(0, Vec::len) {
        for (n, column) in columns.iter().enumerate() {
            let comma = if n == 0 { '\n' } else { ',' };
            write!(text, "{comma}{}", column[row]).expect("a string takes all");
        }
    }
    text.push('\n');
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_with_a_comma_is_one_cell() {
        let heads = [("time", Some("s")), ("a[1,2]", None)].into_iter();
        let text = to_csv(heads, &[vec![0.0, 0.5], vec![1.0, 1e-7]]);
        assert_eq!(text, "time[s],\"a[1,2]\"\n0,1\n0.5,0.0000001\n");
    }
}
