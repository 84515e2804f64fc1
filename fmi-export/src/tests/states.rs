use super::cart::{ACCELERATION, Cart, FORCE, MASS, POSITION, RAIL, TIME, WHEELS};
use super::host::{Host, check, run};
use crate::{Instance, ffi};
use fmi2::{fmi2Discard, fmi2Error, fmi2OK};
use sha2::{Digest, Sha256};
use std::ptr::{null_mut, without_provenance_mut};

/// Position and time.
fn whereabouts(host: &Host) -> [u64; 2] {
    [POSITION, TIME].map(|reference| host.get(reference).to_bits())
}

#[test]
fn a_saved_state_brings_everything_back() {
    let mut host = check("setup enter exit step input-derivative get-state");
    let at = whereabouts(&host);
    run(&mut host, "step step");
    let after = whereabouts(&host);
    assert_ne!(at, after);
    host.set(FORCE, 7.0);
    run(&mut host, "set-state");
    assert_eq!(whereabouts(&host), at);
    run(&mut host, "step step");
    assert_eq!(whereabouts(&host), after);
    run(&mut host, "free-state");
    assert!(host.saved.is_null());
}

#[test]
fn a_saved_state_brings_back_the_life_cycle() {
    check("get-state setup enter set-state setup enter exit");
    check("setup enter get-state exit step set-state set-fixed exit");
    check("setup enter exit get-state leap? set-state step terminate set-state step");
    // an uninitialised place for what is read back
    let mut host = check("setup enter exit step get-state");
    let bytes = host.bytes();
    host.saved = without_provenance_mut(1 << 50);
    assert_eq!(host.take_bytes(&bytes), fmi2OK);
    run(&mut host, "set-state free-state");
    // saving in place
    let mut host = check("get-state setup enter exit get-state reset set-state");
    run(&mut host, "step");
}

#[test]
fn another_instance_can_take_a_state() {
    let mut host = check("setup enter exit step get-state step");
    let after = whereabouts(&host);
    let mut other = Host::new(true);
    // by pointer
    other.saved = host.saved;
    run(&mut other, "set-state");
    other.time = 0.5;
    run(&mut other, "step");
    assert_eq!(whereabouts(&other), after);
    // by bytes
    let bytes = host.bytes();
    other.saved = null_mut();
    assert_eq!(other.take_bytes(&bytes), fmi2OK);
    run(&mut host, "free-state");
    run(&mut other, "reset set-state");
    other.time = 0.5;
    run(&mut other, "step free-state");
    assert_eq!(whereabouts(&other), after);
}

#[test]
fn with_an_instance_go_its_states() {
    let mut keeper = Host::new(true);
    let host = check("setup enter exit step get-state");
    keeper.saved = host.saved;
    run(&mut keeper, "set-state");
    drop(host);
    run(&mut keeper, "set-state!");
}

#[test]
fn what_is_no_saved_state_is_refused() {
    let mut host = check("setup enter exit step get-state");
    let freed = host.saved;
    run(&mut host, "set-state free-state free-state set-state!");
    for wrong in [
        freed,
        without_provenance_mut(1 << 40),
        without_provenance_mut(3),
    ] {
        host.saved = wrong;
        run(&mut host, "set-state! free-state! get-state!");
        let mut size = 0;
        // SAFETY: a live instance; the state may be anything.
        let status =
            unsafe { ffi::serialized_fmu_state_size::<Cart>(host.c, wrong, &raw mut size) };
        assert_eq!(status, fmi2Error);
        assert!(host.log()[0].contains("expected a state from fmi2GetFMUstate"));
    }
    // SAFETY: NULL where a pointer was expected: what is tested.
    unsafe {
        assert_eq!(ffi::get_fmu_state::<Cart>(host.c, null_mut()), fmi2Error);
        assert_eq!(ffi::free_fmu_state::<Cart>(host.c, null_mut()), fmi2OK);
    }
    host.log();
    run(&mut host, "step");
}

#[test]
fn damaged_bytes_are_refused_whatever_the_damage() {
    let mut host = check("setup enter exit step get-state");
    let bytes = host.bytes();
    let mut refused = |bytes: &[i8], expected: &str| {
        assert_eq!(host.take_bytes(bytes), fmi2Error, "{expected}");
        let log = host.log();
        assert!(log.len() == 1 && log[0].contains(expected), "{log:?}");
    };
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1;
        refused(&damaged, "serialised state:");
    }
    for length in 0..bytes.len() {
        refused(&bytes[..length], "serialised state:");
    }
    let longer = [&bytes[..], &[0]].concat();
    refused(&longer, "checksum");
    refused(&[], "expected a saved state, found 0 bytes");
    refused(&[7; 100], "expected a saved state, found other bytes");
    let mut newer = bytes.clone();
    newer[8] = 9;
    refused(&newer, "expected version 1, found 9");
    let mut other = bytes.clone();
    other[20] = b'x'.cast_signed();
    refused(&other, "expected a state of guid {");
    run(&mut host, "set-state step");
}

#[test]
fn a_right_checksum_over_a_wrong_value_is_refused() {
    let mut host = check("setup enter exit step get-state");
    let mut bytes: Vec<u8> = host
        .bytes()
        .iter()
        .map(|byte| byte.cast_unsigned())
        .collect();
    let mass = 2_f64.to_le_bytes();
    let at = bytes
        .windows(8)
        .position(|window| window == mass)
        .expect("the mass");
    bytes[at..at + 8].copy_from_slice(&f64::NAN.to_le_bytes());
    let body = bytes.len() - 32;
    let checksum = Sha256::digest(&bytes[..body]);
    bytes[body..].copy_from_slice(&checksum);
    let bytes: Vec<i8> = bytes.iter().map(|byte| byte.cast_signed()).collect();
    assert_eq!(host.take_bytes(&bytes), fmi2Error);
    assert!(host.log()[0].contains("variable mass: expected a finite value"));
}

#[test]
fn a_buffer_that_is_too_small_is_refused() {
    let mut host = check("setup enter exit get-state");
    let mut bytes = host.bytes();
    let room = bytes.len() - 1;
    // SAFETY: a buffer of the size said.
    let status =
        unsafe { ffi::serialize_fmu_state::<Cart>(host.c, host.saved, bytes.as_mut_ptr(), room) };
    assert_eq!(status, fmi2Error);
    assert!(host.log()[0].contains("expected room for"));
    run(&mut host, "set-state step");
}

#[test]
fn an_input_slope_is_a_ramp_within_the_step() {
    // F = 1 N + 2 N/s · t on 2 kg: x = t²/4 + t³/6
    let mut host = check("setup enter input-derivative exit");
    for h in [0.5, 0.25, 0.75] {
        assert_eq!(host.step(h), fmi2OK);
        let t = host.time;
        let exact = 0.25 * t * t + t * t * t / 6.0;
        assert!((host.get(POSITION) - exact).abs() < 1e-15, "{t}");
        assert_eq!(host.get(FORCE), 1.0 + 2.0 * t);
    }
}

#[test]
fn slopes_are_checked() {
    let host = check("setup enter");
    let slope = |reference: u32, order: i32, value: f64, expected: &str| {
        // SAFETY: one element each.
        let status = unsafe {
            ffi::set_real_input_derivatives::<Cart>(
                host.c,
                &raw const reference,
                1,
                &raw const order,
                &raw const value,
            )
        };
        assert_eq!(status, fmi2Error, "{expected}");
        let log = host.log();
        assert!(log.len() == 1 && log[0].ends_with(expected), "{log:?}");
    };
    slope(
        FORCE,
        2,
        1.0,
        "expected a derivative of order 1, found one of order 2",
    );
    slope(
        FORCE,
        0,
        1.0,
        "expected a derivative of order 1, found one of order 0",
    );
    slope(FORCE, 1, f64::NAN, "expected a finite value, found NaN");
    slope(
        MASS,
        1,
        1.0,
        "expected a continuous input, found another variable",
    );
    slope(
        WHEELS,
        1,
        1.0,
        "expected a call for Integer, found one for Real",
    );
    slope(99, 1, 1.0, "expected a value reference below 11, found 99");
}

#[test]
fn output_rates_are_read() {
    let mut host = check("setup enter exit step");
    let rate = |host: &Host, reference: u32, order: i32| {
        let mut value = f64::NAN;
        // SAFETY: one element each.
        let status = unsafe {
            ffi::get_real_output_derivatives::<Cart>(
                host.c,
                &raw const reference,
                1,
                &raw const order,
                &raw mut value,
            )
        };
        (status, value)
    };
    // from rest, 1 N on 2 kg for .5 s
    assert_eq!(rate(&host, POSITION, 1), (fmi2OK, 0.25));
    assert_eq!(rate(&host, POSITION, 2).0, fmi2Error);
    assert_eq!(rate(&host, FORCE, 1).0, fmi2Error);
    assert_eq!(host.log().len(), 2);
    assert_eq!(host.step(100.0), fmi2Discard);
    assert_eq!(host.get(POSITION), RAIL);
}

#[test]
fn directional_derivatives_follow_the_mode() {
    let mut host = check("setup enter");
    assert_eq!(host.derivative(FORCE), (fmi2OK, 0.5));
    assert_eq!(host.derivative(MASS), (fmi2OK, -0.25));
    assert_eq!(host.derivative(ACCELERATION).0, fmi2Error);
    assert!(host.log()[0].contains("acceleration: expected an input or a variable with an exact"));
    run(&mut host, "exit step");
    assert_eq!(host.derivative(FORCE), (fmi2OK, 0.5));
    assert_eq!(host.derivative(MASS).0, fmi2Error);
    assert!(host.log()[0].contains("mass: expected an input or a continuous state"));
    assert_eq!(host.derivative(POSITION).0, fmi2Error);
    host.log();
    let (unknown, known, seed, mut found) = (ACCELERATION, FORCE, f64::NAN, 7.0);
    // SAFETY: one element each.
    let status = unsafe {
        ffi::get_directional_derivative::<Cart>(
            host.c,
            &raw const unknown,
            1,
            &raw const known,
            1,
            &raw const seed,
            &raw mut found,
        )
    };
    assert_eq!((status, found), (fmi2Error, 7.0));
    assert!(host.log()[0].contains("force: expected a finite value, found NaN"));
}

#[test]
fn the_safe_instance_alone_does_it_too() {
    let mut instance = Instance::<Cart>::new().expect("described");
    let experiment = crate::Experiment {
        start_time: 0.0,
        stop_time: None,
        tolerance: None,
    };
    instance.setup_experiment(experiment).expect("legal");
    instance.enter_initialization_mode().expect("legal");
    instance.exit_initialization_mode().expect("legal");
    instance.do_step(0.0, 1.0).expect("a step");
    let mut found = [0.0];
    instance.get(&[POSITION], &mut found).expect("read");
    assert_eq!(found, [0.25]);
}
