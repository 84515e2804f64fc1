//! What was asked besides one search: starts, population, profiles, bootstrap, reduction.

use super::markup::{self, cell, escape, paragraph, section};
use super::number::{in_unit, significant, with_unit};
use super::plot::plot;
use super::plots;
use super::words::{join, words};
use crate::effort::{Agreement, Population};
use crate::fit::Fit;
use crate::run::Run;
use crate::trust::bootstrap::{Kind, Resampled};
use crate::trust::insensitivity::{Dropped, Reduction, Rule};
use crate::trust::profile::Profile;
use crate::verdict::Estimate;
use std::fmt::Write as _;

/// The sections of what was asked.
pub(super) fn sections(run: &Run) -> String {
    let (fit, further) = (&run.fit, &run.fit.further);
    let mut page = String::new();
    if let Some(unmade) = unmade(run) {
        page += &section("Stopped", &paragraph("advice", &unmade));
    }
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
        page += &section("What the data can do without", &reduced(reduction, fit));
    }
    page
}

/// The same as lines of plain text.
pub(super) fn lines(run: &Run) -> Vec<String> {
    let (fit, further) = (&run.fit, &run.fit.further);
    let mut lines: Vec<String> = further.population.iter().map(searched).collect();
    lines.extend(further.starts.iter().map(agreement));
    for profile in &further.profiles {
        let [_, from, to] = ends(profile, &unit_of(fit, &profile.name));
        lines.push(format!(
            "profile of {}: 95 % from {from} to {to}",
            profile.name
        ));
    }
    if let Some(bootstrap) = &further.bootstrap {
        lines.push(made_again(bootstrap));
        for row in &bootstrap.parameters {
            if let Some(s) = row.scatter {
                let unit = unit_of(fit, &row.name);
                lines.push(format!(
                    "bootstrap of {}: std. error {}, bias {}, 95 % {}",
                    row.name,
                    with_unit(s.std_error, &unit, 2),
                    with_unit(s.bias, &unit, 2),
                    interval(s.basic, &unit),
                ));
            }
        }
    }
    if let Some(reduction) = &further.reduction {
        let kept = join(reduction.kept.iter().map(|s| s.name.as_str()));
        let dropped = reduction.dropped.iter().map(|d| {
            let unit = unit_of(fit, &d.sensitivity.name);
            let (name, at) = (&d.sensitivity.name, with_unit(d.fixed_at, &unit, 4));
            format!("{name} ({}), held at {at}", reason(d))
        });
        lines.push(match reduction.dropped.len() {
            0 => format!("the data can do without none of {kept}"),
            _ => format!("left out, the worst first: {}; kept: {kept}", join(dropped)),
        });
    }
    lines.extend(unmade(run));
    lines
}

/// What was asked and not made, since somebody asked to stop.
pub(super) fn unmade(run: &Run) -> Option<String> {
    let (asked, further) = (&run.asked.effort, &run.fit.further);
    let missing = [
        ("starts", asked.starts > 0 && further.starts.is_none()),
        (
            "profiles",
            asked.profiles && further.profiles.len() < run.fit.parameters.len(),
        ),
        (
            "bootstrap",
            asked.bootstrap > 0 && further.bootstrap.is_none(),
        ),
        ("reduction", asked.reduce && further.reduction.is_none()),
    ];
    let missing: Vec<&str> = (missing.iter())
        .filter_map(|(what, lacks)| lacks.then_some(*what))
        .collect();
    let stopped = (!missing.is_empty()).then(|| join(missing.into_iter()));
    stopped.map(|what| format!("Stopped before all that was asked was made: {what}."))
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
    does not rise to the dashed level on a side, the data leave that side open. The level is that \
    of a 95 % interval of a parabola of the reported variance: correlated bins and the scatter \
    between windows raise it, by as much as they widen the parameter, so it differs from one to the next.";

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
        (
            escape(&words(&p.name)),
            ends(p, &unit_of(fit, &p.name))
                .map(|text| cell(&escape(&text)))
                .to_vec(),
        )
    };
    let rows: Vec<_> = profiles.iter().map(row).collect();
    let heads = ["parameter", "estimate", "95 % from", "to"].map(str::to_owned);
    markup::table("profiles", &heads, &rows) + &plot("profiles", &panels, "", PROFILE)
}

/// Estimate and ends of a profile.
fn ends(profile: &Profile, unit: &str) -> [String; 3] {
    let end = |v: Option<f64>| v.map_or_else(|| "open".into(), |v| with_unit(v, unit, 3));
    [
        with_unit(profile.value, unit, 4),
        end(profile.lower),
        end(profile.upper),
    ]
}

fn interval((from, to): (f64, f64), unit: &str) -> String {
    format!("{} to {}", in_unit(from, unit, 3), with_unit(to, unit, 3))
}

/// How the data of a bootstrap were made, and how many of its fits there are.
fn made_again(bootstrap: &Resampled) -> String {
    let stopped = match bootstrap.planned.saturating_sub(bootstrap.jobs as u64) {
        0 => String::new(),
        _ => format!(" Stopped before all {} had been made.", bootstrap.planned),
    };
    format!(
        "{} fits of data made again ({}), seed {}; {} of {} without an estimate.{stopped}",
        bootstrap.jobs,
        match bootstrap.kind {
            Kind::Rides => "simulated rides of the fitted model",
            Kind::Windows => "windows drawn with replacement",
        },
        bootstrap.seed,
        bootstrap.failed,
        bootstrap.jobs
    )
}

/// What spoke against a parameter that was left out.
fn reason(dropped: &Dropped) -> String {
    let s = &dropped.sensitivity;
    match dropped.rule {
        Rule::Insensitivity => format!("insensitivity {}", percent(s.insensitivity)),
        Rule::CramerRao => format!("Cramér–Rao bound {}", percent(s.cramer_rao)),
        Rule::Bound => "at a bound".into(),
    }
}

fn percent(part: Option<f64>) -> String {
    part.map_or_else(|| "∞".into(), |part| format!("{:.1} %", 100.0 * part))
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
                    let cells = [
                        with_unit(s.std_error, &unit, 2),
                        with_unit(s.bias, &unit, 2),
                        interval(s.percentile, &unit),
                        interval(s.basic, &unit),
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
    let text = made_again(bootstrap);
    markup::table("bootstrap", &heads.map(str::to_owned), &rows) + &paragraph("text", &text)
}

fn reduced(reduction: &Reduction, fit: &Fit) -> String {
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
        let unit = unit_of(fit, &d.sensitivity.name);
        let fate = format!(
            "left out: {}; held at {}",
            reason(d),
            with_unit(d.fixed_at, &unit, 4)
        );
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

const RULE: &str = "The rule of Tischler and Remple, after those at a bound: a parameter is kept while its insensitivity \
    is at most 10 % of its value and its Cramér–Rao bound at most 20 %; the worst is left out and \
    the rest sought anew.";
