//! Inputs that run straight in time: the same rules of the grid, and the same order.

use bicycle::simulate::Simulation;
use bicycle::{Formulation, Input, Output, Parameters};

/// Smoothing so wide that the fourth order shows at steps of milliseconds.
fn parameters() -> Parameters {
    Parameters {
        steer_smoothing: 0.05,
        steer_rate_smoothing: 0.5,
        roll_start: -0.05,
        steer_start: 0.02,
        ..Parameters::default()
    }
}

const START: Input = Input {
    speed: 2.0,
    steer_torque: -1.0,
    assist_torque: 0.0,
    roll_moment: -0.0,
};

/// Faster by 3 m/s and more torque by 4 N m in a second.
const SLOPE: Input = Input {
    speed: 3.0,
    steer_torque: 4.0,
    ..Input::ZERO
};

fn at_rest(p: &Parameters) -> Simulation {
    Simulation::new(p, Formulation::Repaired, START, 0.0).expect("stable at 2 m/s")
}

/// The ramp from the start on.
fn ride(p: &Parameters) -> Simulation {
    let mut ride = at_rest(p);
    ride.set(p, START, SLOPE).expect("no other speed yet");
    ride
}

fn through(mut ride: Simulation, instants: impl IntoIterator<Item = f64>) -> Simulation {
    for t in instants {
        ride.check_until(t).expect("stable up to 5 m/s");
        ride.advance(t).expect("no fall");
    }
    ride
}

fn seen(ride: &Simulation) -> ([u64; Output::LEN], [u64; Input::LEN]) {
    (
        ride.output().to_array().map(f64::to_bits),
        ride.input().to_array().map(f64::to_bits),
    )
}

fn rate(hertz: u32) -> impl Iterator<Item = f64> {
    (1..=hertz).map(move |k| f64::from(k) / f64::from(hertz))
}

#[test]
fn inputs_follow_the_ramp() {
    let ride = through(ride(&parameters()), [0.25, 0.5]);
    assert_eq!(
        ride.input(),
        Input {
            speed: 3.5,
            steer_torque: 1.0,
            ..START
        }
    );
    assert_eq!(ride.input_slope(), &SLOPE);
    // what stands still is handed out as it was set, the sign of zero and all
    assert!(ride.input().roll_moment.is_sign_negative());
}

#[test]
fn looking_at_a_ramp_changes_nothing() {
    let p = parameters();
    let at_once = seen(&through(ride(&p), [1.0]));
    for hertz in [7, 60, 200, 1000] {
        assert_eq!(seen(&through(ride(&p), rate(hertz))), at_once, "{hertz} Hz");
    }
    let mut straight = at_rest(&p);
    straight.advance(1.0).expect("no fall");
    assert_ne!(seen(&straight), at_once, "and a ramp does count");
}

/// What the ramp has just reached is no change, on the grid and off it: it goes on from its old
/// anchor, and no step is shortened.
#[test]
fn setting_what_a_ramp_has_reached_is_no_change() {
    let p = parameters();
    let at_once = through(ride(&p), [1.0]);
    let mut again = ride(&p);
    for t in rate(60) {
        again.advance(t).expect("no fall");
        let reached = again.input();
        again.set(&p, reached, SLOPE).expect("no change");
        again.set_parameters(&p).expect("no change");
    }
    assert_eq!(seen(&again), seen(&at_once));
    // another slope at the same value is a change
    let mut kept = through(ride(&p), [0.3004]);
    let work = kept.derivatives();
    let reached = kept.input();
    kept.set_input(reached).expect("the ramp ends");
    kept.advance(0.301).expect("no fall");
    assert_eq!(kept.derivatives() - work, 4, "one shortened step");
    assert_eq!(kept.input(), reached);
}

/// A change of parameters off the grid leaves the anchor where it is.
#[test]
fn a_ramp_goes_on_through_a_change_of_parameters() {
    let p = parameters();
    let heavier = Parameters {
        rear_load: 10.0,
        ..p
    };
    let changed = |instants: &[f64]| {
        let mut ride = through(ride(&p), instants.iter().copied().chain([0.3004]));
        ride.set_parameters(&heavier).expect("a load");
        through(ride, [0.77, 1.0])
    };
    assert_eq!(seen(&changed(&[])), seen(&changed(&[0.1, 0.2999])));
    assert_eq!(changed(&[]).input(), through(ride(&p), [1.0]).input());
}

#[test]
fn an_instant_on_the_grid_up_to_rounding_is_on_it_for_a_ramp_too() {
    let p = parameters();
    let ramped_from = |t: f64| {
        let mut ride = through(at_rest(&p), [t]);
        ride.set(&p, START, SLOPE).expect("2 m/s");
        assert_eq!(ride.input(), START);
        through(ride, [1.0])
    };
    let (product, sum) = (3.0 * 0.1, 0.3);
    assert_ne!(product, sum);
    assert_eq!(seen(&ramped_from(product)), seen(&ramped_from(sum)));
}

fn difference(a: &Simulation, b: &Simulation) -> f64 {
    let (a, b) = (a.output().to_array(), b.output().to_array());
    // roll, steer, their rates, yaw rate, heading and place
    let square = |i: usize| (a[i] - b[i]).powi(2);
    (0..8).map(square).sum::<f64>().sqrt()
}

#[test]
fn a_ramp_keeps_the_order_of_the_stepper() {
    let end = |internal_step| {
        let p = Parameters {
            internal_step,
            ..parameters()
        };
        through(ride(&p), [1.0])
    };
    let truth = end(1e-3 / 8.0);
    let errors = [4e-3, 2e-3, 1e-3].map(|step| difference(&end(step), &truth));
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        // the next order's term and the reference's own error (8⁻⁴ of the finest) bend it by .1
        assert!((order - 4.0).abs() < 0.3, "{order} from {errors:?}");
    }
}

/// Stairs with the ramp's mean over each stair come as close as one likes.
#[test]
fn a_ramp_is_the_limit_of_stairs() {
    let p = parameters();
    let ramp = through(ride(&p), [1.0]);
    let stairs = |count: u32| {
        let mut ride = at_rest(&p);
        for k in 0..count {
            let middle = (f64::from(k) + 0.5) / f64::from(count);
            let mean = START.zip(&SLOPE, |u: f64, slope: f64| u + slope * middle);
            ride.set_input(mean).expect("stable");
            ride.advance(f64::from(k + 1) / f64::from(count))
                .expect("no fall");
        }
        difference(&ride, &ramp)
    };
    let errors = [50, 100, 200].map(stairs);
    for pair in errors.windows(2) {
        // the midpoint rule: second order in the length of a stair
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 2.0).abs() < 0.1, "{order} from {errors:?}");
    }
    assert!(errors[2] < 1e-4, "{errors:?}");
}

/// A located event takes the inputs of its own time.
#[test]
fn a_stop_on_a_ramp_does_not_depend_on_where_one_looks() {
    let p = Parameters::default().riderless();
    let stopped = |hertz: u32| {
        let mut ride = ride(&p);
        let torque = Input {
            steer_torque: 100.0,
            ..Input::ZERO
        };
        ride.set(&p, START, torque).expect("2 m/s");
        for k in 1.. {
            if let Err(stop) = ride.advance(f64::from(k) / f64::from(hertz)) {
                let elapsed = stop.time() * 100.0;
                assert_eq!(ride.input().steer_torque, START.steer_torque + elapsed);
                return (stop, seen(&ride));
            }
        }
        unreachable!("it falls or steers to its limit")
    };
    assert_eq!(stopped(1), stopped(60));
    assert_eq!(stopped(1), stopped(3333));
}

/// At once or not at all.
#[test]
fn a_refused_change_changes_nothing() {
    let p = Parameters {
        cornering_stiffness: 40.0,
        internal_step: 5e-3,
        ..parameters()
    };
    let mut ride = at_rest(&p);
    ride.advance(0.3004).expect("no fall");
    let before = (seen(&ride), *ride.parameters(), *ride.input_slope());
    let slow = Input {
        speed: 0.5,
        ..START
    };
    let softer = Parameters {
        viscous_friction: 0.2,
        ..p
    };
    assert!(ride.set(&softer, slow, SLOPE).is_err());
    assert!(ride.set(&p, slow, SLOPE).is_err());
    let after = (seen(&ride), *ride.parameters(), *ride.input_slope());
    assert_eq!(after, before);
    let untouched = through(at_rest(&p), [1.0]);
    assert_eq!(seen(&through(ride, [1.0])), seen(&untouched));
}
