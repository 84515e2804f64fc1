//! The nine cases, the same study with loads, and what is said of them.

use crate::published::{benchmark, benchmark_bicycle};
use bicycle::cases::{self, Course, Oscillation, Rearward, dominant_frequency, reversals};
use bicycle::simulate::{Simulation, Stop};
use bicycle::{Formulation, Input, Parameters, linear};
use std::f64::consts::TAU;

/// The dominant frequency of four seconds in steps of 5 ms from 1 s on, as the cases have them.
fn found(trace: impl Fn(f64) -> f64) -> Option<f64> {
    let time: Vec<f64> = (200..=1000).map(|k| 0.005 * f64::from(k)).collect();
    let trace: Vec<f64> = time.iter().map(|t| trace(*t)).collect();
    dominant_frequency(&reversals(&time, &trace))
}

#[test]
fn a_swing_has_its_frequency_whatever_its_damping_phase_and_drift() {
    for frequency in [0.3, 0.61, 1.0, 2.345, 9.9] {
        for phase in [0.0, 1.0, 2.0] {
            for (decay, drift) in [(0.0, 0.0), (0.9, 0.0), (-0.3, 0.0), (0.0, 0.01)] {
                let swing = |t: f64| (-decay * t).exp() * (TAU * frequency * t + phase).sin();
                let found = found(|t| swing(t) + drift * t).expect("a swing");
                // steps of up to .31 rad of a period: the parabola finds the top to a few
                // thousandths of one. The slowest has two turns, which the drift moves apart.
                let enough = if frequency < 0.5 { 1e-2 } else { 1e-3 };
                assert!(
                    (found / frequency - 1.0).abs() < enough,
                    "{found} Hz for {frequency} Hz, phase {phase}, decay {decay}, drift {drift}"
                );
            }
        }
    }
}

#[test]
fn what_does_not_swing_has_no_frequency() {
    assert_eq!(found(|_| 0.1), None);
    assert_eq!(found(|t| 0.1 - 0.02 * t), None);
    assert_eq!(found(|t| (-t).exp()), None);
    assert_eq!(found(|t| (t - 3.0).powi(2)), None, "one turn");
    for short in 0..3 {
        let few = [0.0, 1.0, 0.0];
        let turns = reversals(&few[..short], &few[..short]);
        assert_eq!(turns, [0.0; 0]);
        assert_eq!(dominant_frequency(&turns), None);
    }
}

#[test]
fn the_quick_swings_dominate_where_they_are_many() {
    assert_eq!(dominant_frequency(&[1.0, 1.5]), Some(1.0));
    assert_eq!(dominant_frequency(&[1.0, 1.5, 3.0]), Some(0.5));
    // four periods of .5 s, then one of 2 s
    let turns = [1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 3.75];
    assert_eq!(dominant_frequency(&turns), Some(2.0));
}

#[test]
fn a_trace_that_rests_between_turns_back_once() {
    let time: Vec<f64> = (0..9).map(f64::from).collect();
    let trace = [0.0, 1.0, 2.0, 2.0, 2.0, 1.0, 1.0, 0.0, 1.0];
    assert_eq!(reversals(&time, &trace), [3.0, 7.0]);
    assert_eq!(reversals(&time, &[1.0; 9]), [0.0; 0]);
}

#[test]
fn loads_are_trail_by_trail() {
    let twelve = cases::loaded(&[0.0, 10.0, 20.0, 30.0]);
    assert_eq!(twelve.len(), 12);
    assert_eq!(twelve[9].number, 10);
    assert_eq!(twelve[9].trail, -0.035);
    assert_eq!(twelve[9].rearward, Rearward::RearLoad(10.0));
}

#[test]
fn a_case_with_a_load_changes_only_trail_load_and_start() {
    let p = Parameters::default();
    let case = cases::loaded(&[20.0])[2];
    let expected = Parameters {
        trail: -0.035,
        rear_load: 20.0,
        roll_start: (-5.0f64).to_radians(),
        steer_start: 1f64.to_radians(),
        yaw_rate_start: 2.0,
        ..p
    };
    assert_eq!(case.parameters(&p), expected);
}

/// Each formulation rides the cases of the nominal bicycle: what ends early says so, the rest has
/// an amplitude.
#[test]
fn every_formulation_rides_the_cases() {
    let p = Parameters::default();
    for formulation in Formulation::ALL {
        for case in cases::all().into_iter().chain(cases::loaded(&[0.0, 30.0])) {
            let course = case
                .run(&p, formulation, Input::default(), 5e-3)
                .expect("a bicycle that can be stepped");
            let name = format!("{}, case {}", formulation.name(), case.number);
            assert!(course.steer.iter().all(|s| s.is_finite()), "{name}");
            assert_eq!(
                course.amplitude().is_some(),
                course.stop.is_none(),
                "{name}"
            );
            assert_eq!(
                course.time.last().copied(),
                Some(course.end_time()),
                "{name}"
            );
            if course.stop.is_some() {
                assert_eq!(course.dominant_frequency(), None, "{name}");
            }
        }
    }
}

/// The benchmark bicycle, pushed at the speed of its published responses, swings in its weave.
#[test]
fn the_trace_swings_at_the_frequency_of_the_least_damped_mode() {
    let input = Input {
        speed: 4.6,
        ..Input::default()
    };
    let p = Parameters {
        roll_rate_start: 0.1,
        ..benchmark_bicycle()
    };
    let mode = Oscillation::least_damped(&p, Formulation::Whipple, input.speed).expect("weave");
    let mut ride = Simulation::new(&p, Formulation::Whipple, input, 0.0)
        .expect("a step below the stability limit");
    let (mut time, mut steer) = (Vec::new(), Vec::new());
    for k in 0..=800 {
        ride.advance(0.005 * f64::from(k)).expect("upright");
        time.push(ride.time());
        steer.push(ride.state().steer);
    }
    let found = dominant_frequency(&reversals(&time, &steer)).expect("weave");
    // the push moves the slowly decaying capsize mode as well, over which the weave rides
    assert!(
        (found / mode.frequency - 1.0).abs() < 0.05,
        "{found} Hz, {mode:?}"
    );
}

/// The weave of the benchmark, −.775 ± 4.465i at 5 m/s.
#[test]
fn the_least_damped_mode_of_the_benchmark_is_its_published_weave() {
    let file = benchmark();
    let published = |i: usize| file["eigenvalues"]["5"][1][i].as_f64().expect("a number");
    let (re, im) = (published(0), published(1).abs());
    let weave =
        Oscillation::least_damped(&benchmark_bicycle(), Formulation::Whipple, 5.0).expect("weave");
    // eigenvalues to 1e-10, as they are tested
    assert!((weave.frequency * TAU - im).abs() < 1e-9);
    assert!((weave.damping_ratio + re / re.hypot(im)).abs() < 1e-9);
}

#[test]
fn the_least_damped_mode_is_among_the_eigenvalues() {
    let p = Parameters::default();
    for formulation in [Formulation::Repaired, Formulation::WhippleSlip] {
        let mode = Oscillation::least_damped(&p, formulation, 3.0).expect("a pair");
        let growth = linear::fastest_growth(&p, formulation, 3.0).re;
        let decay =
            mode.damping_ratio / (1.0 - mode.damping_ratio.powi(2)).sqrt() * TAU * mode.frequency;
        // no pair decays more slowly than the slowest eigenvalue; 1e-9 for two ways of computing it
        assert!(-decay < growth + 1e-9, "{decay} {growth}");
    }
}

/// The swings of a course that ended early are not judged.
#[test]
fn a_course_that_ended_early_has_no_amplitude() {
    let course = Course {
        case: cases::all()[0],
        time: vec![0.0, 0.5, 1.0, 1.5],
        steer: vec![0.0, 0.4, 0.2, 0.1],
        stop: Some(Stop::SteerLimit { t: 1.5 }),
    };
    assert_eq!(course.amplitude(), None);
    assert_eq!(course.dominant_frequency(), None);
    assert_eq!(course.early_reversals(), 1);
}
