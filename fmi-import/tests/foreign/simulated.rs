//! From start to end.

use crate::build::{Variant, reference};
use fmi_import::{Error, Plan, Trajectory, Value, simulate, simulate_with};

fn plan() -> Plan {
    Plan {
        start_values: vec![],
        record: ["position", "steps", "held"].map(str::to_owned).to_vec(),
        start_time: 1.0,
        stop_time: 2.05,
        step: 0.1,
        tolerance: Some(1e-6),
    }
}

fn run(variant: &Variant, plan: &Plan) -> Result<Trajectory, Error> {
    simulate(&variant.load(), plan)
}

#[test]
fn start_values_of_every_type_are_set_and_the_motion_is_exact() {
    let plan = Plan {
        start_values: [
            ("mass", Value::Real(8.0)),
            ("position_start", Value::Real(0.5)),
            ("refuse", Value::Integer(4)),
            ("held", Value::Boolean(false)),
            ("label", Value::String("pendulum".to_owned())),
        ]
        .map(|(name, value)| (name.to_owned(), value))
        .to_vec(),
        ..plan()
    };
    let trajectory = run(&Variant::default(), &plan).expect("simulated");
    assert_eq!(trajectory.names, ["time", "position", "steps", "held"]);
    let time = &trajectory.columns[0];
    // ten whole steps and one of 0.05 s
    assert_eq!((time.len(), time[0], time[11]), (12, 1.0, 2.05));
    for (time, position) in time.iter().zip(&trajectory.columns[1]) {
        // ω = √(8/8) = 1; a dozen roundings
        assert!((position - 0.5 * (time - 1.0).cos()).abs() < 1e-14);
    }
    assert_eq!(trajectory.columns[2][11], 11.0);
    assert_eq!(trajectory.ended, None);
}

#[test]
fn an_early_end_is_no_error() {
    let plan = Plan {
        start_values: vec![("refuse".to_owned(), Value::Integer(1))],
        ..plan()
    };
    let trajectory = run(&Variant::default(), &plan).expect("ended early");
    assert_eq!(trajectory.columns[0], [1.0, 1.05]);
    let log = trajectory.ended.expect("words");
    assert!(
        log[0].message.starts_with("step 1 of mass to 1.1 s"),
        "{log:?}"
    );
}

#[test]
fn an_fmu_with_one_step_length_gets_no_other() {
    let fixed = Variant {
        edits: &[("canHandleVariableCommunicationStepSize=\"true\"", "")],
        ..Variant::default()
    };
    let trajectory = run(&fixed, &plan()).expect("simulated");
    let time = &trajectory.columns[0];
    assert_eq!((time.len(), time[10]), (11, 2.0));
    // a stop on the grid is reached, whatever the rounding
    let plan = Plan {
        stop_time: 1.3,
        ..plan()
    };
    let trajectory = run(&fixed, &plan).expect("simulated");
    assert_eq!(trajectory.columns[0].len(), 4);
}

#[test]
fn inputs_can_be_set_at_each_step() {
    let fmu = Variant::default().load();
    let force = reference(&fmu, "force");
    let mut plan = plan();
    plan.record = vec!["force".to_owned()];
    plan.stop_time = 1.3;
    let trajectory = simulate_with(&fmu, &plan, |instance, time| {
        instance.set_real(&[force], &[10.0 * time])
    })
    .expect("simulated");
    // a row shows what acted until then
    assert_eq!(trajectory.columns[1], [0.0, 10.0, 11.0, 12.0]);
}

#[test]
fn a_plan_that_cannot_be_is_refused() {
    #[track_caller]
    fn check(plan: &Plan, expected: &str) {
        let error = run(&Variant::default(), plan).expect_err("refused");
        assert!(error.to_string().contains(expected), "{error}");
    }
    let with = |name: &str, value| Plan {
        start_values: vec![(name.to_owned(), value)],
        ..plan()
    };
    check(&with("positron", Value::Real(1.0)), "found \"positron\"");
    check(
        &with("position", Value::Real(1.0)),
        "variable position: expected one that can be set before the start, found one that the FMU calculates",
    );
    check(
        &with("mass", Value::Integer(1)),
        "expected Real, found Integer",
    );
    let record = |name: &str| Plan {
        record: vec![name.to_owned()],
        ..plan()
    };
    check(&record("nothing"), "found \"nothing\"");
    check(&record("label"), "recorded as a number");
    for (step, expected) in [
        (0.0, "communication step: expected a positive time, found 0"),
        (f64::NAN, "communication step"),
        (1e-12, "number of steps: expected at most 1e8"),
    ] {
        check(&Plan { step, ..plan() }, expected);
    }
    let stop_time = 1.0;
    check(
        &Plan {
            stop_time,
            ..plan()
        },
        "stop time: expected a finite time after",
    );
    let start_time = f64::INFINITY;
    check(
        &Plan {
            start_time,
            ..plan()
        },
        "start time: expected a finite",
    );
}
