//! A sweep as one HTML file that needs nothing else.

use super::words::{by_value, ranges, short, speed};
use super::{Crossing, Plan, Point, Stability};
use crate::figure;
use crate::report::markup::{self, FOOT, cell, escape, head, list, paragraph, section};
use bicycle::modes::Root;

/// Rows of the table of eigenvalues: more are in the JSON.
const MOST_ROWS: usize = 500;

/// The page of what was found of `plan`; `name` is the bicycle's, `command` what was typed.
pub fn html(plan: &Plan, found: &Stability, name: &str, command: &str) -> String {
    let heading = match found.row {
        Some(row) => format!("Stability of {name} over {}", row.name.replace('_', " ")),
        None => format!("Stability of {name}"),
    };
    let law = if plan.rider_law {
        "with its rider law in the loop"
    } else {
        "without a rider law"
    };
    let about = format!("{} equations, {law}, upright", plan.formulation.name());
    let svg = figure::stability(found);
    let caption = if found.row.is_some() && plan.speeds.len() > 1 {
        format!("{MAP} {NAMES}")
    } else {
        format!("{CURVES} {NAMES}")
    };
    let mut page = head(&heading, &heading);
    page += &paragraph("about", &about);
    page += &section("Modes", &markup::figure(&svg, &caption));
    let (from, to) = found.searched;
    let asked = format!("Looked for between {from} and {to} m/s; of several the lowest.");
    page += &section(
        "Weave and capsize speed",
        &(crossings(found) + &paragraph("text", &asked)),
    );
    page += &section("Eigenvalues", &eigenvalues(found));
    if !found.notes.is_empty() {
        page += &section("Notes", &list(&found.notes));
    }
    let program = concat!("wobble ", env!("CARGO_PKG_VERSION"));
    let origin = format!("<pre>{}</pre>", escape(command));
    page += &section("Provenance", &(paragraph("text", program) + &origin));
    page + FOOT
}

const CURVES: &str = "Eigenvalues of the bicycle upright, by mode: where the real part is above \
    zero the mode grows. What decays much faster than weave and capsize is not drawn.";
const MAP: &str = "Shaded is the growth of whichever mode grows fastest, of the bicycle upright.";
const NAMES: &str = "Modes have their names from riding speed, carried along by eigenvector: a \
    pair that splits on the real axis keeps its name for both.";

fn crossings(found: &Stability) -> String {
    let mut heads: Vec<String> = row_head(found).into_iter().collect();
    let kinds = [
        "weave speed [m/s]",
        "capsize speed [m/s]",
        "every mode decays [m/s]",
    ];
    heads.extend(kinds.map(str::to_owned));
    let row = |crossing: &Crossing| {
        let mut cells = [crossing.weave_speed, crossing.capsize_speed]
            .map(speed)
            .to_vec();
        cells.push(ranges(&crossing.stable_speeds));
        line(crossing.value.map(|v| format!("{v:.4}")), cells)
    };
    let rows: Vec<_> = found.crossings.iter().map(row).collect();
    markup::table("crossings", &heads, &rows)
}

fn row_head(found: &Stability) -> Option<String> {
    let row = found.row?;
    Some(format!("{} [{}]", row.name, escape(row.unit.symbol)))
}

/// A row of a table whose first cell is its head.
fn line(value: Option<String>, cells: Vec<String>) -> (String, Vec<String>) {
    let mut all = value.into_iter().chain(cells);
    let head = all.next().unwrap_or_default();
    (
        escape(&head),
        all.map(|text| cell(&escape(&text))).collect(),
    )
}

fn eigenvalues(found: &Stability) -> String {
    let mut heads: Vec<String> = row_head(found).into_iter().collect();
    heads.extend(["speed [m/s]", "eigenvalues [1/s]"].map(str::to_owned));
    let row = |point: &Point| {
        let named = |root: &Root| Some(format!("{} {}", root.mode.name(), short(root)?));
        let roots: Vec<_> = point.roots.iter().filter_map(named).collect();
        let speed = format!("{:.4}", point.speed);
        let value = point.value.map(|v| format!("{v:.4}"));
        line(value, vec![speed, roots.join(", ")])
    };
    // a whole map is no table: evenly every so many
    let stride = found.points.len().div_ceil(MOST_ROWS).max(1);
    let rows: Vec<_> = found.points.iter().step_by(stride).map(row).collect();
    let text = markup::table("eigenvalues", &heads, &rows);
    if stride == 1 {
        return text;
    }
    let values = by_value(found).len();
    let said = format!(
        "One point in {stride} of {} at {values} values; --json has all.",
        found.points.len()
    );
    text + &paragraph("text", &said)
}
