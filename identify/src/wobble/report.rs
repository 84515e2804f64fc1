//! `wobble report`: a fit on record, drawn beside its rides.

use crate::output::Output;
use anyhow::Result;
use clap::Args;
use identify::error::Error;
use identify::import::Import;
use identify::map::Map;
use identify::ride::Ride;
use identify::run::{Recorded, Run};
use identify::{file, report};
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct Report {
    /// The fit, as `wobble fit -o` wrote it
    fit: PathBuf,
    /// The ride files, in their order, where they have moved
    #[arg(long, value_name = "FILE")]
    ride: Vec<PathBuf>,
    /// Print the fit as JSON
    #[arg(long)]
    json: bool,
    /// The report to write
    #[arg(short, long, value_name = "FILE", default_value = "report.html")]
    out: PathBuf,
}

impl Report {
    pub fn run(&self) -> Result<()> {
        let run = Run::read(&self.fit)?;
        let own = run.rides.iter().map(|ride| Path::new(&ride.source.file));
        file::check_apart([self.out.as_path()], own)?;
        let rides = read_again(&run, &self.ride)?;
        file::write(&self.out, report::html(&run, &rides)?)?;
        eprintln!("wrote {}", self.out.display());
        let output = Output {
            json: self.json,
            out: None,
        };
        output.json_or(&run, String::new)
    }
}

/// The rides of a fit, which must be the same to the last byte; `moved` names their files where
/// they are no longer where they were.
pub fn read_again(run: &Run, moved: &[PathBuf]) -> Result<Vec<Ride>> {
    if !moved.is_empty() && moved.len() != run.rides.len() {
        let error = Error::Form {
            expected: "--ride for each ride of the fit, or none",
            found: format!("{} for {} rides", moved.len(), run.rides.len()),
        };
        return Err(error.typed("--ride").into());
    }
    let read = |(i, recorded): (usize, &Recorded)| {
        let own = Path::new(&recorded.source.file);
        one_again(recorded, moved.get(i).map_or(own, PathBuf::as_path))
    };
    run.rides.iter().enumerate().map(read).collect()
}

fn one_again(recorded: &Recorded, path: &Path) -> Result<Ride> {
    let source = &recorded.source;
    let map = source.map.as_deref().map(Map::open).transpose()?;
    let changed = map
        .as_ref()
        .filter(|map| source.map_sha256.as_ref() != Some(&map.sha256));
    if let Some(map) = changed {
        return Err(Error::OtherFile {
            file: source.map.clone().unwrap_or_default(),
            what: "map",
            expected: source.map_sha256.clone().unwrap_or_default(),
            found: map.sha256.clone(),
        }
        .into());
    }
    let import = Import {
        map,
        rate: source.rate,
        resample: source.resample,
    };
    let mut ride = import.read(path)?;
    let found = ride
        .origin
        .as_ref()
        .map(|o| o.sha256.as_str())
        .unwrap_or_default();
    if found != source.sha256 {
        return Err(Error::OtherFile {
            file: path.display().to_string(),
            what: "ride",
            expected: source.sha256.clone(),
            found: found.into(),
        }
        .into());
    }
    if let Some((start, stop)) = source.times {
        ride = ride.slice(start..stop)?;
    }
    ride.law_in_loop = Some(recorded.start.law_in_loop);
    Ok(ride)
}
