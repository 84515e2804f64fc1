//! Where a report comes from: program, ride, bicycle, and how to make it again.

use super::markup::{cell, escape, paragraph, symbol, table};
use super::number::{exact, exact_with_unit};
use super::words::words;
use crate::bicycles::{Bicycle, Changes};
use crate::figure::shown;
use crate::free::{Candidate, Free, Scope};
use crate::model::Spec;
use crate::plan::Plan;
use crate::ride::base;
use crate::run::{Recorded, Run};
use std::fmt::Write as _;

/// Definition lists, command line, and the values that differ from the nominal ones.
pub(super) fn provenance(run: &Run) -> String {
    let mut text = String::new();
    for ride in &run.rides {
        text += &origin(ride, run);
    }
    let _ = writeln!(text, "<pre>{}</pre>", escape(&command(run)));
    for ride in &run.rides {
        text += &values(ride, run.rides.len() > 1);
    }
    text
}

fn origin(ride: &Recorded, run: &Run) -> String {
    let (source, start) = (&ride.source, &ride.start);
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
    if !ride.condition.is_empty() {
        entry("Condition", &ride.condition);
    }
    entry("Bicycle", &start.bicycle);
    match &run.asked.model {
        Spec::Equations => entry("Formulation", &start.formulation),
        Spec::Simulated(_) => entry("Formulation", &format!("{}, simulated", start.formulation)),
        Spec::Fmu { origin, .. } => {
            entry("Model", &origin.file);
            entry("SHA-256", &origin.sha256);
            if let Some(sha256) = &origin.fmu_sha256 {
                entry("SHA-256 of its FMU", sha256);
            }
        }
    }
    entry(
        "Speed",
        &format!(
            "{} where the ride does not record it",
            exact_with_unit(start.speed, "m/s")
        ),
    );
    entry("Seed", &run.asked.effort.seed.to_string());
    text + "</dl>\n"
}

/// The values of a ride's bicycle that differ from the nominal ones.
fn values(ride: &Recorded, several: bool) -> String {
    let of = if several {
        format!(" of {}", base(&ride.source.file))
    } else {
        String::new()
    };
    let rows = ride.start.rows.iter();
    let rows: Vec<_> = rows
        .filter_map(|(name, value)| changed(name, *value))
        .collect();
    if rows.is_empty() {
        let text = format!("Every parameter{of} started at its nominal value.");
        return paragraph("text", &text);
    }
    let text = format!("Start and held values{of} that differ from the nominal ones:");
    let heads = ["parameter", "symbol", "value", "nominal", "unit"].map(str::to_owned);
    paragraph("text", &text) + &table("values", &heads, &rows)
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

/// The fit as it would be typed; the same result comes of it.
fn command(run: &Run) -> String {
    let (fit, asked) = (&run.fit, &run.asked);
    let mut words = vec!["wobble fit".into()];
    match &asked.study {
        Some(study) => words.push(format!("--study {}", quoted(study))),
        None => words.extend(ridden(run)),
    }
    let mut option = |name: &str, value: String| words.push(format!("--{name} {value}"));
    match &asked.model {
        Spec::Equations => {}
        Spec::Simulated(_) => option("model", "simulated".into()),
        Spec::Fmu { origin, .. } => option("model", quoted(&origin.file)),
    }
    if let Some(count) = asked.model.seeds().and_then(|seeds| seeds.count) {
        option("seeds", count.to_string());
    }
    if let Some(windows) = &asked.windows {
        option("windows", quoted(windows));
    }
    option("objective", fit.objective.name().into());
    option("channels", fit.channels.join(","));
    let names: Vec<&str> = asked.free.iter().map(|p| p.name.as_str()).collect();
    option("free", names.join(","));
    for p in &asked.free {
        let Ok(usual) = Free::new(&p.name) else {
            continue;
        };
        if (usual.lower, usual.upper) != (p.lower, p.upper) {
            option("bounds", format!("{}={}:{}", p.name, p.lower, p.upper));
        }
        if usual.scope != p.scope {
            let scope = match p.scope {
                Scope::Shared => "shared",
                Scope::Condition => "per-condition",
                Scope::Ride => "per-ride",
            };
            option(scope, p.name.clone());
        }
        if usual.scale != p.scale {
            option("log", p.name.clone());
        }
        if let Some(prior) = p.prior {
            let (mean, deviation) = (prior.mean, prior.deviation);
            option("prior", format!("{}={mean}:{deviation}", p.name));
        }
    }
    for (follower, leader) in &asked.ties {
        option("tie", format!("{follower}={leader}"));
    }
    for (channel, noise) in fit.channels.iter().zip(asked.noise.iter().flatten()) {
        option("noise", format!("{channel}={noise}"));
    }
    if let Some(window) = asked.window {
        option("window", window.to_string());
    }
    if !fit.objective.is_replayed() {
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
    let effort = &asked.effort;
    option("seed", effort.seed.to_string());
    for (name, count) in [
        ("starts", effort.starts as u64),
        ("population", effort.population),
        ("bootstrap", effort.bootstrap),
    ] {
        if count > 0 {
            option(name, count.to_string());
        }
    }
    for (name, is_asked) in [("profile", effort.profiles), ("reduce", effort.reduce)] {
        if is_asked {
            words.push(format!("--{name}"));
        }
    }
    words.join(" ")
}

/// The rides as they would be typed, how they are read, and the bicycle that was ridden: rides that
/// no study names share them.
fn ridden(run: &Run) -> Vec<String> {
    let Recorded { source, start, .. } = &run.rides[0];
    let mut words: Vec<String> = run
        .rides
        .iter()
        .map(|ride| quoted(&ride.source.file))
        .collect();
    let mut option = |name: &str, value: String| words.push(format!("--{name} {value}"));
    // an FMU is the bicycle itself
    if !matches!(run.asked.model, Spec::Fmu { .. }) {
        option("bicycle", quoted(&start.bicycle));
        option("formulation", start.formulation.clone());
    }
    option("set", format!("speed={}", start.speed));
    // what was changed of the bicycle; of a file that is gone, against the nominal one
    let known = Bicycle::open(&start.bicycle, &Changes::default());
    let known = known.map_or_else(
        |_| Candidate::default(),
        |bicycle| Candidate {
            parameters: bicycle.parameters,
            excitation: bicycle.excitation,
            ..Candidate::default()
        },
    );
    // where every spectral fit starts unless told
    let started = Plan::default().excitation.remnant_intensity;
    for (name, value) in &start.rows {
        let own = Free::new(name).map_or(*value, |free| known.get(&free));
        if *value != own && (name != "remnant_intensity" || *value != started) {
            option("set", format!("{name}={value}"));
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
    if source.resample {
        words.push("--resample".into());
    }
    words
}

/// A word of a command line, in quotes where a shell would take it apart.
pub fn quoted(word: &str) -> String {
    if word
        .chars()
        .all(|c| c.is_alphanumeric() || "._-/:=,+%@\\".contains(c))
    {
        word.into()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}
