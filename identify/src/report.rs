//! The report of a fit: one HTML file that needs nothing else, and its table as plain text.

mod comparison;
mod further;
pub(crate) mod markup;
pub(crate) mod number;
pub(crate) mod plot;
mod plots;
mod provenance;
mod residuals;
pub(crate) mod table;
#[cfg(test)]
mod tests;
mod validation;
pub(crate) mod words;

pub use comparison::comparison;
pub use provenance::quoted;
pub use table::{summary, table};
pub use words::advice;

use crate::error::Result;
use crate::figure;
use crate::fit::Fit;
use crate::free::Free;
use crate::objective::Objective;
use crate::ride::{Ride, base, quantity};
use crate::run::Run;
use crate::spectrum::Taper;
use crate::validate::Validation;
use crate::verdict::Estimate;
use markup::{cell, escape, list, paragraph, section, symbol};
use number::{exact, exact_with_unit, significant, with_unit};
use plot::plot;
use words::{capitalised, distinct, headline, join, misfit, words, work};

/// Points of all curves of signals together: a megabyte or two.
const POINTS: usize = 150_000;
/// Rides up to this number are all shown; of more, all but the first are folded.
const SHOWN: usize = 3;

/// The report of `run` on its `rides`: one self-contained HTML file. An error where the rides are
/// not those that the run can have come from.
pub fn html(run: &Run, rides: &[Ride]) -> Result<String> {
    page(run, rides, None)
}

/// The same with what `validation` found on rides that were not fitted.
pub fn validated(run: &Run, rides: &[Ride], validation: &Validation) -> Result<String> {
    page(run, rides, Some(validation))
}

fn page(run: &Run, rides: &[Ride], validation: Option<&Validation>) -> Result<String> {
    let fit = &run.fit;
    let names: Vec<&str> = run.rides.iter().map(|r| base(&r.source.file)).collect();
    let title = &match names.len() {
        1 => names[0].to_owned(),
        n => format!("{} and {} more", names[0], n - 1),
    };
    let bicycles = run.rides.iter().map(|r| r.start.bicycle.clone());
    let about = format!(
        "Bicycle {}, {} equations; objective {} on {}",
        join(distinct(bicycles).into_iter()),
        run.rides[0].start.formulation,
        fit.objective.name(),
        join(fit.channels.iter().map(|c| words(c))),
    );
    let mut page = markup::head(title, &format!("{title}: fit by {}", run.program));
    page += &paragraph("about", &about);
    page += &paragraph("result", &headline(fit));
    if let Some(advice) = advice(fit) {
        page += &paragraph("advice", &words(&advice));
    }
    page += &section("Parameters", &parameters(fit));
    let explains = match names.len() {
        1 => "Does the model explain the ride?",
        _ => "Does the model explain the rides?",
    };
    page += &section(explains, &agreement(fit));
    if let Some(validation) = validation {
        page += &section("Validation", &validation::section(validation));
    }
    let problem = run.problem(rides)?;
    let recipe = &run.asked.recipe;
    let lines: Vec<f64> = recipe.lines.iter().map(|line| line.frequency).collect();
    let titled = |what: &str, i: usize| match names.len() {
        1 => what.to_owned(),
        _ => format!("{what}: {}", names[i]),
    };
    // still pictures of many rides would outweigh all the rest
    let still = |i: usize, draw: &dyn Fn() -> String| {
        if i < SHOWN { draw() } else { String::new() }
    };
    let spectra = run.curves(&problem)?;
    let figures = spectra.iter().enumerate().map(|(i, curves)| {
        let still = still(i, &|| figure::spectrum(curves, &lines));
        let panels = plots::spectrum(curves, &lines);
        let figure = plot(&format!("spectrum-{i}"), &panels, &still, SPECTRUM);
        section(&titled("Spectrum", i), &figure)
    });
    page += &folded(&figures.collect::<Vec<_>>(), "spectra");
    let caption = match fit.objective {
        Objective::Time => REPLAY.into(),
        Objective::FreeResponse => FREE.into(),
        _ if lines.is_empty() => RESIDUAL.into(),
        _ => format!("{RESIDUAL} {LINES}"),
    };
    let traces = run.traces(&problem, rides)?;
    let curves: usize = traces.iter().map(|traces| 2 * traces.len()).sum();
    let most = POINTS / curves.max(1);
    let figures = traces.iter().enumerate().map(|(i, traces)| {
        let signals = if traces.is_empty() {
            paragraph("text", FALLEN)
        } else {
            let still = still(i, &|| figure::traces(traces));
            let panels = plots::traces(traces, most);
            plot(&format!("signals-{i}"), &panels, &still, &caption)
        };
        section(&titled("Signals", i), &signals)
    });
    page += &folded(&figures.collect::<Vec<_>>(), "signals");
    let responses = run.responses(&problem)?;
    let figures = responses.iter().enumerate().map(|(i, responses)| {
        let panels = plots::responses(responses);
        let figure = plot(&format!("response-{i}"), &panels, "", RESPONSE);
        section(&titled("Frequency response", i), &figure)
    });
    page += &folded(&figures.collect::<Vec<_>>(), "frequency responses");
    page += &residuals::section(&spectra, &traces, &responses);
    page += &further::sections(run);
    if fit.parameters.len() > 1 {
        page += &section("Correlations", &correlations(fit));
    }
    page += &section("Assumptions and notes", &list(&assumptions(run)?));
    page += &section("Work", &paragraph("text", &work(fit)));
    page += &section("Provenance", &provenance::provenance(run));
    Ok(page + &plot::script() + markup::FOOT)
}

/// Sections of the same kind, one a ride: of many, all but the first folded away.
fn folded(sections: &[String], what: &str) -> String {
    if sections.len() <= SHOWN {
        return sections.concat();
    }
    let (first, others) = sections.split_at(1);
    let summary = format!("The {what} of the other {} rides", others.len());
    format!(
        "{}<details><summary>{summary}</summary>\n{}</details>\n",
        first.concat(),
        others.concat()
    )
}

const SPECTRUM: &str = "Amplitudes of sines in the residual of the moving average. In a single \
    ride a bin scatters by half its mean: 19 of 20 dots should lie in the band, not on the line.";
const REPLAY: &str = "The recorded torque replayed in windows, each from a free initial state: \
    the model must follow the record in time, but may jump between windows.";
const FREE: &str = "Windows in which the bicycle was left to itself, each replayed from a free \
    initial state without the recorded torque.";
const RESIDUAL: &str = "Residual of the moving average. The model’s curve is a seeded ride of \
    the fitted bicycle: it has the statistics that were fitted and shares nothing else with the \
    measured ride, so the two are not meant to coincide in time; only size and pace compare.";
const LINES: &str = "The lines left out of the spectrum are in the measured curve only.";
const RESPONSE: &str = "From the recorded torque to each channel, bins of a coherence of .6 and \
    more; the weights fall with the coherence.";
const FALLEN: &str = "The fitted bicycle falls or reaches its steer limit when it is simulated: \
    there is no ride to show.";
const READING: &str = "Determined: the standard error is below .3 of the spread that the \
    literature leaves open; weak: up to .7; not determined: more, or at a bound, or in a \
    direction the ride does not see at all, where the standard error is infinite and shown as –. \
    A nuisance is estimated for the others’ sake.";
const TRADE: &str = "Near ±1 the ride tells the two apart badly: a change of one is made up for \
    by the other. Without a standard error (–) there is no correlation to speak of.";

fn parameters(fit: &Fit) -> String {
    let row = |estimate: &Estimate| {
        let what = Free::new(&estimate.name).map_or("", |free| free.row.what);
        let [name, sign, value, error, interval, bounds, _, trades] = table::cells(estimate);
        let verdict = estimate.verdict.name();
        let class = verdict.replace(' ', "-");
        let bound = if estimate.at_bound {
            "<small>at a bound</small>"
        } else {
            ""
        };
        let cells = [value, error, interval, bounds].map(|text| cell(&escape(&text)));
        let mut row = vec![cell(&symbol(&sign))];
        row.extend(cells);
        row.push(cell(&format!(
            "<span class=\"verdict {class}\">{verdict}</span>{bound}"
        )));
        row.push(cell(&escape(&words(&trades))));
        (
            format!(
                "{}{}<small>{}</small>",
                escape(&words(&estimate.name)),
                escape(&name[estimate.name.len()..]),
                escape(what)
            ),
            row,
        )
    };
    let rows: Vec<_> = fit.parameters.iter().map(row).collect();
    let heads = table::HEADS.map(str::to_owned);
    markup::table("parameters", &heads, &rows) + &paragraph("text", READING)
}

fn agreement(fit: &Fit) -> String {
    let text = paragraph("text", &misfit(fit));
    let several = fit.explained.len() > 1;
    let mut rows = Vec::new();
    for ride in &fit.explained {
        let name = if several {
            format!("{}, ", base(&ride.ride))
        } else {
            String::new()
        };
        rows.extend(ride.replays.iter().map(|replay| {
            let unit = quantity(&replay.channel).map_or("", |row| row.unit.symbol);
            let accounted = significant(100.0 * replay.variance_accounted_for, 4) + "\u{a0}%";
            let cells = [accounted, with_unit(replay.residual_rms, unit, 3)];
            (
                escape(&format!("{name}{}", words(&replay.channel))),
                cells.map(|text| cell(&text)).to_vec(),
            )
        }));
    }
    if rows.is_empty() {
        return text;
    }
    let heads = ["channel", "variance accounted for", "residual, rms"].map(str::to_owned);
    text + &markup::table("replays", &heads, &rows)
}

/// The correlation matrix, red for one sign and blue for the other; – where a standard error is
/// missing.
fn correlations(fit: &Fit) -> String {
    let name = |p: &Estimate| escape(&words(&p.label()));
    let known = |p: &Estimate| p.std_error.is_some();
    let coloured = |value: f64| {
        let colour = if value < 0.0 { "0,114,178" } else { "213,94,0" };
        let shade = 0.6 * value.abs().min(1.0);
        let digits = format!("{value:+.2}").replace('-', "−");
        format!("<td style=\"background:rgba({colour},{shade:.2})\">{digits}</td>")
    };
    let row = |(i, p): (usize, &Estimate)| {
        let cells = fit.parameters.iter().enumerate().map(|(j, other)| {
            match (i == j, known(p) && known(other)) {
                (true, _) => "<td style=\"background:#eee\">1</td>".into(),
                (false, true) => coloured(fit.correlation[i][j]),
                (false, false) => cell("–"),
            }
        });
        (name(p), cells.collect())
    };
    let rows: Vec<_> = fit.parameters.iter().enumerate().map(row).collect();
    let heads: Vec<_> = std::iter::once(String::new())
        .chain(fit.parameters.iter().map(name))
        .collect();
    markup::table("matrix", &heads, &rows) + &paragraph("text", TRADE)
}

/// What the numbers rest on, a sentence each.
fn assumptions(run: &Run) -> Result<Vec<String>> {
    let (fit, recipe) = (&run.fit, &run.asked.recipe);
    let mut items: Vec<String> = fit
        .notes
        .iter()
        .map(|note| capitalised(note) + ".")
        .collect();
    let notes = run.rides.iter().flat_map(|ride| &ride.source.notes);
    items.extend(
        distinct(notes)
            .into_iter()
            .map(|note| format!("Ride: {note}.")),
    );
    if fit.objective.has_remnant() {
        items.push(format!(
            "Spectra: residual of a moving average over {}, {} window, bins from {} to {}; model \
             and ride pass the same filter.",
            exact_with_unit(recipe.average, "s"),
            match recipe.taper {
                Taper::Rectangle => "rectangular",
                Taper::Hann => "Hann",
            },
            exact(recipe.band.0),
            exact_with_unit(recipe.band.1, "Hz"),
        ));
        items.push(
            "The model spectrum is that of the closed loop of bicycle and rider, statistically \
             linearised; rider gains that are not free are those of the bicycle’s set."
                .into(),
        );
    } else {
        let law = if run.rides[0].start.law_in_loop {
            "The steer torque of the ride acts besides the bicycle’s steering law, which is \
             closed on the simulated state."
        } else {
            "The steer torque of the ride is taken as the whole torque on the handlebar; no \
             steering law acts besides."
        };
        items.push(law.into());
    }
    for (i, channel) in fit.channels.iter().enumerate() {
        let origin = if run.asked.noise.is_some() {
            "given"
        } else if fit.objective.is_replayed() {
            "what a first search left of it"
        } else {
            "estimated above 10 Hz"
        };
        let unit = quantity(channel)?.unit.symbol;
        // a frequency response has no noise of a channel but a coherence of each bin
        let noise = fit.explained.iter().filter_map(|ride| ride.noise.get(i));
        let values = distinct(noise.map(|noise| with_unit(*noise, unit, 2)));
        if values.is_empty() {
            continue;
        }
        let values = join(values.into_iter());
        items.push(format!("Noise of {}: {values} ({origin}).", words(channel)));
    }
    if fit.objective == Objective::Whittle && fit.estimate("camber_stiffness").is_some() {
        items.push(
            "Intervals are symmetric about the estimate in the variable of the search. On \
             synthetic rides those of camber stiffness held the truth in 85 to 88 of 100, not \
             95: read them as a little wider."
                .into(),
        );
    }
    Ok(items)
}
