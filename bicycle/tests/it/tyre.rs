//! The front contact, and the signs of what it does.

use bicycle::dynamics::{Angles, derivative};
use bicycle::mass::PAPER_BICYCLE;
use bicycle::real::sign;
use bicycle::{Bicycle, Formulation, Input, Parameters, State, tyre};
use proptest::prelude::*;

/// The bicycle without a rider's hand: what the geometry does by itself.
fn free() -> Bicycle {
    let p = Parameters {
        rider_roll_gain: 0.0,
        rider_roll_rate_gain: 0.0,
        rider_steer_gain: 0.0,
        rider_steer_rate_gain: 0.0,
        ..Parameters::default()
    };
    Bicycle::new(&p, Formulation::Repaired)
}

fn rates(x: &State) -> State {
    derivative(&free(), x, &Input::default())
}

proptest! {
    #[test]
    fn slip_angle_solves_the_yaw_rate(
        steer in -1.4..1.4f64, slip in -1.4..1.4f64, speed in 0.5..20.0f64,
    ) {
        // the front contact runs less than 90° off the frame, or it runs backwards
        prop_assume!((steer - slip).abs() < 1.4);
        let b = free();
        let yaw_rate = tyre::yaw_rate(&b, speed, steer, slip);
        let back = tyre::slip_angle(steer, tyre::path_angle(&b, speed, yaw_rate));
        // a few roundings of angles up to 1.4
        prop_assert!((back - slip).abs() < 1e-15 * 4.0, "{back} {slip}");
        // and the other way round, V tan(θ − β)/L is the yaw rate itself; the tangent of 1.4
        // stretches the angle's rounding by 1/(sin 1.4 cos 1.4) = 6
        let again = tyre::yaw_rate(&b, speed, steer, back);
        prop_assert!((again - yaw_rate).abs() <= 40.0 * f64::EPSILON * yaw_rate.abs());
    }
}

proptest! {
    #[test]
    fn sign_is_smooth_or_a_jump(x in -2.0..2.0f64, width in 1e-6..1.0f64) {
        // hypot and √(x² + w²) round differently, an ulp of at most 1
        prop_assert!((sign(x, width) - x / x.hypot(width)).abs() <= 4.0 * f64::EPSILON);
        prop_assert_eq!(sign(-x, width), -sign(x, width));
        prop_assert_eq!(sign(x, 0.0), x.signum());
    }
}

#[test]
fn sign_of_nothing_is_nothing() {
    assert_eq!(sign(0.0, 0.0), 0.0);
    assert_eq!(sign(0.0, 1e-3), 0.0);
}

#[test]
fn steering_left_yaws_left_and_leans_right() {
    let x = State {
        steer: 0.02,
        ..State::default()
    };
    let dx = rates(&x);
    assert!(dx.yaw_rate > 0.0);
    // the turn that follows throws the bicycle over to the right, out of it
    let turning = State {
        yaw_rate: 0.5,
        ..State::default()
    };
    assert!(rates(&turning).roll_rate > 0.0);
    // and a tyre that slips to the left of its path pushes left
    let b = free();
    assert!(tyre::lateral_force(&b, tyre::slip_angle(x.steer, 0.0)) > 0.0);
}

#[test]
fn leaning_right_falls_right_and_steers_right() {
    let x = State {
        roll: 0.02,
        ..State::default()
    };
    let dx = rates(&x);
    assert!(dx.roll_rate > 0.0);
    assert!(dx.steer_rate < 0.0);
    // camber thrust pushes the way the wheel leans, and yaws the front that way
    let b = free();
    assert!(tyre::camber_thrust(&b, &x) > 0.0);
    assert!(dx.yaw_rate < 0.0);
}

#[test]
fn torques_and_moments_act_to_their_side() {
    let at_rest = State::default();
    let with = |u| derivative(&free(), &at_rest, &u);
    let left = with(Input {
        steer_torque: 1.0,
        ..Input::default()
    });
    let assist = with(Input {
        assist_torque: 1.0,
        ..Input::default()
    });
    let right = with(Input {
        roll_moment: 1.0,
        ..Input::default()
    });
    let b = free();
    assert_eq!(left.steer_rate, 1.0 / b.steering_inertia);
    assert_eq!(assist, left);
    assert_eq!(right.roll_rate, 1.0 / b.lumps.roll_inertia);
    assert_eq!((right.steer_rate, right.yaw_rate), (0.0, 0.0));
}

#[test]
fn the_rider_steers_into_the_lean() {
    let p = Parameters::<f64>::default();
    let lean = State {
        roll: 0.1,
        ..State::default()
    };
    let falling = State {
        roll_rate: 0.1,
        ..State::default()
    };
    for x in [lean, falling] {
        assert!(bicycle::rider::torque(&p, &x, 2.0) < 0.0);
    }
    let scheduled = Parameters {
        rider_roll_rate_gain: 13.256,
        rider_roll_rate_gain_slope: -2.132,
        ..p
    };
    // k(V) = k + slope · V at 3 m/s, one rounding each
    let expected = -(13.256 - 2.132 * 3.0) * 0.1;
    let found = bicycle::rider::torque(&scheduled, &falling, 3.0);
    assert!((found - expected).abs() < 1e-15, "{found} {expected}");
}

#[test]
fn trail_follows_the_contact_point() {
    let b = free();
    let (roll, r, trail) = (0.2f64, b.p.front_wheel_radius, b.p.trail);
    // sines from two libraries, an ulp apart
    let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-15);
    let leaning = Angles::at(&State {
        roll,
        ..State::default()
    });
    close(tyre::contact_shift(&b, &leaning), r * roll.sin());
    // lean right, steer left: the contact moves away from the steer axis
    close(
        tyre::effective_trail(&b, &leaning, 1.0),
        trail * roll.cos() + r * roll.sin(),
    );
    close(
        tyre::effective_trail(&b, &leaning, -1.0),
        trail * roll.cos() - r * roll.sin(),
    );
    close(
        b.fork_offset,
        r * b.p.caster_angle.sin() - trail * b.p.caster_angle.cos(),
    );
}

#[test]
fn the_front_carries_its_share() {
    let b = free();
    let p = &b.p;
    let moment = b.front_load * p.wheelbase;
    // moments about the rear contact; two roundings
    let weight = p.gravity * (PAPER_BICYCLE.mass * PAPER_BICYCLE.x + 75.0 * 0.30);
    assert!((moment - weight).abs() < 1e-12 * weight);
}
