//! A study as one HTML file that needs nothing else.

use super::words::{changed, headline, interval, or_nothing, oscillation, reasons};
use super::{Comparison, Falls, JUDGED, Known, Modes, Motor, Outcome, PathError, Study, Worth};
use crate::compare::BANDS;
use crate::figure;
use crate::report::markup::{FOOT, cell, escape, figure, head, list, paragraph, section, table};
use crate::report::number::{exact, exact_with_unit, significant, with_unit};
use crate::report::table::NOTHING;
use crate::report::words::capitalised;
use crate::ride::quantity;

/// The page of a study; `provenance` is how it was made, as it would be typed.
pub fn html(study: &Study, provenance: &str) -> String {
    let heading = format!("What {} is worth", study.controller);
    let (first, rest) = headline(study).split_first().map_or_else(
        || (String::new(), Vec::new()),
        |(first, rest)| (first.clone(), rest.to_vec()),
    );
    let pairs: Vec<usize> = study.rows.iter().map(|row| row.pairs).collect();
    let (fewest, most) = (pairs.iter().min(), pairs.iter().max());
    let seeds = match (fewest, most) {
        (Some(a), Some(b)) if a == b => a.to_string(),
        (Some(a), Some(b)) => format!("{a} to {b}"),
        _ => "no".into(),
    };
    let about =
        format!("Rides of the same seed without and with the assist, {seeds} of each a case");
    let (low, high) = BANDS[JUDGED];
    let mut page = head(&heading, &heading);
    page += &paragraph("about", &about);
    page += &paragraph("result", &first);
    page += &list(&rest);
    page += &section(&format!("{low} to {high} Hz at a glance"), &glance(study));
    page += &section("Spectra", &figure(&figure::assist(study), SPECTRA));
    page += &section(
        "Steering by band",
        &(bands(study) + &paragraph("text", INTERVAL)),
    );
    page += &section("Motor", &(motor(study) + &paragraph("text", MOTOR)));
    page += &section(
        "Course and falls",
        &(rides(study) + &paragraph("text", RIDES)),
    );
    page += &section(
        "Closed loop",
        &(closed_loop(study) + &paragraph("text", LOOP)),
    );
    let missing = reasons(study);
    if !missing.is_empty() {
        page += &section(&format!("What {NOTHING} stands for"), &list(&missing));
    }
    let recipe = &study.recipe;
    let mut notes = vec![format!(
        "Spectra: residual of a moving average over {}, bins from {} to {}.",
        exact_with_unit(recipe.average, "s"),
        exact(recipe.band.0),
        exact_with_unit(recipe.band.1, "Hz")
    )];
    notes.extend(recipe.lines.iter().map(|line| {
        let line = exact_with_unit(line.frequency, "Hz");
        format!("The line at {line} is left out of spectra and bands.")
    }));
    notes.extend(study.notes.iter().map(|note| capitalised(note) + "."));
    page += &section("Notes", &list(&notes));
    let program = concat!("wobble ", env!("CARGO_PKG_VERSION"));
    let origin = format!("<pre>{}</pre>\n", escape(provenance));
    page += &section("Provenance", &(paragraph("text", program) + &origin));
    page + FOOT
}

const SPECTRA: &str = "Residual steering without and with the assist: mean power over the seeds, \
    as amplitude of a sine on each bin. Shaded is the band that the assist is judged by; the number \
    is what it leaves of the root mean square there. Panels beside each other share their scale.";
const INTERVAL: &str = "Root mean square of the residual steering with the assist over that \
    without, below it both and the 95 % interval of the ratio, from its scatter over the pairs of \
    rides (of a single pair: both taken for noise of their own). Falls or rises: the interval does \
    not hold 1. Pairs of which a ride fell are left out.";
const MOTOR: &str = "Delivered is what the motor puts into the steering; net is that less what it \
    takes out by braking. Energies are those of one ride, mean power is delivered energy over its \
    length.";
const RIDES: &str = "Beside the course: root mean square and largest distance over the rides. Half \
    had fallen: time by which half of all rides had; – where fewer fell.";
const LOOP: &str = "Of bicycle, rider and controller, linearised: the oscillation of least damping \
    ratio, and the largest real part of the eigenvalues; where that is above zero something grows.";

/// A word on a coloured ground.
fn badge(class: &str, text: &str) -> String {
    let class = class.replace(' ', "-");
    format!("<span class=\"verdict {class}\">{}</span>", escape(text))
}

fn small(text: &str) -> String {
    format!("<small>{}</small>", escape(text))
}

/// A ratio on the colour of its verdict.
fn ratio(c: &Comparison) -> String {
    badge(c.verdict.name(), &c.to_string())
}

/// Who fell, on the colour of the outcome; nothing where all stood.
fn outcome(row: &Worth) -> String {
    let name = row.outcome.name();
    match row.outcome {
        Outcome::Stood => String::new(),
        _ => badge(name, name) + &small(&row.fell()),
    }
}

fn glance(study: &Study) -> String {
    let (down, across) = study.labels();
    let change = |row: &Worth| {
        let judged = row.judged();
        judged.map_or_else(String::new, |c| ratio(c) + &small(&interval(c))) + &outcome(row)
    };
    let line = |down: &String| {
        let cells = across.iter().map(|across| {
            let row = study.at(down, across);
            cell(&row.map_or_else(|| NOTHING.into(), change))
        });
        (escape(down), cells.collect())
    };
    let rows: Vec<_> = down.iter().map(line).collect();
    let mut heads = vec![String::new()];
    heads.extend(across.iter().map(|label| escape(label)));
    table("glance", &heads, &rows)
}

/// A table with a line a case.
fn by_case(
    study: &Study,
    class: &str,
    heads: &[&str],
    cells: impl Fn(&Worth) -> Vec<String>,
) -> String {
    let mut all = vec!["case".to_owned()];
    all.extend(heads.iter().map(|head| escape(head)));
    let line = |row: &Worth| {
        let cells = cells(row);
        (
            escape(&row.case.to_string()),
            cells.iter().map(|c| cell(c)).collect(),
        )
    };
    let rows: Vec<_> = study.rows.iter().map(line).collect();
    table(class, &all, &rows)
}

fn bands(study: &Study) -> String {
    let heads = BANDS.map(|(low, high)| format!("{low} to {high} Hz"));
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let unit = quantity(super::STEER).map_or("", |row| row.unit.symbol);
    let change = |c: &Comparison| {
        let rms = changed(&c.rms, |rms| with_unit(*rms, unit, 3));
        ratio(c) + &small(&format!("{rms}; {}", interval(c)))
    };
    by_case(study, "worth", &heads, |row| {
        let bands = row.bands.iter();
        bands.map(|band| or_nothing(&band.change, change)).collect()
    })
}

fn motor(study: &Study) -> String {
    type Column = (&'static str, fn(&Motor) -> f64);
    let columns: [Column; 5] = [
        ("peak torque [N m]", |m| m.peak_torque),
        ("rms torque [N m]", |m| m.rms_torque),
        ("delivered [J]", |m| m.delivered_energy),
        ("net [J]", |m| m.net_energy),
        ("mean power [W]", |m| m.mean_power),
    ];
    by_case(
        study,
        "worth motor",
        &columns.map(|column| column.0),
        |row| {
            let number = |(_, value): Column| or_nothing(&row.motor, |m| significant(value(m), 3));
            columns.map(number).to_vec()
        },
    )
}

fn rides(study: &Study) -> String {
    let heads = [
        "rms beside course [m]",
        "largest [m]",
        "fell",
        "half had fallen [s]",
    ];
    by_case(study, "worth", &heads, |row| {
        let path = |part: fn(&PathError) -> f64| {
            changed(&row.path, |path| {
                or_nothing(path, |p| significant(part(p), 3))
            })
        };
        let time = |falls: &Falls| or_nothing(&falls.median_time, |time| significant(*time, 3));
        let fell = match row.outcome {
            Outcome::Stood => row.fell(),
            _ => outcome(row),
        };
        let (rms, largest) = (path(|p| p.rms), path(|p| p.largest));
        vec![rms, largest, fell, changed(&row.falls, time)]
    })
}

fn closed_loop(study: &Study) -> String {
    let heads = ["least damping ratio", "growth [1/s]"];
    by_case(study, "worth", &heads, |row| {
        let growth = |modes: &Known<Modes>| or_nothing(modes, |m| significant(m.growth, 3));
        vec![oscillation(row), changed(&row.modes, growth)]
    })
}
