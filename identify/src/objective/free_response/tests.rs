#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
use super::*;
use crate::free::{Candidate, Free};
use crate::solver::{Limits, Search, minimise};
use bicycle::simulate::Simulation;
use bicycle::{Input, Parameters};
use nalgebra::DVector;
use std::ops::Range;

/// Three seconds of a bicycle left to itself, three times, from other states, at 100 Hz.
fn ridden() -> Ride {
    let mut steer = Vec::new();
    let mut roll_rate = Vec::new();
    for start in [0.03, -0.02, 0.05] {
        let parameters = Parameters {
            roll_start: start,
            steer_rate_start: -10.0 * start,
            internal_step: 0.5e-3,
            ..Parameters::default()
        };
        let input = Input {
            speed: 4.0,
            ..Input::default()
        };
        let mut ride = Simulation::new(&parameters, Formulation::Whipple, input, 0.0).unwrap();
        for i in 0..300 {
            ride.advance(0.01 * f64::from(i)).unwrap();
            steer.push(ride.state().steer);
            roll_rate.push(ride.state().roll_rate);
        }
    }
    let mut ride = Ride::new(0.0, 0.01, steer.len());
    ride.insert("speed", vec![4.0; steer.len()]).unwrap();
    ride.insert("steer", steer).unwrap();
    ride.insert("roll_rate", roll_rate).unwrap();
    ride.law_in_loop = Some(true);
    ride
}

fn unknowns() -> Unknowns {
    Unknowns {
        free: vec![Free::new("viscous_friction").unwrap()],
        ties: Vec::new(),
        start: Candidate {
            parameters: Parameters {
                viscous_friction: 0.6,
                ..Parameters::default()
            },
            ..Candidate::default()
        },
    }
}

#[test]
fn friction_comes_back_from_windows_of_different_lengths() {
    let ride = ridden();
    let windows = [10..250, 305..420, 600..899];
    let landscape = in_windows(
        &ride,
        &["steer", "roll_rate"],
        unknowns(),
        Formulation::Whipple,
        Torque::Off,
        (4.0, &windows),
        None,
    )
    .unwrap();
    assert_eq!(landscape.observations(), 2 * (240 + 115 + 299));
    let bounds = |value: f64| DVector::from_element(1, value);
    let limits = Limits {
        lower: bounds(0.0),
        upper: bounds(10.0),
        reach: bounds(0.7),
    };
    let found = minimise(
        &landscape,
        landscape.start(),
        &Search {
            limits: &limits,
            held: &[],
            tolerance: 1e-9,
            max_iterations: 100,
            watch: crate::progress::Watch::default(),
        },
    )
    .unwrap();
    let value = landscape.unknowns.free[0].value(found.point[0]);
    // noise-free: what is left is the step of the replay, 2.5 ms against .5 ms, some 1e-5 of the
    // motion
    assert!((value - 0.30).abs() < 1e-3, "{value}");
}

#[test]
fn a_file_of_windows_is_read_in_samples_and_in_seconds() {
    let mut ride = ridden();
    let expected = vec![10..60, 100..150];
    let samples =
        "file,start_sample,stop_sample,what\nride,10,60,a\nother,0,1,b\nride.csv,100,150,c\n";
    assert_eq!(parse("w.csv", samples, &ride).unwrap(), expected);
    let seconds = "# by hand\nstart, stop\n.1,.6\n1.0,1.5\n";
    assert_eq!(parse("w.csv", seconds, &ride).unwrap(), expected);
    ride.origin = None;
    for (text, message) in [
        (
            "from,to\n1,2\n",
            "w.csv, row 1: expected columns start and stop, or start_sample and stop_sample, found from, to",
        ),
        (
            "file,start,stop\nother,1,2\n",
            "w.csv, row 1: expected windows of ride, found none",
        ),
        (
            "start,stop\n1,2\n3,soon\n",
            "w.csv, row 3: expected a number of at least 0 in column `stop`, found `soon`",
        ),
    ] {
        assert_eq!(
            parse("w.csv", text, &ride).unwrap_err().to_string(),
            message
        );
    }
}

#[test]
fn contradictory_windows_are_refused() {
    let mut ride = ridden();
    let mut speed = vec![4.0; ride.len()];
    speed[850..].fill(0.1);
    ride.insert("speed", speed).unwrap();
    for (windows, message) in [
        (
            vec![
                0..100,
                Range {
                    start: 300,
                    end: 200,
                },
            ],
            "found 3 to 2 s",
        ),
        (vec![0..100, 300..1000], "found 3 to 10 s"),
        (vec![0..100, 50..200], "found 0 to 1 s and 0.5 to 2 s"),
        (vec![0..100, 700..860], "found standstill in 8.5 to 8.99 s"),
        (vec![0..100, 200..203], "found 2 windows"),
        (Vec::new(), "found 0 windows"),
    ] {
        let refused = in_windows(
            &ride,
            &["steer"],
            unknowns(),
            Formulation::Whipple,
            Torque::Off,
            (4.0, &windows),
            None,
        );
        let error = refused.unwrap_err().to_string();
        assert!(error.contains(message), "{windows:?}: {error}");
    }
}
