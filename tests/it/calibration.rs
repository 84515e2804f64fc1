//! Calibration: how often 95 % intervals hold the truth, how far the median estimate is from it and
//! what the verdicts say, over synthetic rides whose truth is known. Slow; it writes the table
//! `identify/CALIBRATION.md`, in which what falls outside stands as a failure:
//!
//! `cargo test --release -p tests --test it -- --ignored calibration`
//!
//! The rider leans on roll and roll rate alone (150 N m/rad, 60 N m s/rad), 8 km/h, 24 s at 200 Hz,
//! encoder noise .1°, gyro noise .2°/s, remnant 1.2 N m rms. The rides are made with half the
//! internal step of the fits' tables.

use bicycle::{Excitation, Parameters};
use identify::checkpoint::Journal;
use identify::effort::Effort;
use identify::fit::{Fit, fit};
use identify::free::{Free, Scope};
use identify::objective::Objective;
use identify::plan::{Plan, Ridden};
use identify::progress::Watch;
use identify::ride::Ride;
use identify::synthesis::{SensorNoise, Synthesis};
use identify::trust::Solved;
use identify::trust::bootstrap::{Bootstrap, Resampled};
use identify::trust::profile::Profile;
use identify::verdict::Verdict;
use rayon::prelude::*;
use std::f64::consts::FRAC_2_PI;
use std::fmt::Write as _;

/// Truth of the remnant's intensity [N m rms].
const INTENSITY: f64 = 1.2;
/// Jobs of each bootstrap: with 39 the 2.5 % and 97.5 % quantiles are the first and the last.
const JOBS: u64 = 39;

/// What is fitted to each ride, or to each six.
struct Setup {
    name: &'static str,
    objective: Objective,
    free: &'static [&'static str],
    /// Rides to a fit.
    rides: usize,
    /// What the verdicts should be in 95 %, of the parameters it is claimed of.
    expected: &'static [(&'static str, Verdict)],
    /// Whether its intervals are held to the rule; else it shows what the verdicts say.
    calibrated: bool,
    /// How many of the fits get profiles, and how many a bootstrap.
    profiled: usize,
    resampled: usize,
}

const TYRES_AND_DAMPING: [&str; 3] = [
    "cornering_stiffness",
    "camber_stiffness",
    "effective_damping",
];
const TYRES_DETERMINED: [(&str, Verdict); 2] = [
    ("cornering_stiffness", Verdict::Determined),
    ("camber_stiffness", Verdict::Determined),
];

/// All of them.
fn setups() -> [Setup; 8] {
    let plain = Setup {
        name: "",
        objective: Objective::Whittle,
        free: &TYRES_AND_DAMPING,
        rides: 1,
        expected: &TYRES_DETERMINED,
        calibrated: true,
        profiled: 0,
        resampled: 0,
    };
    [
        Setup {
            name: "amplitude, steer, 24 s",
            objective: Objective::Amplitude,
            free: &["effective_damping"],
            expected: &[],
            profiled: 200,
            resampled: 100,
            ..plain
        },
        Setup {
            name: "amplitude, steer, 6 × 24 s",
            objective: Objective::Amplitude,
            free: &["effective_damping"],
            expected: &[],
            rides: 6,
            profiled: 200,
            ..plain
        },
        Setup {
            name: "whittle, three channels, 24 s",
            profiled: 200,
            resampled: 100,
            ..plain
        },
        Setup {
            name: "whittle, three channels, 6 × 24 s",
            rides: 6,
            profiled: 100,
            ..plain
        },
        Setup {
            name: "time, 24 s",
            objective: Objective::Time,
            free: &identify::free::ALL,
            expected: &[
                ("cornering_stiffness", Verdict::Determined),
                ("camber_stiffness", Verdict::Determined),
                ("viscous_friction", Verdict::Determined),
                ("coulomb_friction", Verdict::Determined),
            ],
            profiled: 40,
            resampled: 40,
            ..plain
        },
        Setup {
            name: "amplitude, steer, tyres free, 24 s",
            calibrated: false,
            objective: Objective::Amplitude,
            expected: &[
                ("cornering_stiffness", Verdict::NotDetermined),
                ("camber_stiffness", Verdict::NotDetermined),
            ],
            ..plain
        },
        Setup {
            name: "whittle, c and d both free, 24 s",
            calibrated: false,
            free: &identify::free::ALL,
            expected: &[
                ("viscous_friction", Verdict::NotDetermined),
                ("coulomb_friction", Verdict::NotDetermined),
            ],
            ..plain
        },
        Setup {
            name: "whittle, rider gains free, 24 s",
            calibrated: false,
            free: &[
                "cornering_stiffness",
                "camber_stiffness",
                "viscous_friction",
                "rider_roll_gain",
                "rider_roll_rate_gain",
            ],
            expected: &[("viscous_friction", Verdict::NotDetermined)],
            profiled: 40,
            ..plain
        },
    ]
}

fn rider() -> Parameters {
    Parameters::default().steered_by_roll(150.0, 60.0)
}

fn synthesis(seed: u64) -> Synthesis {
    Synthesis {
        parameters: Parameters {
            internal_step: 0.5e-3,
            ..rider()
        },
        excitation: Excitation {
            remnant_intensity: INTENSITY,
            ..Excitation::default()
        },
        torque_recorded: true,
        seed: 20_000 + seed,
        ..Synthesis::default()
    }
}

fn ride(synthesis: &Synthesis) -> Ride {
    synthesis.ride().expect("a ride that does not fall")
}

/// The effective damping behind the rides: viscous friction, and Coulomb friction over the steer
/// rate of 20 rides without sensor noise.
fn effective_damping() -> f64 {
    let squares: Vec<f64> = (0..20_u64)
        .into_par_iter()
        .flat_map_iter(|seed| {
            let silent = ride(&Synthesis {
                noise: SensorNoise::NONE,
                ..synthesis(seed)
            });
            let steer = silent.channel("steer").expect("recorded").to_vec();
            let step = silent.step();
            let rates = steer.windows(2).map(|w| ((w[1] - w[0]) / step).powi(2));
            rates.collect::<Vec<_>>()
        })
        .collect();
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    rider().viscous_friction + FRAC_2_PI.sqrt() * rider().coulomb_friction / rms
}

/// A fit and what more was asked of it.
struct Trial {
    fit: Fit,
    profiles: Option<Vec<Profile>>,
    resampled: Option<Resampled>,
}

fn trial(setup: &Setup, number: usize, rides: &[Ride]) -> Trial {
    let free = |name: &&str| Free::new(name).expect("a row");
    let mut sought: Vec<Free> = setup.free.iter().map(free).collect();
    if setup.objective != Objective::Time {
        sought.push(free(&"remnant_intensity").per(Scope::Shared));
    }
    let plan = Plan {
        parameters: rider(),
        objective: Some(setup.objective),
        free: Some(sought),
        ..Plan::default()
    };
    let ridden: Vec<Ridden> = rides.iter().map(|ride| plan.ridden(ride)).collect();
    let (problem, fit) = fit(&ridden, &plan, &Effort::default(), &Watch::default()).expect("a fit");
    let z = problem.at(&fit.parameters.iter().map(|p| p.value).collect::<Vec<_>>());
    let profiles = (number < setup.profiled).then(|| {
        let solved = Solved::new(&problem, &z).expect("an optimum");
        solved.profiles()
    });
    let resampled = (number < setup.resampled).then(|| {
        let seed = 1 + number as u64;
        let bootstrap = Bootstrap::new(&ridden, &plan, &problem, &z, seed).expect("a bootstrap");
        let resampled = bootstrap.run(JOBS, &Journal::in_memory(), &Watch::default());
        resampled.expect("a journal in memory")
    });
    Trial {
        fit,
        profiles,
        resampled,
    }
}

/// Part of `all` in per cent, or a dash of none.
fn share(all: impl Iterator<Item = bool>) -> (Option<f64>, usize) {
    let (mut hits, mut count) = (0, 0);
    for hit in all {
        hits += usize::from(hit);
        count += 1;
    }
    let part = 100.0 * f64::from(hits as u32) / f64::from(count as u32);
    ((count > 0).then_some(part), count)
}

/// `share` in words: the part and of how many.
fn words((part, count): (Option<f64>, usize)) -> String {
    part.map_or_else(|| "–".into(), |part| format!("{part:.1} ({count})"))
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The rows of a setup; returns what fell outside.
fn rows(setup: &Setup, trials: &[Trial], effective: f64, table: &mut String) -> Vec<String> {
    let mut outside = Vec::new();
    for (i, estimate) in trials[0].fit.parameters.iter().enumerate() {
        let name = estimate.name.as_str();
        let truth = match name {
            "effective_damping" => effective,
            "remnant_intensity" => INTENSITY,
            _ => rider().get(Parameters::index(name).expect("a row")),
        };
        let of = |t: &Trial| t.fit.parameters[i].clone();
        let mut errors: Vec<f64> = trials.iter().map(|t| of(t).value - truth).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let variance = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>();
        let sigma = (variance / (errors.len() - 1) as f64).sqrt();
        let middle = median(&mut errors);
        let inside = |(low, high): (f64, f64)| low <= truth && truth <= high;
        let wald = share(trials.iter().filter_map(|t| of(t).interval).map(inside));
        let profile = share(
            trials
                .iter()
                .filter_map(|t| Some(t.profiles.as_ref()?[i].holds(truth))),
        );
        let scatter = |t: &Trial| t.resampled.as_ref()?.parameters[i].scatter;
        let scattered = || trials.iter().filter_map(scatter);
        let percentile = share(scattered().map(|s| inside(s.percentile)));
        let basic = share(scattered().map(|s| inside(s.basic)));
        let verdict = |v| {
            share(trials.iter().map(|t| of(t).verdict == v))
                .0
                .unwrap_or(0.0)
        };
        let (determined, weak, not) = (
            verdict(Verdict::Determined),
            verdict(Verdict::Weak),
            verdict(Verdict::NotDetermined),
        );
        let always = ["effective_damping", "remnant_intensity"].contains(&name);
        let usually = determined + weak > 50.0 || always;
        let claimed = setup.expected.iter().find(|(of, _)| *of == name);
        let calibrated = usually && setup.calibrated;
        let mut wrong = Vec::new();
        if calibrated {
            let covers = wald.0.is_some_and(|part| (88.0..=99.0).contains(&part));
            if !covers {
                wrong.push("coverage");
            }
            if middle.abs() >= 0.35 * sigma && middle.abs() >= 0.005 * truth {
                wrong.push("bias");
            }
        }
        if claimed.is_some_and(|(_, v)| verdict(*v) < 95.0) {
            wrong.push("verdict");
        }
        outside.extend(
            wrong
                .iter()
                .map(|what| format!("{}: {name}: {what}", setup.name)),
        );
        let judged = match (calibrated || claimed.is_some(), wrong.is_empty()) {
            (false, _) => "–".into(),
            (true, true) => "holds".into(),
            (true, false) => format!("**fails: {}**", wrong.join(", ")),
        };
        let _ = writeln!(
            table,
            "| {} | `{name}` | {} | {} | {} | {} | {:+.2} σ, {:+.1} % | {determined:.0}/{weak:.0}/{not:.0} | {judged} |",
            setup.name,
            words(wald),
            words(profile),
            words(percentile),
            words(basic),
            middle / sigma,
            100.0 * middle / truth,
        );
    }
    outside
}

/// The table over `fits` fits of each setup whose name holds `which`, and what fell outside.
pub fn calibrate(fits: usize, which: &str) -> (String, Vec<String>) {
    let effective = effective_damping();
    let mut table = String::from(
        "| fit | parameter | Wald [%] | profile [%] | bootstrap, percentile [%] | bootstrap, basic [%] | median bias | determined/weak/not [%] | 88–99 %, bias < .35 σ or < .5 % |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    let mut outside = Vec::new();
    for setup in setups().iter().filter(|setup| setup.name.contains(which)) {
        let trials: Vec<Trial> = (0..fits)
            .into_par_iter()
            .map(|number| {
                let seeds = (number * setup.rides..).take(setup.rides);
                let rides: Vec<Ride> = seeds.map(|s| ride(&synthesis(s as u64))).collect();
                trial(setup, number, &rides)
            })
            .collect();
        outside.extend(rows(setup, &trials, effective, &mut table));
    }
    (table, outside)
}

/// What falls outside, known and published; an estimator that changes changes this list.
const PUBLISHED: [&str; 3] = [
    "whittle, three channels, 24 s: camber_stiffness: coverage",
    "whittle, three channels, 6 × 24 s: cornering_stiffness: coverage",
    "whittle, three channels, 6 × 24 s: camber_stiffness: coverage",
];

#[test]
#[ignore = "slow: 200 fits of each setup, in release"]
fn calibration_is_published() {
    let (table, outside) = calibrate(200, "");
    let text = format!(
        "# Calibration\n\n\
         How often 95 % intervals hold the truth over 200 synthetic rides (or sextets of rides) of a\n\
         known bicycle, by standard error (Wald), profile likelihood and bootstrap ({JOBS} refits each), the\n\
         number of fits in brackets; the median error in standard deviations of the estimates and in\n\
         per cent of the truth; and what the verdicts say. The set-up and the seeds are in\n\
         `tests/it/calibration.rs`; `cargo test --release -p tests --test it -- --ignored calibration`\n\
         makes this file. A row that fails its rule is published as it is.\n\n{table}"
    );
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../identify/CALIBRATION.md");
    std::fs::write(path, text).expect("writable");
    assert_eq!(outside, PUBLISHED);
}
