//! What loads do to the spectrum of a channel: the paper's Figs. 8 to 10 as small multiples.

use super::canvas::{BLACK, BLUE, GREEN, GREY, LETTER, Mark, VERMILLION, grid, px, stroke, write};
use super::multiples::multiples;
use super::{range, shown, words};
use crate::compare::{Cell, Change, Level, Loads, Shift};
use plotters::element::{Circle, Polygon, Rectangle};
use plotters::series::LineSeries;
use plotters::style::{Color, RGBColor};

/// The colour of a verdict.
fn colour(change: Change) -> RGBColor {
    match change {
        Change::Rises => VERMILLION,
        Change::Falls => GREEN,
        Change::None => GREY,
    }
}

/// The residual with and without a load, slice by slice of the spectrum, a panel a rider and trail;
/// panels beside each other share their scale. Shaded are the 95 % intervals; dots are slices in
/// which the load changes something, numbers are the ratios in the bands.
pub fn loads(found: &Loads) -> String {
    let mut entries = vec![
        (Mark::Line(BLACK), "smallest load".to_owned()),
        (Mark::Line(BLUE), "with the load".into()),
        (Mark::Dot(VERMILLION), "rises".into()),
        (Mark::Dot(GREEN), "falls".into()),
    ];
    if !found.lines.is_empty() {
        entries.push((Mark::Area(GREY.mix(0.2)), "line left out".into()));
    }
    let (down, across) = found.labels();
    let (factor, unit) = shown(found.unit);
    let ends = |shift: &Shift| [shift.low, shift.high];
    let frequencies = found
        .cells
        .iter()
        .flat_map(|cell| &cell.slices)
        .flat_map(ends);
    let x = range(frequencies);
    let y_label = format!("{} [{unit}]", words(&found.channel));
    multiples(&entries, (&down, &across), |panel, place| {
        let row = across
            .iter()
            .filter_map(|across| found.at(&down[place.down], across));
        let tops = row
            .flat_map(|cell| &cell.slices)
            .map(|s| s.with.interval.1.max(s.without.interval.1));
        // room above for the words
        let y = 0.0..1.3 * factor * range(tops.chain([0.0])).end;
        let Some(cell) = found.at(&down[place.down], &across[place.across]) else {
            return Ok(());
        };
        let labels = (
            place.is_last.then_some("frequency [Hz]"),
            (place.across == 0).then_some(y_label.as_str()),
        );
        let mut chart = grid(panel, labels, (x.clone(), y.clone()), (4, 4))?;
        for line in &found.lines {
            let corners = [(line - 0.02, 0.0), (line + 0.02, y.end)];
            chart.draw_series([Rectangle::new(corners, GREY.mix(0.2).filled())])?;
        }
        for (is_with, colour) in [(false, BLACK), (true, BLUE)] {
            let side = |s: &Shift| if is_with { s.with } else { s.without };
            let at = |value: fn(&Level) -> f64| {
                let point = move |shift: &Shift| (middle(shift), factor * value(&side(shift)));
                cell.slices.iter().map(point)
            };
            let outline: Vec<_> = at(|l| l.interval.0)
                .chain(at(|l| l.interval.1).rev())
                .collect();
            chart.draw_series([Polygon::new(outline, colour.mix(0.12).filled())])?;
            chart.draw_series(LineSeries::new(at(|l| l.rms), stroke(colour.into(), 1.3)))?;
        }
        let changed = cell
            .slices
            .iter()
            .filter(|slice| slice.verdict != Change::None);
        let dots = changed.map(|slice| {
            let at = (middle(slice), factor * slice.with.rms);
            Circle::new(at, px(3.0), colour(slice.verdict).filled())
        });
        chart.draw_series(dots)?;
        for (nth, (text, colour)) in ratios(cell).into_iter().enumerate() {
            let width = LETTER * text.chars().count() as f64;
            let at = (place.right - width, 9.0 + 15.0 * nth as f64);
            write(panel, at, &text, colour)?;
        }
        Ok(())
    })
}

fn middle(shift: &Shift) -> f64 {
    0.5 * (shift.low + shift.high)
}

/// What becomes of the bands, in words with their colours.
fn ratios(cell: &Cell) -> Vec<(String, RGBColor)> {
    let ratio = |shift: &Shift| {
        let text = format!("{} to {} Hz × {:.2}", shift.low, shift.high, shift.ratio);
        (text, colour(shift.verdict))
    };
    cell.bands.iter().map(ratio).collect()
}
