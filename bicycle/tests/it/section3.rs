//! The nine cases of section 3 under exact jumps, with the bicycle calibrated to the paper's
//! claims.

use crate::published;
use bicycle::cases::{self, Case, Course};
use bicycle::mass::{self, Body};
use bicycle::simulate::{Simulation, Stop};
use bicycle::{Formulation, Input, Parameters};

/// The set `section3`, the smoothing widths [rad, rad/s] given.
fn section3(internal_step: f64, [steer_smoothing, steer_rate_smoothing]: [f64; 2]) -> Parameters {
    let mut p = Parameters::default();
    let value = published::section("section3", &["parameters"]);
    for name in [
        "front_wheel_mass",
        "steer_inertia",
        "front_wheel_inertia",
        "rear_wheel_inertia",
        "cornering_stiffness",
        "camber_stiffness",
        "viscous_friction",
        "coulomb_friction",
        "rider_roll_gain",
        "rider_roll_rate_gain",
        "rider_steer_gain",
        "rider_steer_rate_gain",
    ] {
        p.set(Parameters::index(name).expect("a row"), value(name));
    }
    let value = published::section("section3", &["lumps"]);
    p.set_lumps(mass::compose(&[Body {
        mass: value("total_mass"),
        x: value("cog_to_rear"),
        h: value("cog_height"),
        roll_inertia: value("roll_inertia"),
        yaw_inertia: value("yaw_inertia"),
        cross_inertia: value("cross_inertia"),
    }]));
    Parameters {
        internal_step,
        steer_smoothing,
        steer_rate_smoothing,
        ..p
    }
}

const EXACT: [f64; 2] = [0.0, 0.0];

/// The widths of the table.
fn default() -> [f64; 2] {
    let p = Parameters::<f64>::default();
    [p.steer_smoothing, p.steer_rate_smoothing]
}

fn course(case: &Case, p: &Parameters) -> Course {
    case.run(p, Formulation::Repaired, Input::default(), 1e-3)
        .expect("a stable step")
}

fn limit_passed(course: &Course) -> f64 {
    match course.stop {
        Some(Stop::SteerLimit { t }) => t,
        other => panic!("{other:?}"),
    }
}

fn largest_difference(one: &Course, other: &Course) -> f64 {
    assert_eq!(one.time.len(), other.time.len());
    let pairs = one.steer.iter().zip(&other.steer);
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// What the search for this set found with jumps not smoothed.
#[test]
fn amplitudes_and_times_are_those_of_the_calibration() {
    for step in [1e-3, 1e-4] {
        let p = section3(step, EXACT);
        let found = cases::all().map(|case| course(&case, &p));
        let amplitudes = [2.832, 2.724, 1.745, 0.851, 0.831, 0.533];
        for (course, expected) in found.iter().zip(amplitudes) {
            let found = course.amplitude().expect("five seconds").to_degrees();
            // half a unit of the last digit given
            assert!(
                (found - expected).abs() < 5.1e-4,
                "{found}° for {expected}°"
            );
        }
        for (course, expected) in found[6..].iter().zip([0.361, 0.395, 0.433]) {
            let t = limit_passed(course);
            assert!((t - expected).abs() < 5.1e-4, "{t} s for {expected} s");
        }
    }
}

/// Left and right are alike: the mirrored start gives the mirrored motion, to the last bit.
#[test]
fn the_mirrored_case_is_the_mirror_of_the_case() {
    for case in cases::all() {
        let p = case.parameters(&section3(1e-3, EXACT));
        let mirrored = Parameters {
            roll_start: -p.roll_start,
            steer_start: -p.steer_start,
            yaw_rate_start: -p.yaw_rate_start,
            ..p
        };
        let mut rides = [p, mirrored].map(|p| {
            Simulation::new(&p, Formulation::Repaired, Input::default(), 0.0)
                .expect("a stable step")
        });
        for k in 1..=50 {
            let [one, other] = rides.each_mut().map(|ride| {
                let _ = ride.advance(0.1 * f64::from(k));
                (*ride.state(), ride.stop(), ride.derivatives())
            });
            assert_eq!(one.0, other.0.map(|value| -value), "case {}", case.number);
            assert_eq!((one.1, one.2), (other.1, other.2), "case {}", case.number);
        }
    }
}

#[test]
fn steps_of_a_millisecond_are_fine_enough() {
    for case in &cases::all()[..6] {
        let [whole, tenth] = [1e-3, 1e-4].map(|step| course(case, &section3(step, EXACT)));
        let moved = largest_difference(&whole, &tenth);
        // 5e-8 rad is seen: a ten-thousandth of what the default smoothing changes
        assert!(moved < 1e-7, "case {}: {moved} rad", case.number);
    }
}

/// The error that the default smoothing widths make: the largest change of θ [rad] in each bounded
/// case, and of the time of 85° [s]. It comes from the friction, which creeps where it should hold.
#[test]
fn error_of_the_default_smoothing() {
    let stated = [2.84e-3, 2.97e-3, 3.90e-3, 1.81e-3, 1.45e-3, 2.24e-3];
    for (case, stated) in cases::all().iter().zip(stated) {
        // steps of .1 ms, so that it is the smoothing that is seen
        let [exact, smooth] =
            [EXACT, default()].map(|widths| course(case, &section3(1e-4, widths)));
        let error = largest_difference(&exact, &smooth);
        // stated to three digits, rounded up
        assert!(
            (0.99 * stated..stated).contains(&error),
            "case {}: {error}",
            case.number
        );
    }
    for case in &cases::all()[6..] {
        let [exact, smooth] =
            [EXACT, default()].map(|widths| limit_passed(&course(case, &section3(1e-4, widths))));
        assert!(
            (exact - smooth).abs() < 2.2e-5,
            "case {}: {exact} s, {smooth} s",
            case.number
        );
    }
}

/// Each jump is exact by itself, and what is smoothed narrowly enough is the exact motion.
#[test]
fn narrow_smoothing_comes_near_the_jump() {
    for case in &cases::all()[..6] {
        let exact = course(case, &section3(1e-4, EXACT));
        // in steps of a third of what the friction's slope d/(ε I) allows
        for (widths, step) in [([0.0, 1e-5], 1e-5), ([1e-4, 0.0], 1e-4)] {
            let error = largest_difference(&exact, &course(case, &section3(step, widths)));
            // a fiftieth of what the default widths make: the bicycle falls over slowly while its
            // fork sticks, and that multiplies the creep
            assert!(error < 6e-5, "case {} {widths:?}: {error}", case.number);
        }
    }
}

/// The fork stops, sticks and turns some ten times in five seconds; it does not chatter.
#[test]
fn nothing_chatters() {
    for case in cases::all() {
        let p = case.parameters(&section3(1e-3, EXACT));
        let mut ride = Simulation::new(&p, Formulation::Repaired, Input::default(), 0.0)
            .expect("a stable step");
        let mut senses = Vec::new();
        while ride.stop().is_none() && senses.len() < 5000 {
            let _ = ride.advance(1e-3 * (senses.len() + 1) as f64);
            let rate = ride.state().steer_rate;
            senses.push(if rate == 0.0 { 0.0 } else { rate.signum() });
        }
        let changes = senses.windows(2).filter(|w| w[0] != w[1]).count();
        assert!(
            (3..=15).contains(&changes),
            "case {}: {changes}",
            case.number
        );
        let back_and_forth = senses
            .windows(3)
            .filter(|w| w[0] * w[1] < 0.0 && w[1] * w[2] < 0.0);
        assert_eq!(back_and_forth.count(), 0, "case {}", case.number);
        // four derivatives a step, eight more while the fork is held; about ten pieces of four for
        // each change of sense and as many passages of θ = 0, and fifty for the steer limit
        let held = senses.iter().filter(|s| **s == 0.0).count();
        let steps = 4 * senses.len() + 8 * held;
        let events = ride.derivatives() - steps as u64;
        assert!(events < 1500, "case {}: {events}", case.number);
    }
}

/// When |θ| passes `steer_limit` [°], or the bicycle falls without [s].
fn end_times(case: &Case, steer_limit: f64) -> [f64; 5] {
    [5e-4, 2e-4, 1e-4, 5e-5, 2e-5].map(|step| {
        let p = Parameters {
            steer_limit: steer_limit.to_radians(),
            ..section3(step, EXACT)
        };
        course(case, &p).end_time()
    })
}

/// At 90° sec θ and tan θ push back without bound: only the overshoot of a finite step gets across,
/// each at a time of its own. That is why the steer limit is 85°.
#[test]
fn ninety_degrees_are_a_barrier() {
    for case in &cases::all()[6..] {
        let t = end_times(case, 85.0);
        for pair in t.windows(2) {
            assert!(
                (pair[0] - pair[1]).abs() < 2e-6,
                "case {}: {t:?}",
                case.number
            );
        }
        // fourth order: 1e-10 s is seen
        assert!((t[3] - t[4]).abs() < 1e-9, "case {}: {t:?}", case.number);

        let t = end_times(case, 90.0);
        let spread = |t: &[f64]| {
            let latest = t.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            latest - t.iter().copied().fold(f64::INFINITY, f64::min)
        };
        // at .1, .05 and .02 ms still seconds apart
        assert!(spread(&t[2..]) > 0.1, "case {}: {t:?}", case.number);
    }
}
