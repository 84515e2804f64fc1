//! What this machine does: rides a second, fits, and the error that goes with the speed.
//!
//! The ride is one of 24 s, 200 samples a second, `repaired` with its rider law; times are the best
//! of several, on one core unless named, set-up and start of every ride included.

mod population;
mod suite;
mod yardstick;

pub use yardstick::Yardstick;

use crate::batch::{Excited, Wanted, ride_together};
use crate::effort::Effort;
use crate::error::Result;
use crate::fit::fit;
use crate::kernel::Isa;
use crate::objective::Objective;
use crate::plan::Plan;
use crate::progress::Watch;
use crate::ride::Ride;
use crate::synthesis::{SensorNoise, Synthesis};
use bicycle::Formulation;
use bicycle::batch;
use fmi_import::{Fmu, simulate};
use serde::Serialize;
use std::path::Path;
use std::time::Instant;
use suite::{Errors, Excitation};

/// Length of the ride [s].
const DURATION: f64 = 24.0;
/// How often times are taken.
const ROUNDS: usize = 5;

/// The measurements, as printed in JSON.
#[derive(Debug, Clone, Serialize)]
pub struct Bench {
    /// Rides a second by the reference method at 1 kHz, in plain numbers.
    pub scalar_sims_per_s: f64,
    /// Rides a second in a batch.
    pub batch_sims_per_s: f64,
    /// The batch's step [s].
    pub batch_step_s: f64,
    /// Its largest error against the same smoothed model at 16 kHz [rad].
    pub batch_error_rad: Errors,
    /// Largest difference between that model and one with exact jumps [rad].
    pub smoothing_error_rad: f64,
    /// Rides a second of the bicycle's FMU; none where its library is not built.
    pub fmu_sims_per_s: Option<f64>,
    /// Times of fits [ms].
    pub fit_ms: Fits,
    /// Twenty fits by `whittle` from different starts, on all cores [s].
    pub multistart20_s: f64,
    /// A global search of 3600 simulated rides, 225 candidates of 16 seeds, on all cores [s].
    pub population_s: f64,
    /// Rides advanced together.
    pub lanes: usize,
    /// The vector instructions.
    pub isa: &'static str,
    /// The yardstick's figures.
    pub yardstick: Option<Yardstick>,
    /// Rides a second in a batch at the yardstick's step of 1 ms.
    #[serde(skip)]
    pub batch_at_1ms_sims_per_s: f64,
    /// The largest error over what it may be: the reference method's at 1 kHz on the same ride, or
    /// 1e-5 rad where that is larger.
    #[serde(skip)]
    pub worst_share: f64,
    /// What a reader should know.
    #[serde(skip)]
    pub notes: Vec<String>,
}

/// Times of fits with covariance and verdicts to one ride [ms].
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Fits {
    /// `amplitude` of the steer angle.
    pub amplitude: f64,
    /// `whittle` of three channels.
    pub whittle: f64,
    /// `time`: four parameters, 48 windows.
    pub time: f64,
}

/// Measures. `yardstick` is a C++ program to be timed in turn with ours.
pub fn measure(yardstick: Option<&Path>, progress: &dyn Fn(&str)) -> Result<Bench> {
    let plan = batch::Plan::of(DURATION);
    let fine = batch::Plan {
        steps_per_sample: 5,
        ..plan
    };
    let mut notes = Vec::new();
    progress("building the yardstick");
    let built = yardstick.and_then(|file| match yardstick::build(file) {
        Ok(built) => Some(built),
        Err(why) => {
            notes.push(format!("no yardstick: {why}"));
            None
        }
    });
    let torque = Excitation::ALL[1].torque(plan.samples + 1);
    let lanes = Isa::best().lanes();
    let rides: Vec<_> = suite::alike(lanes);
    let rides: Vec<_> = rides
        .into_iter()
        .map(|lane| Excited {
            lane,
            torque: &torque,
        })
        .collect();
    let (mut scalar, mut wide, mut wide_at_1ms) = (Best::new(), Best::new(), Best::new());
    let mut measured = None;
    for round in 1..=ROUNDS {
        progress(&format!("riding, round {round} of {ROUNDS}"));
        for _ in 0..3 {
            scalar.time(|| suite::reference(&rides[0].lane, &torque, plan.samples, 5));
        }
        for (best, plan) in [(&mut wide, &plan), (&mut wide_at_1ms, &fine)] {
            for _ in 0..20 {
                best.time(|| {
                    ride_together(&rides, Formulation::Repaired, plan, Wanted::Steer).map(drop)
                })?;
            }
        }
        if let Some(built) = &built {
            match built.run() {
                Ok(again) => measured = Some(again.better(measured)),
                Err(why) => notes.push(format!("no yardstick: {why}")),
            }
        }
    }
    progress("comparing with the reference method at 16 kHz");
    let accuracy = suite::accuracy(&plan)?;
    progress("fitting");
    let (fits, multistart) = fits()?;
    progress("searching with simulated rides");
    let population = population()?;
    progress("running the FMU");
    let fmu = fmu_rate()
        .map_err(|why| notes.push(format!("no FMU: {why}")))
        .ok();
    Ok(Bench {
        scalar_sims_per_s: 1.0 / scalar.0,
        batch_sims_per_s: lanes as f64 / wide.0,
        batch_step_s: plan.step(),
        batch_error_rad: accuracy.batch,
        smoothing_error_rad: accuracy.smoothing,
        fmu_sims_per_s: fmu,
        fit_ms: fits,
        multistart20_s: multistart,
        population_s: population,
        lanes,
        isa: Isa::best().name(),
        yardstick: measured,
        batch_at_1ms_sims_per_s: lanes as f64 / wide_at_1ms.0,
        worst_share: accuracy.worst_share,
        notes,
    })
}

/// The shortest time of several [s].
struct Best(f64);

impl Best {
    fn new() -> Self {
        Self(f64::INFINITY)
    }

    fn time<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = std::hint::black_box(work());
        self.0 = self.0.min(start.elapsed().as_secs_f64());
        result
    }
}

/// Times of the three fits [ms], and of twenty by `whittle` [s].
fn fits() -> Result<(Fits, f64)> {
    let ridden = |torque_recorded| {
        let synthesis = Synthesis {
            torque_recorded,
            noise: SensorNoise::INSTRUMENTED,
            duration: DURATION,
            ..Synthesis::default()
        };
        synthesis.ride()
    };
    let (seen, felt) = (ridden(false)?, ridden(true)?);
    let plan = |objective, channels: Option<Vec<&'static str>>| Plan {
        objective: Some(objective),
        channels,
        ..Plan::default()
    };
    let time = |ride: &Ride, plan: &Plan| -> Result<f64> {
        let mut best = Best::new();
        for _ in 0..3 {
            best.time(|| {
                fit(
                    &[plan.ridden(ride)],
                    plan,
                    &Effort::default(),
                    &Watch::default(),
                )
            })?;
        }
        Ok(1e3 * best.0)
    };
    let whittle = plan(Objective::Whittle, None);
    let fits = Fits {
        amplitude: time(&seen, &plan(Objective::Amplitude, Some(vec!["steer"])))?,
        whittle: time(&seen, &whittle)?,
        time: time(&felt, &plan(Objective::Time, None))?,
    };
    let twenty = Effort {
        starts: 20,
        seed: 1,
        ..Effort::default()
    };
    let mut all = Best::new();
    all.time(|| {
        fit(
            &[whittle.ridden(&seen)],
            &whittle,
            &twenty,
            &Watch::default(),
        )
    })?;
    Ok((fits, all.0))
}

/// The time of a search with simulated rides [s].
fn population() -> Result<f64> {
    let ride = Synthesis {
        duration: DURATION,
        ..Synthesis::default()
    };
    let ride = ride.ride()?;
    let mut best = Best::new();
    for _ in 0..ROUNDS {
        best.time(|| population::search(&ride))?;
    }
    Ok(best.0)
}

/// Rides a second of the bicycle's FMU, loaded once, instantiated for every ride.
fn fmu_rate() -> anyhow::Result<f64> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("bicycle.fmu");
    fmu::pack(&fmu::built_library()?, &path)?;
    let fmu = Fmu::open(&path)?;
    let plan = fmi_import::Plan {
        start_values: vec![("roll_start".into(), fmi_import::Value::Real(-0.05))],
        record: vec!["steer".into()],
        start_time: 0.0,
        stop_time: DURATION,
        step: 5e-3,
        tolerance: None,
    };
    let mut best = Best::new();
    for _ in 0..ROUNDS {
        best.time(|| simulate(&fmu, &plan))?;
    }
    Ok(1.0 / best.0)
}

impl Bench {
    /// For people.
    pub fn table(&self) -> String {
        let mut lines = vec![
            format!(
                "one ride of 24 s, 200 Hz, repaired, rider law; {} lanes of {}, one core",
                self.lanes, self.isa
            ),
            format!(
                "  reference method, 1 ms  {:>9.1} rides/s",
                self.scalar_sims_per_s
            ),
            format!(
                "  batch, {:.2} ms          {:>9.1} rides/s",
                1e3 * self.batch_step_s,
                self.batch_sims_per_s
            ),
            format!(
                "  batch, 1 ms             {:>9.1} rides/s",
                self.batch_at_1ms_sims_per_s
            ),
        ];
        let degrees = |error: Option<f64>| error.map_or_else(|| "-".into(), |e| format!("{e:.1e}"));
        lines.push(format!(
            "  batch's error           {} rad below 10 deg, {} rad elsewhere, at worst {:.2} of \
             the reference method's at 1 kHz or 1e-5 rad",
            degrees(self.batch_error_rad.below_10deg),
            degrees(self.batch_error_rad.elsewhere),
            self.worst_share
        ));
        lines.push(format!(
            "  smoothing's own error   {:.1e} rad",
            self.smoothing_error_rad
        ));
        if let Some(y) = &self.yardstick {
            lines.push(format!(
                "  yardstick, {:.0} ms         {:>9.1} rides/s, {:.1} scalar: batch {:.1} times, at \
                 its step {:.1} times, scalar {:.2} times",
                1e3 * y.step_s,
                y.vector_per_s,
                y.scalar_per_s,
                self.batch_sims_per_s / y.vector_per_s,
                self.batch_at_1ms_sims_per_s / y.vector_per_s,
                self.scalar_sims_per_s / y.scalar_per_s
            ));
        }
        if let Some(fmu) = self.fmu_sims_per_s {
            lines.push(format!("  the FMU                 {fmu:>9.1} rides/s"));
        }
        lines.push(format!(
            "one fit: amplitude {:.1} ms, whittle {:.1} ms, time {:.1} ms; 20 starts of whittle {:.2} s",
            self.fit_ms.amplitude, self.fit_ms.whittle, self.fit_ms.time, self.multistart20_s
        ));
        lines.push(format!(
            "one global search of {} simulated rides {:.2} s",
            population::RIDES,
            self.population_s
        ));
        lines.join("\n") + "\n"
    }
}
