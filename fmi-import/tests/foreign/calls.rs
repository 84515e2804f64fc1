//! Calls, and what the FMU says in them.

use crate::build::{Variant, reference};
use fmi_import::{Error, Fmu, Instance, LogLine, Status, Step, Value};

/// An instance ready to step from 0 s.
pub fn started(fmu: &Fmu) -> Instance<'_> {
    let mut instance = fmu.instantiate("swing").expect("an instance");
    instance
        .setup_experiment(None, 0.0, None)
        .expect("accepted");
    instance.enter_initialization_mode().expect("entered");
    instance.exit_initialization_mode().expect("left");
    instance
}

pub fn real(instance: &mut Instance, name: &str) -> f64 {
    let mut value = [f64::NAN];
    let reference = [reference(instance.fmu(), name)];
    instance.get_real(&reference, &mut value).expect("read");
    value[0]
}

pub fn set(instance: &mut Instance, name: &str, value: &Value) {
    let variable = instance.fmu().description().variable(name);
    let variable = variable.expect("a variable").clone();
    instance.set(&variable, value).expect("set");
}

/// Bids the FMU to refuse the next steps.
pub fn refuse(instance: &mut Instance, item: i32) {
    set(instance, "refuse", &Value::Integer(item));
}

const DISCARD: i32 = 1;
const ERROR: i32 = 2;
const FATAL: i32 = 3;
const LATER: i32 = 4;
const LATER_BY_ERROR: i32 = 5;

/// A refused call's status and words.
#[track_caller]
fn refused<T: std::fmt::Debug>(call: Result<T, Error>) -> (Status, Vec<String>) {
    match call.expect_err("refused") {
        Error::Refused { status, log, .. } => {
            (status, log.into_iter().map(|line| line.message).collect())
        }
        other => panic!("{other}"),
    }
}

#[test]
fn values_of_all_types_go_in_and_come_out() {
    let fmu = Variant::default().load();
    let mut instance = fmu.instantiate("swing").expect("an instance");
    for (name, value) in [
        ("mass", Value::Real(3.5)),
        ("refuse", Value::Integer(4)),
        ("held", Value::Boolean(true)),
        ("label", Value::String("été".to_owned())),
    ] {
        set(&mut instance, name, &value);
        let variable = fmu.description().variable(name).expect("a variable");
        assert_eq!(instance.get(variable).expect("read"), value);
    }
    let mass = fmu.description().variable("mass").expect("a variable");
    let error = instance.set(mass, &Value::Boolean(true));
    assert_eq!(
        error.expect_err("refused").to_string(),
        "variable mass: expected Real, found Boolean"
    );
    let mut two = [0.0; 2];
    let error = instance.get_real(&[0], &mut two).expect_err("refused");
    assert!(error.to_string().contains("found 2"), "{error}");
    let zero = "a\0b".to_owned();
    let error = instance.set_string(&[0], &[&zero]).expect_err("refused");
    assert!(matches!(error, Error::Text { .. }), "{error}");
    let (status, words) = refused(instance.get_integer(&[99], &mut [0]));
    assert_eq!(
        (status, words.as_slice()),
        (Status::Error, &["no Integer 99".to_owned()][..])
    );
}

#[test]
fn placeholders_are_filled_in() {
    let fmu = Variant::default().load();
    let mut instance = fmu.instantiate("swing").expect("an instance");
    instance.enter_initialization_mode().expect("a warning");
    let line = |status, category: &str, message: &str| LogLine {
        status,
        category: category.to_owned(),
        message: message.to_owned(),
    };
    assert_eq!(
        instance.log(),
        [
            line(Status::Ok, "", "100% ready: mass 42 0.5"),
            line(Status::Warning, "logStatusWarning", ""),
            line(Status::Ok, "logAll", "plain"),
        ]
    );
    assert_eq!(instance.log(), []);
    // longer than any buffer, and on its edge
    for length in [1000, 1009, 1010, 1011, 1012, 1013, 100_000] {
        let label = "x".repeat(length);
        set(&mut instance, "label", &Value::String(label.clone()));
        instance.enter_initialization_mode().expect("a warning");
        let log = instance.log();
        assert_eq!(log[0].message, format!("100% ready: {label} 42 0.5"));
    }
}

#[test]
fn logging_is_turned_off_and_on() {
    let fmu = Variant::default().load();
    let mut instance = fmu.instantiate("swing").expect("an instance");
    instance.set_debug_logging(false, &[]).expect("off");
    instance.enter_initialization_mode().expect("entered");
    assert_eq!(instance.log(), []);
    instance.set_debug_logging(true, &["logAll"]).expect("on");
    instance.enter_initialization_mode().expect("entered");
    assert_eq!(instance.log().len(), 3);
    let (_, words) = refused(instance.set_debug_logging(true, &["other"]));
    assert_eq!(words, ["no category other"]);
}

#[test]
fn a_step_that_ends_early_says_where_and_why() {
    let fmu = Variant::default().load();
    let mut instance = started(&fmu);
    refuse(&mut instance, DISCARD);
    let step = instance.do_step(0.0, 0.5).expect("a discard");
    let Step::Discarded {
        last_successful_time,
        terminated,
        log,
    } = step
    else {
        panic!("{step:?}");
    };
    assert_eq!(last_successful_time, Some(0.25));
    assert!(terminated);
    // ω = √(8/2) = 2: cos 0.5 at 0.25 s; the variable is named where the FMU wrote #r3#
    assert_eq!(log[0].message, "step 1 of mass to 0.5 s: position is 0.878");
    assert_eq!(log[0].status, Status::Discard);
}

#[test]
fn an_error_comes_with_the_fmus_words_and_can_be_overcome() {
    let fmu = Variant::default().load();
    let mut instance = started(&fmu);
    refuse(&mut instance, ERROR);
    let error = instance.do_step(0.0, 0.5).expect_err("refused");
    assert_eq!(
        error.to_string(),
        "fmi2DoStep returned Error:\n  [logStatusError] mass refuses at 0 s"
    );
    refuse(&mut instance, 0);
    assert_eq!(instance.do_step(0.0, 0.5).expect("a step"), Step::Complete);
    // the motion is exact but for the rounding of one sine
    assert!((real(&mut instance, "position") - 1.0_f64.cos()).abs() < 1e-15);
}

#[test]
fn a_step_in_the_background_is_waited_for() {
    let fmu = Variant::default().load();
    let mut instance = started(&fmu);
    refuse(&mut instance, LATER);
    assert_eq!(instance.do_step(0.0, 0.5).expect("a step"), Step::Complete);
    refuse(&mut instance, LATER_BY_ERROR);
    let (status, words) = refused(instance.do_step(0.5, 0.5));
    assert_eq!(
        (status, words.as_slice()),
        (Status::Error, &["in vain".to_owned()][..])
    );
}

#[test]
fn after_fatal_nothing_is_called() {
    let (folder, path) = Variant::default().pack();
    let trace = folder.path().join("trace");
    let fmu = Fmu::open(&path).expect("loaded");
    let mut other = started(&fmu);
    let mut instance = started(&fmu);
    let trace_text = trace.to_str().expect("UTF-8").to_owned();
    set(&mut instance, "trace", &Value::String(trace_text));
    let saved = instance.get_fmu_state().expect("saved");
    refuse(&mut instance, FATAL);
    let (status, words) = refused(instance.do_step(0.0, 0.5));
    assert_eq!(
        (status, words.as_slice()),
        (Status::Fatal, &["mass is broken".to_owned()][..])
    );
    // "for all FMU instances" (FMI 2.0 §2.1.3)
    for error in [
        instance.reset().expect_err("refused"),
        instance.set_fmu_state(&saved).expect_err("refused"),
        other.terminate().expect_err("refused"),
        fmu.instantiate("third").expect_err("refused"),
    ] {
        assert!(matches!(error, Error::Broken { .. }), "{error}");
    }
    drop((saved, instance, other));
    assert!(!trace.exists(), "freed, which the standard forbids");
    drop(fmu);
    let told = std::fs::read_to_string(&trace).expect("written at the end");
    assert_eq!(told, "unload with resources\n");
    let again = Fmu::open(&path).expect("loaded anew");
    started(&again).terminate().expect("alive");
}

#[test]
fn a_refused_instance_says_why() {
    let fmu = Variant {
        edits: &[("{f0e1}", "{dead}")],
        ..Variant::default()
    }
    .load();
    let error = fmu.instantiate("swing").expect_err("refused");
    assert_eq!(
        error.to_string(),
        "the FMU made no instance:\n  [logStatusError] expected guid {f0e1}, found {dead}"
    );
}

#[test]
fn derivatives_go_in_and_come_out() {
    let fmu = Variant::default().load();
    let mut instance = started(&fmu);
    let [force, position, velocity, acceleration] =
        ["force", "position", "velocity", "acceleration"].map(|name| reference(&fmu, name));
    let mut sensitivity = [f64::NAN; 2];
    instance
        .get_directional_derivative(
            &[position, acceleration],
            &[force],
            &[3.0],
            &mut sensitivity,
        )
        .expect("given");
    // ∂a/∂F = 1/m
    assert_eq!(sensitivity, [0.0, 1.5]);

    // A force that rises by 1 N/s: F(t) = t, and x = t/k − sin ωt/(ωk) + cos ωt with ω = 2, k = 8.
    instance
        .set_real_input_derivatives(&[force], &[1], &[1.0])
        .expect("taken");
    instance.do_step(0.0, 0.5).expect("a step");
    assert_eq!(real(&mut instance, "force"), 0.5);
    let expected = 0.5 / 8.0 - 1.0_f64.sin() / 16.0 + 1.0_f64.cos();
    assert!((real(&mut instance, "position") - expected).abs() < 1e-15);

    let mut rates = [f64::NAN; 2];
    instance
        .get_real_output_derivatives(&[position, velocity], &[1, 1], &mut rates)
        .expect("given");
    assert_eq!(rates[0], real(&mut instance, "velocity"));
    assert_eq!(rates[1], real(&mut instance, "acceleration"));
    let (status, _) = refused(instance.get_real_output_derivatives(&[position], &[2], &mut [0.0]));
    assert_eq!(status, Status::Error);
    let error = instance.get_directional_derivative(&[position], &[force], &[], &mut [0.0]);
    assert!(matches!(
        error,
        Err(Error::Length {
            references: 1,
            values: 0
        })
    ));
}

/// The description as of an FMU without capabilities.
pub const BARE: &[(&str, &str)] = &[
    ("canInterpolateInputs=\"true\"", ""),
    ("maxOutputDerivativeOrder=\"1\"", ""),
    ("canGetAndSetFMUstate=\"true\"", ""),
    ("canSerializeFMUstate=\"true\"", ""),
    ("providesDirectionalDerivative=\"true\"", ""),
];

#[test]
fn an_fmu_without_capabilities_is_loaded_and_the_flag_named() {
    let fmu = Variant {
        defines: &["BARE"],
        edits: BARE,
        ..Variant::default()
    }
    .load();
    let mut instance = started(&fmu);
    refuse(&mut instance, DISCARD);
    let step = instance.do_step(0.0, 0.5).expect("a discard");
    let Step::Discarded {
        last_successful_time,
        terminated,
        ..
    } = step
    else {
        panic!("{step:?}");
    };
    assert_eq!((last_successful_time, terminated), (None, false));
    for (error, flag) in [
        (instance.get_fmu_state().err(), "canGetAndSetFMUstate"),
        (
            instance.deserialize_fmu_state(&[]).err(),
            "canSerializeFMUstate",
        ),
        (
            instance
                .get_directional_derivative(&[], &[], &[], &mut [])
                .err(),
            "providesDirectionalDerivative",
        ),
        (
            instance.set_real_input_derivatives(&[], &[], &[]).err(),
            "canInterpolateInputs",
        ),
        (
            instance
                .get_real_output_derivatives(&[], &[], &mut [])
                .err(),
            "maxOutputDerivativeOrder",
        ),
    ] {
        let error = error.expect("refused").to_string();
        assert!(
            error.contains(&format!("an FMU that declares {flag}, ")),
            "{error}"
        );
    }
    let error = instance.set_debug_logging(true, &[]).expect_err("absent");
    assert_eq!(
        error.to_string(),
        "expected the FMU's library to have fmi2SetDebugLogging, found none"
    );
}

#[test]
fn a_capability_declared_but_not_built_is_named() {
    let fmu = Variant {
        defines: &["BARE"],
        ..Variant::default()
    }
    .load();
    let mut instance = started(&fmu);
    let error = instance.get_fmu_state().expect_err("absent").to_string();
    assert!(error.contains("library to have fmi2GetFMUstate"), "{error}");
}
