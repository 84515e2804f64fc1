//! A sweep as JSON, as a table of plain text, and in notes.

use super::{Crossing, Plan, Point, Stability};
use bicycle::modes::Root;
use serde_json::{Map, Value, json};
use std::fmt::Write as _;

/// What the numbers of a plan rest on.
pub(super) fn notes(plan: &Plan, found: &Stability) -> Vec<String> {
    let mut notes = left_out(plan, true);
    let p = &plan.parameters;
    if plan.rider_law && p.riderless() == *p {
        notes.push("this bicycle has no rider law: all its gains are 0".into());
    }
    if let (Some(row), Some((first, rest))) = (found.row, by_value(found).split_first()) {
        let same = |points: &&[Point]| {
            let mut both = points.iter().zip(*first);
            both.all(|(a, b)| a.roots == b.roots)
        };
        if !rest.is_empty() && rest.iter().all(same) {
            let name = row.name;
            let formulation = plan.formulation.name();
            let law = if !plan.rider_law && name.starts_with("rider_") {
                " without its rider law"
            } else {
                ""
            };
            notes.push(format!("{name} plays no part in {formulation}{law}"));
        }
    }
    notes
}

/// What a linear system does not have.
pub(super) fn left_out(plan: &Plan, upright: bool) -> Vec<String> {
    let mut notes = Vec::new();
    let swept = plan.sweep.as_ref().map(|sweep| sweep.row.name);
    if plan.parameters.coulomb_friction != 0.0 || swept == Some("coulomb_friction") {
        notes.push(
            "Coulomb friction is a jump without a linear part and is left out: it holds the \
             steering in motions too small to overcome it"
                .into(),
        );
    }
    if upright && !plan.formulation.has_four_bodies() {
        notes.push(
            "upright, the trail's jump with sign θ has no linear part and is left out".into(),
        );
    }
    notes
}

/// The points of each value.
pub(super) fn by_value(found: &Stability) -> Vec<&[Point]> {
    found.points.chunk_by(|a, b| a.value == b.value).collect()
}

fn row(name: Option<&str>, value: Option<f64>) -> Map<String, Value> {
    let named = name.zip(value);
    named
        .map(|(name, value)| (name.to_owned(), json!(value)))
        .into_iter()
        .collect()
}

/// `{"rows": […], "weave_speed": …, "capsize_speed": …, "stable_speeds": [[from, to]…],
/// "searched": [from, to], "notes": […]}`; with a swept row, rows carry its value and the speeds stand
/// in `"crossings"`, one for each value.
pub fn to_json(found: &Stability) -> Value {
    let name = found.row.map(|row| row.name);
    let point = |point: &Point| {
        let mut fields = row(name, point.value);
        let pair = |root: &Root| json!([root.value.re, root.value.im]);
        let mode = |root: &Root| root.mode.name();
        fields.insert("speed".into(), json!(point.speed));
        let values = point.roots.iter().map(pair).collect();
        fields.insert("eigenvalues".into(), Value::Array(values));
        fields.insert("modes".into(), point.roots.iter().map(mode).collect());
        Value::Object(fields)
    };
    let crossing = |crossing: &Crossing| {
        let mut fields = row(name, crossing.value);
        fields.insert("weave_speed".into(), json!(crossing.weave_speed));
        fields.insert("capsize_speed".into(), json!(crossing.capsize_speed));
        fields.insert("stable_speeds".into(), json!(crossing.stable_speeds));
        fields
    };
    let mut whole = Map::new();
    whole.insert(
        "rows".into(),
        found.points.iter().map(point).collect::<Vec<_>>().into(),
    );
    match (name, &found.crossings[..]) {
        (None, [only]) => whole.extend(crossing(only)),
        (_, all) => {
            let all: Vec<Value> = all.iter().map(|c| Value::Object(crossing(c))).collect();
            whole.insert("crossings".into(), all.into());
        }
    }
    whole.insert("searched".into(), json!(found.searched));
    whole.insert("notes".into(), json!(found.notes));
    Value::Object(whole)
}

/// An eigenvalue in short; of a pair its upper member, none for the lower.
pub(super) fn short(root: &Root) -> Option<String> {
    let (re, im) = (root.value.re, root.value.im);
    match im {
        0.0 => Some(format!("{re:.3}")),
        im if im > 0.0 => Some(format!("{re:.3} ± {im:.3}i")),
        _ => None,
    }
}

/// A speed in short; – where there is none.
pub(super) fn speed(value: Option<f64>) -> String {
    value.map_or_else(|| "–".into(), |value| format!("{value:.4}"))
}

/// Ranges of speeds in short.
pub(super) fn ranges(ranges: &[[f64; 2]]) -> String {
    let one = |[from, to]: &[f64; 2]| format!("{from:.4} to {to:.4}");
    let all: Vec<_> = ranges.iter().map(one).collect();
    if all.is_empty() {
        "none".into()
    } else {
        all.join(", ")
    }
}

/// The sweep as a table: a line a point, then the weave and capsize speeds.
pub fn table(found: &Stability) -> String {
    let head = found.row.map_or_else(String::new, |row| {
        format!("{:>18}  ", format!("{} [{}]", row.name, row.unit.symbol))
    });
    let value = |value: Option<f64>| {
        value.map_or_else(String::new, |v| format!("{:>18}  ", format!("{v:.6}")))
    };
    let mut text = format!("{head}speed [m/s]  eigenvalues [1/s]\n");
    for point in &found.points {
        let roots = point.roots.iter();
        let named = roots.filter_map(|root| Some(format!("{} {}", root.mode.name(), short(root)?)));
        let named = named.collect::<Vec<_>>().join("  ");
        let _ = writeln!(text, "{}{:11.4}  {named}", value(point.value), point.speed);
    }
    let (from, to) = found.searched;
    let _ = writeln!(
        text,
        "\n{head}weave speed [m/s]  capsize speed [m/s]  every mode decays [m/s]; looked for at \
         {from} to {to} m/s"
    );
    for crossing in &found.crossings {
        let (weave, capsize) = (speed(crossing.weave_speed), speed(crossing.capsize_speed));
        let stable = ranges(&crossing.stable_speeds);
        let value = value(crossing.value);
        let _ = writeln!(text, "{value}{weave:>17}  {capsize:>19}  {stable}");
    }
    text
}
