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

/// Signals of the ride and of the model over time, a panel a channel, each curve of about `most`
/// points. Windows that cover less than half of the time stand side by side.
pub(super) fn traces(traces: &[Trace], most: usize) -> Vec<Panel> {
    let panel = |trace: &Trace| {
        let (factor, unit) = shown(&trace.unit);
        let placed = Placed::of(trace);
        let curve = |name, colour, y: &[f64]| {
            let (x, y) = placed.curve(&scaled(y, factor));
            let (x, y) = thinned(&x, &y, most);
            Series::Line(points(name, colour, &x, y))
        };
        Panel {
            x: Axis::linear(placed.label),
            y: Axis::linear(format!("{} [{unit}]", words(&trace.channel))),
            series: vec![
                curve("measured", GREY, &trace.measured),
                curve("model", VERMILLION, &trace.model),
            ],
            marks: placed.marks.clone(),
        }
    };
    traces.iter().map(panel).collect()
}

/// Where the samples of a trace are drawn.
struct Placed<'a> {
    trace: &'a Trace,
    label: &'static str,
    /// Start of each window on the axis; empty where all are drawn at their own time.
    starts: Vec<f64>,
    marks: Vec<Mark>,
}

/// Windows up to this number are named.
const NAMED: usize = 12;

impl<'a> Placed<'a> {
    fn of(trace: &'a Trace) -> Self {
        let plain = Self {
            trace,
            label: "time [s]",
            starts: Vec::new(),
            marks: Vec::new(),
        };
        if !trace.is_sparse() {
            return plain;
        }
        let (mut starts, mut marks, mut at) = (Vec::new(), Vec::new(), 0.0);
        for window in &trace.windows {
            let (from, to) = (trace.time[window.start], trace.time[window.end - 1]);
            let named = trace.windows.len() <= NAMED;
            marks.push(Mark {
                x: at,
                name: if named {
                    format!("{from:.1} s")
                } else {
                    String::new()
                },
            });
            starts.push(at);
            // a tenth of a window between two
            at += 1.1 * (to - from);
        }
        Self {
            label: "windows side by side, each over its own time [s]",
            starts,
            marks,
            ..plain
        }
    }

    /// The curve of `y`, with a gap between windows.
    fn curve(&self, y: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let time = &self.trace.time;
        if self.trace.windows.is_empty() {
            return (time.clone(), y.to_vec());
        }
        let (mut xs, mut ys) = (Vec::new(), Vec::new());
        for (k, window) in self.trace.windows.iter().enumerate() {
            let own = time[window.start];
            let start = self.starts.get(k).copied().unwrap_or(own);
            xs.extend(time[window.clone()].iter().map(|t| t - own + start));
            ys.extend_from_slice(&y[window.clone()]);
            xs.extend(xs.last().copied());
            ys.push(f64::NAN);
        }
        (xs, ys)
    }
}

/// A curve of about `most` points: the extremes of every few neighbours, in their order; gaps stay.
fn thinned(x: &[f64], y: &[f64], most: usize) -> (Vec<f64>, Vec<f64>) {
    if x.len() <= most {
        return (x.to_vec(), y.to_vec());
    }
    let half = x.len().div_ceil(most.max(2));
    let (mut xs, mut ys) = (Vec::new(), Vec::new());
    for (x, y) in x.chunks(2 * half).zip(y.chunks(2 * half)) {
        let by = |a: &usize, b: &usize| y[*a].total_cmp(&y[*b]);
        let finite = || (0..y.len()).filter(|&i| y[i].is_finite());
        if let (Some(least), Some(largest)) = (finite().min_by(by), finite().max_by(by)) {
            // on an even grid of their own, which is three numbers
            let places = [0, half.min(x.len() - 1)];
            for (place, k) in places
                .into_iter()
                .zip([least.min(largest), least.max(largest)])
            {
                xs.push(x[place]);
                ys.push(y[k]);
            }
        }
        if y.iter().any(|v| !v.is_finite()) {
            xs.push(x[x.len() - 1]);
            ys.push(f64::NAN);
        }
    }
    (xs, ys)
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Two windows of three samples, 10 s apart.
    fn windows() -> Trace {
        Trace {
            channel: "steer".into(),
            unit: "1".into(),
            time: vec![1.0, 1.1, 1.2, 11.0, 11.1, 11.2],
            windows: vec![0..3, 3..6],
            measured: vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
            model: vec![0.0; 6],
        }
    }

    #[test]
    fn windows_far_apart_stand_side_by_side_and_no_line_joins_them() {
        let panels = traces(&[windows()], 100);
        let Series::Line(Points { x, y, .. }) = &panels[0].series[0] else {
            panic!("a line");
        };
        let gaps: Vec<bool> = y.iter().map(|v| v.is_nan()).collect();
        assert_eq!(gaps, [false, false, false, true, false, false, false, true]);
        assert!(x.is_sorted() && x[7] < 0.5, "{x:?}");
        let names: Vec<&str> = panels[0].marks.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["1.0 s", "11.0 s"]);
        assert_eq!(windows().residuals(), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    }

    #[test]
    fn a_thinned_curve_keeps_its_extremes_in_their_order() {
        let x: Vec<f64> = (0..1000).map(f64::from).collect();
        let mut y = vec![0.0; 1000];
        (y[400], y[407], y[999]) = (7.0, -5.0, 3.0);
        let (xs, ys) = thinned(&x, &y, 100);
        assert_eq!(xs.len(), ys.len());
        assert!(ys.len() <= 100 && xs.is_sorted(), "{}", ys.len());
        let seen: Vec<f64> = ys.into_iter().filter(|v| *v != 0.0).collect();
        assert_eq!(seen, [7.0, -5.0, 3.0]);
        assert_eq!(thinned(&x, &y, 1000), (x, y));
    }
}
