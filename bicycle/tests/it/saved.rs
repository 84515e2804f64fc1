//! Saved and restored: the same to the last bit, or refused.

use bicycle::simulate::{Simulation, Stop};
use bicycle::{Formulation, Input, Output, Parameters};
use serde_json::{Value, json};

fn parameters() -> Parameters {
    Parameters {
        roll_start: -5f64.to_radians(),
        steer_start: 1f64.to_radians(),
        ..Parameters::default()
    }
}

/// Under way to `to` from a start that is no round number; with `ramp` the inputs move.
fn ride(formulation: Formulation, ramp: bool, to: f64) -> Simulation {
    let (p, u) = (parameters(), Input::default());
    let mut ride = Simulation::new(&p, formulation, u, 0.7).expect("nominal");
    if ramp {
        let slope = Input {
            speed: 0.3,
            steer_torque: -0.7,
            ..Input::ZERO
        };
        ride.advance(0.70031).expect("no fall");
        ride.set(&p, u, slope).expect("nominal");
    }
    let _ = ride.advance(to);
    ride
}

fn restored(ride: &Simulation) -> Simulation {
    let text = serde_json::to_string(ride).expect("numbers");
    serde_json::from_str(&text).expect("what was saved")
}

fn seen(ride: &Simulation) -> ([u64; Output::LEN], u64, u64, Option<Stop>) {
    let output = ride.output().to_array().map(f64::to_bits);
    (
        output,
        ride.time().to_bits(),
        ride.derivatives(),
        ride.stop(),
    )
}

#[test]
fn the_copy_goes_on_to_the_same_bits() {
    for formulation in Formulation::ALL {
        for ramp in [false, true] {
            // on the grid, on it up to rounding, off it; the first step is a shortened one
            for to in [0.7, 0.701, 0.7 + 3.0 * 0.1, 0.81234, 0.7004] {
                let mut one = ride(formulation, ramp, to);
                let mut other = restored(&one);
                assert_eq!(seen(&other), seen(&one));
                assert_eq!(other.parameters(), one.parameters());
                for t in [0.8139, 0.9, 1.0 / 3.0 + 0.7] {
                    assert_eq!(other.check_until(t), one.check_until(t));
                    assert_eq!(other.advance(t), one.advance(t));
                    assert_eq!(seen(&other), seen(&one), "{formulation:?} {ramp} {to} {t}");
                }
                let pushed = Input {
                    steer_torque: 2.0,
                    ..one.input()
                };
                for ride in [&mut one, &mut other] {
                    ride.set_input(pushed).expect("a push");
                    let _ = ride.advance(1.5);
                }
                assert_eq!(seen(&other), seen(&one));
            }
        }
    }
}

#[test]
fn a_stop_is_saved() {
    for (roll_moment, name) in [(0.0, "steer_limit"), (5000.0, "diverged")] {
        let p = Parameters::default().riderless();
        let u = Input {
            steer_torque: 80.0,
            roll_moment,
            ..Input::default()
        };
        let mut ride = Simulation::new(&p, Formulation::Repaired, u, 0.0).expect("nominal");
        let stop = ride.advance(10.0).expect_err("a stop");
        assert_eq!(stop.name(), name);
        let mut copy = restored(&ride);
        assert_eq!(seen(&copy), seen(&ride));
        assert_eq!(copy.advance(11.0), Err(stop));
        // and after a change that comes too late
        ride.set_input(Input::default()).expect("nominal");
        assert_eq!(seen(&restored(&ride)), seen(&ride));
    }
}

/// Saves, changes one value by its path, and restores.
fn tampered(ride: &Simulation, path: &str, value: Value) -> Result<Simulation, String> {
    let mut saved = serde_json::to_value(ride).expect("numbers");
    *saved.pointer_mut(path).unwrap_or_else(|| panic!("{path}")) = value;
    serde_json::from_value(saved).map_err(|e| e.to_string())
}

#[test]
fn what_no_simulation_could_become_is_refused() {
    // off the grid, on a ramp: base at .70031 or a grid point, here ahead of it
    let ride = ride(Formulation::Repaired, true, 0.81234);
    assert!(tampered(&ride, "/here/time", json!(0.81236)).is_ok());
    let cases = [
        (
            "/parameters/internal_step",
            json!(0.0),
            "internal_step: expected",
        ),
        (
            "/parameters/internal_step",
            json!(-1e-3),
            "internal_step: expected",
        ),
        (
            "/parameters/internal_step",
            json!(1e-300),
            "internal_step: expected",
        ),
        (
            "/parameters/internal_step",
            json!(2e-3),
            "the base on the grid",
        ),
        (
            "/parameters/total_mass",
            json!(-5.0),
            "total_mass: expected 5 to 250 kg",
        ),
        (
            "/parameters/steer_limit",
            json!(3.0),
            "steer_limit: expected",
        ),
        ("/formulation", json!("whippel"), "unknown variant"),
        ("/start_time", json!(0.7001), "the base on the grid"),
        ("/start_time", json!(-1e300), "times that tell"),
        ("/base/time", json!(0.8), "the base on the grid"),
        ("/base/time", json!(1e300), "times that tell"),
        ("/base_on_grid", json!(false), "the base on the grid"),
        ("/next", json!(0), "the base on the grid"),
        ("/next", json!(1), "the base on the grid"),
        ("/next", json!(u64::MAX), "the base on the grid"),
        ("/here/time", json!(0.8), "an arrival before"),
        ("/here/time", json!(0.9), "an arrival before"),
        ("/here/time", json!(1e300), "times that tell"),
        ("/ahead", json!(false), "an arrival before"),
        ("/ramp/since", json!(0.9), "inputs that were set"),
        ("/ramp/since", json!(0.0), "inputs that were set"),
        (
            "/stop",
            json!({"diverged": {"t": 0.5}}),
            "the time of the stop",
        ),
        ("/derivatives", json!(u64::MAX), "fewer derivatives"),
        ("/here/state/roll", Value::Null, "invalid type"),
    ];
    for (path, value, expected) in cases {
        let found = tampered(&ride, path, value.clone()).expect_err(path);
        assert!(found.contains(expected), "{path} {value}: {found}");
    }
    // where base and here are one, they are
    let on_grid = self::ride(Formulation::Repaired, false, 0.9);
    let found = tampered(&on_grid, "/here/state/roll", json!(0.3)).expect_err("another roll");
    assert!(found.contains("an arrival before"), "{found}");
}

/// JSON has no words for these; a form in bytes does.
#[test]
fn what_is_not_finite_is_refused() {
    let mut ride = ride(Formulation::Repaired, false, 0.9);
    let fine = postcard::to_stdvec(&ride).expect("numbers");
    let copy: Simulation = postcard::from_bytes(&fine).expect("what was saved");
    assert_eq!(seen(&copy), seen(&ride));
    for odd in [f64::NAN, f64::INFINITY] {
        ride.set_input(Input {
            steer_torque: odd,
            ..Input::default()
        })
        .expect("only the speed is checked");
        let bytes = postcard::to_stdvec(&ride).expect("numbers");
        assert!(postcard::from_bytes::<Simulation>(&bytes).is_err());
    }
    // any eight bytes of it made another number: refused, or it goes on and comes to an end
    let mut taken = 0;
    for at in 0..fine.len() - 8 {
        for odd in [f64::NAN, -1e300, 1e300, 1e9, 5e-324, -0.25] {
            let mut bytes = fine.clone();
            bytes[at..at + 8].copy_from_slice(&odd.to_le_bytes());
            if let Ok(mut garbage) = postcard::from_bytes::<Simulation>(&bytes) {
                let (time, work) = (garbage.time(), garbage.derivatives());
                let _ = garbage.check_until(time + 0.1);
                let _ = garbage.advance(time + 0.1);
                let _ = garbage.output_rate();
                // a hundred steps of a millisecond, or the shortest ones, and one location of a stop
                assert!(garbage.derivatives() - work < 4 * (11_000 + 1100));
                taken += 1;
            }
        }
    }
    assert!(taken > 0, "not everything is garbage");
}
