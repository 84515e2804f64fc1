use super::cart::{CURSED, Cart, FORCE, MASS, POSITION, RAIL, TIME, WHEELS};
use super::host::{Host, SHARED, callbacks, check, run, text};
use crate::{Function, Model, ffi};
use fmi2::{fmi2Discard, fmi2Error, fmi2Fatal, fmi2OK};
use std::ptr::{null, null_mut};

#[test]
fn a_simulation_runs_and_can_be_repeated() {
    check("setup enter exit step step get terminate get reset setup enter exit step");
}

#[test]
fn instantiated_allows_start_values_and_setup() {
    check(
        "get! exit! terminate! step! cancel! time-status! ended-status! status! \
         derivative! output-derivative! input-derivative get-state set-state free-state \
         set-fixed set-tunable set-input set-output! enter! setup setup debug reset enter! \
         setup enter",
    );
}

#[test]
fn initialization_mode_allows_start_values_and_reading() {
    check(
        "setup enter setup! enter! terminate! step! cancel! time-status! status! \
         output-derivative! derivative derivative-fixed input-derivative \
         get-state set-state copy-state free-state \
         get set-fixed set-tunable set-input set-output! get debug exit",
    );
    check("setup enter reset setup enter");
}

#[test]
fn step_complete_allows_inputs_tunables_and_steps() {
    check(
        "setup enter exit setup! enter! exit! cancel! get set-fixed! set-tunable set-input \
         set-output! time-status ended-status status? integer-status? string-status? \
         output-derivative derivative derivative-fixed! input-derivative \
         get-state set-state copy-state free-state step get debug terminate",
    );
}

#[test]
fn after_an_early_end_only_reading_and_endings_are_left() {
    check(
        "setup enter exit step leap? get time-status ended-status status? \
         step! setup! enter! exit! set-fixed! set-tunable! set-input! cancel! \
         input-derivative! output-derivative derivative get-state set-state free-state \
         terminate get time-status ended-status",
    );
    check("setup enter exit leap? reset setup enter exit step");
}

#[test]
fn terminated_allows_reading_and_reset() {
    check(
        "setup enter exit terminate get time-status terminate! step! setup! enter! exit! \
         set-input! set-tunable! set-fixed! cancel! input-derivative! output-derivative \
         derivative get-state copy-state set-state free-state debug reset setup enter",
    );
}

#[test]
fn the_table_has_every_function_of_the_standard_once() {
    let mut names: Vec<&str> = Function::ALL.iter().map(|function| function.name).collect();
    names.sort_unstable();
    names.dedup();
    // 34 functions, less the two that ask for versions, less fmi2Instantiate.
    assert_eq!(names.len(), 31);
}

#[test]
fn a_null_instance_is_an_error_everywhere() {
    let mut host = Host::new(true);
    let live = std::mem::replace(&mut host.c, null_mut());
    for word in "debug setup enter exit terminate reset get set-input step cancel time-status \
                 ended-status status integer-status string-status get-state set-state free-state \
                 derivative input-derivative output-derivative"
        .split_whitespace()
    {
        assert_eq!(host.call(word), fmi2Error, "{word}");
    }
    // SAFETY: NULL is nothing to free.
    unsafe { ffi::free_instance(&SHARED, null_mut()) };
    host.c = live;
}

#[test]
fn instantiation_refuses_with_one_line() {
    let log = super::host::Log::default();
    let given = callbacks(&log);
    let guid = text(&Cart::description().fingerprint());
    let check = |name, kind, guid, expected: &str| {
        // SAFETY: texts are null-terminated or NULL.
        let c =
            unsafe { ffi::instantiate(&SHARED, name, kind, guid, null(), &raw const given, 0, 0) };
        assert!(c.is_null());
        let lines = std::mem::take(&mut *log.lock().expect("one thread"));
        assert_eq!(lines.len(), 1, "{lines:?}");
        assert!(lines[0].contains(expected), "{lines:?}");
    };
    let (name, other) = (c"cart".as_ptr(), c"{0}".as_ptr());
    check(null(), 1, guid.as_ptr(), "instanceName: expected a pointer");
    check(
        c"".as_ptr(),
        1,
        guid.as_ptr(),
        "instanceName: expected a name",
    );
    check(
        c"\xff".as_ptr(),
        1,
        guid.as_ptr(),
        "instanceName: expected UTF-8",
    );
    check(name, 0, guid.as_ptr(), "fmuType: expected fmi2CoSimulation");
    check(name, 1, null(), "fmuGUID: expected a pointer");
    check(name, 1, other, "fmuGUID: expected {");
    // SAFETY: texts are null-terminated; there are no callbacks.
    let c = unsafe { ffi::instantiate(&SHARED, name, 1, guid.as_ptr(), null(), null(), 0, 1) };
    assert!(c.is_null());
}

#[test]
fn steps_are_checked_and_a_refused_one_can_be_repeated() {
    let mut host = Host::new(true);
    assert_eq!(host.setup(0.0, Some(1.0)), fmi2OK);
    run(&mut host, "enter exit");
    for h in [0.0, -1.0, f64::NAN, f64::INFINITY, 1.1] {
        assert_eq!(host.step(h), fmi2Error, "{h}");
    }
    for wrong in [0.1, f64::NAN, -1e-9] {
        host.time = wrong;
        assert_eq!(host.step(0.1), fmi2Error, "{wrong}");
    }
    host.time = 0.0;
    assert_eq!(host.get(POSITION), 0.0);
    // Ten times 0.1 is not 1 in floating point, and then beyond the stop.
    for _ in 0..10 {
        assert_eq!(host.step(0.1), fmi2OK, "{:?}", host.log());
    }
    assert_eq!(host.step(0.1), fmi2Error);
    // a = 1 N / 2 kg over 1 s, from rest, exact in each step but for rounding
    assert!((host.get(POSITION) - 0.25).abs() < 1e-15);
}

#[test]
fn the_importers_round_off_in_time_is_accepted() {
    let mut host = check("setup enter exit");
    for n in 0..1000 {
        host.time = f64::from(n) * 1e-9;
        assert_eq!(host.step(1e-9), fmi2OK, "{:?}", host.log());
    }
    host.time = 999.0 * 1e-9;
    assert_eq!(host.step(1e-9), fmi2Error);
}

#[test]
fn time_may_cross_zero() {
    for (start, h, steps) in [
        (-1.0, 0.1, 20),
        (-10.0, 0.01, 1100),
        (-2.0, 1.0 / 60.0, 240),
    ] {
        let mut host = Host::new(true);
        assert_eq!(host.setup(start, None), fmi2OK);
        run(&mut host, "set-heavy enter exit");
        for n in 0..steps {
            host.time = start + f64::from(n) * h;
            assert_eq!(host.step(h), fmi2OK, "{:?}", host.log());
        }
    }
}

#[test]
fn a_time_without_end_is_no_time() {
    let mut host = Host::new(true);
    assert_eq!(host.setup(1e308, None), fmi2OK);
    run(&mut host, "enter exit");
    host.time = 1e308;
    assert_eq!(host.step(1e308), fmi2Error);
    assert!(host.log()[0].contains("end of the communication step: expected a finite time"));
}

#[test]
fn an_experiment_that_makes_no_sense_is_refused() {
    let host = Host::new(true);
    for (start, stop) in [
        (f64::NAN, None),
        (f64::INFINITY, None),
        (0.0, Some(f64::NAN)),
        (1.0, Some(0.5)),
    ] {
        assert_eq!(host.setup(start, stop), fmi2Error, "{start} {stop:?}");
    }
    // SAFETY: a live instance.
    let status = unsafe { ffi::setup_experiment::<Cart>(host.c, 1, -1.0, 0.0, 0, 0.0) };
    assert_eq!(status, fmi2Error);
    assert_eq!(host.setup(5.0, Some(6.0)), fmi2OK);
}

#[test]
fn an_early_end_is_a_discard_at_the_last_successful_time() {
    let mut host = check("setup enter exit step");
    assert_eq!(host.step(100.0), fmi2Discard);
    assert_eq!(
        host.log(),
        ["cart 2 logStatusDiscard the rail ends; the last successful time is 50.5 s"]
    );
    let (mut at, mut ended) = (0.0, 0);
    // SAFETY: pointers to locals.
    unsafe {
        ffi::get_real_status::<Cart>(host.c, 2, &raw mut at);
        ffi::get_boolean_status::<Cart>(host.c, 3, &raw mut ended);
    }
    assert_eq!((at, ended), (50.5, 1));
    assert_eq!((host.get(TIME), host.get(POSITION)), (50.5, RAIL));
}

#[test]
fn a_model_may_refuse_to_initialise_and_to_step() {
    let mut host = check("setup enter");
    assert_eq!(host.set(MASS, 2e3), fmi2OK);
    run(&mut host, "get! exit!");
    assert_eq!(host.set(MASS, 2.0), fmi2OK);
    run(&mut host, "get exit");
    let set_brake = |on: i32| {
        // SAFETY: one element each.
        let status =
            unsafe { ffi::set_boolean::<Cart>(host.c, &super::cart::BRAKED, 1, &raw const on) };
        assert_eq!(status, fmi2OK);
    };
    set_brake(1);
    // SAFETY: a live instance.
    let status = unsafe { ffi::do_step::<Cart>(host.c, 0.0, 0.5, 1) };
    assert_eq!(status, fmi2Error);
    assert_eq!(host.log(), ["cart 3 logStatusError the brake is on"]);
    set_brake(0);
    run(&mut host, "step");
}

#[test]
fn reset_brings_back_the_start_values() {
    let mut host = check("setup set-fixed enter set-input exit step reset setup enter");
    assert_eq!(
        (host.get(MASS), host.get(FORCE), host.get(POSITION)),
        (2.0, 1.0, 0.0)
    );
    run(&mut host, "exit step");
}

#[test]
fn after_a_panic_everything_is_fatal() {
    let mut host = Host::new(true);
    assert_eq!(host.set_integer(WHEELS, CURSED), fmi2OK);
    run(&mut host, "setup enter exit");
    assert_eq!(host.call("step"), fmi2Fatal);
    assert_eq!(
        host.log(),
        ["cart 4 logStatusFatal internal failure, the instance is unusable: 100 %% cursed"]
    );
    for word in ["get", "step", "reset", "terminate", "debug"] {
        assert_eq!(host.call(word), fmi2Fatal, "{word}");
    }
    assert!(host.log().is_empty());
}

#[test]
fn logging_follows_the_categories() {
    let categories = |host: &Host, on, names: &[&str]| {
        let texts: Vec<_> = names.iter().map(|name| text(name)).collect();
        let pointers: Vec<_> = texts.iter().map(|text| text.as_ptr()).collect();
        // SAFETY: as many texts as said.
        unsafe { ffi::set_debug_logging::<Cart>(host.c, on, pointers.len(), pointers.as_ptr()) }
    };
    let mut host = Host::new(false);
    assert_eq!(host.call("exit"), fmi2Error);
    assert!(host.log().is_empty(), "silent when logging is off");
    assert_eq!(categories(&host, 1, &["logStatusDiscard"]), fmi2OK);
    host.call("exit");
    assert!(host.log().is_empty(), "another category is on");
    assert_eq!(categories(&host, 1, &["logStatusError"]), fmi2OK);
    host.call("exit");
    assert_eq!(host.log().len(), 1);
    assert_eq!(categories(&host, 1, &["logGossip"]), fmi2Error);
    assert!(host.log()[0].contains("expected a log category out of logStatusWarning"));
    // SAFETY: a count without an array.
    let status = unsafe { ffi::set_debug_logging::<Cart>(host.c, 1, 1, null()) };
    assert_eq!(status, fmi2Error);
    host.log();
    assert_eq!(categories(&host, 0, &[]), fmi2OK);
    host.call("exit");
    assert!(host.log().is_empty());
}
