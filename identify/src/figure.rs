//! Figures as SVG text: the same input gives the same bytes. Angles are shown in degrees.
//!
//! Only this module names plotters.

mod assist;
mod canvas;
mod compare;
mod coupled;
mod multiples;
mod rides;
mod stability;
#[cfg(test)]
pub(crate) mod tests;

pub use assist::assist;
pub use compare::loads;
pub use coupled::{Drawn, coupled};
pub use rides::{channels, lines};
pub use stability::stability;

use crate::run::{Curve, Trace};
use bicycle::cases::{Course, DURATION, Rearward, TRAILS};
use bicycle::simulate::Stop;
use canvas::{
    BELOW, BLACK, BLUE, GREEN, GREY, LINE, Mark, ORANGE, PANEL, PURPLE, SKY, VERMILLION, WIDTH,
    axes, minus, panels, px, stacked, stroke, svg, write,
};
use plotters::element::{Circle, PathElement, Polygon, Rectangle};
use plotters::series::LineSeries;
use plotters::style::{Color, RGBColor};
use std::ops::Range;

type Points = Vec<(f64, f64)>;

/// Factor from SI to the unit that is shown, and its symbol: degrees for angles.
pub fn shown(unit: &str) -> (f64, String) {
    let degrees = 180.0 / std::f64::consts::PI;
    match unit {
        "rad" => (degrees, "°".into()),
        "rad/s" => (degrees, "°/s".into()),
        "rad/s2" => (degrees, "°/s²".into()),
        _ => (1.0, unit.replace('.', "\u{a0}").replace('2', "²")),
    }
}

/// Cases as in the paper's Fig. 4: a panel a trail, a colour a centre of mass or a load. Beside
/// each curve's name its largest steer angle after the first second, or where it ended.
pub fn cases(courses: &[Course]) -> String {
    let of = |trail: f64| courses.iter().filter(move |c| c.case.trail == trail);
    let mut shown: Vec<Rearward> = Vec::new();
    for course in courses {
        if !shown.contains(&course.case.rearward) {
            shown.push(course.case.rearward);
        }
    }
    let colour = |course: &Course| {
        let mut pairs = shown.iter().zip(colours());
        pairs.find_map(|(shown, colour)| (*shown == course.case.rearward).then_some(colour))
    };
    let most = TRAILS.map(|trail| of(trail).count()).into_iter().max();
    let legend = |curves: usize| 44.0 + 2.0 * LINE * curves as f64;
    let height = PANEL.max(legend(most.unwrap_or(0)) + LINE);
    svg(TRAILS.len() as f64 * height + BELOW, |root| {
        let areas = panels(root, TRAILS.len(), height);
        for ((trail, panel), last) in TRAILS.iter().zip(areas).zip(1..) {
            let (plot, aside) = panel.split_horizontally(px(530.0));
            let curves: Vec<(&Course, RGBColor, Points)> = of(*trail)
                .map(|course| {
                    let steer = course.steer.iter().map(|s| s.to_degrees());
                    let colour = colour(course).unwrap_or(BLACK);
                    (course, colour, points(&course.time, steer))
                })
                .collect();
            let steer = range(curves.iter().flat_map(|(.., points)| points).map(|p| p.1));
            let x = (last == TRAILS.len()).then_some("time [s]");
            let mut chart = axes(&plot, x, 0.0..DURATION, "steer [°]", steer)?;
            write(
                &aside,
                (12.0, 20.0),
                &minus(&format!("trail {trail:.3} m")),
                BLACK,
            )?;
            for (nth, (course, colour, points)) in curves.into_iter().enumerate() {
                let columns = decimated(&points, &(0.0..DURATION), 430);
                chart.draw_series(LineSeries::new(columns, stroke(colour.into(), 1.3)))?;
                let end = points.last().filter(|_| course.stop.is_some()).copied();
                chart.draw_series(end.map(|end| Circle::new(end, px(3.0), colour.filled())))?;
                let y = legend(nth);
                Mark::Line(colour).draw(&aside, (12.0, y), &name_of(course))?;
                let below = (12.0, y + 0.9 * LINE);
                if course.stop.is_some() {
                    Mark::Dot(colour).draw(&aside, below, &end_of(course))?;
                } else {
                    write(
                        &aside,
                        (below.0 + Mark::WIDTH, below.1),
                        &end_of(course),
                        BLACK,
                    )?;
                }
            }
        }
        Ok(())
    })
}

/// Colours of curves, in their order, without end.
fn colours() -> impl Iterator<Item = RGBColor> {
    [BLUE, VERMILLION, ORANGE, GREEN, PURPLE, SKY, BLACK]
        .into_iter()
        .cycle()
}

/// What sets a case apart from the others of its trail.
fn name_of(course: &Course) -> String {
    match course.case.rearward {
        Rearward::CogToRear(x) => format!("cog at {x:.2} m"),
        Rearward::RearLoad(mass) => format!("{mass} kg of load"),
    }
}

/// How a case went, in words.
fn end_of(course: &Course) -> String {
    match (course.stop, course.amplitude()) {
        (Some(Stop::SteerLimit { t }), _) => format!("steer limit at {t:.3} s"),
        (Some(Stop::Diverged { t }), _) => format!("fell at {t:.3} s"),
        (None, Some(amplitude)) => format!("up to {:.2}° after 1 s", amplitude.to_degrees()),
        (None, None) => String::new(),
    }
}

/// Measured spectra over those of a fitted model, a panel a channel: the model's mean and the
/// band that holds 95 % of the amplitudes of one ride. `lines` [Hz] were left out of the fit.
pub fn spectrum(curves: &[Curve], lines: &[f64]) -> String {
    let mut entries = vec![
        (Mark::Dot(BLACK), "measured".to_owned()),
        (Mark::Line(BLUE), "fitted model, mean".into()),
        (
            Mark::Area(BLUE.mix(0.18)),
            "95 % of single rides of the model".into(),
        ),
    ];
    if !lines.is_empty() {
        entries.push((Mark::Area(GREY.mix(0.2)), "line left out".into()));
    }
    stacked(&entries, curves.len(), |nth, panel| {
        let curve = &curves[nth];
        let (factor, unit) = shown(&curve.unit);
        let scaled = |y: &[f64]| points(&curve.frequency, y.iter().map(|y| factor * y));
        let [measured, expected, low, high] =
            [&curve.measured, &curve.expected, &curve.low, &curve.high].map(|y| scaled(y));
        let y = 0.0..range(measured.iter().chain(&high).map(|p| p.1)).end;
        let x = range(curve.frequency.iter().copied());
        let x_label = (nth + 1 == curves.len()).then_some("frequency [Hz]");
        let y_label = format!("{} [{unit}]", words(&curve.channel));
        let mut chart = axes(panel, x_label, x.clone(), &y_label, y.clone())?;
        for line in lines {
            let gap = gap(&curve.frequency, *line);
            let corners = [(gap.start, y.start), (gap.end, y.end)];
            chart.draw_series([Rectangle::new(corners, GREY.mix(0.2).filled())])?;
        }
        for stretch in stretches(&curve.frequency) {
            let outline = low[stretch.clone()]
                .iter()
                .chain(high[stretch.clone()].iter().rev());
            let band = Polygon::new(
                outline.copied().collect::<Vec<_>>(),
                BLUE.mix(0.18).filled(),
            );
            chart.draw_series([band])?;
            let path =
                |y: &[(f64, f64)], style| PathElement::new(y[stretch.clone()].to_vec(), style);
            chart.draw_series([path(&measured, stroke(GREY.mix(0.6), 0.7))])?;
            chart.draw_series([path(&expected, stroke(BLUE.into(), 1.6))])?;
        }
        let dots = measured
            .iter()
            .map(|p| Circle::new(*p, px(1.9), BLACK.filled()));
        chart.draw_series(dots)?;
        Ok(())
    })
}

/// Signals of a ride and of a model over time, a panel a channel.
pub fn traces(traces: &[Trace]) -> String {
    let entries = [
        (Mark::Line(BLACK), "measured".to_owned()),
        (Mark::Line(VERMILLION), "model".into()),
    ];
    stacked(&entries, traces.len(), |nth, panel| {
        let trace = &traces[nth];
        let (factor, unit) = shown(&trace.unit);
        let scaled = |y: &[f64]| points(&trace.time, y.iter().map(|y| factor * y));
        let (measured, model) = (scaled(&trace.measured), scaled(&trace.model));
        let y = range(measured.iter().chain(&model).map(|p| p.1));
        let x =
            trace.time.first().copied().unwrap_or(0.0)..trace.time.last().copied().unwrap_or(1.0);
        let x_label = (nth + 1 == traces.len()).then_some("time [s]");
        let y_label = format!("{} [{unit}]", words(&trace.channel));
        let mut chart = axes(panel, x_label, x.clone(), &y_label, y)?;
        for (signal, colour) in [(measured, BLACK.mix(0.75)), (model, VERMILLION.mix(0.85))] {
            // no line from one window to the next
            let whole = 0..signal.len();
            let windows = if trace.windows.is_empty() {
                std::slice::from_ref(&whole)
            } else {
                &trace.windows
            };
            for window in windows {
                let columns = decimated(&signal[window.clone()], &x, WIDTH as usize);
                chart.draw_series(LineSeries::new(columns, stroke(colour, 0.9)))?;
            }
        }
        Ok(())
    })
}

/// Amplitude spectra in one panel: label, frequencies [Hz] and amplitudes in `unit` (SI) of
/// each.
pub fn comparison(spectra: &[(String, &[f64], &[f64])], unit: &str) -> String {
    let label =
        |((label, ..), colour): (&(String, &[f64], &[f64]), _)| (Mark::Line(colour), label.clone());
    let entries: Vec<_> = spectra.iter().zip(colours()).map(label).collect();
    let (factor, unit) = shown(unit);
    stacked(&entries, 1, |_, panel| {
        let y = range(spectra.iter().flat_map(|s| s.2).map(|a| factor * a)).end;
        let x = range(spectra.iter().flat_map(|s| s.1).copied());
        let y_label = format!("amplitude [{unit}]");
        let mut chart = axes(panel, Some("frequency [Hz]"), x, &y_label, 0.0..y)?;
        for ((_, frequency, amplitude), colour) in spectra.iter().zip(colours()) {
            let curve = points(frequency, amplitude.iter().map(|a| factor * a));
            for stretch in stretches(frequency) {
                let curve = curve[stretch].iter().copied();
                chart.draw_series(LineSeries::new(curve, stroke(colour.into(), 1.3)))?;
            }
        }
        Ok(())
    })
}

/// A name of the tables as words.
fn words(name: &str) -> String {
    name.replace('_', " ")
}

/// Points of a curve; what is not finite is left at zero height.
fn points(x: &[f64], y: impl Iterator<Item = f64>) -> Points {
    x.iter()
        .copied()
        .zip(y.map(|y| if y.is_finite() { y } else { 0.0 }))
        .collect()
}

/// The range of `values` with a margin; never empty.
fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let ends = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
            (a.min(v), b.max(v))
        });
    match ends {
        (low, high) if low < high => low - 0.05 * (high - low)..high + 0.05 * (high - low),
        (low, high) if low == high => low - 1.0..high + 1.0,
        _ => 0.0..1.0,
    }
}

/// The extremes of a signal in each of `columns` of the range `x`, in their order in time: what
/// the eye can see of it.
fn decimated(signal: &[(f64, f64)], x: &Range<f64>, columns: usize) -> Vec<(f64, f64)> {
    if signal.len() <= 2 * columns {
        return signal.to_vec();
    }
    let column = |t: f64| ((t - x.start) / (x.end - x.start) * columns as f64) as usize;
    let extremes = |chunk: &[(f64, f64)]| {
        let order = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let (low, high) = (chunk.iter().min_by(order), chunk.iter().max_by(order));
        let mut both: Vec<(f64, f64)> = low.into_iter().chain(high).copied().collect();
        both.sort_by(|a, b| a.0.total_cmp(&b.0));
        both.dedup();
        both
    };
    signal
        .chunk_by(|a, b| column(a.0) == column(b.0))
        .flat_map(extremes)
        .collect()
}

/// The stretches of neighbouring bins: where bins were left out, a new one starts.
fn stretches(frequency: &[f64]) -> Vec<Range<usize>> {
    let spacing = frequency
        .windows(2)
        .map(|f| f[1] - f[0])
        .fold(f64::INFINITY, f64::min);
    let mut stretches = Vec::new();
    let mut start = 0;
    for chunk in frequency.chunk_by(|a, b| b - a < 1.5 * spacing) {
        stretches.push(start..start + chunk.len());
        start += chunk.len();
    }
    stretches
}

/// From the last bin below `line` to the first above it.
fn gap(frequency: &[f64], line: f64) -> Range<f64> {
    let below = frequency
        .iter()
        .copied()
        .filter(|f| *f < line)
        .fold(f64::NEG_INFINITY, f64::max);
    let above = frequency
        .iter()
        .copied()
        .filter(|f| *f > line)
        .fold(f64::INFINITY, f64::min);
    let or_line = |f: f64| if f.is_finite() { f } else { line };
    or_line(below)..or_line(above)
}
