#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]

use super::{HeldOut, formulations, validate};
use crate::effort::Effort;
use crate::fit::fit;
use crate::free::Free;
use crate::objective::Objective;
use crate::plan::Plan;
use crate::progress::Watch;
use crate::ride::Ride;
use crate::run::{Recorded, Run, Source};
use crate::synthesis::Synthesis;
use bicycle::{Excitation, Parameters};

fn rider() -> Parameters {
    Parameters {
        rider_roll_gain: 150.0,
        rider_roll_rate_gain: 60.0,
        rider_steer_gain: 0.0,
        rider_steer_rate_gain: 0.0,
        ..Parameters::default()
    }
}

fn ride(parameters: &Parameters, intensity: f64, duration: f64, seed: u64) -> Ride {
    let synthesis = Synthesis {
        parameters: *parameters,
        excitation: Excitation {
            remnant_intensity: intensity,
            ..Excitation::default()
        },
        torque_recorded: true,
        duration,
        seed,
        ..Synthesis::default()
    };
    synthesis.ride().unwrap()
}

fn run(ride: &Ride, objective: Objective, free: &[&str]) -> Run {
    let plan = Plan {
        parameters: rider(),
        objective: Some(objective),
        free: Some(free.iter().map(|name| Free::new(name).unwrap()).collect()),
        ..Plan::default()
    };
    let ridden = plan.ridden(ride);
    let recorded = Recorded::new(Source::of(ride), "nominal", &ridden, &plan);
    let (problem, fit) = fit(&[ridden], &plan, &Effort::default(), &Watch::default()).unwrap();
    Run::new(vec![recorded], &plan, &problem, 1, fit)
}

const SPECTRAL: [&str; 3] = [
    "cornering_stiffness",
    "camber_stiffness",
    "effective_damping",
];

fn mean_misfit(held_out: &HeldOut) -> f64 {
    held_out.spectrum.as_ref().unwrap().misfit.mean
}

#[test]
fn a_ride_of_the_same_bicycle_is_foretold_and_one_on_other_tyres_is_not() {
    let run = run(&ride(&rider(), 1.2, 24.0, 1), Objective::Whittle, &SPECTRAL);
    let soft = Parameters {
        cornering_stiffness: 9.0,
        ..rider()
    };
    // half the intensity: the scatter of one ride is 7 %
    let rides = [ride(&rider(), 0.6, 24.0, 2), ride(&soft, 1.2, 24.0, 3)];
    let validation = validate(&run, &rides).unwrap();
    let [same, other] = &validation.held_out[..] else {
        panic!("two rides");
    };
    let misfit = &same.spectrum.as_ref().unwrap().misfit;
    assert!(
        (misfit.mean_band.0..misfit.mean_band.1).contains(&misfit.mean),
        "{}",
        misfit.mean
    );
    // 1 % of 65 bins is expected outside; the fit's own errors add a few
    assert!(misfit.outside < 0.1, "{}", misfit.outside);
    assert!(
        mean_misfit(other) > 1.5 * misfit.mean_band.1,
        "{}",
        mean_misfit(other)
    );
    assert!(same.error() < other.error());
    // each ride has its own intensity
    let [renewed] = &same.renewed[..] else {
        panic!("{:?}", same.renewed);
    };
    assert_eq!(renewed.name, "remnant_intensity");
    assert!(renewed.value < renewed.fitted);
}

#[test]
fn windows_of_another_ride_are_replayed() {
    let free = ["cornering_stiffness", "viscous_friction"];
    let run = run(&ride(&rider(), 1.2, 12.0, 1), Objective::Time, &free);
    let validation = validate(&run, &[ride(&rider(), 1.2, 6.0, 2)]).unwrap();
    for replay in &validation.held_out[0].replays {
        // encoder and gyroscope noise is all that is left
        assert!(replay.variance_accounted_for > 0.95, "{replay:?}");
        assert!(
            replay.median_window > 0.8 && replay.fit > 75.0,
            "{replay:?}"
        );
    }
    assert!(validation.held_out[0].error() < 0.05);
}

#[test]
fn the_formulation_that_made_the_rides_is_preferred_and_foretells_best() {
    let own = [ride(&rider(), 1.2, 24.0, 1)];
    let other = [ride(&rider(), 1.2, 24.0, 2)];
    let run = run(&own[0], Objective::Whittle, &SPECTRAL);
    let names = ["repaired", "whipple", "minimal"].map(String::from);
    let candidates = formulations(&run, &own, &other, &names).unwrap();
    let [repaired, whipple] = [0, 1].map(|i| candidates[i].weighed.clone().unwrap());
    assert!(repaired.criteria.aic < whipple.criteria.aic, "{whipple:?}");
    assert!(repaired.criteria.bic < whipple.criteria.bic);
    assert!(repaired.error < whipple.error);
    // without slip there are no tyres to seek
    assert_eq!(
        (repaired.parameters.len(), whipple.parameters.len()),
        (4, 2)
    );
    // and this rider cannot keep the third upright, which says so and stops neither
    assert_eq!(candidates[2].weighed, None);
    let why = candidates[2].failed.clone().unwrap();
    assert!(why.contains("closed loop"), "{why}");
    // four parameters under a Hann window
    let p = repaired.criteria.parameters;
    assert!((p - 4.0 * 35.0 / 18.0).abs() < 1e-6, "{p}");
}
