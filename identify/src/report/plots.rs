//! What the report plots: spectra, signals, starts and profiles as panels of a [`super::plot`].

use super::plot::{Axis, BLACK, BLUE, GREEN, GREY, Mark, Panel, Points, Series, VERMILLION};
use super::words::words;
use crate::figure::shown;
use crate::run::{Curve, Responded, Trace};
use crate::trust::profile::Profile;

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

/// Where the searches from many starts ended, the least cost first, over that least cost.
pub(super) fn waterfall(costs: &[f64]) -> Panel {
    let least = costs.first().copied().unwrap_or(0.0);
    let rank: Vec<f64> = (1..=costs.len()).map(|k| k as f64).collect();
    // a logarithm of nothing: the least itself stands at the agreement that is asked for
    let above = costs.iter().map(|cost| (cost - least).max(1e-6)).collect();
    Panel {
        x: Axis::linear("search, in the order of its end"),
        y: Axis::logarithmic("cost above the least"),
        series: vec![
            Series::Dashes(points(
                "ends that count as the same",
                GREEN,
                &[1.0, costs.len().max(2) as f64],
                vec![1e-3, 1e-3],
            )),
            Series::Dots(points("end of a search", BLUE, &rank, above)),
        ],
        marks: Vec::new(),
    }
}

/// The profile of a parameter: least cost over its value, and the level of a 95 % interval.
pub(super) fn profile(profile: &Profile, unit: &str) -> Panel {
    let (factor, shown) = shown(unit);
    let values = scaled(&profile.values, factor);
    let rise = profile.rise.iter().map(|r| r.unwrap_or(f64::NAN)).collect();
    let ends = [values.first(), values.last()].map(|v| v.copied().unwrap_or(0.0));
    let mark = |value: Option<f64>, name: &str| {
        value.map(|x| Mark {
            x: factor * x,
            name: name.into(),
        })
    };
    Panel {
        x: Axis::linear(format!("{} [{shown}]", words(&profile.name))),
        y: Axis::linear("rise of the least cost"),
        series: vec![
            Series::Line(points("profile", BLUE, &values, rise)),
            Series::Dashes(points("95 %", VERMILLION, &ends, vec![profile.level; 2])),
        ],
        marks: [
            mark(profile.lower, "lower"),
            mark(Some(profile.value), "estimate"),
            mark(profile.upper, "upper"),
        ]
        .into_iter()
        .flatten()
        .collect(),
    }
}

/// Measured and expected frequency responses: magnitude, phase and coherence of each channel.
pub(super) fn responses(responses: &[Responded]) -> Vec<Panel> {
    let panel = |r: &Responded, y: Axis, measured: &[f64], model: Option<&[f64]>| {
        let mut series = vec![Series::Dots(points(
            "measured",
            BLACK,
            &r.frequency,
            measured.to_vec(),
        ))];
        series.extend(model.map(|y| Series::Line(points("model", BLUE, &r.frequency, y.to_vec()))));
        Panel {
            x: Axis::linear("frequency [Hz]"),
            y,
            series,
            marks: Vec::new(),
        }
    };
    let panels = |r: &Responded| {
        let name = words(&r.channel);
        [
            panel(
                r,
                Axis::linear(format!("{name}, magnitude [dB]")),
                &r.magnitude,
                Some(&r.expected_magnitude),
            ),
            panel(
                r,
                Axis::linear(format!("{name}, phase [°]")),
                &r.phase,
                Some(&r.expected_phase),
            ),
            panel(
                r,
                Axis::linear(format!("{name}, coherence")),
                &r.coherence,
                None,
            ),
        ]
    };
    responses.iter().flat_map(panels).collect()
}
