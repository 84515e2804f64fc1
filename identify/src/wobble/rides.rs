//! Commands about rides: inspect, spectrum, compare.

use crate::arguments::{RideArguments, SpectrumArguments};
use crate::foreign;
use crate::output::{Output, typed};
use anyhow::Result;
use clap::Args;
use identify::compare::{self, Amplitudes, BandRow};
use identify::error::Error;
use identify::inspect;
use identify::ride::Ride;
use identify::study::Study;
use identify::{figure, file, report};
use serde_json::json;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct Inspect {
    /// Ride file, or FMU of any maker
    ride: PathBuf,
    #[command(flatten)]
    reading: RideArguments,
    /// Page to write besides: channels over time, findings marked, spectra
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Figure of the channels over time to write besides, SVG
    #[arg(long, value_name = "FILE")]
    figure: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

impl Inspect {
    pub fn run(&self) -> Result<()> {
        if foreign::is_fmu(&self.ride) {
            if let Some(path) = self.html.as_ref().or(self.figure.as_ref()) {
                let found = self.ride.display().to_string();
                let expected = "a ride file to draw";
                let form = Error::Form { expected, found };
                return Err(form.typed(path.display().to_string()).into());
            }
            return foreign::inspect(&self.ride, &self.output);
        }
        let ride = self.reading.read_bridging_gaps(&self.ride)?;
        let found = inspect::inspect(&ride);
        if let Some(path) = &self.html {
            file::write(path, inspect::html(&ride, &found, &typed()))?;
        }
        if let Some(path) = &self.figure {
            file::write(path, figure::channels(&ride, &found.findings))?;
        }
        self.output.json_or(&found, || {
            let mut text = format!(
                "{}: {} samples at {} Hz, {} to {:.3} s\n",
                ride.name(),
                found.samples,
                found.rate,
                found.start,
                found.start + found.duration
            );
            for c in &found.channels {
                let [min, max, mean, rms] = [c.min, c.max, c.mean, c.rms].map(number);
                let _ = writeln!(
                    text,
                    "  {:18} {min:>12} to {max:>12} {:6} mean {mean:>12}  rms {rms:>12}",
                    c.name, c.unit
                );
            }
            for note in &found.notes {
                let _ = writeln!(text, "note: {note}");
            }
            for finding in &found.findings {
                let _ = writeln!(text, "found: {finding}");
            }
            text
        })
    }
}

/// `value` to five decimals, or in powers of ten where these would not show it.
fn number(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        format!("{value:.5}")
    } else {
        format!("{value:.3e}")
    }
}

#[derive(Args)]
pub struct Spectrum {
    /// Ride file
    ride: PathBuf,
    /// Channel
    #[arg(long, default_value = "steer")]
    channel: String,
    #[command(flatten)]
    reading: RideArguments,
    #[command(flatten)]
    recipe: SpectrumArguments,
    /// Figure to write besides, SVG
    #[arg(long, value_name = "FILE")]
    figure: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

impl Spectrum {
    pub fn run(&self) -> Result<()> {
        let recipe = self.recipe.recipe()?;
        let ride = self.reading.read(&self.ride)?;
        let amplitudes = compare::amplitudes(&ride, &self.channel, &recipe)?;
        if let Some(path) = &self.figure {
            file::write(path, draw(std::slice::from_ref(&amplitudes)))?;
        }
        self.output.json_or(&amplitudes, || {
            let mut text = format!("frequency[Hz],amplitude[{}]\n", amplitudes.unit);
            for (f, a) in amplitudes.frequency.iter().zip(&amplitudes.amplitude) {
                let _ = writeln!(text, "{f},{a}");
            }
            text
        })
    }
}

#[derive(Args)]
pub struct Compare {
    /// Ride files; the first is what the others are held against
    #[arg(required_unless_present = "study", num_args = 2..)]
    rides: Vec<PathBuf>,
    /// Study, TOML: each load against the smallest of the same rider, trail and condition
    #[arg(long, value_name = "FILE", conflicts_with_all = ["rides", "map", "rate", "resample"])]
    study: Option<PathBuf>,
    /// Channel
    #[arg(long, default_value = "steer")]
    channel: String,
    #[command(flatten)]
    reading: RideArguments,
    #[command(flatten)]
    recipe: SpectrumArguments,
    /// Figure to write besides, SVG
    #[arg(long, value_name = "FILE")]
    figure: Option<PathBuf>,
    /// Page to write besides: table and figure
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

impl Compare {
    pub fn run(&self) -> Result<()> {
        let recipe = self.recipe.recipe()?;
        if let Some(path) = &self.study {
            let study = Study::read(path)?;
            for entry in &study.rides {
                for note in entry.ride.notes.iter().chain(&entry.bicycle.notes) {
                    eprintln!("note: {}: {note}", entry.ride.name());
                }
            }
            let outputs = [&self.output.out, &self.figure, &self.html];
            let outputs = outputs.into_iter().flatten().map(PathBuf::as_path);
            let own = study.rides.iter().map(|ride| Path::new(&ride.source.file));
            file::check_apart(outputs, own)?;
            Ride::check_sampled_alike(study.rides.iter().map(|entry| &entry.ride))?;
            let found = compare::loads(&study.rides, &self.channel, &recipe)?;
            for note in &found.notes {
                eprintln!("note: {note}");
            }
            self.draw(&study.name, &found.table(), || figure::loads(&found))?;
            return self.output.json_or(&found, || found.table());
        }
        let rides: Vec<Ride> = self
            .rides
            .iter()
            .map(|path| self.reading.read(path))
            .collect::<Result<_>>()?;
        Ride::check_sampled_alike(&rides)?;
        let rows = compare::bands(&rides, &self.channel, &recipe)?;
        let spectra: Vec<_> = rides
            .iter()
            .map(|ride| compare::amplitudes(ride, &self.channel, &recipe))
            .collect::<Result<_, _>>()?;
        let title = format!("{} and {} more", spectra[0].ride, spectra.len() - 1);
        let table = table(&rows, spectra[0].unit);
        self.draw(&title, &table, || draw(&spectra))?;
        let json = json!({ "channel": self.channel, "bands": rows, "spectra": spectra });
        self.output.json_or(&json, || table)
    }

    /// Writes what was asked for of figure and page.
    fn draw(&self, title: &str, table: &str, figure: impl Fn() -> String) -> Result<()> {
        if let Some(path) = &self.figure {
            file::write(path, figure())?;
        }
        if let Some(path) = &self.html {
            let page = report::comparison(title, &self.channel, table, &figure(), &typed());
            file::write(path, page)?;
        }
        Ok(())
    }
}

fn draw(spectra: &[Amplitudes]) -> String {
    let curves: Vec<_> = spectra
        .iter()
        .map(|s| {
            (
                s.ride.clone(),
                s.frequency.as_slice(),
                s.amplitude.as_slice(),
            )
        })
        .collect();
    figure::comparison(&curves, spectra[0].unit)
}

fn table(rows: &[BandRow], unit: &str) -> String {
    let mut text =
        format!("band [Hz]    rms [{unit}]  against first  95 % interval   verdict    ride\n");
    for row in rows {
        let band = format!("{}–{}", row.low, row.high);
        let _ = writeln!(
            text,
            "{band:9}  {:>10.6}  {:>13.2}  {:>6.2}–{:<6.2}  {:9}  {}",
            row.rms, row.ratio, row.interval.0, row.interval.1, row.verdict, row.ride
        );
    }
    text
}
