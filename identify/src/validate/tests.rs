#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]

use super::replay::{Replayed, replayed};
use super::{HeldOut, Validation, formulations, unfitted};
use crate::effort::Effort;
use crate::fit::fit;
use crate::free::{Candidate, Free, Scope};
use crate::objective::time::Time;
use crate::objective::{Objective, Unknowns};
use crate::plan::{Change, Plan, Ridden};
use crate::progress::Watch;
use crate::ride::Ride;
use crate::run::{Recorded, Run, Source};
use crate::synthesis::{SensorNoise, Synthesis};
use bicycle::{Excitation, Formulation, Parameters};

fn rider() -> Parameters {
    Parameters::default().steered_by_roll(150.0, 60.0)
}

fn ride(parameters: &Parameters, intensity: f64, duration: f64, seed: u64) -> Ride {
    let formulation = Formulation::default();
    ridden_by(formulation, parameters, intensity, duration, seed)
}

fn ridden_by(
    formulation: Formulation,
    parameters: &Parameters,
    intensity: f64,
    duration: f64,
    seed: u64,
) -> Ride {
    let synthesis = Synthesis {
        parameters: *parameters,
        formulation,
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
    Run::new(vec![recorded], &plan, &problem, &Effort::default(), fit)
}

const SPECTRAL: [&str; 3] = [
    "cornering_stiffness",
    "camber_stiffness",
    "effective_damping",
];

/// `rides` of the only condition of `run`.
fn ridden<'a>(run: &Run, rides: &'a [Ride]) -> Vec<Ridden<'a>> {
    let rides = rides.iter();
    rides
        .map(|ride| unfitted(run, ride, None).unwrap())
        .collect()
}

fn validate(run: &Run, rides: &[Ride]) -> Validation {
    super::validate(run, &ridden(run, rides)).unwrap()
}

fn mean_misfit(held_out: &HeldOut) -> f64 {
    held_out.spectrum.as_ref().unwrap().misfit.mean
}

#[test]
fn a_ride_of_the_same_bicycle_is_predicted_and_one_on_other_tyres_is_not() {
    let run = run(&ride(&rider(), 1.2, 24.0, 1), Objective::Whittle, &SPECTRAL);
    let soft = Parameters {
        cornering_stiffness: 9.0,
        ..rider()
    };
    // half the intensity: the scatter of one ride is 7 %
    let rides = [ride(&rider(), 0.6, 24.0, 2), ride(&soft, 1.2, 24.0, 3)];
    let validation = validate(&run, &rides);
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
    let [again] = &same.reestimated[..] else {
        panic!("{:?}", same.reestimated);
    };
    assert_eq!(again.name, "remnant_intensity");
    assert!(again.value < again.fitted);
}

#[test]
fn windows_of_another_ride_are_replayed() {
    let free = ["cornering_stiffness", "viscous_friction"];
    let run = run(&ride(&rider(), 1.2, 12.0, 1), Objective::Time, &free);
    let validation = validate(&run, &[ride(&rider(), 1.2, 6.0, 2)]);
    for Replayed { replay, fit, .. } in &validation.held_out[0].replays {
        // encoder and gyroscope noise is all that is left
        assert!(replay.variance_accounted_for > 0.95, "{replay:?}");
        assert!(replay.median_window > 0.8 && *fit > 75.0, "{replay:?}");
    }
    assert!(validation.held_out[0].error() < 0.05);
}

#[test]
fn given_windows_are_replayed_under_the_gain_that_rides_share() {
    // three rides of few windows each, whose torque was recorded with a gain of .8; a fit needs
    // more windows than parameters of all of them, not of each
    let rides: Vec<Ride> = (1..=3)
        .map(|seed| {
            let mut ride = ride(&rider(), 1.2, 3.0, seed);
            let torque = ride.channel("steer_torque").unwrap();
            let torque = torque.iter().map(|t| 0.8 * t).collect();
            ride.insert("steer_torque", torque).unwrap();
            ride
        })
        .collect();
    let windows = vec![100..200, 350..430];
    let free = ["viscous_friction", "torque_gain"];
    let plan = Plan {
        parameters: rider(),
        objective: Some(Objective::Time),
        free: Some(free.iter().map(|name| Free::new(name).unwrap()).collect()),
        changes: vec![("torque_gain", Change::Scope(Scope::Shared))],
        ..Plan::default()
    };
    let ridden = |ride| Ridden {
        windows: windows.clone(),
        ..plan.ridden(ride)
    };
    let fitted: Vec<_> = rides[..2].iter().map(ridden).collect();
    let (effort, watch) = (Effort::default(), Watch::default());
    let (problem, fit) = fit(&fitted, &plan, &effort, &watch).unwrap();
    let gain = fit.estimate("torque_gain").unwrap();
    let error = gain.std_error.unwrap();
    // four windows: Student's t at 1 % of two degrees of freedom is 10 standard errors
    assert!((gain.value - 0.8).abs() < 10.0 * error, "{gain:?}");
    assert!((gain.value - 0.8).abs() < 0.1, "{gain:?}");
    let too_few = fit_of_one(&ridden(&rides[0]), &plan);
    assert!(too_few.contains("found 1 windows"), "{too_few}");

    let recorded =
        |ridden: &Ridden| Recorded::new(Source::of(ridden.ride), "nominal", ridden, &plan);
    let run = Run::new(
        fitted.iter().map(recorded).collect(),
        &plan,
        &problem,
        &Effort::default(),
        fit,
    );
    let in_windows = |windows| {
        let whole = unfitted(&run, &rides[2], None).unwrap();
        super::validate(&run, &[Ridden { windows, ..whole }])
    };
    let held_out = &in_windows(windows.clone()).unwrap().held_out[0];
    assert_eq!(held_out.reestimated, []);
    for Replayed { replay, .. } in &held_out.replays {
        // encoder and gyroscope noise is all that is left
        assert!(replay.median_window > 0.9, "{replay:?}");
    }
    // a window behind the ride's end is not cut out of it but refused
    let refused = in_windows(vec![100..200, 500..700])
        .unwrap_err()
        .to_string();
    assert!(refused.contains("found 2.5 to 3.5 s"), "{refused}");
}

/// Why one window of `ridden` cannot be fitted.
fn fit_of_one(ridden: &Ridden, plan: &Plan) -> String {
    let one = Ridden {
        windows: ridden.windows[..1].to_vec(),
        ..ridden.clone()
    };
    let refused = fit(&[one], plan, &Effort::default(), &Watch::default());
    refused.map(drop).unwrap_err().to_string()
}

#[test]
fn the_formulation_that_made_the_rides_is_preferred_and_predicts_best() {
    let own = [ride(&rider(), 1.2, 24.0, 1)];
    let other = [ride(&rider(), 1.2, 24.0, 2)];
    let run = run(&own[0], Objective::Whittle, &SPECTRAL);
    let names = ["repaired", "whipple", "minimal"].map(String::from);
    let candidates = formulations(&run, &own, &ridden(&run, &other), &names).unwrap();
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

/// The channels of a ride of 12 s replayed in half seconds by `parameters`.
fn judged(ride: &Ride, parameters: &Parameters) -> Vec<Replayed> {
    let unknowns = Unknowns {
        free: Vec::new(),
        ties: Vec::new(),
        start: Candidate {
            parameters: *parameters,
            ..Candidate::default()
        },
    };
    let channels = ["steer", "roll_rate", "yaw_rate"];
    let speed = Plan::default().speed;
    let formulation = Formulation::default();
    let time = Time::new(ride, &channels, unknowns, formulation, (speed, 0.5), None).unwrap();
    replayed(&time, &time.start(), ride).unwrap()
}

/// At 1 % about 1 % of true models are rejected, and with the inputs' 99 % bands about 1 % of the lags
/// lie outside: of 60 rides and 3 channels 1.8 ± 1.3 rejections, 99.9 % up to 7.
#[test]
fn a_true_model_leaves_white_noise_and_a_wrong_one_does_not() {
    let wrong = Parameters {
        cornering_stiffness: 9.0,
        ..rider()
    };
    let (mut rejected, mut statistic, mut freedom) = ([0; 3], [0.0; 3], 0.0);
    let (mut found, mut outside) = (0, [0.0; 3]);
    let rides = 60;
    for seed in 0..rides {
        // noise of the torque sensor drives the replay and would show in what it leaves
        let synthesis = Synthesis {
            parameters: rider(),
            noise: SensorNoise {
                torque: 0.0,
                ..SensorNoise::INSTRUMENTED
            },
            torque_recorded: true,
            duration: 12.0,
            seed: 100 + seed,
            ..Synthesis::default()
        };
        let ride = synthesis.ride().unwrap();
        for (c, replayed) in judged(&ride, &rider()).into_iter().enumerate() {
            rejected[c] += u32::from(replayed.whiteness.probability < 0.01);
            statistic[c] += replayed.whiteness.statistic;
            outside[c] += replayed.torque.unwrap().outside / rides as f64;
            freedom += replayed.whiteness.freedom as f64 / 3.0;
        }
        let white = |r: &Replayed| r.whiteness.probability >= 0.01;
        found += u32::from(!judged(&ride, &wrong).iter().all(white));
    }
    assert!(
        rejected.iter().sum::<u32>() <= 7,
        "{rejected:?} {outside:?}"
    );
    for statistic in statistic {
        // Σ χ² over rides: 3.3 deviations, and a hundredth for what is no noise
        let reach = 3.3 * (2.0 * freedom).sqrt() + 0.01 * freedom;
        assert!(
            (statistic - freedom).abs() < reach,
            "{statistic} of {freedom}"
        );
    }
    for outside in outside {
        // 6000 lags of which neighbours are nearly alike
        assert!((0.003..0.025).contains(&outside), "{outside}");
    }
    assert!(found > 50, "{found} of {rides}");
}

/// Formulations of windows differ in how many states start freely: without a price for them the one
/// with the most would seem the best.
#[test]
fn starts_of_windows_have_their_price() {
    let rider = rider();
    let whipple = Formulation::Whipple;
    let own = [ridden_by(whipple, &rider, 1.2, 12.0, 1)];
    let other = [ridden_by(whipple, &rider, 1.2, 12.0, 2)];
    let plan = Plan {
        parameters: rider,
        formulation: whipple,
        objective: Some(Objective::Time),
        free: Some(vec![Free::new("viscous_friction").unwrap()]),
        ..Plan::default()
    };
    let first = plan.ridden(&own[0]);
    let recorded = Recorded::new(Source::of(&own[0]), "nominal", &first, &plan);
    let (problem, fit) = fit(&[first], &plan, &Effort::default(), &Watch::default()).unwrap();
    let run = Run::new(vec![recorded], &plan, &problem, &Effort::default(), fit);
    let names = ["whipple", "whipple_slip", "repaired"].map(String::from);
    let candidates = formulations(&run, &own, &ridden(&run, &other), &names).unwrap();
    let criteria: Vec<_> = (candidates.iter())
        .map(|c| c.weighed.clone().unwrap().criteria)
        .collect();
    // 24 windows, and the states of each formulation
    assert_eq!(criteria[0].starts, 24 * 4);
    assert_eq!(criteria[2].starts, 24 * 5);
    assert!(criteria[0].aic < criteria[1].aic && criteria[0].aic < criteria[2].aic);
    assert!(criteria[0].bic < criteria[1].bic && criteria[0].bic < criteria[2].bic);
}

#[test]
fn a_ride_is_predicted_by_the_estimates_of_its_condition() {
    let soft = Parameters {
        cornering_stiffness: 7.0,
        ..rider()
    };
    let own = [ride(&rider(), 1.2, 24.0, 1), ride(&soft, 1.2, 24.0, 2)];
    let plan = Plan {
        parameters: rider(),
        objective: Some(Objective::Whittle),
        free: Some(vec![Free::new("cornering_stiffness").unwrap()]),
        changes: vec![("cornering_stiffness", Change::Scope(Scope::Condition))],
        ..Plan::default()
    };
    let of = |(ride, condition): (_, &str)| Ridden {
        condition: condition.into(),
        ..plan.ridden(ride)
    };
    let both: Vec<Ridden> = own.iter().zip(["hard", "soft"]).map(of).collect();
    let recorded = both
        .iter()
        .map(|r| Recorded::new(Source::of(r.ride), "nominal", r, &plan));
    let recorded = recorded.collect();
    let (problem, fit) = fit(&both, &plan, &Effort::default(), &Watch::default()).unwrap();
    let run = Run::new(recorded, &plan, &problem, &Effort::default(), fit);
    let ride = ride(&soft, 1.2, 24.0, 3);
    let misfit = |condition| {
        let ridden = unfitted(&run, &ride, condition).unwrap();
        let held_out = super::validate(&run, &[ridden]).unwrap().held_out.remove(0);
        assert_eq!(held_out.condition.as_deref(), condition);
        let misfit = held_out.spectrum.unwrap().misfit;
        (misfit.mean, misfit.mean_band)
    };
    let (own, band) = misfit(Some("soft"));
    assert!((band.0..band.1).contains(&own), "{own}");
    // with the mean of both it is not
    assert!(misfit(None).0 > band.1, "{:?}", misfit(None));
    assert!(misfit(Some("hard")).0 > misfit(None).0);
    let unknown = unfitted(&run, &ride, Some("sofd")).unwrap_err().to_string();
    assert!(unknown.contains("soft"), "{unknown}");
}

#[test]
fn responses_have_nothing_to_predict() {
    let run = run(&ride(&rider(), 1.2, 24.0, 1), Objective::Whittle, &SPECTRAL);
    let mut frf = run;
    frf.fit.objective = Objective::Frf;
    let error = super::validate(&frf, &[]).unwrap_err().to_string();
    assert!(
        error.contains("amplitude, whittle, time, free-response, not for frf"),
        "{error}"
    );
}
