//! Where a report comes from: program, ride, bicycle, and how to make it again.

use super::markup::{cell, escape, paragraph, symbol, table};
use super::number::{exact, exact_with_unit};
use super::words::words;
use crate::figure::shown;
use crate::free::Free;
use crate::objective::Objective;
use crate::plan::Plan;
use crate::run::Run;
use std::fmt::Write as _;

/// Definition list, command line, and the values that differ from the nominal ones.
pub(super) fn provenance(run: &Run) -> String {
    let source = &run.ride;
    let mut text = String::from("<dl>\n");
    let mut entry = |name: &str, value: &str| {
        let _ = writeln!(text, "<dt>{name}</dt><dd>{}</dd>", escape(value));
    };
    entry("Program", &run.program);
    entry("Ride", &source.file);
    entry(
        "SHA-256",
        if source.sha256.is_empty() {
            "not from a file"
        } else {
            &source.sha256
        },
    );
    entry("Channel map", source.map.as_deref().unwrap_or("none"));
    if let Some(rate) = source.rate {
        entry("Rate given", &exact_with_unit(rate, "Hz"));
    }
    if let Some((start, stop)) = source.times {
        entry(
            "Stretch used",
            &format!("{} to {}", exact(start), exact_with_unit(stop, "s")),
        );
    }
    entry("Bicycle", &run.start.bicycle);
    entry("Formulation", &run.start.formulation);
    entry(
        "Speed",
        &format!(
            "{} where the ride does not record it",
            exact_with_unit(run.start.speed, "m/s")
        ),
    );
    entry("Seed", &run.asked.seed.to_string());
    let _ = writeln!(text, "</dl>\n<pre>{}</pre>", escape(&command(run)));
    let rows: Vec<_> = run
        .start
        .rows
        .iter()
        .filter_map(|(name, value)| changed(name, *value))
        .collect();
    if rows.is_empty() {
        return text + &paragraph("text", "Every parameter started at its nominal value.");
    }
    text += &paragraph(
        "text",
        "Start and held values that differ from the nominal ones:",
    );
    let heads = ["parameter", "symbol", "value", "nominal", "unit"].map(str::to_owned);
    text + &table("values", &heads, &rows)
}

/// The row of a parameter, if `value` [SI] differs from the nominal one.
fn changed(name: &str, value: f64) -> Option<(String, Vec<String>)> {
    let Free { row, .. } = Free::new(name)
        .ok()
        .filter(|free| free.row.nominal != value)?;
    let (factor, unit) = shown(row.unit.symbol);
    let numbers = [value, row.nominal].map(|value| exact(factor * value));
    let cells = [symbol(row.symbol)]
        .into_iter()
        .chain(numbers)
        .chain([unit]);
    Some((
        escape(&words(name)),
        cells.map(|text| cell(&text)).collect(),
    ))
}

/// The fit as it would be typed. What was changed of another set than the nominal one is not in
/// it: the table of values has it.
fn command(run: &Run) -> String {
    let (fit, source, asked) = (&run.fit, &run.ride, &run.asked);
    let mut words = vec!["wobble fit".into(), quoted(&source.file)];
    let mut option = |name: &str, value: String| words.push(format!("--{name} {value}"));
    option("bicycle", quoted(&run.start.bicycle));
    option("formulation", run.start.formulation.clone());
    option("set", format!("speed={}", run.start.speed));
    if run.start.bicycle == "nominal" {
        // where every spectral fit starts unless told
        let started = Plan::default().excitation.remnant_intensity;
        for (name, value) in &run.start.rows {
            let nominal = Free::new(name).map_or(*value, |free| free.row.nominal);
            if *value != nominal && (name != "remnant_intensity" || *value != started) {
                option("set", format!("{name}={value}"));
            }
        }
    }
    if let Some(map) = &source.map {
        option("map", quoted(map));
    }
    if let Some(rate) = source.rate {
        option("rate", rate.to_string());
    }
    if let Some((start, stop)) = source.times {
        option("times", format!("{start}:{stop}"));
    }
    option("objective", fit.objective.name().into());
    option("channels", fit.channels.join(","));
    let names: Vec<&str> = fit.parameters.iter().map(|p| p.name.as_str()).collect();
    option("free", names.join(","));
    for p in &fit.parameters {
        let whole =
            Free::new(&p.name).is_ok_and(|free| (free.lower, free.upper) == (p.lower, p.upper));
        if !whole {
            option("bounds", format!("{}={}:{}", p.name, p.lower, p.upper));
        }
    }
    for (channel, noise) in fit.channels.iter().zip(asked.noise.iter().flatten()) {
        option("noise", format!("{channel}={noise}"));
    }
    if fit.objective == Objective::Time {
        option("window", asked.window.to_string());
    } else {
        option(
            "band",
            format!("{}:{}", asked.recipe.band.0, asked.recipe.band.1),
        );
        option("average", asked.recipe.average.to_string());
        for line in &asked.recipe.lines {
            option("line", line.frequency.to_string());
        }
    }
    option("max-iterations", asked.max_iterations.to_string());
    option("seed", asked.seed.to_string());
    if source.resample {
        words.push("--resample".into());
    }
    words.join(" ")
}

/// A word of a command line, in quotes where a shell would take it apart.
fn quoted(word: &str) -> String {
    if word
        .chars()
        .all(|c| c.is_alphanumeric() || "._-/:\\".contains(c))
    {
        word.into()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}
