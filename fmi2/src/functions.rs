//! Pointer types of the functions a co-simulation FMU exports (FMI 2.0 §2.1, §4.2).

use crate::{
    fmi2Boolean, fmi2Byte, fmi2CallbackFunctions, fmi2Component, fmi2FMUstate, fmi2Integer,
    fmi2Real, fmi2Status, fmi2StatusKind, fmi2String, fmi2Type, fmi2ValueReference,
};

macro_rules! functions {
    ($($name:ident($($argument:ty),*) $(-> $result:ty)?;)*) => {
        $(
            #[doc = concat!("`", stringify!($name), "`, without its suffix `TYPE`.")]
            pub type $name = unsafe extern "C" fn($($argument),*) $(-> $result)?;
        )*
    };
}

functions! {
    fmi2GetTypesPlatformTYPE() -> fmi2String;
    fmi2GetVersionTYPE() -> fmi2String;
    fmi2SetDebugLoggingTYPE(fmi2Component, fmi2Boolean, usize, *const fmi2String) -> fmi2Status;
    fmi2InstantiateTYPE(fmi2String, fmi2Type, fmi2String, fmi2String, *const fmi2CallbackFunctions, fmi2Boolean, fmi2Boolean) -> fmi2Component;
    fmi2FreeInstanceTYPE(fmi2Component);
    fmi2SetupExperimentTYPE(fmi2Component, fmi2Boolean, fmi2Real, fmi2Real, fmi2Boolean, fmi2Real) -> fmi2Status;
    fmi2EnterInitializationModeTYPE(fmi2Component) -> fmi2Status;
    fmi2ExitInitializationModeTYPE(fmi2Component) -> fmi2Status;
    fmi2TerminateTYPE(fmi2Component) -> fmi2Status;
    fmi2ResetTYPE(fmi2Component) -> fmi2Status;
    fmi2GetRealTYPE(fmi2Component, *const fmi2ValueReference, usize, *mut fmi2Real) -> fmi2Status;
    fmi2GetIntegerTYPE(fmi2Component, *const fmi2ValueReference, usize, *mut fmi2Integer) -> fmi2Status;
    fmi2GetBooleanTYPE(fmi2Component, *const fmi2ValueReference, usize, *mut fmi2Boolean) -> fmi2Status;
    fmi2GetStringTYPE(fmi2Component, *const fmi2ValueReference, usize, *mut fmi2String) -> fmi2Status;
    fmi2SetRealTYPE(fmi2Component, *const fmi2ValueReference, usize, *const fmi2Real) -> fmi2Status;
    fmi2SetIntegerTYPE(fmi2Component, *const fmi2ValueReference, usize, *const fmi2Integer) -> fmi2Status;
    fmi2SetBooleanTYPE(fmi2Component, *const fmi2ValueReference, usize, *const fmi2Boolean) -> fmi2Status;
    fmi2SetStringTYPE(fmi2Component, *const fmi2ValueReference, usize, *const fmi2String) -> fmi2Status;
    fmi2GetFMUstateTYPE(fmi2Component, *mut fmi2FMUstate) -> fmi2Status;
    fmi2SetFMUstateTYPE(fmi2Component, fmi2FMUstate) -> fmi2Status;
    fmi2FreeFMUstateTYPE(fmi2Component, *mut fmi2FMUstate) -> fmi2Status;
    fmi2SerializedFMUstateSizeTYPE(fmi2Component, fmi2FMUstate, *mut usize) -> fmi2Status;
    fmi2SerializeFMUstateTYPE(fmi2Component, fmi2FMUstate, *mut fmi2Byte, usize) -> fmi2Status;
    fmi2DeSerializeFMUstateTYPE(fmi2Component, *const fmi2Byte, usize, *mut fmi2FMUstate) -> fmi2Status;
    fmi2GetDirectionalDerivativeTYPE(fmi2Component, *const fmi2ValueReference, usize, *const fmi2ValueReference, usize, *const fmi2Real, *mut fmi2Real) -> fmi2Status;
    fmi2SetRealInputDerivativesTYPE(fmi2Component, *const fmi2ValueReference, usize, *const fmi2Integer, *const fmi2Real) -> fmi2Status;
    fmi2GetRealOutputDerivativesTYPE(fmi2Component, *const fmi2ValueReference, usize, *const fmi2Integer, *mut fmi2Real) -> fmi2Status;
    fmi2DoStepTYPE(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean) -> fmi2Status;
    fmi2CancelStepTYPE(fmi2Component) -> fmi2Status;
    fmi2GetStatusTYPE(fmi2Component, fmi2StatusKind, *mut fmi2Status) -> fmi2Status;
    fmi2GetRealStatusTYPE(fmi2Component, fmi2StatusKind, *mut fmi2Real) -> fmi2Status;
    fmi2GetIntegerStatusTYPE(fmi2Component, fmi2StatusKind, *mut fmi2Integer) -> fmi2Status;
    fmi2GetBooleanStatusTYPE(fmi2Component, fmi2StatusKind, *mut fmi2Boolean) -> fmi2Status;
    fmi2GetStringStatusTYPE(fmi2Component, fmi2StatusKind, *mut fmi2String) -> fmi2Status;
}
