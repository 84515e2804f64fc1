//! The internal grid: results depend on the instants of change, not on where one looks.
//! Everything here is compared bitwise: the rule promises the same operations.

use bicycle::dynamics;
use bicycle::simulate::{Simulation, rk4};
use bicycle::{Formulation, Input, Output, Parameters};

fn parameters() -> Parameters {
    Parameters {
        roll_start: -5f64.to_radians(),
        steer_start: 1f64.to_radians(),
        ..Parameters::default()
    }
}

fn ride() -> Simulation {
    Simulation::new(&parameters(), Formulation::Repaired, Input::default(), 0.0).expect("nominal")
}

fn seen(ride: &Simulation) -> [u64; Output::LEN] {
    ride.output().to_array().map(f64::to_bits)
}

/// Arrives at each of `instants` in turn.
fn through(mut ride: Simulation, instants: impl IntoIterator<Item = f64>) -> Simulation {
    for t in instants {
        ride.advance(t).expect("no fall");
        assert_eq!(ride.time().to_bits(), t.to_bits());
    }
    ride
}

#[test]
fn looking_changes_nothing() {
    for end in [1u32, 2] {
        let at_once = seen(&through(ride(), [f64::from(end)]));
        let each = |rate: u32| {
            through(
                ride(),
                (1..=end * rate).map(|k| f64::from(k) / f64::from(rate)),
            )
        };
        assert_eq!(seen(&each(60)), at_once, "60 Hz");
        assert_eq!(seen(&each(200)), at_once, "5 ms");
        assert_eq!(seen(&each(1000)), at_once, "1 ms");
        assert_eq!(seen(&each(7)), at_once, "7 Hz");
        let by_product = through(ride(), (1..=end * 200).map(|k| f64::from(k) * 5e-3));
        assert_eq!(seen(&by_product), at_once, "5 ms, times as products");
        // a thousand arrivals 1e-9 s apart across the grid point at .5 s, and their sums round
        let mut t = 0.5 - 500e-9;
        let mut close = through(ride(), [t]);
        for _ in 0..1000 {
            t += 1e-9;
            close.advance(t).expect("no fall");
        }
        assert_eq!(seen(&through(close, [f64::from(end)])), at_once, "1e-9 s");
    }
}

#[test]
fn a_grid_that_starts_elsewhere() {
    let start = |t0| {
        Simulation::new(&parameters(), Formulation::Repaired, Input::default(), t0).expect("fine")
    };
    let at_once = seen(&through(start(3.7), [4.7]));
    assert_eq!(
        seen(&through(start(3.7), [3.7004, 3.7 + 1.0 / 60.0, 4.7])),
        at_once
    );
    // the model knows no clock: the step is Δ whatever the time
    assert_eq!(seen(&through(start(0.0), [1.0])), at_once);
}

#[test]
fn the_same_value_is_no_change() {
    let at_once = seen(&through(ride(), [1.0]));
    let mut again = ride();
    for k in 1..=60 {
        again.set_input(Input::default()).expect("no change");
        again.set_parameters(&parameters()).expect("no change");
        again.advance(f64::from(k) / 60.0).expect("no fall");
    }
    assert_eq!(seen(&again), at_once);
}

fn pushed() -> Input {
    Input {
        steer_torque: 2.0,
        ..Input::default()
    }
}

/// A push from `change` on, looked at at `before` and `after` besides.
fn push(change: f64, before: &[f64], after: &[f64]) -> Simulation {
    let mut ride = through(ride(), before.iter().copied().chain([change]));
    ride.set_input(pushed()).expect("a push");
    through(ride, after.iter().copied().chain([1.0]))
}

#[test]
fn only_the_instant_of_change_counts() {
    // off the grid, near it on either side, and on it
    for change in [0.3004, 0.300_000_1, 0.299_999_9, 0.3] {
        let plain = seen(&push(change, &[], &[]));
        let watched = push(
            change,
            &[0.1, 0.123_456, 0.2999],
            &[0.30045, 0.3007, 0.31, 0.77],
        );
        assert_eq!(seen(&watched), plain, "{change}");
        assert_ne!(
            plain,
            seen(&push(change + 1e-4, &[], &[])),
            "and it does count"
        );
    }
    let plain = seen(&push(0.3004, &[], &[]));
    let in_two = {
        let mut ride = through(ride(), [0.3004]);
        ride.set_input(pushed()).expect("a push");
        let softer = Parameters {
            viscous_friction: 0.2,
            ..parameters()
        };
        let mut ride = through(ride, [0.5001]);
        ride.set_parameters(&softer).expect("a change");
        seen(&through(ride, [1.0]))
    };
    assert_ne!(in_two, plain, "a parameter counts as well");
}

#[test]
fn an_instant_on_the_grid_up_to_rounding_is_on_it() {
    let (product, sum) = (3.0 * 0.1, 0.3);
    assert_ne!(product, sum);
    assert_eq!(seen(&push(product, &[], &[])), seen(&push(sum, &[], &[])));
}

#[test]
fn the_shortened_step_ends_on_the_grid() {
    let change = 0.0104;
    let mut ride = through(ride(), [change]);
    let state = *ride.state();
    ride.set_input(pushed()).expect("a push");
    let work = ride.derivatives();
    ride.advance(0.011).expect("no fall");
    assert_eq!(ride.derivatives() - work, 4);
    let b = ride.bicycle();
    let by_hand = rk4(state, 11.0 * 1e-3 - change, |_, x| {
        dynamics::derivative(b, x, &pushed())
    });
    assert_eq!(*ride.state(), by_hand);
    // and from there on whole steps
    let by_hand = rk4(by_hand, 1e-3, |_, x| dynamics::derivative(b, x, &pushed()));
    ride.advance(0.012).expect("no fall");
    assert_eq!(*ride.state(), by_hand);
}

#[test]
fn work_is_counted() {
    let work = |rate: u32| {
        through(ride(), (1..=rate).map(|k| f64::from(k) / f64::from(rate))).derivatives()
    };
    assert_eq!(work(1), 4000);
    assert_eq!(work(200), 4000);
    // 20 of the 60 arrivals lie on the grid of 1 ms, 40 take a step of their own
    assert_eq!(work(60), 4000 + 40 * 4);
    // arriving at t_c and the rest of that step
    assert_eq!(push(0.3004, &[], &[]).derivatives(), 4000 + 4);
}

#[test]
fn a_clone_goes_its_own_way() {
    let mut one = through(ride(), [0.5]);
    let other = one.clone();
    one.set_input(pushed()).expect("a push");
    let one = through(one, [1.0]);
    assert_eq!(seen(&through(other, [1.0])), seen(&through(ride(), [1.0])));
    assert_eq!(seen(&one), seen(&push(0.5, &[], &[])));
}
