//! A look at a ride as one HTML file that needs nothing else.

use super::{Finding, Inspection, SPECTRAL, Summary};
use crate::compare::{Amplitudes, amplitudes};
use crate::figure::{self, shown};
use crate::report::markup::{self, FOOT, cell, escape, head, list, paragraph, section, table};
use crate::report::number::{exact_with_unit, significant};
use crate::report::words::{capitalised, words};
use crate::ride::Ride;
use crate::spectrum::Recipe;

/// The page of what `found` says of `ride`; `command` is what was typed.
pub fn html(ride: &Ride, found: &Inspection, command: &str) -> String {
    let name = ride.name();
    let title = name.rsplit(['/', '\\']).next().unwrap_or_default();
    let about = format!(
        "{} samples at {} from {}, {} long",
        found.samples,
        exact_with_unit(found.rate, "Hz"),
        exact_with_unit(found.start, "s"),
        exact_with_unit(found.duration, "s")
    );
    let mut page = head(title, &format!("{title}: what is in it"));
    page += &paragraph("about", &about);
    let findings: Vec<String> = found.findings.iter().map(Finding::to_string).collect();
    page += &section(
        "What to know before trusting it",
        &if findings.is_empty() {
            paragraph("text", "Nothing looks wrong.")
        } else {
            list(&findings)
        },
    );
    let channels = figure::channels(ride, &found.findings);
    page += &section("Channels over time", &markup::figure(&channels, CHANNELS));
    let spectra: Vec<Amplitudes> = SPECTRAL
        .iter()
        .filter_map(|channel| amplitudes(ride, channel, &Recipe::default()).ok())
        .collect();
    if !spectra.is_empty() {
        let svg = figure::lines(&spectra, &found.findings);
        page += &section("Spectra", &markup::figure(&svg, SPECTRA));
    }
    page += &section("Channels in numbers", &numbers(&found.channels));
    if !found.notes.is_empty() {
        let notes: Vec<String> = found.notes.iter().map(|n| capitalised(n) + ".").collect();
        page += &section("What was done at the door", &list(&notes));
    }
    let program = concat!("wobble ", env!("CARGO_PKG_VERSION"));
    let sha256 = found.sha256.as_deref().unwrap_or("not from a file");
    let origin = format!(
        "<pre>{}\nSHA-256 {}</pre>\n",
        escape(command),
        escape(sha256)
    );
    page += &section("Provenance", &(paragraph("text", program) + &origin));
    page + FOOT
}

const CHANNELS: &str = "As read: SI and ISO 8855 (roll right +, steer and yaw left +), angles in \
    degrees. Of what occurs several times in a channel the longest or farthest is marked.";
const SPECTRA: &str = "One-sided amplitude of what a moving average over 5 s leaves. A line stands \
    out of its surroundings as noise hardly ever does; mask it where noise is fitted.";

fn numbers(channels: &[Summary]) -> String {
    let heads = [
        "channel",
        "smallest",
        "largest",
        "mean",
        "rms about the mean",
    ];
    let row = |channel: &Summary| {
        let (factor, unit) = shown(channel.unit);
        let number = |value: f64| cell(&escape(&significant(factor * value, 4)));
        let values = [channel.min, channel.max, channel.mean, channel.rms];
        let name = format!("{} [{unit}]", words(channel.name));
        (escape(&name), values.map(number).to_vec())
    };
    let rows: Vec<_> = channels.iter().map(row).collect();
    table("worth", &heads.map(str::to_owned), &rows)
}
