//! Known parameters come back from synthetic rides, as often as their standard errors say.
//!
//! The set-up is that of a rider who only leans on roll and roll rate (150 N m/rad, 60 N m s/rad),
//! 8 km/h, 24 s at 200 Hz, remnant 1.2 N m rms: about 4° of steering. Rides are made with half the
//! internal step of the fits' tables, other seeds and sensor noise.

use bicycle::{Excitation, Formulation, Parameters};
use identify::effort::Effort;
use identify::fit::{Fit, fit};
use identify::free::{ALL, Free};
use identify::objective::Objective;
use identify::plan::Plan;
use identify::progress::Watch;
use identify::ride::Ride;
use identify::synthesis::{SensorNoise, Synthesis};
use identify::verdict::Verdict;
use std::f64::consts::FRAC_2_PI;

const SEEDS: u64 = 20;
const INTENSITY: f64 = 1.2;

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
        seed: 500 + seed,
        ..Synthesis::default()
    }
}

fn ride(synthesis: &Synthesis) -> Ride {
    synthesis.ride().expect("a ride that does not fall")
}

fn plan(objective: Objective) -> Plan {
    Plan {
        parameters: rider(),
        objective: Some(objective),
        ..Plan::default()
    }
}

fn run(ride: &Ride, plan: &Plan) -> Fit {
    let (_, fit) = fit(
        &[plan.ridden(ride)],
        plan,
        &Effort::default(),
        &Watch::default(),
    )
    .expect("a fit");
    assert!(fit.converged, "{}", fit.termination);
    fit
}

/// The effective damping behind a ride: its own steer rate, without sensor noise.
fn effective_damping(seed: u64) -> f64 {
    let ridden = ride(&Synthesis {
        noise: SensorNoise::NONE,
        ..synthesis(seed)
    });
    let steer = ridden.channel("steer").expect("recorded");
    let rates = steer.windows(2).map(|w| (w[1] - w[0]) / ridden.step());
    let rms = (rates.map(|r| r * r).sum::<f64>() / (steer.len() - 1) as f64).sqrt();
    rider().viscous_friction + FRAC_2_PI.sqrt() * rider().coulomb_friction / rms
}

fn truth(name: &str, seed: u64) -> f64 {
    match name {
        "effective_damping" => effective_damping(seed),
        "remnant_intensity" => INTENSITY,
        _ => rider().get(Parameters::index(name).expect("a row")),
    }
}

/// A number in 0..1 that differs from seed to seed and parameter to parameter.
fn spread(seed: u64, which: u64) -> f64 {
    ((seed * 7 + which * 13 + 1) as f64 * 0.618_033_988_75).fract()
}

/// Each of `names` within 3 standard errors in at least 18 of the fits.
fn assert_recovered(fits: &[Fit], names: &[&str]) {
    for name in names {
        let within = fits.iter().enumerate().filter(|(seed, fit)| {
            let e = fit.estimate(name).expect("a free parameter");
            let error = e.std_error.unwrap_or(0.0);
            (e.value - truth(name, *seed as u64)).abs() <= 3.0 * error
        });
        let count = within.count();
        assert!(count >= 18, "{name}: {count} of {SEEDS}");
    }
}

#[test]
fn with_the_torque_measured_all_four_come_back() {
    let fits: Vec<Fit> = (0..SEEDS)
        .map(|seed| {
            let mut plan = plan(Objective::Time);
            for (k, name) in ALL.iter().enumerate() {
                let index = Parameters::index(name).expect("a row");
                let start = plan.parameters.get(index) * (0.6 + 0.9 * spread(seed, k as u64));
                plan.parameters.set(index, start);
            }
            run(
                &ride(&Synthesis {
                    torque_recorded: true,
                    ..synthesis(seed)
                }),
                &plan,
            )
        })
        .collect();
    assert_recovered(&fits, &ALL);
    for fit in &fits {
        assert!(
            fit.parameters
                .iter()
                .all(|e| e.verdict == Verdict::Determined),
            "{fit:?}"
        );
    }
}

#[test]
fn from_steering_alone_effective_damping_and_intensity_come_back_from_any_start() {
    let fits: Vec<Fit> = (0..SEEDS)
        .map(|seed| {
            let mut plan = plan(Objective::Amplitude);
            plan.excitation.effective_damping = 10.0 * spread(seed, 1);
            plan.excitation.remnant_intensity = 20.0 * spread(seed, 2);
            run(&ride(&synthesis(seed)), &plan)
        })
        .collect();
    assert_recovered(&fits, &["effective_damping", "remnant_intensity"]);
}

#[test]
fn from_steering_alone_neither_tyres_nor_the_kinds_of_friction_are_determined() {
    for seed in 0..5 {
        let mut plan = plan(Objective::Amplitude);
        let free = ALL.iter().map(|name| Free::new(name));
        plan.free = Some(free.collect::<Result<_, _>>().expect("rows"));
        let fit = run(&ride(&synthesis(seed)), &plan);
        for name in ALL {
            let e = fit.estimate(name).expect("a free parameter");
            assert_eq!(e.verdict, Verdict::NotDetermined, "seed {seed}: {e:?}");
        }
        for (name, other) in [
            ("viscous_friction", "coulomb_friction"),
            ("coulomb_friction", "viscous_friction"),
        ] {
            let e = fit.estimate(name).expect("a free parameter");
            assert_eq!(e.std_error, None, "their sum only is seen: {e:?}");
            assert!(e.trades_against.iter().any(|t| t == other), "{e:?}");
        }
    }
}

#[test]
fn from_three_channels_the_tyres_come_back_determined() {
    let fits: Vec<Fit> = (0..SEEDS)
        .map(|seed| {
            let mut plan = plan(Objective::Whittle);
            plan.parameters.cornering_stiffness = 2.0 + 38.0 * spread(seed, 1);
            plan.parameters.camber_stiffness = 3.0 * spread(seed, 2);
            run(&ride(&synthesis(seed)), &plan)
        })
        .collect();
    assert_recovered(&fits, &["cornering_stiffness", "camber_stiffness"]);
    for fit in &fits {
        for name in ["cornering_stiffness", "camber_stiffness"] {
            let e = fit.estimate(name).expect("a free parameter");
            assert_eq!(e.verdict, Verdict::Determined, "{e:?}");
        }
    }
}

/// The four-body bicycle is fitted as any other: with slip all four, without slip the friction, and
/// nothing is sought that its equations do not have.
#[test]
fn rides_of_the_four_body_bicycle_are_fitted_by_it() {
    let friction = ["viscous_friction", "coulomb_friction"];
    for (formulation, sought) in [
        (Formulation::Whipple, &friction[..]),
        (Formulation::WhippleSlip, &ALL[..]),
    ] {
        let truth = Parameters::default();
        let recorded = ride(&Synthesis {
            parameters: Parameters {
                internal_step: 0.5e-3,
                ..truth
            },
            formulation,
            torque_recorded: true,
            ..synthesis(7)
        });
        let fit = run(
            &recorded,
            &Plan {
                formulation,
                parameters: Parameters {
                    viscous_friction: 0.5,
                    coulomb_friction: 0.1,
                    ..truth
                },
                objective: Some(Objective::Time),
                ..Plan::default()
            },
        );
        let found: Vec<_> = fit.parameters.iter().map(|e| e.name.as_str()).collect();
        assert_eq!(found, sought, "{formulation:?}");
        for e in &fit.parameters {
            let expected = truth.get(Parameters::index(&e.name).expect("a row"));
            let error = e.std_error.expect("known");
            // one ride: within four standard errors
            assert!(
                (e.value - expected).abs() < 4.0 * error,
                "{formulation:?} {e:?}"
            );
        }
        let alone = fit
            .notes
            .iter()
            .any(|note| note.starts_with("only the front tyre"));
        assert_eq!(alone, formulation == Formulation::WhippleSlip);
    }
}

#[test]
fn a_whole_ride_cannot_be_replayed_and_the_eigenvalue_is_named() {
    let plan = Plan {
        window: Some(24.0),
        ..plan(Objective::Time)
    };
    let recorded = ride(&Synthesis {
        torque_recorded: true,
        ..synthesis(0)
    });
    let error = fit(
        &[plan.ridden(&recorded)],
        &plan,
        &Effort::default(),
        &Watch::default(),
    )
    .map(drop)
    .expect_err("the bicycle is unstable");
    let error = error.to_string();
    for said in [
        "found 24 s",
        "eigenvalue +2.78 ± 2.41i 1/s",
        "grow by e^12 in that time",
    ] {
        assert!(error.contains(said), "{error}");
    }
}

/// Over a second errors of a start grow by e^2.8: such windows are reached by way of half as long
/// ones.
#[test]
fn windows_too_long_to_begin_with_are_fitted_by_way_of_short_ones() {
    let plan = Plan {
        window: Some(1.0),
        ..plan(Objective::Time)
    };
    let recorded = ride(&Synthesis {
        torque_recorded: true,
        ..synthesis(0)
    });
    let fit = run(&recorded, &plan);
    assert_eq!(fit.work.passes, 2, "one search a length");
    for e in &fit.parameters {
        let error = e.std_error.expect("known");
        // one ride: within four standard errors
        assert!((e.value - truth(&e.name, 0)).abs() < 4.0 * error, "{e:?}");
    }
}

#[test]
fn the_work_of_a_fit_is_counted() {
    let fit = run(&ride(&synthesis(3)), &plan(Objective::Whittle));
    // one curvature an iteration, at least one cost an iteration besides the start's
    assert_eq!(fit.work.curvature_evaluations, fit.work.iterations);
    assert!(fit.work.cost_evaluations > fit.work.iterations);
    assert!(
        fit.work.iterations <= 30,
        "about twelve from the nominal values: {:?}",
        fit.work
    );
}
