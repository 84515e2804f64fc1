//! What was asked besides one search: starts, population, profiles, bootstrap, reduction.

use super::markup::{self, cell, escape, paragraph, section};
use super::number::{significant, with_unit};
use super::plot::plot;
use super::plots;
use super::words::words;
use crate::effort::{Agreement, Population};
use crate::fit::Fit;
use crate::free::Free;
use crate::trust::bootstrap::Resampled;
use crate::trust::insensitivity::Reduction;
use crate::trust::profile::Profile;
use crate::verdict::Estimate;
use std::fmt::Write as _;

/// The sections of what was asked.
pub(super) fn sections(fit: &Fit) -> String {
    let further = &fit.further;
    let mut page = String::new();
    if let Some(population) = &further.population {
        page += &section("Population", &paragraph("text", &searched(population)));
    }
    if let Some(starts) = &further.starts {
        page += &section("Starts", &waterfall(starts));
    }
    if !further.profiles.is_empty() {
        page += &section("Profiles", &profiles(&further.profiles, fit));
    }
    if let Some(bootstrap) = &further.bootstrap {
        page += &section("Bootstrap", &resampled(bootstrap, fit));
    }
    if let Some(reduction) = &further.reduction {
        page += &section("What the data can do without", &reduced(reduction));
    }
    page
}

fn searched(population: &Population) -> String {
    format!(
        "A population searched the whole box: {}, {} of {} points without a cost. Least cost {} \
         before a local search went on from there.",
        population.termination,
        population.failures,
        population.evaluations,
        significant(population.cost, 8)
    )
}

/// What came of many starts, in a sentence.
pub(super) fn agreement(starts: &Agreement) -> String {
    let mut text = format!(
        "{} of {} searches ended where the best did: at its cost to 1e-3 and at each determined \
         parameter to a tenth of its standard error.",
        starts.agreeing, starts.planned
    );
    if starts.failed > 0 {
        let _ = write!(text, " {} could not begin.", starts.failed);
    }
    if starts.passed_over > 0 {
        let _ = write!(
            text,
            " {} points of the box were passed over for starts: no model stands there.",
            starts.passed_over
        );
    }
    if starts.stopped {
        text += " It was stopped before all had ended.";
    }
    text
}

fn waterfall(starts: &Agreement) -> String {
    let figure = plot("starts", &[plots::waterfall(&starts.costs)], "", WATERFALL);
    paragraph("text", &agreement(starts)) + &figure
}

const WATERFALL: &str = "Steps are local minima; ends on the floor are one and the same.";
const PROFILE: &str = "Least cost with the parameter held, all others sought anew. Where a curve \
    does not rise to the dashed level on a side, the data leave that side open.";

fn unit_of(fit: &Fit, label: &str) -> String {
    let row = |p: &Estimate| (p.label() == label || p.name == label).then(|| p.unit.clone());
    fit.parameters.iter().find_map(row).unwrap_or_default()
}

fn profiles(profiles: &[Profile], fit: &Fit) -> String {
    let panels: Vec<_> = profiles
        .iter()
        .map(|p| plots::profile(p, &unit_of(fit, &p.name)))
        .collect();
    let row = |p: &Profile| {
        let unit = unit_of(fit, &p.name);
        let end = |v: Option<f64>| v.map_or_else(|| "open".into(), |v| with_unit(v, &unit, 3));
        let cells = [with_unit(p.value, &unit, 4), end(p.lower), end(p.upper)];
        (
            escape(&words(&p.name)),
            cells.map(|text| cell(&escape(&text))).to_vec(),
        )
    };
    let rows: Vec<_> = profiles.iter().map(row).collect();
    let heads = ["parameter", "estimate", "95 % from", "to"].map(str::to_owned);
    markup::table("profiles", &heads, &rows) + &plot("profiles", &panels, "", PROFILE)
}

fn resampled(bootstrap: &Resampled, fit: &Fit) -> String {
    let rows: Vec<_> = bootstrap
        .parameters
        .iter()
        .map(|row| {
            let unit = unit_of(fit, &row.name);
            let cells = row.scatter.map_or_else(
                || vec![cell("–"); 4],
                |s| {
                    let both = |(a, b): (f64, f64)| {
                        format!("{} to {}", significant(a, 3), with_unit(b, &unit, 3))
                    };
                    let cells = [
                        with_unit(s.std_error, &unit, 2),
                        with_unit(s.bias, &unit, 2),
                        both(s.percentile),
                        both(s.basic),
                    ];
                    cells.map(|text| cell(&escape(&text))).to_vec()
                },
            );
            (escape(&words(&row.name)), cells)
        })
        .collect();
    let heads = [
        "parameter",
        "std. error",
        "bias",
        "95 %, percentile",
        "95 %, basic",
    ];
    let text = format!(
        "{} fits of data made again ({}), seed {}; {} of {} without an estimate.",
        bootstrap.jobs,
        match bootstrap.kind {
            crate::trust::bootstrap::Kind::Rides => "simulated rides of the fitted model",
            crate::trust::bootstrap::Kind::Windows => "windows drawn with replacement",
        },
        bootstrap.seed,
        bootstrap.failed,
        bootstrap.jobs
    );
    markup::table("bootstrap", &heads.map(str::to_owned), &rows) + &paragraph("text", &text)
}

fn reduced(reduction: &Reduction) -> String {
    let percent = |v: Option<f64>| v.map_or_else(|| "∞".into(), |v| format!("{:.1} %", 100.0 * v));
    let kept = reduction.kept.iter().map(|s| {
        let cells = [
            percent(s.insensitivity),
            percent(s.cramer_rao),
            "kept".into(),
        ];
        (
            escape(&words(&s.name)),
            cells.map(|text| cell(&text)).to_vec(),
        )
    });
    let dropped = reduction.dropped.iter().map(|d| {
        let unit = Free::new(&d.sensitivity.name).map_or("", |f| f.row.unit.symbol);
        let fate = format!("left out, held at {}", with_unit(d.fixed_at, unit, 4));
        let s = &d.sensitivity;
        let cells = [
            percent(s.insensitivity),
            percent(s.cramer_rao),
            escape(&fate),
        ];
        (
            escape(&words(&s.name)),
            cells.map(|text| cell(&text)).to_vec(),
        )
    });
    let rows: Vec<_> = kept.chain(dropped).collect();
    let heads = ["parameter", "insensitivity", "Cramér–Rao", ""].map(str::to_owned);
    markup::table("reduction", &heads, &rows) + &paragraph("text", RULE)
}

const RULE: &str = "The rule of Tischler and Remple: a parameter is kept while its insensitivity \
    is at most 10 % of its value and its Cramér–Rao bound at most 20 %; the worst is left out and \
    the rest sought anew.";
