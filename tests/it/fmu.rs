//! The packed FMU, loaded by fmi-import, against the native bicycle: equal to the last bit.

use bicycle::simulate::{Simulation, Stop};
use bicycle::{Bicycle, Derived, Formulation, Input, Output, Parameters, Quantity, cases};
use fmi_import::{Error, Fmu, Instance, Plan, Status, Step, Value, simulate};
use tempfile::TempDir;

/// The FMU with the library that cargo built for these tests, and the folder it lies in.
pub fn packed() -> (TempDir, Fmu) {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("RearLoadBicycle.fmu");
    let library = fmu::built_library().expect("cargo builds it as a dependency");
    fmu::pack(&library, &path).expect("packed");
    let fmu = Fmu::open(&path).expect("loaded");
    (folder, fmu)
}

fn references(fmu: &Fmu, table: &[Quantity]) -> Vec<u32> {
    table
        .iter()
        .map(|row| {
            fmu.description()
                .variable(row.name)
                .expect("every row is a variable")
                .value_reference
        })
        .collect()
}

/// The same bicycle twice: behind FMI, and native.
struct Pair<'a> {
    instance: Instance<'a>,
    native: Simulation,
    parameters: Vec<u32>,
    inputs: Vec<u32>,
    outputs: Vec<u32>,
    time: f64,
}

impl<'a> Pair<'a> {
    fn new(fmu: &'a Fmu, parameters: &Parameters, formulation: Formulation) -> Self {
        let mut pair = Self {
            instance: fmu.instantiate("bicycle").expect("an instance"),
            native: Simulation::new(parameters, formulation, Input::default(), 0.0)
                .expect("started"),
            parameters: references(fmu, Parameters::TABLE),
            inputs: references(fmu, Input::TABLE),
            outputs: references(fmu, Output::TABLE),
            time: 0.0,
        };
        pair.initialize(parameters, formulation)
            .expect("initialised");
        pair.check();
        pair
    }

    fn initialize(
        &mut self,
        parameters: &Parameters,
        formulation: Formulation,
    ) -> Result<(), Error> {
        let (number, _) = (1..)
            .zip(Formulation::ALL)
            .find(|&(_, choice)| choice == formulation)
            .expect("one of all");
        let reference = self
            .instance
            .fmu()
            .description()
            .variable("formulation")
            .expect("a variable")
            .value_reference;
        self.instance.setup_experiment(None, 0.0, None)?;
        self.instance
            .set_real(&self.parameters, &parameters.to_array())?;
        self.instance.set_integer(&[reference], &[number])?;
        self.instance.enter_initialization_mode()?;
        self.instance.exit_initialization_mode()
    }

    fn set_input(&mut self, input: Input) {
        self.native.set_input(input).expect("accepted");
        self.instance
            .set_real(&self.inputs, &input.to_array())
            .expect("accepted");
        self.check();
    }

    fn step(&mut self, h: f64) {
        let step = self.instance.do_step(self.time, h).expect("a step");
        assert_eq!(step, Step::Complete);
        self.time += h;
        self.native.advance(self.time).expect("arrived");
        self.check();
    }

    /// Every output, bit for bit.
    fn check(&mut self) {
        let mut found = [0.0; Output::LEN];
        self.instance
            .get_real(&self.outputs, &mut found)
            .expect("read");
        let expected = self.native.output().to_array();
        for ((row, expected), found) in Output::TABLE.iter().zip(expected).zip(found) {
            assert!(
                expected.to_bits() == found.to_bits(),
                "{} at {} s: native {expected}, FMU {found}",
                row.name,
                self.time
            );
        }
    }
}

/// Leaning and turning, so that every term of the equations is at work.
fn aslant() -> Parameters {
    Parameters {
        roll_start: 0.05,
        steer_start: -0.02,
        yaw_rate_start: 0.1,
        rear_load: 12.5,
        ..Parameters::default()
    }
}

#[test]
fn steps_of_any_length_give_the_native_trajectory() {
    let (_folder, fmu) = packed();
    for (h, count) in [
        (0.005, 1000),
        (0.001, 2000),
        (1.0 / 60.0, 300),
        (1e-9, 1000),
        (1.0, 8),
    ] {
        let mut pair = Pair::new(&fmu, &aslant(), Formulation::Repaired);
        for _ in 0..count {
            pair.step(h);
        }
    }
}

#[test]
fn unequal_steps_and_changes_on_and_off_the_grid_give_the_native_trajectory() {
    let (_folder, fmu) = packed();
    let mut pair = Pair::new(&fmu, &aslant(), Formulation::Repaired);
    let mut input = Input::default();
    for n in 0..200 {
        for h in [1.0 / 60.0, 1e-9, 0.005, 0.0003] {
            pair.step(h);
        }
        match n % 4 {
            0 => input.steer_torque = 0.01 * f64::from(n % 7),
            1 => input.speed = 2.0 + 0.01 * f64::from(n),
            2 => input.roll_moment = f64::from(n % 5) - 2.0,
            _ => {} // the same values again: no change
        }
        pair.set_input(input);
    }
}

#[test]
fn tunable_parameters_act_from_where_they_are_set() {
    let (_folder, fmu) = packed();
    let mut pair = Pair::new(&fmu, &aslant(), Formulation::Repaired);
    for load in [20.0, 0.0] {
        for _ in 0..50 {
            pair.step(1.0 / 60.0);
        }
        let parameters = Parameters {
            rear_load: load,
            ..aslant()
        };
        pair.native.set_parameters(&parameters).expect("accepted");
        let row = Parameters::index("rear_load").expect("a row");
        pair.instance
            .set_real(&[pair.parameters[row]], &[load])
            .expect("tunable");
        pair.check();
    }
    pair.step(1.0);
}

#[test]
fn setting_a_value_and_setting_it_back_is_no_change() {
    let (_folder, fmu) = packed();
    let mut pair = Pair::new(&fmu, &aslant(), Formulation::Repaired);
    for _ in 0..50 {
        pair.step(1.0 / 60.0);
        let (speed, there) = (pair.inputs[0], Input::default().speed);
        for value in [5.0, there] {
            pair.instance.set_real(&[speed], &[value]).expect("set");
        }
    }
}

#[test]
fn every_formulation_is_the_native_one() {
    let (_folder, fmu) = packed();
    for formulation in Formulation::ALL {
        let mut pair = Pair::new(&fmu, &aslant(), formulation);
        for _ in 0..20 {
            pair.step(0.005);
        }
    }
}

/// A case of the paper with negative trail and a rider who cannot hold it.
fn falling() -> Parameters {
    let case = cases::all()
        .into_iter()
        .min_by(|a, b| a.trail.total_cmp(&b.trail))
        .expect("nine cases");
    let rider = Parameters {
        rider_steer_gain: 0.0,
        rider_steer_rate_gain: 0.0,
        ..Parameters::default()
    };
    case.parameters(&rider)
}

#[test]
fn the_steer_limit_ends_both_at_the_same_instant() {
    let (_folder, fmu) = packed();
    let mut pair = Pair::new(&fmu, &falling(), Formulation::Repaired);
    let stop = loop {
        let to = pair.time + 0.005;
        match pair.native.advance(to) {
            Ok(()) => {
                let step = pair.instance.do_step(pair.time, to - pair.time);
                assert_eq!(step.expect("a step"), Step::Complete);
                pair.time = to;
                pair.check();
            }
            Err(stop) => break stop,
        }
        assert!(to < 10.0, "this rider was to fall");
    };
    assert!(matches!(stop, Stop::SteerLimit { .. }), "{stop}");
    let Step::Discarded {
        last_successful_time,
        terminated,
        log,
    } = pair.instance.do_step(pair.time, 0.005).expect("a discard")
    else {
        panic!("expected the step to end early");
    };
    assert_eq!(last_successful_time, Some(stop.time()));
    assert!(terminated);
    assert!(log[0].message.contains("steer limit"), "{log:?}");
    pair.check();
    pair.instance.terminate().expect("terminated");
}

#[test]
fn a_simulation_from_start_to_end_records_the_native_trajectory() {
    let (_folder, fmu) = packed();
    let plan = Plan {
        start_values: vec![
            ("roll_start".to_owned(), Value::Real(0.05)),
            ("speed".to_owned(), Value::Real(3.0)),
            ("formulation".to_owned(), Value::Integer(3)),
        ],
        record: vec!["steer".to_owned(), "formulation".to_owned()],
        start_time: 0.0,
        stop_time: 2.003,
        step: 0.005,
        tolerance: Some(1e-4),
    };
    let trajectory = simulate(&fmu, &plan).expect("simulated");
    assert_eq!(trajectory.names, ["time", "steer", "formulation"]);
    assert_eq!(trajectory.ended, None);
    assert_eq!(trajectory.columns[0].last(), Some(&2.003));
    let parameters = Parameters {
        roll_start: 0.05,
        ..Parameters::default()
    };
    let input = Input {
        speed: 3.0,
        ..Input::default()
    };
    let mut native =
        Simulation::new(&parameters, Formulation::Repaired, input, 0.0).expect("started");
    for (time, steer) in trajectory.columns[0].iter().zip(&trajectory.columns[1]) {
        native.advance(*time).expect("arrived");
        assert!(native.state().steer.to_bits() == steer.to_bits(), "{time}");
    }
}

#[test]
fn reset_starts_anew() {
    let (_folder, fmu) = packed();
    let mut pair = Pair::new(&fmu, &aslant(), Formulation::Repaired);
    pair.step(0.5);
    pair.instance.reset().expect("reset");
    pair.initialize(&Parameters::default(), Formulation::Repaired)
        .expect("initialised");
    pair.time = 0.0;
    let parameters = Parameters::default();
    pair.native = Simulation::new(&parameters, Formulation::Repaired, Input::default(), 0.0)
        .expect("started");
    pair.check();
    pair.step(0.5);
}

#[test]
fn a_refused_call_says_why_and_changes_nothing() {
    #[track_caller]
    fn refused(call: Result<impl std::fmt::Debug, Error>, expected: &str) {
        match call.expect_err("refused") {
            Error::Refused {
                status: Status::Error,
                log,
                ..
            } => assert!(
                log.len() == 1 && log[0].message.contains(expected),
                "{log:?}"
            ),
            other => panic!("{other}"),
        }
    }
    let (_folder, fmu) = packed();
    let mut pair = Pair::new(&fmu, &aslant(), Formulation::Repaired);
    pair.step(0.1);
    let row = |name| Parameters::index(name).expect("a row");
    let (speed, wheelbase) = (pair.inputs[0], pair.parameters[row("wheelbase")]);
    let step = pair.parameters[row("internal_step")];
    let i = &mut pair.instance;
    refused(
        i.set_real(&[speed], &[f64::NAN]),
        "speed: expected a finite value",
    );
    refused(
        i.set_real(&[wheelbase], &[9.0]),
        "wheelbase: expected a value in [0.5, 2] m",
    );
    refused(
        i.set_real(&[step], &[1e-3]),
        "cannot be set in state step complete",
    );
    refused(
        i.set_real(&[9999], &[0.0]),
        "expected a value reference below",
    );
    refused(i.do_step(0.1, 0.0), "expected a finite positive time");
    refused(i.do_step(0.2, 0.1), "expected 0.1 s");
    refused(i.do_step(0.1, 1e15), "expected at most 10000 s");
    pair.step(0.1);

    // Too slow for explicit steps with so stiff a tyre: the step is refused, not the value.
    let stiffness = pair.parameters[row("cornering_stiffness")];
    let i = &mut pair.instance;
    i.set_real(&[speed, stiffness], &[0.1, 40.0])
        .expect("in range");
    refused(i.do_step(0.2, 0.1), "internal_step: expected less than");
    let (before, nominal) = (Input::default().speed, aslant().cornering_stiffness);
    i.set_real(&[speed, stiffness], &[before, nominal])
        .expect("in range");
    pair.step(0.1);
}

#[test]
fn instances_in_threads_do_not_meet() {
    let (_folder, fmu) = packed();
    let fmu = &fmu;
    std::thread::scope(|scope| {
        for number in 0..8 {
            scope.spawn(move || {
                let parameters = Parameters {
                    roll_start: 0.01 * f64::from(number),
                    ..aslant()
                };
                let mut pair = Pair::new(fmu, &parameters, Formulation::Repaired);
                for _ in 0..200 {
                    pair.step(0.005);
                }
            });
        }
    });
}

#[test]
fn locals_follow_the_load_dropped_under_way() {
    let (_folder, fmu) = packed();
    let locals = references(&fmu, Derived::TABLE);
    let mut pair = Pair::new(&fmu, &aslant(), Formulation::Repaired);
    let mut found = [0.0; Derived::LEN];
    for rear_load in [12.5, 0.0] {
        let parameters = Parameters {
            rear_load,
            ..aslant()
        };
        let row = pair.parameters[Parameters::index("rear_load").expect("a row")];
        pair.instance
            .set_real(&[row], &[rear_load])
            .expect("tunable");
        pair.instance.get_real(&locals, &mut found).expect("read");
        let expected = Bicycle::new(&parameters, Formulation::Repaired).derived();
        assert_eq!(found, expected.to_array());
    }
}
