#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
use super::*;
use crate::free::{Candidate, Free};
use crate::ride::Ride;
use crate::solver::{Limits, Search, minimise};
use bicycle::simulate::Simulation;

/// A ride of the nominal bicycle with its law in the loop and a torque of many sines besides:
/// `seconds` at 100 Hz.
fn ridden(formulation: Formulation, seconds: usize) -> Ride {
    let parameters = Parameters {
        internal_step: 0.5e-3,
        ..Parameters::default()
    };
    // no two in phase, no two multiples of one another
    let torque = |t: f64| -> f64 {
        (1..=24)
            .map(|k| {
                let k = f64::from(k);
                (TAU * 0.127 * k.powf(1.03) * t + k * k).sin()
            })
            .sum()
    };
    let mut input = Input {
        speed: 4.0,
        ..Input::default()
    };
    let mut simulation = Simulation::new(&parameters, formulation, input, 0.0).unwrap();
    let n = 100 * seconds;
    let mut ride = Ride::new(0.0, 0.01, n);
    let (mut steer, mut roll_rate, mut torques) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..n {
        let t = 0.01 * i as f64;
        steer.push(simulation.state().steer);
        roll_rate.push(simulation.state().roll_rate);
        torques.push(torque(t));
        for piece in 0..10 {
            let t = t + 1e-3 * f64::from(piece);
            input.steer_torque = torque(t + 0.5e-3);
            simulation.set_input(input).unwrap();
            simulation.advance(t + 1e-3).unwrap();
        }
    }
    ride.insert("speed", vec![4.0; n]).unwrap();
    ride.insert("steer", steer).unwrap();
    ride.insert("roll_rate", roll_rate).unwrap();
    ride.insert("steer_torque", torques).unwrap();
    ride.law_in_loop = Some(true);
    ride
}

fn landscape(ride: &Ride, formulation: Formulation, free: &[&str], start: &Parameters) -> Frf {
    let unknowns = Unknowns {
        free: free.iter().map(|name| Free::new(name).unwrap()).collect(),
        ties: Vec::new(),
        start: Candidate {
            parameters: *start,
            ..Candidate::default()
        },
    };
    let channels = ["steer", "roll_rate"];
    Frf::new(
        ride,
        &channels,
        unknowns,
        formulation,
        (4.0, 10.0),
        (0.3, 3.0),
    )
    .unwrap()
}

#[test]
fn a_linear_bicycle_is_its_own_response() {
    let ride = ridden(Formulation::Whipple, 120);
    let smooth = Parameters {
        coulomb_friction: 0.0,
        ..Parameters::default()
    };
    let frf = landscape(&ride, Formulation::Whipple, &["viscous_friction"], &smooth);
    let z = frf.unknowns.start.variables(&frf.unknowns.free);
    // Coulomb friction of the ride apart, magnitudes within 1 dB and phases within 10°
    let (costs, all) = frf.costs(&z).unwrap();
    assert!((costs.iter().sum::<f64>() - all).abs() < 1e-9 * all);
    assert!(all < 100.0, "{costs:?}");
    for (points, model) in frf.points.iter().zip(frf.model(&z).unwrap()) {
        assert!(points.len() > 8, "{} bins", points.len());
        for (point, model) in points.iter().zip(model) {
            assert!(
                (point.response / model).ln().norm() < 0.25,
                "{point:?} {model}"
            );
        }
    }
}

#[test]
fn tyres_and_friction_come_back_from_responses() {
    let formulation = Formulation::Repaired;
    let ride = ridden(formulation, 240);
    let truth = Parameters::default();
    let names = ["cornering_stiffness", "viscous_friction"];
    let start = Parameters {
        cornering_stiffness: 9.0,
        viscous_friction: 0.8,
        ..truth
    };
    let frf = landscape(&ride, formulation, &names, &start);
    let free = &frf.unknowns.free;
    let bound = |value: fn(&Free) -> f64| {
        DVector::from_iterator(free.len(), free.iter().map(|f| f.variable(value(f))))
    };
    let limits = Limits {
        lower: bound(|f| f.lower),
        upper: bound(|f| f.upper),
        reach: DVector::from_element(free.len(), 0.7),
    };
    let z = frf.unknowns.start.variables(free);
    let found = minimise(
        &frf,
        z,
        &Search {
            limits: &limits,
            held: &[],
            tolerance: 1e-9,
            max_iterations: 100,
            watch: crate::progress::Watch::default(),
        },
    )
    .unwrap();
    assert!(found.converged, "{}", found.termination);
    let information = frf.information(&found.point).unwrap();
    let inverse = information.curvature.clone().try_inverse().unwrap();
    let covariance = &inverse * information.meat.unwrap() * &inverse;
    for (i, name) in names.iter().enumerate() {
        let value = free[i].value(found.point[i]);
        let expected = truth.get(Parameters::index(name).unwrap());
        let error = covariance[(i, i)].sqrt() * free[i].slope(value);
        // one ride: four standard errors, and the two per cent that the linearisation may be off
        assert!(
            (value - expected).abs() < 4.0 * error + 0.02 * expected,
            "{name}: {value} ± {error}, expected {expected}"
        );
    }
}

#[test]
fn what_a_response_cannot_know_is_refused() {
    let ride = ridden(Formulation::Whipple, 30);
    let unknowns = |name: &str| Unknowns {
        free: vec![Free::new(name).unwrap()],
        ties: Vec::new(),
        start: Candidate::default(),
    };
    let frf = |name: &str, window: f64, band: (f64, f64)| {
        let whipple = Formulation::Whipple;
        Frf::new(
            &ride,
            &["steer"],
            unknowns(name),
            whipple,
            (4.0, window),
            band,
        )
    };
    for (refused, message) in [
        (frf("torque_offset", 10.0, (0.3, 3.0)), "torque_offset"),
        (
            frf("remnant_intensity", 10.0, (0.3, 3.0)),
            "remnant_intensity",
        ),
        (
            frf("viscous_friction", 10.0, (3.0, 60.0)),
            "50 Hz (Nyquist)",
        ),
        (
            frf("viscous_friction", 25.0, (0.3, 3.0)),
            "30 s (the record)",
        ),
        (frf("viscous_friction", 10.0, (40.0, 45.0)), "found 0"),
    ] {
        let error = refused.unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}
