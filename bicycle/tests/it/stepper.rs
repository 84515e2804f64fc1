//! The stepper: its order, its rest, its stability limit, what it refuses.

use crate::draw;
use bicycle::linear;
use bicycle::simulate::{Refusal, Simulation, stability_limit};
use bicycle::{Bicycle, Formulation, Input, Output, Parameters, State};
use nalgebra::Complex;
use proptest::prelude::*;

/// Smoothing so wide that the fourth order shows at steps of milliseconds.
fn smooth() -> Parameters {
    Parameters {
        steer_smoothing: 0.05,
        steer_rate_smoothing: 0.5,
        roll_start: -0.05,
        steer_start: 0.02,
        ..Parameters::default()
    }
}

fn after_a_second(internal_step: f64) -> [f64; Output::LEN] {
    let p = Parameters {
        internal_step,
        ..smooth()
    };
    let mut ride = Simulation::new(&p, Formulation::Repaired, Input::default(), 0.0)
        .expect("steps below the stability limit");
    ride.advance(1.0).expect("a ride without a fall");
    ride.output().to_array()
}

#[test]
fn order_of_the_stepper_is_four() {
    let truth = after_a_second(1e-3 / 8.0);
    let error = |step| {
        let end = after_a_second(step);
        let square = |i: usize| (end[i] - truth[i]).powi(2);
        // roll, steer, their rates, yaw rate, heading and place
        (0..8).map(square).sum::<f64>().sqrt()
    };
    let errors = [4e-3, 2e-3, 1e-3].map(error);
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        // the next order's term and the reference's own error (8⁻⁴ of the finest) bend it by .1
        assert!((order - 4.0).abs() < 0.3, "{order} from {errors:?}");
    }
}

#[test]
fn upright_and_straight_stays_so() {
    for formulation in Formulation::ALL {
        let p = Parameters::default();
        let mut ride = Simulation::new(&p, formulation, Input::default(), 0.0).expect("nominal");
        ride.advance(2.0).expect("rest");
        assert_eq!(*ride.state(), State::default());
        let end = ride.output();
        assert_eq!((end.heading, end.y), (0.0, 0.0));
        // x is a sum of 2000 equal steps: a rounding of half an ulp of 4.4 each
        assert!((end.x - 2.0 * 8.0 / 3.6).abs() < 2000.0 * f64::EPSILON * 4.0);
    }
}

/// RK4's growth of a mode in one step, z = h λ.
fn amplification(z: Complex<f64>) -> f64 {
    ((((z / 24.0 + 1.0 / 6.0) * z + 0.5) * z + 1.0) * z + 1.0).norm()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn decaying_modes_decay_at_the_stability_limit(
        p in draw::parameters(),
        formulation in prop::sample::select(&Formulation::ALL[..]),
        speed in 0.1..20.0f64,
        share in 0.0..=1.0f64,
    ) {
        let b = Bicycle::new(&p, formulation);
        prop_assume!(b.front_load > 0.0);
        let limit = stability_limit(&b, speed);
        let input = Input { speed, ..Input::default() };
        let (a, _) = linear::state_equations(&b, &State::default(), &input);
        let mut fastest = 0.0f64;
        for mode in linear::eigenvalues(&a) {
            fastest = fastest.max(mode.norm());
            if mode.re < 0.0 {
                // round-off of the eigenvalues: a double root splits by √ε
                prop_assert!(amplification(mode * (share * limit)) <= 1.0 + 1e-7, "{mode}");
            }
        }
        // and the bound is no idle one: Gelfand's root leaves n and the units' spread to 1/512
        prop_assert!(limit * fastest > 2.4, "{limit} s at {fastest} 1/s");
    }
}

#[test]
fn a_mode_beyond_the_limit_would_grow() {
    let b = Bicycle::new(&Parameters::default(), Formulation::Repaired);
    let speed = 8.0 / 3.6;
    let (a, _) = linear::state_equations(
        &b,
        &State::default(),
        &Input {
            speed,
            ..Input::default()
        },
    );
    let largest = |h: f64| {
        let modes = linear::eigenvalues(&a);
        let growths = modes
            .iter()
            .filter(|l| l.re < 0.0)
            .map(|l| amplification(l * h));
        growths.fold(0.0, f64::max)
    };
    let limit = stability_limit(&b, speed);
    // 2.6 of 2.785 on the real axis, and the few per cent of the bound
    assert!(largest(limit) < 1.0 && largest(1.12 * limit) > 1.0);
}

#[test]
fn steps_too_long_are_refused() {
    let p = Parameters {
        cornering_stiffness: 40.0,
        internal_step: 5e-3,
        ..Parameters::default()
    };
    let slow = Input {
        speed: 1.0,
        ..Input::default()
    };
    let refusal = Simulation::new(&p, Formulation::Repaired, slow, 0.0).expect_err("5 ms");
    let Refusal::StepTooLong { step, limit } = refusal else {
        panic!("{refusal}")
    };
    // the yaw pole −L² F_z C_θ/(V I_zz) = −746 1/s admits less than 2.785/746 = 3.7 ms
    assert_eq!(step, 5e-3);
    assert!((3.3e-3..3.74e-3).contains(&limit), "{limit}");
    assert!(
        refusal
            .to_string()
            .contains("internal_step: expected less than")
    );

    // refused as a change, too, and then nothing has changed
    let mut ride = Simulation::new(&p, Formulation::Repaired, Input::default(), 0.0)
        .expect("fast enough for 5 ms");
    assert!(ride.set_input(slow).is_err());
    assert_eq!(ride.input(), Input::default());
    let soft = Parameters {
        steer_rate_smoothing: 1e-4,
        ..p
    };
    assert!(ride.set_parameters(&soft).is_err());
    assert_eq!(ride.parameters(), &p);
    // no speed, no step
    for speed in [0.0, f64::NAN] {
        let still = Input {
            speed,
            ..Input::default()
        };
        assert!(ride.set_input(still).is_err());
    }
}

/// A jump has no slope: width 0 asks for no shorter step than no Coulomb friction does.
#[test]
fn jumps_do_not_shorten_the_step() {
    let limit = |p: &Parameters| stability_limit(&Bicycle::new(p, Formulation::Repaired), 3.0);
    let exact = Parameters {
        steer_smoothing: 0.0,
        steer_rate_smoothing: 0.0,
        ..Parameters::default()
    };
    let frictionless = Parameters {
        coulomb_friction: 0.0,
        ..Parameters::default()
    };
    assert_eq!(limit(&exact), limit(&frictionless));
    assert!(limit(&exact) > limit(&Parameters::default()));
}

#[test]
fn a_lifted_front_wheel_is_refused() {
    let p = Parameters {
        rear_load: 100.0,
        rear_load_x: -0.4,
        ..Parameters::default()
    };
    let refusal = Simulation::new(&p, Formulation::Repaired, Input::default(), 0.0);
    // (92.5 · .339 − 100 · .4) kg m · g/L
    let expected = (p.total_mass * p.cog_to_rear - 40.0) * p.gravity / p.wheelbase;
    match refusal.expect_err("lifted") {
        Refusal::Lifted { wheel, load } => {
            assert_eq!(wheel, "front");
            assert!((load - expected).abs() < 1e-9);
        }
        other => panic!("{other}"),
    }
}

/// Each wheel carries something: the centre of mass behind the front contact, before the rear one.
#[test]
fn a_lifted_rear_wheel_is_refused() {
    for formulation in Formulation::ALL {
        let mut p = Parameters::default();
        p.set_lumps(p.lumps().moved(p.wheelbase + 0.01, p.cog_height));
        let refusal = Simulation::new(&p, formulation, Input::default(), 0.0).expect_err("lifted");
        assert!(matches!(refusal, Refusal::Lifted { wheel: "rear", load } if load < 0.0));
    }
}

#[test]
fn fixed_rows_keep_their_values() {
    let p = smooth();
    let mut ride = Simulation::new(&p, Formulation::Repaired, Input::default(), 0.0).expect("fine");
    let other = Parameters {
        internal_step: 5e-3,
        roll_start: 0.3,
        trail: 0.11,
        ..p
    };
    ride.set_parameters(&other).expect("a change of trail");
    assert_eq!(ride.parameters(), &Parameters { trail: 0.11, ..p });
}
