//! The macro that makes the functions a shared library must export.

/// Exports every function of an FMI 2.0 co-simulation FMU for one [`Model`](crate::Model).
///
/// Once per library, in a crate of type `cdylib`:
/// `fmi_export::export!(Bicycle);`
#[macro_export]
macro_rules! export {
    ($model:ty) => {
        #[allow(non_snake_case, reason = "the standard's names")]
        const _: () = {
            use $crate::ffi;
            use $crate::fmi2::*;

            static SHARED: ffi::Shared<$model> = ffi::Shared::new();

            /// `fmi2GetTypesPlatform`.
            #[unsafe(no_mangle)]
            extern "C" fn fmi2GetTypesPlatform() -> fmi2String {
                ffi::types_platform()
            }

            /// `fmi2GetVersion`.
            #[unsafe(no_mangle)]
            extern "C" fn fmi2GetVersion() -> fmi2String {
                ffi::version()
            }

            /// `fmi2Instantiate`.
            #[unsafe(no_mangle)]
            unsafe extern "C" fn fmi2Instantiate(
                instance_name: fmi2String,
                fmu_type: fmi2Type,
                guid: fmi2String,
                resource_location: fmi2String,
                callbacks: *const fmi2CallbackFunctions,
                visible: fmi2Boolean,
                logging_on: fmi2Boolean,
            ) -> fmi2Component {
                ffi::silence_panics();
                // SAFETY: the importer keeps to the contract of `ffi`.
                unsafe {
                    ffi::instantiate(
                        &SHARED, instance_name, fmu_type, guid, resource_location, callbacks, visible,
                        logging_on,
                    )
                }
            }

            /// `fmi2FreeInstance`.
            #[unsafe(no_mangle)]
            unsafe extern "C" fn fmi2FreeInstance(c: fmi2Component) {
                // SAFETY: the importer keeps to the contract of `ffi`.
                unsafe { ffi::free_instance(&SHARED, c) }
            }

            $crate::export! { @functions
                fmi2SetDebugLogging(on: fmi2Boolean, n: usize, categories: *const fmi2String)
                    = ffi::set_debug_logging::<$model>;
                fmi2SetupExperiment(tolerance_defined: fmi2Boolean, tolerance: fmi2Real, start: fmi2Real, stop_defined: fmi2Boolean, stop: fmi2Real)
                    = ffi::setup_experiment::<$model>;
                fmi2EnterInitializationMode() = ffi::enter_initialization_mode::<$model>;
                fmi2ExitInitializationMode() = ffi::exit_initialization_mode::<$model>;
                fmi2Terminate() = ffi::terminate::<$model>;
                fmi2Reset() = ffi::reset::<$model>;
                fmi2GetReal(vr: *const fmi2ValueReference, n: usize, value: *mut fmi2Real)
                    = ffi::get::<$model, fmi2Real>;
                fmi2GetInteger(vr: *const fmi2ValueReference, n: usize, value: *mut fmi2Integer)
                    = ffi::get::<$model, fmi2Integer>;
                fmi2GetBoolean(vr: *const fmi2ValueReference, n: usize, value: *mut fmi2Boolean)
                    = ffi::get_boolean::<$model>;
                fmi2GetString(vr: *const fmi2ValueReference, n: usize, value: *mut fmi2String)
                    = ffi::get_string::<$model>;
                fmi2SetReal(vr: *const fmi2ValueReference, n: usize, value: *const fmi2Real)
                    = ffi::set::<$model, fmi2Real>;
                fmi2SetInteger(vr: *const fmi2ValueReference, n: usize, value: *const fmi2Integer)
                    = ffi::set::<$model, fmi2Integer>;
                fmi2SetBoolean(vr: *const fmi2ValueReference, n: usize, value: *const fmi2Boolean)
                    = ffi::set_boolean::<$model>;
                fmi2SetString(vr: *const fmi2ValueReference, n: usize, value: *const fmi2String)
                    = ffi::set_string::<$model>;
                fmi2GetFMUstate(state: *mut fmi2FMUstate) = ffi::get_fmu_state::<$model>;
                fmi2SetFMUstate(state: fmi2FMUstate) = ffi::set_fmu_state::<$model>;
                fmi2FreeFMUstate(state: *mut fmi2FMUstate) = ffi::free_fmu_state::<$model>;
                fmi2SerializedFMUstateSize(state: fmi2FMUstate, size: *mut usize)
                    = ffi::serialized_fmu_state_size::<$model>;
                fmi2SerializeFMUstate(state: fmi2FMUstate, bytes: *mut fmi2Byte, size: usize)
                    = ffi::serialize_fmu_state::<$model>;
                fmi2DeSerializeFMUstate(bytes: *const fmi2Byte, size: usize, state: *mut fmi2FMUstate)
                    = ffi::deserialize_fmu_state::<$model>;
                fmi2GetDirectionalDerivative(unknown: *const fmi2ValueReference, unknowns: usize, known: *const fmi2ValueReference, knowns: usize, seed: *const fmi2Real, value: *mut fmi2Real)
                    = ffi::get_directional_derivative::<$model>;
                fmi2SetRealInputDerivatives(vr: *const fmi2ValueReference, n: usize, order: *const fmi2Integer, value: *const fmi2Real)
                    = ffi::set_real_input_derivatives::<$model>;
                fmi2GetRealOutputDerivatives(vr: *const fmi2ValueReference, n: usize, order: *const fmi2Integer, value: *mut fmi2Real)
                    = ffi::get_real_output_derivatives::<$model>;
                fmi2DoStep(point: fmi2Real, h: fmi2Real, no_set_state_prior: fmi2Boolean)
                    = ffi::do_step::<$model>;
                fmi2CancelStep() = ffi::cancel_step::<$model>;
                fmi2GetStatus(kind: fmi2StatusKind, value: *mut fmi2Status)
                    = ffi::get_status::<$model>;
                fmi2GetRealStatus(kind: fmi2StatusKind, value: *mut fmi2Real)
                    = ffi::get_real_status::<$model>;
                fmi2GetIntegerStatus(kind: fmi2StatusKind, value: *mut fmi2Integer)
                    = ffi::get_integer_status::<$model>;
                fmi2GetBooleanStatus(kind: fmi2StatusKind, value: *mut fmi2Boolean)
                    = ffi::get_boolean_status::<$model>;
                fmi2GetStringStatus(kind: fmi2StatusKind, value: *mut fmi2String)
                    = ffi::get_string_status::<$model>;
            }
        };
    };
    (@functions $($name:ident($($argument:ident: $type:ty),*) = $body:expr;)*) => {
        $(
            #[doc = concat!("`", stringify!($name), "`.")]
            #[unsafe(no_mangle)]
            unsafe extern "C" fn $name(c: fmi2Component $(, $argument: $type)*) -> fmi2Status {
                // SAFETY: the importer keeps to the contract of `ffi`.
                unsafe { ($body)(c $(, $argument)*) }
            }
        )*
    };
}
