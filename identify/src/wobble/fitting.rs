//! Commands about fits: fit, report.

use crate::arguments::{
    BicycleArguments, RideArguments, SpectrumArguments, assignment, pair, quantity,
};
use crate::output::{Output, Progress};
use anyhow::{Context, Result};
use bicycle::Formulation;
use bicycle::quantity::S;
use clap::Args;
use identify::bicycles::Bicycle;
use identify::csv::Import;
use identify::error::{Error, Result as Typed};
use identify::fit;
use identify::free::{Free, all};
use identify::map::Map;
use identify::objective::Objective;
use identify::plan::{self, Plan};
use identify::ride::{Ride, quantity as channel_row};
use identify::run::Run;
use identify::{file, report};
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct Fit {
    /// Ride file
    ride: PathBuf,
    #[command(flatten)]
    reading: RideArguments,
    /// The stretch of the ride to use, on its own clock
    #[arg(long, value_name = "START:STOP")]
    times: Option<String>,
    #[command(flatten)]
    bicycle: BicycleArguments,
    /// amplitude, whittle or time; else by what was recorded
    #[arg(long, value_name = "NAME")]
    objective: Option<String>,
    /// Channels to look at, comma-separated; else by what was recorded
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    channels: Vec<String>,
    /// Free parameters, comma-separated, or all; they start at the bicycle's values
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    free: Vec<String>,
    /// Bounds of a free parameter
    #[arg(long, value_name = "NAME=LOW:HIGH")]
    bounds: Vec<String>,
    /// Standard deviation of a channel's noise, else estimated above 10 Hz; for all channels or none
    #[arg(long, value_name = "CHANNEL=VALUE")]
    noise: Vec<String>,
    #[command(flatten)]
    spectrum: SpectrumArguments,
    /// Length of a window of the time objective
    #[arg(long, value_name = "TIME", default_value = "0.5s")]
    window: String,
    /// Most iterations of a search
    #[arg(long, default_value_t = 100)]
    max_iterations: u64,
    /// Seed of the simulated ride in the report: another than that of any ride to be fitted
    #[arg(long, default_value_t = 1000)]
    seed: u64,
    /// Report to write besides, HTML
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

impl Fit {
    pub fn run(&self) -> Result<()> {
        let bicycle = self.bicycle.open()?;
        let mut plan = self.plan(&bicycle)?;
        let times = self
            .times
            .as_deref()
            .map(|text| pair("--times", text, S))
            .transpose()?;
        let mut ride = self.reading.read(&self.ride)?;
        if let Some((start, stop)) = times {
            ride = ride.slice(start..stop)?;
        }
        ride.law_in_loop.get_or_insert(bicycle.law_in_loop);
        if !self.noise.is_empty() {
            let channels = plan::resolve(&ride, &plan)?.channels;
            plan.noise = Some(noise_of(&self.noise, &channels)?);
        }
        if self.bicycle.sets("speed") && ride.has("speed") {
            eprintln!("note: the ride records its speed; --set speed has no say in this fit");
        }
        let run = run(
            &ride,
            &plan,
            &bicycle,
            self.reading.source(&ride, times)?,
            self.seed,
        )?;
        if let Some(path) = &self.report {
            file::write(path, report::html(&run, &ride)?)?;
        }
        eprint!("{}", report::summary(&run.fit));
        if self.output.json || self.output.out.is_some() {
            self.output.text(&(run.to_json() + "\n"))?;
        }
        Ok(())
    }

    fn plan(&self, bicycle: &Bicycle) -> Result<Plan> {
        let defaults = Plan::default();
        let mut excitation = bicycle.excitation;
        if excitation.remnant_intensity == 0.0 {
            excitation.remnant_intensity = defaults.excitation.remnant_intensity;
        }
        let objective = self.objective.as_deref().map(|name| {
            name.parse::<Objective>()
                .map_err(|cause| cause.typed(format!("--objective {name}")))
        });
        let channels = names("--channels", &self.channels, |name| {
            Ok(channel_row(name)?.name)
        })?;
        Ok(Plan {
            parameters: bicycle.parameters,
            formulation: bicycle.formulation,
            speed: bicycle.input.speed,
            excitation,
            objective: objective.transpose()?,
            channels,
            free: self.free(bicycle.formulation)?,
            bounds: self.bounds()?,
            recipe: self.spectrum.recipe()?,
            window: quantity("--window", &self.window, S)?,
            noise: None,
            max_iterations: self.max_iterations,
        })
    }

    fn free(&self, formulation: Formulation) -> Typed<Option<Vec<Free>>> {
        let all: Vec<_> = all(formulation).into_iter().map(str::to_owned).collect();
        let asked = if self.free == ["all"] {
            &all[..]
        } else {
            &self.free[..]
        };
        let twice = asked
            .iter()
            .enumerate()
            .find(|(i, name)| asked[..*i].contains(name));
        if let Some((_, name)) = twice {
            let form = Error::Form {
                expected: "each name once",
                found: name.clone(),
            };
            return Err(form.typed(format!("--free {}", asked.join(","))));
        }
        names("--free", asked, Free::new)
    }

    fn bounds(&self) -> Typed<Vec<Free>> {
        let bound = |text: &String| {
            let typed = |cause: Error| cause.typed(format!("--bounds {text}"));
            let (name, ends) = assignment("--bounds", text)?;
            let free = Free::new(name).map_err(typed)?;
            let (lower, upper) = pair("--bounds", ends, free.row.unit)?;
            free.within(lower, upper).map_err(typed)
        };
        self.bounds.iter().map(bound).collect()
    }
}

/// The noise of each of `channels`: of all of them, or it is no use to a spectrum of several.
fn noise_of(given: &[String], channels: &[&'static str]) -> Typed<Vec<f64>> {
    let typed = |cause: Error| cause.typed(format!("--noise {}", given.join(" --noise ")));
    let form = |expected| {
        typed(Error::Form {
            expected,
            found: given.join(" "),
        })
    };
    let of = |channel: &&str| {
        let named = |text: &&String| text.split('=').next() == Some(channel);
        let text = given
            .iter()
            .find(named)
            .ok_or_else(|| form("the noise of every channel"))?;
        let (name, value) = assignment("--noise", text)?;
        let noise = quantity("--noise", value, channel_row(name)?.unit)?;
        if noise > 0.0 {
            Ok(noise)
        } else {
            Err(form("a standard deviation above 0"))
        }
    };
    channels.iter().map(of).collect()
}

/// `given` names turned into what they mean; none where none were given.
fn names<T>(
    flag: &str,
    given: &[String],
    mean: impl Fn(&str) -> Typed<T>,
) -> Typed<Option<Vec<T>>> {
    if given.is_empty() {
        return Ok(None);
    }
    let one = |name: &String| {
        mean(name).map_err(|cause| cause.typed(format!("{flag} {}", given.join(","))))
    };
    given.iter().map(one).collect::<Typed<Vec<T>>>().map(Some)
}

/// Fits and puts on record.
pub fn run(
    ride: &Ride,
    plan: &Plan,
    bicycle: &Bicycle,
    source: identify::run::Source,
    seed: u64,
) -> Result<Run> {
    let progress = Progress::new();
    let fit = fit::fit(ride, plan, &|what| progress.say(what))
        .with_context(|| format!("fit of {}", ride.name()))?;
    let law_in_loop = ride.law_in_loop.unwrap_or(bicycle.law_in_loop);
    Ok(Run::new(
        source,
        &bicycle.name,
        plan,
        law_in_loop,
        seed,
        fit,
    ))
}

#[derive(Args)]
pub struct Report {
    /// The fit, as `wobble fit -o` wrote it
    fit: PathBuf,
    /// The ride file, where it has moved
    #[arg(long, value_name = "FILE")]
    ride: Option<PathBuf>,
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
        let path = self
            .ride
            .clone()
            .unwrap_or_else(|| PathBuf::from(&run.ride.file));
        let ride = read_again(&run, &path)?;
        file::write(&self.out, report::html(&run, &ride)?)?;
        eprintln!("wrote {}", self.out.display());
        let output = Output {
            json: self.json,
            out: None,
        };
        output.json_or(&run, String::new)
    }
}

/// The ride of a fit, which must be the same to the last byte.
fn read_again(run: &Run, path: &Path) -> Result<Ride> {
    let map = run.ride.map.as_deref().map(Map::open).transpose()?;
    let changed = map
        .as_ref()
        .filter(|map| run.ride.map_sha256.as_ref() != Some(&map.sha256));
    if let Some(map) = changed {
        return Err(Error::OtherFile {
            file: run.ride.map.clone().unwrap_or_default(),
            what: "map",
            expected: run.ride.map_sha256.clone().unwrap_or_default(),
            found: map.sha256.clone(),
        }
        .into());
    }
    let import = Import {
        map,
        rate: run.ride.rate,
        resample: run.ride.resample,
    };
    let mut ride = import.read(path)?;
    let found = ride
        .origin
        .as_ref()
        .map(|o| o.sha256.as_str())
        .unwrap_or_default();
    if found != run.ride.sha256 {
        return Err(Error::OtherFile {
            file: path.display().to_string(),
            what: "ride",
            expected: run.ride.sha256.clone(),
            found: found.into(),
        }
        .into());
    }
    if let Some((start, stop)) = run.ride.times {
        ride = ride.slice(start..stop)?;
    }
    ride.law_in_loop = Some(run.start.law_in_loop);
    Ok(ride)
}
