//! The declared dependencies against what moves when something is changed.

use super::*;
use bicycle::simulate::Simulation;
use std::collections::BTreeSet;

/// Some bicycle in some state: every value a little off its nominal one.
fn somewhere(seed: u64) -> (Parameters, Input) {
    // a linear congruential generator (Knuth's MMIX constants)
    let mut state = seed;
    let mut off = |value: f64, scale: f64| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let random = (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
        value * (1.0 + 0.02 * random) + scale * random
    };
    let mut parameters = Parameters::default();
    start_aslant(&mut parameters);
    parameters.rear_load = 10.0;
    let parameters = Parameters {
        rider_roll_gain_slope: off(0.0, 1.0),
        rider_roll_rate_gain_slope: off(0.0, 1.0),
        rider_steer_gain_slope: off(0.0, 1.0),
        rider_steer_rate_gain_slope: off(0.0, 1.0),
        ..parameters.map(|value| off(value, 0.0))
    };
    // Explicit steps must be stable wherever we are.
    let parameters = Parameters {
        internal_step: 1e-4,
        ..parameters
    };
    (
        parameters,
        Input::default().map(|value: f64| off(value, 1.0)),
    )
}

/// Every formulation a few times, and one without relaxing tyres.
fn everywhere() -> impl Iterator<Item = (Formulation, Parameters, Input)> {
    let moved = (1..)
        .zip(Formulation::ALL.repeat(4))
        .map(|(seed, formulation)| {
            let (parameters, input) = somewhere(seed);
            (formulation, parameters, input)
        });
    let (parameters, input) = somewhere(100);
    let stiff = Parameters {
        relaxation_length: 0.0,
        ..parameters
    };
    moved.chain([(Formulation::WhippleSlip, stiff, input)])
}

fn after_initialization(parameters: &Parameters, formulation: Formulation, input: Input) -> Output {
    Simulation::new(parameters, formulation, input, 0.0)
        .expect("a bicycle that can be simulated")
        .output()
}

/// What moves each output after initialization, by 1-based index.
fn influences() -> Vec<BTreeSet<u32>> {
    let mut found = vec![BTreeSet::new(); Output::LEN];
    for (formulation, parameters, input) in everywhere() {
        let before = after_initialization(&parameters, formulation, input).to_array();
        let mut compare = |row: Row, after: Output| {
            for (output, (before, after)) in before.iter().zip(after.to_array()).enumerate() {
                if before.to_bits() != after.to_bits() {
                    found[output].insert(row.index());
                }
            }
        };
        for row in 0..Parameters::LEN {
            let mut parameters = parameters;
            parameters.set(row, parameters.get(row) * 1.01);
            compare(
                Row::Parameter(row),
                after_initialization(&parameters, formulation, input),
            );
        }
        for row in 0..Input::LEN {
            let mut input = input;
            input.set(row, input.get(row) * 1.01);
            compare(
                Row::Input(row),
                after_initialization(&parameters, formulation, input),
            );
        }
        let stiff = Parameters {
            relaxation_length: 0.0,
            ..parameters
        };
        let relaxation = Parameters::index("relaxation_length").expect("a row");
        compare(
            Row::Parameter(relaxation),
            after_initialization(&stiff, formulation, input),
        );
        for other in Formulation::ALL {
            compare(
                Row::Formulation,
                after_initialization(&parameters, other, input),
            );
        }
    }
    found
}

/// What moves each output at a communication point, by 1-based index.
fn influences_under_way() -> Vec<BTreeSet<u32>> {
    let output_row = |name| Row::Output(Output::index(name).expect("every state is an output"));
    let mut found = vec![BTreeSet::new(); Output::LEN];
    for (formulation, parameters, input) in everywhere() {
        let bicycle = Bicycle::new(&parameters, formulation);
        let path = Path::from_array([0.3, 0.2, 0.1]);
        let state = State {
            lateral_velocity: 0.1,
            front_lateral_force: 30.0,
            rear_lateral_force: -20.0,
            ..parameters.start()
        };
        let before = output(&bicycle, &state, &path, &input).to_array();
        let mut compare = |row: Row, after: Output| {
            for (output, (before, after)) in before.iter().zip(after.to_array()).enumerate() {
                if before.to_bits() != after.to_bits() {
                    found[output].insert(row.index());
                }
            }
        };
        for row in 0..Input::LEN {
            let mut input = input;
            input.set(row, input.get(row) * 1.01);
            compare(Row::Input(row), output(&bicycle, &state, &path, &input));
        }
        for (row, quantity) in State::TABLE.iter().enumerate() {
            let mut state = state;
            state.set(row, state.get(row) * 1.01);
            let after = output(&bicycle, &state, &path, &input);
            compare(output_row(quantity.name), after);
        }
        for (row, quantity) in Path::TABLE.iter().enumerate() {
            let mut path = path;
            path.set(row, path.get(row) * 1.01);
            let after = output(&bicycle, &state, &path, &input);
            compare(output_row(quantity.name), after);
        }
    }
    found
}

#[track_caller]
fn check(declared: &[Vec<u32>], found: &[BTreeSet<u32>]) {
    for (row, (declared, found)) in declared.iter().zip(found).enumerate() {
        let found: Vec<u32> = found.iter().copied().collect();
        assert_eq!(*declared, found, "{}", Output::TABLE[row].name);
    }
}

#[test]
fn what_is_declared_is_what_moves() {
    check(&at_the_start(), &influences());
    check(&at_communication_points(), &influences_under_way());
}

#[test]
fn no_state_depends_on_anything_but_itself() {
    let declared = at_communication_points();
    // states in some formulations, consequences of others elsewhere
    let elsewhere = ["yaw_rate", "front_lateral_force", "rear_lateral_force"];
    for quantity in State::TABLE.iter().chain(Path::TABLE) {
        let row = Output::index(quantity.name).expect("every state is an output");
        let itself = Row::Output(row).index();
        assert!(declared[row].contains(&itself), "{}", quantity.name);
        let alone = declared[row].len() == 1;
        assert_eq!(
            alone,
            !elsewhere.contains(&quantity.name),
            "{}",
            quantity.name
        );
    }
    let acceleration = Output::index("steer_acceleration").expect("an output");
    assert!(declared[acceleration].contains(&Row::Input(0).index()));
}
