//! The bicycle's FMU under the master, against the same bicycle with the controller inlined.

use crate::fmu::packed;
use bicycle::simulate::Simulation;
use bicycle::{Formulation, Input, Parameters};
use fmi_import::master::{
    Algorithm, Direction, End, Foreign, Kind, Master, Member, Participant, Plan, Port, Run, by_name,
};
use fmi_import::{Error, Step, Value};

/// An assist without memory: torque = −gain · roll rate.
struct Damper {
    gain: f64,
    ports: [Port; 2],
    roll_rate: f64,
    kept: f64,
}

impl Damper {
    fn new(gain: f64) -> Self {
        let port = |name: &str, direction| Port {
            name: name.to_owned(),
            direction,
            kind: Kind::Real,
            unit: None,
            depends_on: Some(if direction == Direction::Output {
                vec![0]
            } else {
                vec![]
            }),
            nominal: 1.0,
        };
        Self {
            gain,
            ports: [
                port("roll_rate", Direction::Input),
                port("assist_torque", Direction::Output),
            ],
            roll_rate: 0.0,
            kept: 0.0,
        }
    }
}

impl Participant for Damper {
    fn ports(&self) -> &[Port] {
        &self.ports
    }
    fn enter_initialization(&mut self, _: f64, _: f64) -> Result<(), Error> {
        Ok(())
    }
    fn exit_initialization(&mut self) -> Result<(), Error> {
        Ok(())
    }
    fn read(&mut self, ports: &[usize], values: &mut [f64]) -> Result<(), Error> {
        for (&port, value) in ports.iter().zip(values) {
            *value = [self.roll_rate, -self.gain * self.roll_rate][port];
        }
        Ok(())
    }
    fn write(&mut self, _: &[usize], values: &[f64]) -> Result<(), Error> {
        self.roll_rate = values[0];
        Ok(())
    }
    fn step(&mut self, _: f64, _: f64) -> Result<Step, Error> {
        Ok(Step::Complete)
    }
    fn can_vary_step(&self) -> bool {
        true
    }
    fn can_keep(&self) -> bool {
        true
    }
    fn keep(&mut self) -> Result<(), Error> {
        self.kept = self.roll_rate;
        Ok(())
    }
    fn go_back(&mut self) -> Result<(), Error> {
        self.roll_rate = self.kept;
        Ok(())
    }
    fn terminate(&mut self) -> Result<(), Error> {
        Ok(())
    }
}

const GAIN: f64 = 30.0;
const STOP: f64 = 3.0;
/// Rows that both runs have [s].
const ROW: f64 = 0.024;

/// A smooth ride: a wide smoothing, so that the order of the coupling shows.
fn parameters() -> Parameters {
    Parameters {
        roll_start: 0.05,
        steer_smoothing: 0.05,
        steer_rate_smoothing: 0.5,
        ..Parameters::default()
    }
}

fn starts(parameters: &Parameters) -> Vec<(String, Value)> {
    let rows = Parameters::TABLE.iter().zip(parameters.to_array());
    rows.map(|(row, value)| (row.name.to_owned(), Value::Real(value)))
        .collect()
}

fn coupled(plan: &Plan, turned: bool) -> Run {
    let (_folder, fmu) = packed();
    let plant = Foreign::new(&fmu, "plant", &starts(&parameters())).expect("an instance");
    let mut members = vec![
        Member {
            name: "controller".into(),
            participant: Box::new(Damper::new(GAIN)),
            step: None,
        },
        Member {
            name: "plant".into(),
            participant: Box::new(plant),
            step: None,
        },
    ];
    if turned {
        members.reverse();
    }
    let connections = by_name(&members, &[]);
    assert_eq!(connections.len(), 2);
    let mut master = Master::new(members, connections).expect("connected");
    let run = master.run(plan).expect("ran");
    assert!(matches!(run.end, End::Complete), "{:?}", run.end);
    run
}

fn plan(step: f64) -> Plan {
    Plan {
        start_time: 0.0,
        stop_time: STOP,
        step,
        algorithm: Algorithm::Jacobi,
        tolerance: None,
        initial_exchange: true,
        record: vec!["plant.roll".parse().expect("a terminal")],
    }
}

/// The largest difference in roll [rad] to the bicycle whose rider has the controller's gain too.
fn error(run: &Run) -> f64 {
    let inlined = Parameters {
        rider_roll_rate_gain: parameters().rider_roll_rate_gain + GAIN,
        ..parameters()
    };
    let mut one =
        Simulation::new(&inlined, Formulation::default(), Input::default(), 0.0).expect("started");
    let mut largest = 0.0_f64;
    let step = run.columns[0][1];
    let stride = (ROW / step).round() as usize;
    for (n, roll) in run.columns[1].iter().enumerate().step_by(stride) {
        one.advance(n as f64 * step).expect("arrived");
        largest = largest.max((roll - one.output().roll).abs());
    }
    largest
}

#[test]
fn the_coupled_bicycle_converges_to_the_one_with_the_controller_inlined() {
    for algorithm in [Algorithm::Jacobi, Algorithm::GaussSeidel] {
        let errors = [0.008, 0.004, 0.002, 0.001].map(|step| {
            error(&coupled(
                &Plan {
                    algorithm,
                    ..plan(step)
                },
                false,
            ))
        });
        for pair in errors.windows(2) {
            // the first power of the step, but for the second
            let order = (pair[0] / pair[1]).log2();
            assert!((order - 1.0).abs() < 0.1, "{algorithm:?}: {errors:?}");
        }
    }
}

#[test]
fn within_a_tolerance_the_coupled_bicycle_is_the_one_with_the_controller_inlined() {
    for tolerance in [1e-2, 1e-3] {
        let run = coupled(
            &Plan {
                tolerance: Some(tolerance),
                ..plan(ROW)
            },
            false,
        );
        assert_eq!(run.columns[0].len(), 126);
        assert!(
            error(&run) < tolerance,
            "{tolerance}: {} in {} steps",
            error(&run),
            run.steps
        );
    }
}

#[test]
fn jacobi_does_not_see_the_order_of_the_members() {
    let [one, other] = [false, true].map(|turned| coupled(&plan(0.005), turned).columns);
    assert_eq!(one, other);
}
