//! Which rides are compared: falls, courses, lines, and what is refused.

use super::{SAMPLES, case, fell, of, pair, ride, sampled, stood, swinging, swings, unknown};
use crate::assist::{Known, Outcome, Pair, Ridden, worth};
use crate::spectrum::{Line, Recipe};
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

#[test]
fn who_falls_is_told_and_compared_with_nothing() {
    let up = || stood(swinging(0.1, 1.0, |_, _| 0.5));
    let outcome = |pairs: &[Pair<Ridden>]| of(pairs).expect("rides").outcome;
    let (without, with) = (fell(300), up());
    let saved = of(&[Pair { without, with }]).expect("rides");
    assert_eq!(saved.outcome, Outcome::Saved);
    assert_eq!((saved.pairs, saved.upright), (1, 0));
    assert_eq!(saved.falls.without.median_time, Known::Value(3.0));
    assert_eq!(
        saved.falls.with.median_time.reason(),
        Some("0 of 1 rides fell")
    );
    for band in &saved.bands {
        let reason = band.change.reason().expect("no pair stood");
        assert!(
            reason.contains("1 fell without the assist and 0 with it"),
            "{reason}"
        );
    }
    // what stood has its spectrum and its motor all the same
    assert_eq!(
        saved.spectra.amplitude.without.reason(),
        Some("every ride fell")
    );
    assert!(saved.spectra.amplitude.with.value().is_some());
    assert_eq!(saved.motor.value().expect("stood").peak_torque, 0.5);
    let thrown = Pair {
        without: up(),
        with: fell(300),
    };
    let thrown = of(&[thrown]).expect("rides");
    assert_eq!(thrown.outcome, Outcome::Thrown);
    assert_eq!(thrown.motor.reason(), Some("every ride fell"));
    // a ride may fall before its first sample
    let both = || Pair {
        without: fell(200),
        with: fell(0),
    };
    let fallen = of(&[both()]).expect("rides");
    assert_eq!(fallen.outcome, Outcome::Fell);
    assert!(fallen.spectra.frequency.is_empty());
    assert_eq!(fallen.path.with.reason(), Some("every ride fell"));
    // of three pairs one stood: it alone is compared, though the others have longer steering
    let some = [
        swings(0.1, 0.05),
        Pair {
            without: fell(900),
            with: stood(swinging(0.3, 1.0, |_, _| 9.0)),
        },
        Pair {
            without: fell(500),
            with: fell(700),
        },
    ];
    let found = of(&some).expect("rides");
    assert_eq!(
        (found.outcome, found.pairs, found.upright),
        (Outcome::Saved, 3, 1)
    );
    assert!((found.judged().expect("one pair").ratio - 0.5).abs() < 1e-12);
    assert!(found.motor.value().expect("one pair").peak_torque < 9.0);
    // by 9 s two of three had fallen
    assert_eq!(found.falls.without.median_time, Known::Value(9.0));
    assert_eq!(
        found.falls.with.median_time.reason(),
        Some("1 of 3 rides fell")
    );
    assert_eq!(found.falls.without.each[1].why, "steer limit");
    assert_eq!(outcome(&[swings(0.1, 0.1)]), Outcome::Stood);
}

#[test]
fn the_way_beside_the_course_is_measured_where_there_is_a_course() {
    let ridden = |offset: f64| {
        let mut ride = swinging(0.1, 1.0, |_, _| 0.0);
        ride.insert("lateral_offset", sampled(|t| -offset * (TAU * t).sin()))
            .expect("a channel");
        ride
    };
    let found = of(&[
        pair(ridden(0.2), ridden(0.1)),
        pair(ridden(0.2), ridden(0.1)),
    ]);
    let path = found.expect("rides").path;
    let (without, with) = (
        path.without.value().expect("a course"),
        path.with.value().expect("a course"),
    );
    // .2 m is reached at a quarter of a swing, which is a sample
    assert!((without.largest - 0.2).abs() < 1e-12 && (with.largest - 0.1).abs() < 1e-12);
    assert!(
        (without.rms - 0.2 * FRAC_1_SQRT_2).abs() < 1e-12,
        "{without:?}"
    );
    let none = of(&[swings(0.1, 0.1)]).expect("rides").path;
    assert_eq!(none.with.reason(), Some("no course was ridden"));
    let mixed = [
        pair(ridden(0.2), ridden(0.1)),
        pair(ridden(0.2), swinging(0.1, 1.0, |_, _| 0.0)),
    ];
    let said = of(&mixed)
        .expect_err("a course in one ride only")
        .to_string();
    assert!(
        said.starts_with("with the assist") && said.contains("`lateral_offset`"),
        "{said}"
    );
}

#[test]
fn rides_that_cannot_be_compared_are_refused_by_name() {
    let refused = |pairs: &[Pair<Ridden>]| of(pairs).expect_err("refused").to_string();
    assert_eq!(
        refused(&[]),
        "rides: expected a pair of rides, without and with the assist, found none"
    );
    let empty = || ride(&[("steer", vec![])]);
    assert_eq!(
        refused(&[pair(empty(), empty())]),
        "pair 1, without the assist: expected a ride, found no sample"
    );
    let full = || swinging(0.1, 1.0, |_, _| 0.0);
    let short = full().slice(0.0..15.0).expect("a slice");
    assert_eq!(
        refused(&[pair(full(), full()), pair(full(), short)]),
        "pair 2, with the assist: expected 2000 samples, 0.01 s apart, as in pair 1, without the \
         assist, found 1500, 0.01 s apart"
    );
    let no_motor = ride(&[("steer", sampled(|t| (TAU * t).sin()))]);
    let said = refused(&[pair(full(), no_motor)]);
    assert!(
        said.starts_with("with the assist: ride: no channel `assist_torque`"),
        "{said}"
    );
    let still = ride(&[("steer", vec![0.0; SAMPLES])]);
    let said = refused(&[pair(still, full())]);
    assert!(
        said.starts_with("without the assist") && said.contains("0 rad throughout"),
        "{said}"
    );
    let mut fallen = fell(100);
    fallen.fell.as_mut().expect("fell").time = f64::NAN;
    let said = refused(&[Pair {
        without: stood(full()),
        with: fallen,
    }]);
    assert!(
        said.starts_with("with the assist: time of a fall: expected a finite number"),
        "{said}"
    );
}

#[test]
fn a_band_under_a_line_has_a_reason_and_the_others_their_numbers() {
    let recipe = Recipe {
        // 20 s: bins within .15 Hz are left out; four such lines cover .3 to .8 Hz
        lines: [0.35, 0.5, 0.65, 0.8]
            .map(|frequency| Line { frequency })
            .to_vec(),
        ..Recipe::default()
    };
    let found = worth(case(0.13, 0.0), &[swings(0.1, 0.05)], &recipe, &unknown()).expect("rides");
    let reason = found.bands[0].change.reason().expect("masked");
    assert!(
        reason.contains("0.3 to 0.8 Hz: no unmasked bin"),
        "{reason}"
    );
    assert!(found.judged().is_some());
}
