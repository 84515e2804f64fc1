//! `wobble validate`: a fit on rides it was not made of.

use crate::arguments::{RiddenArguments, RideArguments};
use crate::output::{Output, Progress};
use crate::report::read_again;
use anyhow::Result;
use clap::Args;
use identify::bicycles::Bicycle;
use identify::objective::free_response;
use identify::plan::Ridden;
use identify::ride::Ride;
use identify::run::Run;
use identify::study::{Entry, Study};
use identify::validate::{self, HeldOut, Validation};
use identify::{file, report};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct Validate {
    /// The fit, as `wobble fit -o` wrote it
    fit: PathBuf,
    /// Ride files that it was not fitted to, of the bicycle of the fit's first ride unless told
    #[arg(required_unless_present = "study")]
    rides: Vec<PathBuf>,
    /// Rides with their bicycles and conditions, TOML: each is predicted with the estimates of its own
    /// condition, where the fit has it
    #[arg(long, value_name = "FILE", conflicts_with_all = [
        "rides", "condition", "map", "rate", "resample", "bicycle", "set", "load", "rider"
    ])]
    study: Option<PathBuf>,
    /// Which condition of the fit the rides are of, where it has several
    #[arg(long, value_name = "NAME")]
    condition: Option<String>,
    /// Windows of the rides in which to replay them, as of fit
    #[arg(long, value_name = "FILE")]
    windows: Option<PathBuf>,
    #[command(flatten)]
    reading: RideArguments,
    #[command(flatten)]
    bicycle: RiddenArguments,
    /// Formulations to fit again to the fit's own rides, comma-separated
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    formulation: Vec<String>,
    /// The files of the fit's own rides, in their order, where they have moved
    #[arg(long, value_name = "FILE")]
    ride: Vec<PathBuf>,
    /// The report of the fit with what was found to write besides, HTML
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

/// A ride that was not fitted, and the bicycle it was ridden on.
struct Unseen {
    ride: Ride,
    /// None: that of the fit's first ride.
    bicycle: Option<Bicycle>,
    condition: Option<String>,
}

impl Unseen {
    fn ridden<'a>(&'a self, run: &Run) -> Result<Ridden<'a>> {
        let Some(bicycle) = &self.bicycle else {
            return Ok(validate::unfitted(
                run,
                &self.ride,
                self.condition.as_deref(),
            )?);
        };
        Ok(Ridden {
            ride: &self.ride,
            parameters: bicycle.parameters,
            speed: bicycle.input.speed,
            condition: self.condition.clone().unwrap_or_default(),
            windows: Vec::new(),
        })
    }
}

impl Validate {
    pub fn run(&self) -> Result<()> {
        let run = Run::read(&self.fit)?;
        let unseen = self.unseen(&run)?;
        let fitted = run.rides.iter().map(|r| Path::new(&r.source.file));
        let names: Vec<String> = unseen.iter().map(|unseen| unseen.ride.name()).collect();
        let outputs = [&self.output.out, &self.report];
        let outputs = outputs.into_iter().flatten().map(PathBuf::as_path);
        file::check_apart(outputs, fitted.chain(names.iter().map(Path::new)))?;
        for unseen in &unseen {
            run.check_sampled(&unseen.ride)?;
        }
        let ridden = unseen.iter().map(|unseen| unseen.ridden(&run));
        let mut ridden = ridden.collect::<Result<Vec<_>>>()?;
        if let Some(path) = &self.windows {
            for ridden in &mut ridden {
                ridden.windows = free_response::read(path, ridden.ride)?;
            }
        }
        let validation = self.validation(&run, &ridden)?;
        for held_out in validation.held_out.iter().filter(|h| h.fitted_to) {
            eprintln!(
                "warning: {}: the model was fitted to this ride; it is not held out",
                held_out.ride
            );
        }
        if let Some(path) = &self.report {
            let own = read_again(&run, &self.ride)?;
            file::write(path, report::validated(&run, &own, &validation)?)?;
        }
        self.output.json_or(&validation, || words(&validation))
    }

    /// The rides named, or those of the study.
    fn unseen(&self, run: &Run) -> Result<Vec<Unseen>> {
        let first = &run.rides[0];
        if let Some(path) = &self.study {
            let one = |entry: Entry| Unseen {
                condition: Some(entry.labels.to_string()),
                ride: entry.ride,
                bicycle: Some(entry.bicycle),
            };
            return Ok(Study::read(path)?.rides.into_iter().map(one).collect());
        }
        let bicycle = if self.bicycle.is_empty() {
            None
        } else {
            Some(self.bicycle.open()?)
        };
        if bicycle.is_none() {
            // the load of the fit's ride need not be that of another
            eprintln!(
                "note: held-out rides are taken as ridden on the bicycle of {} ({}, {} kg of load); \
                 --bicycle, --load or --study name another",
                first.source.file,
                first.start.bicycle,
                first.start.rows.get("rear_load").copied().unwrap_or(0.0)
            );
        }
        let one = |path: &PathBuf| {
            let mut ride = self.reading.read(path)?;
            ride.law_in_loop.get_or_insert(first.start.law_in_loop);
            Ok(Unseen {
                ride,
                bicycle: bicycle.clone(),
                condition: self.condition.clone(),
            })
        };
        self.rides.iter().map(one).collect()
    }

    fn validation(&self, run: &Run, rides: &[Ridden]) -> Result<Validation> {
        let progress = Progress::new();
        progress.say("predicting");
        let mut validation = validate::validate(run, rides)?;
        if !self.formulation.is_empty() {
            let fitted = read_again(run, &self.ride)?;
            progress.say("fitting each formulation");
            validation.formulations =
                validate::formulations(run, &fitted, rides, &self.formulation)?;
        }
        Ok(validation)
    }
}

fn words(validation: &Validation) -> String {
    let mut text = String::new();
    for held_out in &validation.held_out {
        one(held_out, &mut text);
    }
    if !validation.formulations.is_empty() {
        let _ = writeln!(
            text,
            "\nformulation     −log L         p     starts  AIC            BIC            held out: {}",
            validation.error_of
        );
    }
    for candidate in &validation.formulations {
        let name = &candidate.formulation;
        let Some(weighed) = &candidate.weighed else {
            let why = candidate.failed.as_deref().unwrap_or_default();
            let _ = writeln!(text, "{name:14}  cannot be fitted: {why}");
            continue;
        };
        let c = &weighed.criteria;
        let _ = writeln!(
            text,
            "{name:14}  {:<13.2}  {:<4.1}  {:<6}  {:<13.2}  {:<13.2}  {:.3}{}",
            c.minus_log_likelihood,
            c.parameters,
            c.starts,
            c.aic,
            c.bic,
            weighed.error,
            if weighed.converged {
                ""
            } else {
                "  (not converged)"
            }
        );
    }
    let weighed = validation
        .formulations
        .iter()
        .find_map(|c| c.weighed.as_ref());
    if let Some(c) = weighed.map(|weighed| &weighed.criteria) {
        let _ = writeln!(text, "n = {:.0}: {}", c.sample, c.sample_of);
        if c.starts > 0 {
            let starts = "starts: parameters of the windows' free starts, which count as well";
            let _ = writeln!(text, "{starts}");
        }
    }
    text
}

fn one(held_out: &HeldOut, text: &mut String) {
    let _ = match &held_out.condition {
        Some(condition) if !condition.is_empty() => {
            writeln!(text, "{} ({condition})", held_out.ride)
        }
        Some(_) => writeln!(text, "{}", held_out.ride),
        None => writeln!(
            text,
            "{} (of no condition of the fit: its mean where conditions differ)",
            held_out.ride
        ),
    };
    for value in &held_out.reestimated {
        let _ = writeln!(
            text,
            "  {} {:.4} on this ride, {:.4} in the fit",
            value.name, value.value, value.fitted
        );
    }
    if let Some(spectrum) = &held_out.spectrum {
        for band in &spectrum.bands {
            let _ = writeln!(
                text,
                "  {:10} {}–{} Hz: expected {:+.1} dB of measured ({:.2}, 95 % {:.2}–{:.2})",
                band.channel,
                band.low,
                band.high,
                band.decibels,
                band.ratio,
                band.interval.0,
                band.interval.1
            );
        }
        let m = &spectrum.misfit;
        let _ = writeln!(
            text,
            "  misfit {:.2} a bin (99 % {:.2}–{:.2} where the model is true), {:.0} % of the bins \
             outside their 99 % band",
            m.mean,
            m.mean_band.0,
            m.mean_band.1,
            100.0 * m.outside
        );
    }
    for replayed in &held_out.replays {
        let (replay, white) = (&replayed.replay, &replayed.whiteness);
        let torque = replayed.torque.as_ref().map_or_else(String::new, |torque| {
            format!(", with the torque at {:.0} %", 100.0 * torque.outside)
        });
        let _ = writeln!(
            text,
            "  {:10} fit {:.1} %, variance accounted for {:.3} (median window {:.3}), residual \
             white with p = {:.2}, correlated with itself at {:.0} %{torque} of the lags",
            replay.channel,
            replayed.fit,
            replay.variance_accounted_for,
            replay.median_window,
            white.probability,
            100.0 * white.correlations.outside,
        );
    }
}
