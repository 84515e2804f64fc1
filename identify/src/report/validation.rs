//! What a validation found, as a section of the report.

use super::markup::{self, cell, escape, paragraph};
use super::number::{significant, with_unit};
use super::plot::{BLUE, Panel, VERMILLION, plot};
use super::residuals::correlation;
use super::words::words;
use crate::ride::{base, quantity};
use crate::validate::replay::Replayed;
use crate::validate::{Candidate, HeldOut, Validation};
use std::fmt::Write as _;

/// The body of the section.
pub(super) fn section(validation: &Validation) -> String {
    let mut body = paragraph("text", HELD_OUT);
    for held_out in validation.held_out.iter().filter(|h| h.fitted_to) {
        let text = format!(
            "{}: the model was fitted to this ride; it is not held out.",
            held_out.ride
        );
        body += &paragraph("advice", &text);
    }
    let bands: Vec<_> = validation.held_out.iter().flat_map(bands).collect();
    if !bands.is_empty() {
        let heads = [
            "channel",
            "band",
            "expected over measured",
            "95 % of one ride",
            "",
        ];
        body += &markup::table("held-out", &heads.map(str::to_owned), &bands);
    }
    for held_out in &validation.held_out {
        if let Some(spectrum) = &held_out.spectrum {
            let m = &spectrum.misfit;
            let text = format!(
                "{}: misfit {:.2} a bin (99 % {:.2} to {:.2} where the model is true), {:.0} % of the \
                 bins outside their 99 % band.",
                base(&held_out.ride),
                m.mean,
                m.mean_band.0,
                m.mean_band.1,
                100.0 * m.outside
            );
            body += &paragraph("text", &text);
        }
    }
    let replays: Vec<_> = validation.held_out.iter().flat_map(replays).collect();
    if !replays.is_empty() {
        let heads = [
            "channel",
            "fit",
            "variance accounted for",
            "of the median window",
            "residual, rms",
            "lags outside 99 %: itself",
            "torque",
        ];
        body += &markup::table("held-out", &heads.map(str::to_owned), &replays);
    }
    for (i, held_out) in validation.held_out.iter().enumerate() {
        let panels: Vec<Panel> = held_out.replays.iter().flat_map(diagnosed).collect();
        if !panels.is_empty() {
            let caption = format!("{}: {WHITE}", base(&held_out.ride));
            body += &plot(&format!("held-out-{i}"), &panels, "", &caption);
        }
    }
    body + &formulations(validation)
}

const HELD_OUT: &str = "Rides that the model was not fitted to, under the estimates of the fit; only \
    nuisances, of which each ride has its own, were estimated on them.";
const WHITE: &str = "correlation of the residual with itself and with the steer torque. Within the \
    bands lie 99 of 100 lags where there is none; beyond them the model misses something, at \
    positive lags something that the torque does. Noise of the torque sensor shows as well: it drives \
    the replay.";
const CRITERIA: &str = "Criteria of the rides of the fit: the least is preferred, differences count, \
    values do not. Beside them the error on the held-out rides.";

fn named(held_out: &HeldOut, channel: &str) -> String {
    let again: String = held_out
        .reestimated
        .iter()
        .fold(String::new(), |mut text, r| {
            let _ = write!(
                text,
                " {} {} here, {} in the fit.",
                words(&r.name),
                significant(r.value, 3),
                significant(r.fitted, 3)
            );
            text
        });
    format!(
        "{}, {}<small>{}</small>",
        escape(base(&held_out.ride)),
        escape(&words(channel)),
        escape(again.trim())
    )
}

fn bands(held_out: &HeldOut) -> Vec<(String, Vec<String>)> {
    let bands = held_out
        .spectrum
        .iter()
        .flat_map(|spectrum| &spectrum.bands);
    let row = |band: &crate::validate::spectrum::BandError| {
        let (low, high) = band.interval;
        let verdict = if low <= 1.0 && 1.0 <= high {
            "as expected"
        } else {
            "differs"
        };
        let cells = [
            format!("{} to {} Hz", band.low, band.high),
            format!("{} ({:+.1} dB)", significant(band.ratio, 3), band.decibels),
            format!("{} to {}", significant(low, 3), significant(high, 3)),
            verdict.to_owned(),
        ];
        (
            named(held_out, &band.channel),
            cells.map(|text| cell(&escape(&text))).to_vec(),
        )
    };
    bands.map(row).collect()
}

fn replays(held_out: &HeldOut) -> Vec<(String, Vec<String>)> {
    let percent = |part: f64| format!("{part:.1}\u{a0}%");
    let row = |replayed: &Replayed| {
        let replay = &replayed.replay;
        let unit = quantity(&replay.channel).map_or("", |row| row.unit.symbol);
        let cells = [
            percent(replayed.fit),
            percent(100.0 * replay.variance_accounted_for),
            percent(100.0 * replay.median_window),
            with_unit(replay.residual_rms, unit, 3),
            percent(100.0 * replayed.whiteness.correlations.outside),
            replayed
                .torque
                .as_ref()
                .map_or_else(|| "–".into(), |torque| percent(100.0 * torque.outside)),
        ];
        (
            named(held_out, &replay.channel),
            cells.map(|text| cell(&escape(&text))).to_vec(),
        )
    };
    held_out.replays.iter().map(row).collect()
}

fn diagnosed(replayed: &Replayed) -> Vec<Panel> {
    let name = words(&replayed.replay.channel);
    let own = correlation(
        &format!("{name}, with itself"),
        "lag [s]",
        BLUE,
        &replayed.whiteness.correlations,
    );
    let torque = replayed.torque.as_ref().map(|torque| {
        correlation(
            &format!("{name}, with torque"),
            "lag behind the torque [s]",
            VERMILLION,
            torque,
        )
    });
    [own].into_iter().chain(torque).collect()
}

fn formulations(validation: &Validation) -> String {
    if validation.formulations.is_empty() {
        return String::new();
    }
    let row = |candidate: &Candidate| {
        let cells = if let Some(weighed) = &candidate.weighed {
            let c = &weighed.criteria;
            let arrived = if weighed.converged {
                ""
            } else {
                "not converged"
            };
            let number = |value: f64| format!("{value:.2}").replace('-', "−");
            vec![
                number(c.minus_log_likelihood),
                format!("{:.1}", c.parameters),
                number(c.aic),
                number(c.bic),
                significant(weighed.error, 3),
                arrived.to_owned(),
            ]
        } else {
            let why = candidate.failed.as_deref().unwrap_or_default();
            let mut cells = vec!["–".to_owned(); 5];
            cells.push(format!("cannot be fitted: {why}"));
            cells
        };
        let cells = cells.iter().map(|text| cell(&escape(text)));
        (escape(&candidate.formulation), cells.collect())
    };
    let rows: Vec<_> = validation.formulations.iter().map(row).collect();
    let heads = ["formulation", "−log L", "p", "AIC", "BIC"].map(str::to_owned);
    let error = format!("held out: {}", validation.error_of);
    let heads: Vec<String> = heads
        .into_iter()
        .chain([escape(&error), String::new()])
        .collect();
    markup::table("formulations", &heads, &rows) + &paragraph("text", CRITERIA)
}
