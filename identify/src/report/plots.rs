//! What the report plots: spectra and signals as panels of a [`super::plot`].

use super::plot::{Axis, BLACK, BLUE, GREY, Mark, Panel, Points, Series, VERMILLION};
use super::words::words;
use crate::figure::shown;
use crate::run::{Curve, Trace};

/// `values` [SI] in the unit that is shown.
fn scaled(values: &[f64], factor: f64) -> Vec<f64> {
    values.iter().map(|v| factor * v).collect()
}

/// A curve of `name` in a colour.
pub(super) fn points(name: &str, colour: &'static str, x: &[f64], y: Vec<f64>) -> Points {
    Points {
        name: name.into(),
        colour,
        x: x.to_vec(),
        y,
    }
}

/// Measured and expected amplitudes, a panel a channel; `lines` [Hz] are marked.
pub(super) fn spectrum(curves: &[Curve], lines: &[f64]) -> Vec<Panel> {
    let panel = |curve: &Curve| {
        let (factor, unit) = shown(&curve.unit);
        let scaled = |values: &[f64]| scaled(values, factor);
        let x = &curve.frequency;
        Panel {
            x: Axis::linear("frequency [Hz]"),
            y: Axis::logarithmic(format!("{} [{unit}]", words(&curve.channel))),
            series: vec![
                Series::Band {
                    name: "19 of 20 bins".into(),
                    colour: BLUE,
                    x: x.clone(),
                    low: scaled(&curve.low),
                    high: scaled(&curve.high),
                },
                Series::Line(points("model", BLUE, x, scaled(&curve.expected))),
                Series::Dots(points("measured", BLACK, x, scaled(&curve.measured))),
            ],
            marks: lines
                .iter()
                .map(|&x| Mark {
                    x,
                    name: "line".into(),
                })
                .collect(),
        }
    };
    curves.iter().map(panel).collect()
}

/// Signals of the ride and of the model over time, a panel a channel.
pub(super) fn traces(traces: &[Trace]) -> Vec<Panel> {
    let panel = |trace: &Trace| {
        let (factor, unit) = shown(&trace.unit);
        let curve = |name, colour, y: &[f64]| {
            Series::Line(points(name, colour, &trace.time, scaled(y, factor)))
        };
        Panel {
            x: Axis::linear("time [s]"),
            y: Axis::linear(format!("{} [{unit}]", words(&trace.channel))),
            series: vec![
                curve("measured", GREY, &trace.measured),
                curve("model", VERMILLION, &trace.model),
            ],
            marks: Vec::new(),
        }
    };
    traces.iter().map(panel).collect()
}
