//! The C functions of the bicycle, as a linker sees them.
#![allow(non_snake_case, reason = "the standard's names")]

use fmi2::{
    fmi2Boolean, fmi2Byte, fmi2CallbackFunctions, fmi2Component, fmi2FMUstate, fmi2Integer,
    fmi2Real, fmi2Status, fmi2StatusKind, fmi2String, fmi2Type, fmi2ValueReference,
};
// The symbols are in this library.
use fmu as _;

macro_rules! functions {
    ($($name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?;)*) => {
        // SAFETY: the types are those of the standard's header fmi2FunctionTypes.h.
        unsafe extern "C" {
            $(
                #[doc = concat!("`", stringify!($name), "`.")]
                pub fn $name($($argument: $type),*) $(-> $result)?;
            )*
        }
    };
}

functions! {
    fmi2GetTypesPlatform() -> fmi2String;
    fmi2GetVersion() -> fmi2String;
    fmi2SetDebugLogging(c: fmi2Component, on: fmi2Boolean, n: usize, categories: *const fmi2String) -> fmi2Status;
    fmi2Instantiate(name: fmi2String, kind: fmi2Type, guid: fmi2String, resources: fmi2String, callbacks: *const fmi2CallbackFunctions, visible: fmi2Boolean, logging: fmi2Boolean) -> fmi2Component;
    fmi2FreeInstance(c: fmi2Component);
    fmi2SetupExperiment(c: fmi2Component, tolerance_defined: fmi2Boolean, tolerance: fmi2Real, start: fmi2Real, stop_defined: fmi2Boolean, stop: fmi2Real) -> fmi2Status;
    fmi2EnterInitializationMode(c: fmi2Component) -> fmi2Status;
    fmi2ExitInitializationMode(c: fmi2Component) -> fmi2Status;
    fmi2Terminate(c: fmi2Component) -> fmi2Status;
    fmi2Reset(c: fmi2Component) -> fmi2Status;
    fmi2GetReal(c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *mut fmi2Real) -> fmi2Status;
    fmi2GetInteger(c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *mut fmi2Integer) -> fmi2Status;
    fmi2GetBoolean(c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *mut fmi2Boolean) -> fmi2Status;
    fmi2GetString(c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *mut fmi2String) -> fmi2Status;
    fmi2SetReal(c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *const fmi2Real) -> fmi2Status;
    fmi2SetInteger(c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *const fmi2Integer) -> fmi2Status;
    fmi2SetBoolean(c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *const fmi2Boolean) -> fmi2Status;
    fmi2SetString(c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *const fmi2String) -> fmi2Status;
    fmi2GetFMUstate(c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status;
    fmi2SetFMUstate(c: fmi2Component, state: fmi2FMUstate) -> fmi2Status;
    fmi2FreeFMUstate(c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status;
    fmi2SerializedFMUstateSize(c: fmi2Component, state: fmi2FMUstate, size: *mut usize) -> fmi2Status;
    fmi2SerializeFMUstate(c: fmi2Component, state: fmi2FMUstate, bytes: *mut fmi2Byte, size: usize) -> fmi2Status;
    fmi2DeSerializeFMUstate(c: fmi2Component, bytes: *const fmi2Byte, size: usize, state: *mut fmi2FMUstate) -> fmi2Status;
    fmi2GetDirectionalDerivative(c: fmi2Component, unknown: *const fmi2ValueReference, unknowns: usize, known: *const fmi2ValueReference, knowns: usize, seed: *const fmi2Real, value: *mut fmi2Real) -> fmi2Status;
    fmi2SetRealInputDerivatives(c: fmi2Component, vr: *const fmi2ValueReference, n: usize, order: *const fmi2Integer, value: *const fmi2Real) -> fmi2Status;
    fmi2GetRealOutputDerivatives(c: fmi2Component, vr: *const fmi2ValueReference, n: usize, order: *const fmi2Integer, value: *mut fmi2Real) -> fmi2Status;
    fmi2DoStep(c: fmi2Component, point: fmi2Real, h: fmi2Real, no_set_state_prior: fmi2Boolean) -> fmi2Status;
    fmi2CancelStep(c: fmi2Component) -> fmi2Status;
    fmi2GetStatus(c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2Status) -> fmi2Status;
    fmi2GetRealStatus(c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2Real) -> fmi2Status;
    fmi2GetIntegerStatus(c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2Integer) -> fmi2Status;
    fmi2GetBooleanStatus(c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2Boolean) -> fmi2Status;
    fmi2GetStringStatus(c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2String) -> fmi2Status;
}
