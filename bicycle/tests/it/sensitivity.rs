//! Derivatives of what is seen against difference quotients, and those known by name.

use crate::draw;
use bicycle::dynamics::output;
use bicycle::sensitivity::{Direction, output_along};
use bicycle::simulate::Simulation;
use bicycle::{Bicycle, Formulation, Input, Output, Parameters, Path, State};
use proptest::prelude::*;

/// Widths at which differences of 1e-5 still resolve the smoothed jumps.
fn smooth() -> Parameters {
    Parameters {
        steer_smoothing: 0.05,
        steer_rate_smoothing: 0.5,
        rear_load: 20.0,
        rider_roll_gain_slope: -3.0,
        rider_steer_rate_gain_slope: 0.4,
        ..Parameters::default()
    }
}

/// Everything a bicycle's outputs depend on.
#[derive(Debug, Clone, Copy)]
struct Point {
    p: Parameters,
    x: State,
    path: Path,
    u: Input,
}

impl Point {
    fn along(&self, d: &Direction, h: f64) -> Self {
        let step = |value: f64, slope: f64| value + h * slope;
        Self {
            p: self.p.zip(&d.parameters, step),
            x: self.x.zip(&d.state, step),
            path: self.path.zip(&d.path, step),
            u: self.u.zip(&d.input, step),
        }
    }

    fn output(&self, formulation: Formulation) -> [f64; Output::LEN] {
        let b = Bicycle::new(&self.p, formulation);
        output(&b, &self.x, &self.path, &self.u).to_array()
    }
}

/// States aslant on either side, and upright.
fn points() -> [Point; 3] {
    let point = |roll_rate, steer_rate, roll, steer, yaw_rate| Point {
        p: smooth(),
        x: State {
            roll_rate,
            steer_rate,
            roll,
            steer,
            yaw_rate,
            lateral_velocity: -0.2 * yaw_rate,
            front_lateral_force: 30.0 * steer,
            rear_lateral_force: -20.0 * roll,
        },
        path: Path {
            heading: 0.6,
            x: 1.0,
            y: 2.0,
        },
        u: Input {
            speed: 3.0,
            steer_torque: 1.5,
            assist_torque: -0.5,
            roll_moment: 4.0,
        },
    };
    [
        point(0.4, -1.1, -0.3, 0.5, 0.9),
        point(-0.2, 0.3, 0.1, -0.9, -1.5),
        point(0.0, 0.0, 0.0, 0.0, 0.0),
    ]
}

/// One direction for each row of each table, and one along all at once.
fn directions() -> Vec<(String, Direction)> {
    let mut found = Vec::new();
    let mut every = Direction::ZERO;
    macro_rules! rows {
        ($($Rows:ident $field:ident;)*) => {$(
            for (i, row) in $Rows::TABLE.iter().enumerate() {
                let mut one = Direction::ZERO;
                one.$field.set(i, 1.0);
                // of the size of the row, so that no row drowns the others
                every.$field.set(i, 0.1 + 0.1 * row.nominal.abs());
                found.push((row.name.to_owned(), one));
            }
        )*};
    }
    rows! {
        Parameters parameters;
        State state;
        Path path;
        Input input;
    }
    found.push(("all".to_owned(), every));
    found
}

#[test]
fn directional_derivatives_agree_with_differences() {
    let h = 1e-5;
    for formulation in Formulation::ALL {
        for point in points() {
            let b = Bicycle::new(&point.p, formulation);
            for (name, d) in directions() {
                let dual = output_along(&b, &point.x, &point.path, &point.u, &d).to_array();
                let (plus, minus) = (point.along(&d, h), point.along(&d, -h));
                let (plus, minus) = (plus.output(formulation), minus.output(formulation));
                for (i, row) in Output::TABLE.iter().enumerate() {
                    let quotient = (plus[i] - minus[i]) / (2.0 * h);
                    // h²/6 of a third derivative, which over the narrowest width, .05 rad, is
                    // 6/.05² slopes: 4e-8 of a slope. Round-off: 1e-16/h = 1e-11 of the value, or
                    // of the terms it is the sum of, up to 1e4 in these units: 1e-7
                    let tolerance = 2e-7 * (1.0 + dual[i].abs());
                    assert!(
                        (dual[i] - quotient).abs() < tolerance,
                        "{formulation:?} ∂{}/∂{name}: {} against {quotient}",
                        row.name,
                        dual[i]
                    );
                }
            }
        }
    }
}

/// Each state's rate is a row of the output, and the derivative of that state's row.
const RATES: [(&str, &str); 11] = [
    ("roll", "roll_rate"),
    ("steer", "steer_rate"),
    ("roll_rate", "roll_acceleration"),
    ("steer_rate", "steer_acceleration"),
    ("yaw_rate", "yaw_acceleration"),
    ("lateral_velocity", "lateral_velocity_rate"),
    ("front_lateral_force", "front_lateral_force_rate"),
    ("rear_lateral_force", "rear_lateral_force_rate"),
    ("heading", "yaw_rate"),
    ("x", "x_rate"),
    ("y", "y_rate"),
];

fn row(name: &str) -> usize {
    Output::index(name).expect("an output")
}

#[test]
fn every_state_is_seen_with_its_rate() {
    let states = State::TABLE.iter().chain(Path::TABLE);
    assert!(states.clone().all(|s| RATES.iter().any(|r| r.0 == s.name)));
    assert_eq!(states.count(), RATES.len());
}

proptest! {
    /// The same operations: equal to the last bit, in every formulation, on any slope of the inputs.
    /// What is no state but follows from them is left out.
    #[test]
    fn rates_of_the_states_are_the_rows_of_their_rates(
        p in draw::possible(),
        formulation in prop::sample::select(&Formulation::ALL[..]),
        u in draw::input(),
        slope in draw::input(),
    ) {
        let p = Parameters { internal_step: 1e-5, ..p };
        let ride = Simulation::new(&p, formulation, u, 0.0);
        prop_assume!(ride.is_ok());
        let mut ride = ride.expect("assumed");
        ride.set(&p, u, slope).expect("the same speed");
        let _ = ride.advance(0.01);
        let (seen, rate) = (ride.output(), ride.output_rate());
        let moves = |name| State::index(name).is_none_or(|i| i < ride.bicycle().order());
        for (state, its_rate) in RATES.into_iter().filter(|(state, _)| moves(state)) {
            prop_assert_eq!(rate.get(row(state)), seen.get(row(its_rate)), "{}", state);
        }
    }
}

/// The rate of every row against what is seen a little later, on a ramp.
#[test]
fn output_rate_is_the_slope_in_time() {
    let p = Parameters {
        roll_start: -0.1,
        steer_start: 0.05,
        yaw_rate_start: 0.5,
        ..smooth()
    };
    for formulation in Formulation::ALL {
        let u = points()[0].u;
        let slope = Input {
            speed: 0.5,
            steer_torque: -3.0,
            assist_torque: 1.0,
            roll_moment: 7.0,
        };
        let mut ride = Simulation::new(&p, formulation, u, 0.0).expect("nominal");
        ride.set(&p, u, slope).expect("the same speed");
        let h = 1e-5;
        let seen = [0.1, 0.1 + h, 0.1 + 2.0 * h].map(|t| {
            ride.advance(t).expect("no fall");
            (ride.output().to_array(), ride.output_rate().to_array())
        });
        for (i, row) in Output::TABLE.iter().enumerate() {
            let quotient = (seen[2].0[i] - seen[0].0[i]) / (2.0 * h);
            let rate = seen[1].1[i];
            // poles of up to 300 1/s: third derivatives of up to 1e5 of a rate, h²/6 = 2e-11;
            // round-off 1e-16/h = 1e-11 of values up to 1e3
            let scale = 1.0 + seen.iter().map(|s| s.1[i].abs()).fold(0.0, f64::max);
            assert!(
                (rate - quotient).abs() < 3e-6 * scale,
                "{formulation:?} {}: {rate} against {quotient}",
                row.name
            );
        }
    }
}

/// A jump has no slope: at its very place nothing blows up.
#[test]
fn a_jump_has_no_slope() {
    let p = Parameters {
        steer_smoothing: 0.0,
        steer_rate_smoothing: 0.0,
        roll_start: 0.1,
        roll_rate_start: 0.3,
        ..Parameters::default()
    };
    let ride = Simulation::new(&p, Formulation::Repaired, Input::default(), 0.0).expect("nominal");
    assert_eq!((ride.state().steer, ride.state().steer_rate), (0.0, 0.0));
    // straight, sign θ = 0: L₃' = L₃ cos φ
    let rate = ride.output_rate();
    let expected = -p.trail * 0.1f64.sin() * 0.3;
    assert!((rate.effective_trail - expected).abs() < 1e-15);
    assert!(rate.to_array().iter().all(|v| v.abs() < 1e6), "{rate:?}");
}

#[test]
fn rows_that_are_states_are_seen_without_the_equations() {
    let p = Parameters {
        roll_start: 0.1,
        ..smooth()
    };
    let mut ride =
        Simulation::new(&p, Formulation::Repaired, Input::default(), 0.0).expect("nominal");
    ride.advance(0.7654).expect("no fall");
    let seen = ride.output();
    let mut cheap = Vec::new();
    for (row, quantity) in Output::TABLE.iter().enumerate() {
        if let Some(value) = ride.output_row(row) {
            assert_eq!(
                value.to_bits(),
                seen.get(row).to_bits(),
                "{}",
                quantity.name
            );
            cheap.push(quantity.name);
        }
    }
    assert_eq!(
        cheap.join(" "),
        "roll steer roll_rate steer_rate yaw_rate heading x y front_load"
    );
}
