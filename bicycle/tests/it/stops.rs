//! What ends a simulation early: the steer limit, located in time, and a fall.

use bicycle::simulate::{Simulation, Stop};
use bicycle::{Formulation, Input, Parameters};

/// A rider who lets go of a leaning bicycle, and a push that turns the fork to its limit;
/// smoothing wide enough for a smooth path.
fn turning(internal_step: f64, steer_limit: f64) -> Simulation {
    let p = Parameters {
        internal_step,
        steer_limit,
        steer_smoothing: 0.05,
        steer_rate_smoothing: 0.5,
        roll_start: -0.05,
        rider_roll_gain: 0.0,
        rider_roll_rate_gain: 0.0,
        rider_steer_gain: 0.0,
        rider_steer_rate_gain: 0.0,
        ..Parameters::default()
    };
    let push = Input {
        steer_torque: 80.0,
        ..Input::default()
    };
    Simulation::new(&p, Formulation::Repaired, push, 0.0).expect("nominal")
}

fn limit() -> f64 {
    85f64.to_radians()
}

/// Runs until it stops.
fn stopped(mut ride: Simulation, interval: f64) -> (Simulation, Stop) {
    let mut k = 0.0;
    loop {
        k += 1.0;
        assert!(k * interval < 10.0, "no stop");
        if let Err(stop) = ride.advance(k * interval) {
            return (ride, stop);
        }
    }
}

#[test]
fn the_steer_limit_is_located_in_time() {
    let times = [1e-3, 5e-4, 2.5e-4].map(|step| {
        let (ride, stop) = stopped(turning(step, limit()), 0.1);
        let Stop::SteerLimit { t } = stop else {
            panic!("{stop}")
        };
        assert_eq!((ride.time(), ride.stop()), (t, Some(stop)));
        // the first instant at or past the limit, to the last bit of the step
        let past = ride.state().steer.abs() - limit();
        assert!((0.0..1e-13).contains(&past), "{past}");
        t
    });
    // the error of RK4 itself: fourth order, 1e-7 s at 1 ms
    assert!((times[0] - times[1]).abs() < 1e-7, "{times:?}");
    assert!((times[1] - times[2]).abs() < 1e-8, "{times:?}");
    // and well inside a step: no multiple of it
    assert!((times[0] / 1e-3).fract() > 0.01);
}

#[test]
fn a_stop_does_not_depend_on_where_one_looks() {
    for formulation in Formulation::ALL {
        let end = |interval| {
            let p = Parameters {
                roll_start: 0.2,
                rider_roll_gain: 0.0,
                rider_roll_rate_gain: 0.0,
                ..Parameters::default()
            };
            let ride = Simulation::new(&p, formulation, Input::default(), 0.0).expect("nominal");
            let (ride, stop) = stopped(ride, interval);
            (stop, *ride.state())
        };
        let stop = end(1.0);
        assert_eq!(end(1.0 / 60.0), stop);
        assert_eq!(end(0.3e-3), stop);
    }
}

#[test]
fn a_stop_is_final() {
    let (mut ride, stop) = stopped(turning(1e-3, limit()), 0.1);
    let (state, work) = (*ride.state(), ride.derivatives());
    assert_eq!(ride.advance(5.0), Err(stop));
    assert_eq!((*ride.state(), ride.derivatives()), (state, work));
    assert_eq!(stop.name(), "steer_limit");
    assert!(stop.to_string().contains("steer limit"));
}

#[test]
fn an_infinite_limit_is_none() {
    let (_, with) = stopped(turning(1e-3, limit()), 0.1);
    let (ride, without) = stopped(turning(1e-3, f64::INFINITY), 0.1);
    assert!(matches!(without, Stop::Diverged { .. }), "{without}");
    assert!(without.time() > with.time());
    assert_eq!(ride.time(), without.time());
    // the last state before the fall is one: on this side of lying down, and next to it
    let roll = ride.state().roll.abs();
    assert!(roll <= std::f64::consts::FRAC_PI_2 && roll > 1.57, "{roll}");
    assert_eq!(without.name(), "diverged");
}

/// What the numbers cannot hold is no state: the last one that is comes back.
#[test]
fn what_overflows_diverges() {
    let p = Parameters {
        steer_limit: f64::INFINITY,
        steer_rate_start: f64::MAX,
        ..Parameters::default()
    };
    let mut ride = Simulation::new(&p, Formulation::Repaired, Input::default(), 0.0)
        .expect("start values are not checked here");
    let stop = ride.advance(1.0).expect_err("an overflow");
    assert!(matches!(stop, Stop::Diverged { .. }), "{stop}");
    assert!(ride.state().to_array().iter().all(|v| v.is_finite()));
}
