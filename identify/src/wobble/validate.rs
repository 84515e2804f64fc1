//! `wobble validate`: a fit on rides it was not made of.

use crate::arguments::RideArguments;
use crate::fitting::read_again;
use crate::output::{Output, Progress};
use anyhow::Result;
use clap::Args;
use identify::ride::Ride;
use identify::run::Run;
use identify::validate::{self, HeldOut, Validation};
use std::fmt::Write as _;
use std::path::PathBuf;

#[derive(Args)]
pub struct Validate {
    /// The fit, as `wobble fit -o` wrote it
    fit: PathBuf,
    /// Ride files that it was not fitted to
    #[arg(required = true)]
    rides: Vec<PathBuf>,
    #[command(flatten)]
    reading: RideArguments,
    /// Readings of the equations to fit anew to the fit's own rides, comma-separated
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    formulation: Vec<String>,
    /// The files of the fit's own rides, in their order, where they have moved
    #[arg(long, value_name = "FILE")]
    ride: Vec<PathBuf>,
    #[command(flatten)]
    output: Output,
}

impl Validate {
    pub fn run(&self) -> Result<()> {
        let run = Run::read(&self.fit)?;
        let mut rides = Vec::new();
        for path in &self.rides {
            let mut ride = self.reading.read(path)?;
            ride.law_in_loop
                .get_or_insert(run.rides[0].start.law_in_loop);
            rides.push(ride);
        }
        let validation = self.validation(&run, &rides)?;
        for held_out in validation.held_out.iter().filter(|h| h.fitted_to) {
            eprintln!(
                "warning: {}: the model was fitted to this ride; it is not held out",
                held_out.ride
            );
        }
        self.output.json_or(&validation, || words(&validation))
    }

    fn validation(&self, run: &Run, rides: &[Ride]) -> Result<Validation> {
        let progress = Progress::new();
        progress.say("foretelling");
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
            "\nformulation     −log L         p     AIC            BIC            held out: {}",
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
            "{name:14}  {:<13.2}  {:<4.1}  {:<13.2}  {:<13.2}  {:.3}{}",
            c.minus_log_likelihood,
            c.parameters,
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
    }
    text
}

fn one(held_out: &HeldOut, text: &mut String) {
    let _ = writeln!(text, "{}", held_out.ride);
    for renewed in &held_out.renewed {
        let _ = writeln!(
            text,
            "  {} {:.4} on this ride, {:.4} in the fit",
            renewed.name, renewed.value, renewed.fitted
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
    for replay in &held_out.replays {
        let _ = writeln!(
            text,
            "  {:10} fit {:.1} %, variance accounted for {:.3} (median window {:.3}), residual \
             correlated with itself at {:.0} %, with the torque at {:.0} % of the lags",
            replay.channel,
            replay.fit,
            replay.variance_accounted_for,
            replay.median_window,
            100.0 * replay.whiteness.correlations.outside,
            100.0 * replay.torque.outside
        );
    }
}
