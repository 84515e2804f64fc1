//! One right call of every function.

use fmi2::{fmi2Component, fmi2OK, fmi2Status};
use std::ptr::{null, null_mut};
use tests::symbols::*;
use tests::{Slave, State};

/// What FMI 2.0 §4.2.4 says of a call in each of the five states, in the order of
/// [`State::ALL`]: `x` obeyed, `-` refused, `d` discarded, for what is asked after belongs to a
/// step that is still pending, of which there is none.
///
/// The footnotes on variables are in the rows of the setters. One leniency is ours: inputs may be
/// set in *instantiated*, where importers do it.
pub(crate) const CALLS: &[(&str, &str)] = &[
    ("fmi2SetDebugLogging", "xxxxx"),
    ("fmi2SetupExperiment", "x----"),
    ("fmi2EnterInitializationMode", "x----"),
    ("fmi2ExitInitializationMode", "-x---"),
    ("fmi2Terminate", "--xx-"),
    ("fmi2Reset", "xxxxx"),
    ("fmi2GetReal parameter", "-xxxx"),
    ("fmi2GetReal input", "-xxxx"),
    ("fmi2GetReal output", "-xxxx"),
    ("fmi2GetReal local", "-xxxx"),
    ("fmi2GetReal time", "-xxxx"),
    ("fmi2GetInteger", "-xxxx"),
    ("fmi2GetBoolean", "-xxxx"),
    ("fmi2GetString", "-xxxx"),
    ("fmi2SetReal input", "xxx--"),
    ("fmi2SetReal tunable parameter", "xxx--"),
    ("fmi2SetReal fixed parameter", "xx---"),
    ("fmi2SetReal output", "-----"),
    ("fmi2SetReal local", "-----"),
    ("fmi2SetReal time", "-----"),
    ("fmi2SetInteger fixed parameter", "xx---"),
    ("fmi2SetBoolean", "xxx--"),
    ("fmi2SetString", "xxx--"),
    ("fmi2GetFMUstate", "xxxxx"),
    ("fmi2GetFMUstate in place", "xxxxx"),
    ("fmi2SetFMUstate", "xxxxx"),
    ("fmi2FreeFMUstate", "xxxxx"),
    ("fmi2SerializedFMUstateSize", "xxxxx"),
    ("fmi2SerializeFMUstate", "xxxxx"),
    ("fmi2DeSerializeFMUstate", "xxxxx"),
    ("fmi2GetDirectionalDerivative by input", "-xxxx"),
    ("fmi2GetDirectionalDerivative by parameter", "-x---"),
    ("fmi2GetDirectionalDerivative by state", "--xxx"),
    ("fmi2SetRealInputDerivatives", "xxx--"),
    ("fmi2GetRealOutputDerivatives", "--xxx"),
    ("fmi2DoStep", "--x--"),
    ("fmi2CancelStep", "-----"),
    ("fmi2GetStatus", "--ddd"),
    ("fmi2GetRealStatus", "--xxx"),
    ("fmi2GetIntegerStatus", "--ddd"),
    ("fmi2GetBooleanStatus", "--xxx"),
    ("fmi2GetStringStatus", "--ddd"),
];

/// What `CALLS` says of `call` in `state`.
pub(crate) fn expected(legal: &str, state: State) -> fmi2Status {
    match legal.as_bytes()[state as usize] {
        b'x' => fmi2OK,
        b'd' => fmi2::fmi2Discard,
        _ => fmi2::fmi2Error,
    }
}

/// Makes the call, rightly but for the state. A saved state must be in `slave.saved`.
#[expect(clippy::too_many_lines, reason = "the interface has that many")]
pub(crate) fn make(slave: &mut Slave, call: &str) -> fmi2Status {
    let c = slave.c;
    let vr = Slave::reference;
    let get_real = |name| {
        let (vr, mut value) = (vr(name), f64::NAN);
        // SAFETY: one element each.
        let status = unsafe { fmi2GetReal(c, &raw const vr, 1, &raw mut value) };
        assert_eq!(status == fmi2OK, value.is_finite(), "{name}");
        status
    };
    let derivative = |known| {
        let (unknown, known) = (vr("roll_acceleration"), vr(known));
        let (seed, mut value) = (1.0, f64::NAN);
        // SAFETY: one element each.
        let status = unsafe {
            fmi2GetDirectionalDerivative(
                c,
                &raw const unknown,
                1,
                &raw const known,
                1,
                &raw const seed,
                &raw mut value,
            )
        };
        assert_eq!(status == fmi2OK, value.is_finite(), "{known}");
        status
    };
    let (mut real, mut integer, mut text, mut size) = (f64::NAN, -1, null(), 0);
    let (one, slope) = (1, 0.25);
    let (input, output, choice) = (vr("steer_torque"), vr("steer"), vr("formulation"));
    // SAFETY: a live instance or NULL, one element each, none where none is said.
    unsafe {
        match call {
            "fmi2SetDebugLogging" => fmi2SetDebugLogging(c, 1, 0, null()),
            "fmi2SetupExperiment" => fmi2SetupExperiment(c, 1, 1e-6, 0.0, 1, 100.0),
            "fmi2EnterInitializationMode" => fmi2EnterInitializationMode(c),
            "fmi2ExitInitializationMode" => fmi2ExitInitializationMode(c),
            "fmi2Terminate" => fmi2Terminate(c),
            "fmi2Reset" => fmi2Reset(c),
            "fmi2GetReal parameter" => get_real("trail"),
            "fmi2GetReal input" => get_real("steer_torque"),
            "fmi2GetReal output" => get_real("roll_acceleration"),
            "fmi2GetReal local" => get_real("loaded_mass"),
            "fmi2GetReal time" => get_real("time"),
            "fmi2GetInteger" => fmi2GetInteger(c, &raw const choice, 1, &raw mut integer),
            "fmi2GetBoolean" => fmi2GetBoolean(c, null(), 0, null_mut()),
            "fmi2GetString" => fmi2GetString(c, null(), 0, null_mut()),
            "fmi2SetReal input" => slave.set("steer_torque", 0.5),
            "fmi2SetReal tunable parameter" => slave.set("rear_load", 3.0),
            "fmi2SetReal fixed parameter" => slave.set("roll_start", 0.01),
            "fmi2SetReal output" => slave.set("roll", 0.01),
            "fmi2SetReal local" => slave.set("loaded_mass", 100.0),
            "fmi2SetReal time" => slave.set("time", 1.0),
            "fmi2SetInteger fixed parameter" => {
                fmi2SetInteger(c, &raw const choice, 1, &raw const one)
            }
            "fmi2SetBoolean" => fmi2SetBoolean(c, null(), 0, null()),
            "fmi2SetString" => fmi2SetString(c, null(), 0, null()),
            "fmi2GetFMUstate" => {
                let mut state = null_mut();
                let status = fmi2GetFMUstate(c, &raw mut state);
                assert_eq!(status == fmi2OK, !state.is_null());
                fmi2FreeFMUstate(c, &raw mut state);
                status
            }
            "fmi2GetFMUstate in place" => {
                let before = slave.saved;
                let status = fmi2GetFMUstate(c, &raw mut slave.saved);
                assert_eq!(slave.saved, before);
                status
            }
            "fmi2SetFMUstate" => fmi2SetFMUstate(c, slave.saved),
            "fmi2FreeFMUstate" => {
                let status = fmi2FreeFMUstate(c, &raw mut slave.saved);
                assert_eq!(status == fmi2OK, slave.saved.is_null());
                status
            }
            "fmi2SerializedFMUstateSize" => {
                fmi2SerializedFMUstateSize(c, slave.saved, &raw mut size)
            }
            "fmi2SerializeFMUstate" => {
                let mut bytes = vec![0; 1 << 16];
                fmi2SerializeFMUstate(c, slave.saved, bytes.as_mut_ptr(), bytes.len())
            }
            "fmi2DeSerializeFMUstate" => deserialize(slave, c),
            "fmi2GetDirectionalDerivative by input" => derivative("steer_torque"),
            "fmi2GetDirectionalDerivative by parameter" => derivative("trail"),
            "fmi2GetDirectionalDerivative by state" => derivative("roll"),
            "fmi2SetRealInputDerivatives" => fmi2SetRealInputDerivatives(
                c,
                &raw const input,
                1,
                &raw const one,
                &raw const slope,
            ),
            "fmi2GetRealOutputDerivatives" => {
                fmi2GetRealOutputDerivatives(c, &raw const output, 1, &raw const one, &raw mut real)
            }
            "fmi2DoStep" => fmi2DoStep(c, slave.time, 0.005, 1),
            "fmi2CancelStep" => fmi2CancelStep(c),
            "fmi2GetStatus" => fmi2GetStatus(c, fmi2::fmi2DoStepStatus, &raw mut integer),
            "fmi2GetRealStatus" => {
                fmi2GetRealStatus(c, fmi2::fmi2LastSuccessfulTime, &raw mut real)
            }
            "fmi2GetIntegerStatus" => {
                fmi2GetIntegerStatus(c, fmi2::fmi2DoStepStatus, &raw mut integer)
            }
            "fmi2GetBooleanStatus" => {
                fmi2GetBooleanStatus(c, fmi2::fmi2Terminated, &raw mut integer)
            }
            "fmi2GetStringStatus" => fmi2GetStringStatus(c, fmi2::fmi2PendingStatus, &raw mut text),
            _ => panic!("no call is named {call}"),
        }
    }
}

/// The saved state to bytes and, as a state of its own, back.
fn deserialize(slave: &Slave, c: fmi2Component) -> fmi2Status {
    let bytes = if c.is_null() {
        vec![0]
    } else {
        slave.bytes_of(slave.saved)
    };
    let mut state = null_mut();
    let status = slave.read(&bytes, &mut state);
    if status == fmi2OK {
        slave.forget(state);
    }
    status
}
