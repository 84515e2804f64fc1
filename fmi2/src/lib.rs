//! The C types of FMI 2.0 and nothing else.
//!
//! Names are those of the standard's headers `fmi2TypesPlatform.h` and
//! `fmi2FunctionTypes.h`. Enumerations are integers with constants, for a value that comes
//! through the interface may be any integer.
#![no_std]
#![allow(
    non_camel_case_types,
    non_upper_case_globals,
    non_snake_case,
    reason = "the standard's names"
)]

mod functions;

pub use functions::*;

use core::ffi::{c_char, c_int, c_uint, c_void};

/// What `fmi2GetTypesPlatform` returns.
pub const fmi2TypesPlatform: &core::ffi::CStr = c"default";
/// What `fmi2GetVersion` returns.
pub const fmi2Version: &core::ffi::CStr = c"2.0";

/// An instance, opaque to the importer.
pub type fmi2Component = *mut c_void;
/// The importer's own, opaque to the FMU; handed back in callbacks.
pub type fmi2ComponentEnvironment = *mut c_void;
/// A saved state, opaque to the importer.
pub type fmi2FMUstate = *mut c_void;
/// Handle of a variable.
pub type fmi2ValueReference = c_uint;
/// Value of a `Real`.
pub type fmi2Real = f64;
/// Value of an `Integer` or `Enumeration`.
pub type fmi2Integer = c_int;
/// Value of a `Boolean`: [`fmi2True`] or [`fmi2False`].
pub type fmi2Boolean = c_int;
/// A character, UTF-8.
pub type fmi2Char = c_char;
/// Value of a `String`: UTF-8, null-terminated.
pub type fmi2String = *const fmi2Char;
/// A byte of a serialised state.
pub type fmi2Byte = c_char;

/// True.
pub const fmi2True: fmi2Boolean = 1;
/// False.
pub const fmi2False: fmi2Boolean = 0;

/// What a function returns.
pub type fmi2Status = c_int;
/// All well.
pub const fmi2OK: fmi2Status = 0;
/// Something is not quite right, but the computation may go on.
pub const fmi2Warning: fmi2Status = 1;
/// The step was computed in part only.
pub const fmi2Discard: fmi2Status = 2;
/// The call was refused.
pub const fmi2Error: fmi2Status = 3;
/// The instance is broken.
pub const fmi2Fatal: fmi2Status = 4;
/// The step is still being computed.
pub const fmi2Pending: fmi2Status = 5;

/// What an instance is for.
pub type fmi2Type = c_int;
/// Model exchange.
pub const fmi2ModelExchange: fmi2Type = 0;
/// Co-simulation.
pub const fmi2CoSimulation: fmi2Type = 1;

/// What a status function asks for.
pub type fmi2StatusKind = c_int;
/// The status of a pending step (`fmi2GetStatus`).
pub const fmi2DoStepStatus: fmi2StatusKind = 0;
/// A text on a pending step (`fmi2GetStringStatus`).
pub const fmi2PendingStatus: fmi2StatusKind = 1;
/// The end of the last successful step \[s\] (`fmi2GetRealStatus`).
pub const fmi2LastSuccessfulTime: fmi2StatusKind = 2;
/// Whether the FMU wants the simulation to end (`fmi2GetBooleanStatus`).
pub const fmi2Terminated: fmi2StatusKind = 3;

/// `(componentEnvironment, instanceName, status, category, message, …)`, `message` a
/// printf format.
pub type fmi2CallbackLogger = unsafe extern "C" fn(
    fmi2ComponentEnvironment,
    fmi2String,
    fmi2Status,
    fmi2String,
    fmi2String,
    ...
);
/// `(nobj, size)`: zeroed memory for `nobj` objects of `size` bytes.
pub type fmi2CallbackAllocateMemory = unsafe extern "C" fn(usize, usize) -> *mut c_void;
/// Frees what [`fmi2CallbackAllocateMemory`] gave.
pub type fmi2CallbackFreeMemory = unsafe extern "C" fn(*mut c_void);
/// A pending step is done.
pub type fmi2StepFinished = unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2Status);

/// What the importer gives to `fmi2Instantiate`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct fmi2CallbackFunctions {
    /// Takes log lines.
    pub logger: Option<fmi2CallbackLogger>,
    /// Gives memory.
    pub allocateMemory: Option<fmi2CallbackAllocateMemory>,
    /// Takes memory back.
    pub freeMemory: Option<fmi2CallbackFreeMemory>,
    /// Hears that a pending step is done; may be absent.
    pub stepFinished: Option<fmi2StepFinished>,
    /// Handed back in callbacks.
    pub componentEnvironment: fmi2ComponentEnvironment,
}
