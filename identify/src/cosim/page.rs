//! A coupled run as one HTML file that needs nothing else.

use super::PLANT;
use super::coupling::Ran;
use crate::figure::{self, Drawn, shown};
use crate::report::markup::{self, FOOT, cell, escape, head, list, paragraph, section};
use crate::report::number::significant;
use bicycle::course::LATERAL_OFFSET;
use fmi_import::master::End;

/// The page of a run; `provenance` is how it was made, as it would be typed.
pub fn html(ran: &Ran, provenance: &str) -> String {
    let heading = "A coupled run";
    let drawn = drawn(ran);
    let time = &ran.run.columns[0];
    let connections: Vec<String> = ran.connections.iter().map(ToString::to_string).collect();
    let mut page = head(heading, heading);
    page += &paragraph("result", &ended(ran));
    page += &section(
        "What travelled",
        &markup::figure(
            &figure::coupled(time, &drawn),
            "Values at the communication points; in between inputs are held.",
        ),
    );
    page += &section("In numbers", &numbers(&drawn));
    page += &section("Connections", &list(&connections));
    if !ran.loops.is_empty() {
        page += &section("Algebraic loops", &list(&ran.loops));
    }
    let program = concat!("wobble ", env!("CARGO_PKG_VERSION"));
    let origin = format!("<pre>{}</pre>", escape(provenance));
    page += &section("Provenance", &(paragraph("text", program) + &origin));
    page + FOOT
}

/// How the run ended, in a sentence.
fn ended(ran: &Ran) -> String {
    let run = &ran.run;
    let last = run.columns[0].last().copied().unwrap_or(0.0);
    let steps = match run.taken_back {
        0 => format!("{} communication steps", run.steps),
        back => format!("{} communication steps, {back} taken back", run.steps),
    };
    match &run.end {
        End::Complete => format!("To the stop at {last} s in {steps}."),
        End::Stopped => format!("Stopped at {last} s after {steps}."),
        End::Early { member, time, .. } => {
            format!("{member} ended early, at {time} s, after {steps}.")
        }
        End::Failed(error) => format!("Failed after {steps}: {error}."),
    }
}

/// What is worth a curve: what travels between FMUs, the steering, the way beside a course.
fn drawn(ran: &Ran) -> Vec<Drawn<'_>> {
    let mut names = ["roll", "steer", LATERAL_OFFSET.name]
        .map(str::to_owned)
        .to_vec();
    names.extend(
        ran.between_fmus()
            .map(|c| match c.source.participant.as_str() {
                PLANT => c.source.variable.clone(),
                _ => c.source.to_string(),
            }),
    );
    let columns = ran.run.names.iter().zip(&ran.units).zip(&ran.run.columns);
    let wanted = columns.filter(|((name, _), _)| names.contains(name));
    wanted
        .map(|((name, unit), values)| Drawn {
            name,
            unit: unit.as_deref().unwrap_or("1"),
            values,
        })
        .collect()
}

fn numbers(drawn: &[Drawn]) -> String {
    let heads = ["", "smallest", "largest", "root mean square"].map(str::to_owned);
    let row = |curve: &Drawn| {
        let (factor, unit) = shown(curve.unit);
        let values = || curve.values.iter().map(|value| factor * value);
        let mean = values().map(|v| v * v).sum::<f64>() / curve.values.len().max(1) as f64;
        let found = [
            values().fold(f64::INFINITY, f64::min),
            values().fold(f64::NEG_INFINITY, f64::max),
            mean.sqrt(),
        ];
        let cells = found.map(|value| cell(&escape(&significant(value, 3))));
        (escape(&format!("{} [{unit}]", curve.name)), cells.into())
    };
    markup::table(
        "numbers",
        &heads,
        &drawn.iter().map(row).collect::<Vec<_>>(),
    )
}
