//! Spectra without and with an assist: small multiples, cases down and across.

use super::canvas::{
    Area, BLACK, BLUE, Drawn, GREEN, GREY, LETTER, LINE, Mark, VERMILLION, grid, stroke, write,
};
use super::multiples::multiples;
use super::{points, range, shown, stretches};
use crate::assist::{JUDGED, Outcome, Pair, STEER, Study, Worth};
use crate::compare::{BANDS, Change};
use crate::ride::quantity;
use plotters::element::Rectangle;
use plotters::series::LineSeries;
use plotters::style::{Color, RGBColor};

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
    let (factor, unit) = shown(quantity(STEER).map_or("", |row| row.unit.symbol));
    let frequencies = || study.rows.iter().flat_map(|row| &row.spectra.frequency);
    let x = if frequencies().next().is_some() {
        range(frequencies().copied())
    } else {
        study.recipe.band.0..study.recipe.band.1
    };
    multiples(&entries, (&down, &across), |panel, place| {
        let down = &down[place.down];
        let row = across.iter().filter_map(|across| study.at(down, across));
        let amplitudes = row.flat_map(curves);
        let amplitudes = amplitudes.flat_map(|(amplitude, _)| amplitude.iter().copied());
        // room above for the words
        let y = 0.0..1.3 * factor * range(amplitudes.chain([0.0])).end;
        let Some(worth) = study.at(down, &across[place.across]) else {
            return Ok(());
        };
        let y_label = format!("steer [{unit}]");
        let labels = (
            place.is_last.then_some("frequency [Hz]"),
            (place.across == 0).then_some(y_label.as_str()),
        );
        let mut chart = grid(panel, labels, (x.clone(), y.clone()), (4, 4))?;
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
        say(panel, place.right, worth)
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
