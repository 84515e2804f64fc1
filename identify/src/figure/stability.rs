//! Eigenvalues by mode over speed or over a row of the table, and the map of both.

use super::canvas::{
    BLACK, BLUE, Drawn, GREEN, Mark, ORANGE, PURPLE, SKY, VERMILLION, WIDTH, axes, px, stacked,
    stroke,
};
use super::{decimated, range, shown, words};
use crate::stability::{Crossing, Point, Stability};
use bicycle::modes::{Mode, Root};
use plotters::element::{Circle, PathElement, Rectangle};
use plotters::style::{Color, RGBAColor, RGBColor};
use std::f64::consts::TAU;
use std::ops::Range;

/// Eigenvalues over the speed, over the swept row at one speed, or, where both vary, the map of
/// growth with the weave and the capsize speed in it.
pub fn stability(found: &Stability) -> String {
    let first = found.points.first().map(|point| point.speed);
    let single = found.points.iter().all(|point| Some(point.speed) == first);
    match found.row {
        Some(_) if !single => map(found),
        _ => curves(found),
    }
}

fn colour(mode: Mode) -> RGBColor {
    match mode {
        Mode::Weave => BLUE,
        Mode::Capsize => VERMILLION,
        Mode::Castering => GREEN,
        Mode::Wobble => PURPLE,
        Mode::Tyre => ORANGE,
    }
}

/// The axis along which a sweep goes: its name with unit, and where each point lies.
fn axis(found: &Stability) -> (String, Vec<f64>) {
    let Some(row) = found.row else {
        let speeds = found.points.iter().map(|point| point.speed);
        return ("speed [m/s]".into(), speeds.collect());
    };
    let (factor, unit) = shown(row.unit.symbol);
    let value = |point: &Point| factor * point.value.unwrap_or(f64::NAN);
    let label = format!("{} [{unit}]", words(row.name));
    (label, found.points.iter().map(value).collect())
}

/// A number that is drawn of each eigenvalue, and a speed of each value.
type Part = fn(&Root) -> f64;
type Speed = fn(&Crossing) -> Option<f64>;

/// What is seen below zero of the real parts: fast decaying modes would flatten all others.
const DEPTH: f64 = 2.0;

fn curves(found: &Stability) -> String {
    let (label, x) = axis(found);
    let roots = || found.points.iter().flat_map(|point| &point.roots);
    let present = |mode: &Mode| roots().any(|root| root.mode == *mode);
    let modes: Vec<Mode> = Mode::ALL.into_iter().filter(present).collect();
    let entry = |mode: &Mode| (Mark::Line(colour(*mode)), mode.name().to_owned());
    let entries: Vec<_> = modes.iter().map(entry).collect();
    let slow = roots().filter(|root| matches!(root.mode, Mode::Weave | Mode::Capsize));
    let slow = range(slow.map(|root| root.value.re).chain([0.0]));
    let deepest = range(roots().map(|root| root.value.re)).start;
    let growth = deepest.max(slow.start - DEPTH * (slow.end - slow.start))..slow.end;
    let swings = 0.0..range(roots().map(|root| root.value.im / TAU)).end;
    let panels: [(&str, Range<f64>, Part); 2] = [
        ("growth [1/s]", growth, |root| root.value.re),
        ("frequency [Hz]", swings, |root| root.value.im.abs() / TAU),
    ];
    stacked(&entries, panels.len(), |nth, panel| {
        let (y_label, y, part) = &panels[nth];
        let ends = range(x.iter().copied());
        let x_label = (nth + 1 == panels.len()).then_some(label.as_str());
        let mut chart = axes(panel, x_label, ends.clone(), y_label, y.clone())?;
        let zero = [(ends.start, 0.0), (ends.end, 0.0)];
        chart.draw_series([PathElement::new(zero, stroke(BLACK.into(), 0.8))])?;
        for mode in &modes {
            for rank in 0..Mode::ALL.len() {
                let of_rank = |point: &Point| {
                    let mut own = point.roots.iter().filter(|root| root.mode == *mode);
                    own.nth(rank).map_or(f64::NAN, part)
                };
                let values = found.points.iter().map(of_rank);
                let line: Vec<(f64, f64)> = x.iter().copied().zip(values).collect();
                // what leaves the panel, and what is not there, breaks the line
                for piece in line.split(|(_, value)| !y.contains(value)) {
                    let style = stroke(colour(*mode).into(), 1.4);
                    let seen = decimated(piece, &ends, WIDTH as usize);
                    chart.draw_series([PathElement::new(seen, style)])?;
                }
            }
        }
        if let (0, None, [only]) = (nth, found.row, &found.crossings[..]) {
            let speeds = [(only.weave_speed, BLUE), (only.capsize_speed, VERMILLION)];
            let marks = speeds
                .into_iter()
                .filter_map(|(speed, colour)| Some((speed?, colour)))
                .filter(|(speed, _)| ends.contains(speed));
            chart.draw_series(
                marks.map(|(speed, colour)| Circle::new((speed, 0.0), px(3.0), colour.filled())),
            )?;
        }
        Ok(())
    })
}

/// Steps of growth [1/s] that the map tells apart, and how it shades them: what grows slower than
/// .5 1/s doubles in more than a second, which a rider holds without effort (assumed).
const SHADES: [(f64, RGBColor, f64, &str); 3] = [
    (0.0, GREEN, 0.25, "all modes decay"),
    (0.5, SKY, 0.25, "slow growth, below .5 1/s"),
    (f64::INFINITY, ORANGE, 0.25, "faster growth"),
];

fn shade(growth: f64) -> Option<usize> {
    SHADES.iter().position(|(most, ..)| growth <= *most)
}

fn map(found: &Stability) -> String {
    let (label, _) = axis(found);
    let factor = found.row.map_or(1.0, |row| shown(row.unit.symbol).0);
    let mut entries = vec![
        (Mark::Line(BLUE), "weave speed".to_owned()),
        (Mark::Line(VERMILLION), "capsize speed".into()),
        (Mark::Line(BLACK), "edge of stability".into()),
    ];
    let tint =
        |(_, colour, alpha, _): &(f64, RGBColor, f64, &str)| -> RGBAColor { colour.mix(*alpha) };
    entries.extend(
        SHADES
            .iter()
            .map(|shade| (Mark::Area(tint(shade)), shade.3.into())),
    );
    let mut columns: Vec<&[Point]> = found.points.chunk_by(|a, b| a.value == b.value).collect();
    columns.sort_by(|a, b| a[0].value.partial_cmp(&b[0].value).expect("numbers"));
    let mut crossings: Vec<&Crossing> = found.crossings.iter().collect();
    crossings.sort_by(|a, b| a.value.partial_cmp(&b.value).expect("numbers"));
    let values: Vec<f64> = columns
        .iter()
        .map(|column| factor * column[0].value.unwrap_or(f64::NAN))
        .collect();
    let borders = borders(&values);
    let x = borders[0]..borders[values.len()];
    let y = found.searched.0..found.searched.1;
    stacked(&entries, 1, |_, panel| {
        let mut chart = axes(panel, Some(&label), x.clone(), "speed [m/s]", y.clone())?;
        for (column, sides) in columns.iter().zip(borders.windows(2)) {
            let mut points: Vec<&Point> = column.iter().collect();
            points.sort_by(|a, b| a.speed.total_cmp(&b.speed));
            let speeds: Vec<f64> = points.iter().map(|point| point.speed).collect();
            let edges = edges(&speeds);
            let mut from = 0;
            for run in points.chunk_by(|a, b| shade(a.growth()) == shade(b.growth())) {
                let to = from + run.len();
                let corners = [(sides[0], edges[from]), (sides[1], edges[to])];
                if let Some(nth) = shade(run[0].growth()) {
                    let fill = tint(&SHADES[nth]).filled();
                    chart.draw_series([Rectangle::new(corners, fill)])?;
                }
                from = to;
            }
        }
        for (crossing, sides) in crossings.iter().zip(borders.windows(2)) {
            // where the search ends nothing changes
            let edges = crossing.stable_speeds.iter().flatten();
            for edge in edges.filter(|edge| **edge != y.start && **edge != y.end) {
                let across = [(sides[0], *edge), (sides[1], *edge)];
                chart.draw_series([PathElement::new(across, stroke(BLACK.into(), 0.9))])?;
            }
        }
        let lines: [(Speed, RGBColor); 2] = [
            (|crossing| crossing.weave_speed, BLUE),
            (|crossing| crossing.capsize_speed, VERMILLION),
        ];
        for (speed, colour) in lines {
            let point = |c: &Crossing| (factor * c.value.unwrap_or(f64::NAN), speed(c));
            let line: Vec<_> = crossings.iter().copied().map(point).collect();
            for piece in line.split(|(_, speed)| speed.is_none()) {
                let known = piece.iter().filter_map(|(x, speed)| Some((*x, (*speed)?)));
                let path = PathElement::new(known.collect::<Vec<_>>(), stroke(colour.into(), 2.0));
                chart.draw_series([path])?;
            }
        }
        Drawn::Ok(())
    })
}

/// Halfway between neighbours, and as far beyond the ends.
fn borders(values: &[f64]) -> Vec<f64> {
    let inner = edges(values);
    match values {
        [] => vec![0.0, 1.0],
        [only] => vec![only - 0.5, only + 0.5],
        [first, .., last] => {
            let mut all = inner;
            let n = all.len();
            all[0] = 2.0 * first - all[1];
            all[n - 1] = 2.0 * last - all[n - 2];
            all
        }
    }
}

/// Halfway between neighbours, and the ends.
fn edges(values: &[f64]) -> Vec<f64> {
    let halfway = values.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    let ends = (values.first().copied(), values.last().copied());
    ends.0.into_iter().chain(halfway).chain(ends.1).collect()
}
