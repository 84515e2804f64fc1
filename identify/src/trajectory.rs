//! The bicycle on its own: everything that can be seen of it, over time.

use crate::error::Result;
use crate::speed::SpeedTrace;
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

impl Settings {
    /// Puts them into force at the present time, with the `speed` that runs from here if there is
    /// one.
    fn drive(&self, simulation: &mut Simulation, speed: Option<&SpeedTrace>) -> Result<()> {
        let now = simulation.time();
        let slope = speed.and_then(|trace| Some(trace.slope(now, trace.next(now)?)));
        let input = Input {
            speed: speed.map_or(self.input.speed, |trace| trace.at(now)),
            ..self.input
        };
        let slope = Input {
            speed: slope.unwrap_or(0.0),
            ..Input::ZERO
        };
        Ok(simulation.set(&self.parameters, input, slope)?)
    }
}

/// Simulates from 0 to `duration` [s], a row every `step` [s]. `settings` hold in the order of
/// their times, the first from the start; a row at the time of a change shows the outputs before.
/// A `speed` that changes stands in place of that among the inputs.
pub fn simulate(
    settings: &[Settings],
    formulation: Formulation,
    speed: Option<&SpeedTrace>,
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
    let start = Input {
        speed: speed.map_or(first.input.speed, |trace| trace.at(0.0)),
        ..first.input
    };
    let mut simulation = Simulation::new(&first.parameters, formulation, start, 0.0)?;
    first.drive(&mut simulation, speed)?;
    let mut current = first;
    let mut later = later.iter().peekable();
    let mut bend = speed.and_then(|trace| trace.next(0.0));
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
        let is_before = |time: f64| time < to - 1e-9 * step;
        let outcome = loop {
            let change = later.peek().map(|change| change.from);
            let next = change.into_iter().chain(bend).reduce(f64::min);
            let Some(next) = next.filter(|next| is_before(*next)) else {
                break simulation.advance(to);
            };
            if let Err(stop) = simulation.advance(next) {
                break Err(stop);
            }
            current = later
                .next_if(|change| change.from <= next)
                .unwrap_or(current);
            if bend.is_some_and(|bend| bend <= next) {
                bend = speed.and_then(|trace| trace.next(next));
            }
            current.drive(&mut simulation, speed)?;
        };
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
    #![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
    use super::*;

    /// The end of 4 s of the nominal bicycle from a lean of 5°.
    fn end(speed: Option<&SpeedTrace>, input: Input, step: f64) -> Output {
        let parameters = Parameters {
            roll_start: 0.1,
            ..Parameters::default()
        };
        let settings = Settings {
            from: 0.0,
            parameters,
            input,
        };
        let formulation = Formulation::default();
        let trajectory = simulate(&[settings], formulation, speed, 4.0, step).unwrap();
        assert_eq!(trajectory.stop, None);
        *trajectory.output.last().unwrap()
    }

    #[test]
    fn a_constant_trace_is_the_constant_to_the_last_bit() {
        for v in [2.0, 8.0 / 3.6, 0.1 + 4.0] {
            let input = Input {
                speed: v,
                ..Input::default()
            };
            let trace = SpeedTrace::new(0.007, vec![v; 300]).unwrap();
            assert_eq!(
                end(Some(&trace), Input::default(), 0.005),
                end(None, input, 0.005)
            );
        }
    }

    #[test]
    fn a_ramp_in_many_samples_is_the_ramp_and_rows_change_nothing() {
        let ramp = |n: usize| {
            let samples = (0..=n).map(|i| 2.0 + 2.0 * i as f64 / n as f64);
            SpeedTrace::new(4.0 / n as f64, samples.collect()).unwrap()
        };
        let two = end(Some(&ramp(1)), Input::default(), 0.005);
        for n in [8, 400, 571] {
            let many = end(Some(&ramp(n)), Input::default(), 0.02);
            // other steps where samples fall between those of the grid: their error, not more
            assert!((many.steer - two.steer).abs() < 1e-8, "{n}: {}", many.steer);
            assert!((many.y - two.y).abs() < 1e-8, "{n}: {}", many.y);
        }
        // and it is no constant: halfway it was 3 m/s
        let three = Input {
            speed: 3.0,
            ..Input::default()
        };
        assert!((end(None, three, 0.005).y - two.y).abs() > 1e-3);
    }

    #[test]
    fn a_curved_speed_converges_with_the_square_of_the_step_between_its_samples() {
        let wave = |n: usize| {
            let samples = (0..=n).map(|i| 3.0 + (5.0 * i as f64 / n as f64).sin());
            let trace = SpeedTrace::new(4.0 / n as f64, samples.collect()).unwrap();
            end(Some(&trace), Input::default(), 0.005).x
        };
        let exact = wave(4000);
        let [coarse, fine] = [20, 40].map(|n| (wave(n) - exact).abs());
        // straight lines err by the square: a factor of 4
        assert!((3.6..4.4).contains(&(coarse / fine)), "{coarse} {fine}");
    }

    #[test]
    fn a_name_with_a_comma_is_one_cell() {
        let heads = [("time", Some("s")), ("a[1,2]", None)].into_iter();
        let text = to_csv(heads, &[vec![0.0, 0.5], vec![1.0, 1e-7]]);
        assert_eq!(text, "time[s],\"a[1,2]\"\n0,1\n0.5,0.0000001\n");
    }
}
