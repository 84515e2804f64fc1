use super::*;
use crate::kernel::{Isa, run_with};
use crate::spectrum::{Analysis, Recipe};
use bicycle::Parameters;

/// The steer angle among the rows of the state.
const STEER: usize = 3;

fn rides(torque: &[f64], count: usize) -> Vec<Excited<'_>> {
    let excited = |i: usize| Excited {
        lane: Lane {
            parameters: Parameters {
                cornering_stiffness: 9.0 + 0.5 * i as f64,
                ..Parameters::default()
            },
            speed: 8.0 / 3.6,
            start: State {
                roll: -0.05,
                ..State::ZERO
            },
        },
        torque,
    };
    (0..count).map(excited).collect()
}

fn torque(samples: usize) -> Vec<f64> {
    let at = |k: usize| {
        let t = 5e-3 * k as f64;
        2.0 * (4.0 * t).sin() + (11.3 * t + 1.0).cos()
    };
    (0..samples).map(at).collect()
}

#[test]
fn every_instruction_set_gives_the_same_ride() {
    let (plan, formulation) = (Plan::of(3.0), Formulation::Repaired);
    let torque = torque(plan.samples);
    let rides = rides(&torque, 1);
    let with = |isa| {
        let batch = Batch {
            rides: &rides,
            formulation,
            plan: &plan,
            wanted: Wanted::Steer,
        };
        match &run_with(isa, batch).expect("ridable")[0] {
            Ridden::Steer(steer) => steer.clone(),
            other => panic!("{other:?}"),
        }
    };
    let plain = with(Isa::Portable);
    for isa in Isa::ALL.into_iter().filter(|isa| isa.is_present()) {
        let apart = with(isa)
            .iter()
            .zip(&plain)
            .fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
        // rounding, and what the ride makes of it
        assert!(apart < 1e-9, "{}: {apart:e} rad", isa.name());
    }
}

#[test]
fn coefficients_folded_in_are_those_of_the_samples() {
    let (plan, formulation) = (Plan::of(6.0), Formulation::Repaired);
    let torque = torque(plan.samples);
    // more than one batch, the last one not full
    let rides = rides(&torque, Isa::best().lanes() + 3);
    let analysis = Analysis::new(&Recipe::default(), plan.interval, plan.samples).expect("a band");
    let weights = analysis.weights();
    let steer = ride(&rides, formulation, &plan, Wanted::Steer).expect("ridable");
    let wanted = Wanted::Band(Band {
        before: 0,
        channels: &[STEER],
        weights: &weights,
    });
    let band = ride(&rides, formulation, &plan, wanted).expect("ridable");
    assert_eq!(steer.len(), rides.len());
    for (steer, band) in steer.iter().zip(&band) {
        let (Ridden::Steer(steer), Ridden::Band(band)) = (steer, band) else {
            panic!("{steer:?}, {band:?}");
        };
        let [band] = &band[..] else {
            panic!("{} channels", band.len());
        };
        let naive = analysis.coefficients(steer);
        let size = naive.iter().map(|c| c.norm()).fold(0.0, f64::max);
        assert_eq!(naive.len(), band.len());
        for (naive, folded) in naive.iter().zip(band) {
            assert!(
                (naive - folded).norm() < 1e-11 * size,
                "{naive} and {folded}"
            );
        }
    }
}

#[test]
fn torque_that_ends_before_the_ride_is_an_error() {
    let plan = Plan::of(2.0);
    let torque = torque(10);
    let error = ride(
        &rides(&torque, 1),
        Formulation::Repaired,
        &plan,
        Wanted::Steer,
    );
    let error = error.expect_err("too short").to_string();
    assert_eq!(error, "torque: expected 400 samples or more, found 10");
}
