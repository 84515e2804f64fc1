//! Spectra without and with an assist: small multiples, cases down and across.

use super::canvas::{
    Area, BELOW, BLACK, BLUE, Drawn, GREEN, GREY, LEFT, LEFT_BARE, LETTER, LINE, Mark, RIGHT,
    VERMILLION, WIDTH, grid, minus, panels, px, stroke, under_legend, write,
};
use super::{points, range, shown, stretches};
use crate::assist::{JUDGED, Outcome, Pair, STEER, Study, Worth};
use crate::compare::{BANDS, Change};
use crate::ride::quantity;
use plotters::element::Rectangle;
use plotters::series::LineSeries;
use plotters::style::{Color, RGBColor};

/// Height of a panel without its labels [px].
const HEIGHT: f64 = 112.0;

/// Height of the labels above them, apart from the legend [px].
const HEADS: f64 = 1.5 * LINE;

/// The residual steering spectra of a study, a panel a case; panels beside each other share their
/// scale. In each what the assist leaves of the band it is judged by, and who fell.
pub fn assist(study: &Study) -> String {
    let (low, high) = BANDS[JUDGED];
    let shade = GREY.mix(0.13);
    let entries = [
        (Mark::Line(BLACK), "without the assist".to_owned()),
        (Mark::Line(BLUE), "with it".into()),
        (Mark::Area(shade), format!("{low} to {high} Hz")),
    ];
    let (down, across) = study.labels();
    let columns = across.len().max(1) as f64;
    let beside = LEFT + RIGHT + (columns - 1.0) * (LEFT_BARE + RIGHT);
    let plot = ((f64::from(WIDTH) - beside) / columns).max(1.0);
    let left = |nth: usize| match nth {
        0 => 0.0,
        n => LEFT - LEFT_BARE + n as f64 * (LEFT_BARE + plot + RIGHT),
    };
    let (factor, unit) = shown(quantity(STEER).map_or("", |row| row.unit.symbol));
    let frequencies = || study.rows.iter().flat_map(|row| &row.spectra.frequency);
    let x = if frequencies().next().is_some() {
        range(frequencies().copied())
    } else {
        study.recipe.band.0..study.recipe.band.1
    };
    let height = HEADS + down.len() as f64 * (LINE + HEIGHT) + BELOW;
    under_legend(&entries, height, |root| {
        for (nth, label) in across.iter().enumerate() {
            let bare = if nth == 0 { LEFT } else { LEFT_BARE };
            write(root, (left(nth) + bare, HEADS - LINE), &minus(label), BLACK)?;
        }
        let (_, rest) = root.split_vertically(px(HEADS));
        let lines = panels(&rest, down.len(), LINE + HEIGHT);
        for ((line, down), nth) in lines.iter().zip(&down).zip(1..) {
            write(line, (LEFT, 0.0), &minus(down), BLACK)?;
            let (_, line) = line.split_vertically(px(LINE));
            let x_label = (nth == lines.len()).then_some("frequency [Hz]");
            let row: Vec<_> = across.iter().map(|across| study.at(down, across)).collect();
            let amplitudes = row.iter().flatten().flat_map(|worth| curves(worth));
            let amplitudes = amplitudes.flat_map(|(amplitude, _)| amplitude.iter().copied());
            // room above for the words
            let y = 0.0..1.3 * factor * range(amplitudes.chain([0.0])).end;
            for (nth, worth) in row.iter().enumerate() {
                let Some(worth) = worth else { continue };
                let width = left(nth + 1) - left(nth);
                let size = (px(width) as u32, line.dim_in_pixel().1);
                let panel = line.clone().shrink((px(left(nth)), 0), size);
                let y_label = format!("steer [{unit}]");
                let y_label = (nth == 0).then_some(y_label.as_str());
                let ranges = (x.clone(), y.clone());
                let mut chart = grid(&panel, (x_label, y_label), ranges, (4, 4))?;
                let corners = [(low.max(x.start), 0.0), (high.min(x.end), y.end)];
                chart.draw_series([Rectangle::new(corners, shade.filled())])?;
                let frequency = &worth.spectra.frequency;
                for (amplitude, colour) in curves(worth) {
                    let curve = points(frequency, amplitude.iter().map(|a| factor * a));
                    for stretch in stretches(frequency) {
                        let piece = curve[stretch].iter().copied();
                        chart.draw_series(LineSeries::new(piece, stroke(colour.into(), 1.3)))?;
                    }
                }
                say(&panel, width - RIGHT - 4.0, worth)?;
            }
        }
        Ok(())
    })
}

/// The spectra that there are, with their colours.
fn curves(worth: &Worth) -> impl Iterator<Item = (&[f64], RGBColor)> {
    let Pair { without, with } = &worth.spectra.amplitude;
    let both = [(without, BLACK), (with, BLUE)];
    both.into_iter()
        .filter_map(|(amplitude, colour)| Some((amplitude.value()?.as_slice(), colour)))
}

/// What becomes of the judged band and who fell, in lines that end at `right` [px].
fn say(panel: &Area, right: f64, worth: &Worth) -> Drawn {
    let change = worth.judged().map(|c| {
        let colour = match c.verdict {
            Change::Falls => GREEN,
            Change::Rises => VERMILLION,
            Change::None => GREY,
        };
        (c.to_string(), colour)
    });
    let fell = (worth.outcome != Outcome::Stood).then(|| {
        let colour = if worth.outcome == Outcome::Saved {
            GREEN
        } else {
            VERMILLION
        };
        (worth.fell(), colour)
    });
    for (nth, (text, colour)) in change.into_iter().chain(fell).enumerate() {
        let width = LETTER * text.chars().count() as f64;
        let at = (right - width, 9.0 + 0.8 * LINE * nth as f64);
        write(panel, at, &text, colour)?;
    }
    Ok(())
}
