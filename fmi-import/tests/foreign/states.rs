//! States saved, restored, and carried as bytes.

use crate::build::Variant;
use crate::calls::{real, set, started};
use fmi_import::{Error, Instance, Value};

fn steps(instance: &mut Instance, from: f64) -> [f64; 2] {
    for n in 0..5 {
        instance
            .do_step(from + 0.1 * f64::from(n), 0.1)
            .expect("a step");
    }
    [real(instance, "position"), real(instance, "velocity")]
}

#[test]
fn a_saved_state_is_come_back_to() {
    let fmu = Variant::default().load();
    let mut instance = started(&fmu);
    steps(&mut instance, 0.0);
    let mut saved = instance.get_fmu_state().expect("saved");
    let once = steps(&mut instance, 0.5);
    instance.set_fmu_state(&saved).expect("restored");
    assert_eq!(steps(&mut instance, 0.5), once);
    // in place of the first
    instance.get_fmu_state_into(&mut saved).expect("saved");
    let once = steps(&mut instance, 1.0);
    instance.set_fmu_state(&saved).expect("restored");
    assert_eq!(steps(&mut instance, 1.0), once);
}

#[test]
fn the_fmu_is_told_whether_time_may_go_back() {
    let fmu = Variant::default().load();
    let mut instance = started(&fmu);
    let settled = fmu.description().variable("settled").expect("a variable");
    instance.do_step(0.0, 0.1).expect("a step");
    assert_eq!(instance.get(settled).expect("read"), Value::Boolean(true));
    let saved = instance.get_fmu_state().expect("saved");
    instance.do_step(0.1, 0.1).expect("a step");
    assert_eq!(instance.get(settled).expect("read"), Value::Boolean(false));
    drop(saved);
}

#[test]
fn bytes_carry_a_state_to_another_instance_and_another_loading() {
    let (fmu, other) = (Variant::default().load(), Variant::default().load());
    let mut instance = started(&fmu);
    steps(&mut instance, 0.0);
    let saved = instance.get_fmu_state().expect("saved");
    let bytes = instance.serialize_fmu_state(&saved).expect("written");
    let there = steps(&mut instance, 0.5);
    for mut instance in [started(&fmu), started(&other)] {
        let error = instance.set_fmu_state(&saved).expect_err("another's");
        assert!(matches!(error, Error::ForeignState), "{error}");
        let error = instance.serialize_fmu_state(&saved).expect_err("another's");
        assert!(matches!(error, Error::ForeignState), "{error}");
        let read = instance.deserialize_fmu_state(&bytes).expect("read");
        instance.set_fmu_state(&read).expect("set");
        assert_eq!(steps(&mut instance, 0.5), there);
    }
    let error = instance
        .deserialize_fmu_state(&bytes[1..])
        .expect_err("refused");
    let words = format!("expected {} bytes, found {}", bytes.len(), bytes.len() - 1);
    assert!(error.to_string().contains(&words), "{error}");
}

#[test]
fn a_state_too_big_for_the_memory_is_an_error() {
    let fmu = Variant {
        defines: &["HUGE_STATE"],
        ..Variant::default()
    }
    .load();
    let mut instance = started(&fmu);
    let saved = instance.get_fmu_state().expect("saved");
    let error = instance.serialize_fmu_state(&saved).expect_err("too big");
    assert!(matches!(error, Error::StateSize { .. }), "{error}");
}

#[test]
fn states_can_be_saved_without_bytes() {
    let fmu = Variant {
        defines: &["NO_BYTES"],
        edits: &[("canSerializeFMUstate=\"true\"", "")],
        ..Variant::default()
    }
    .load();
    let mut instance = started(&fmu);
    let saved = instance.get_fmu_state().expect("saved");
    set(&mut instance, "force", &Value::Real(1.0));
    instance.set_fmu_state(&saved).expect("restored");
    assert_eq!(real(&mut instance, "force"), 0.0);
    let error = instance.serialize_fmu_state(&saved).expect_err("absent");
    assert!(
        error.to_string().contains("canSerializeFMUstate"),
        "{error}"
    );
}
