//! The C interface: pointers to slices, errors to a status and one log line, panics to
//! `fmi2Fatal`. All unsafe code of this crate stands here and in the modules below.
//!
//! # Safety
//! What every function relies on is what FMI 2.0 asks of the importer: `c` is NULL or comes from
//! [`instantiate`] of the same model and has not been freed; it is used by one thread at a time,
//! and not from within its own logger; a non-null array holds as many elements as its length
//! says; texts are null-terminated.

mod derivatives;
mod states;
mod status;
mod values;

pub use crate::class::Shared;
pub use derivatives::*;
pub use states::*;
pub use status::*;
pub use values::*;

use crate::log::{Wanted, category};
use crate::{Error, Experiment, Function, Instance, Model, resources, start};
use fmi2::{
    fmi2Boolean, fmi2CallbackFunctions, fmi2CallbackLogger, fmi2CoSimulation, fmi2Component,
    fmi2ComponentEnvironment, fmi2Error, fmi2False, fmi2Fatal, fmi2OK, fmi2Real, fmi2Status,
    fmi2String, fmi2Type, fmi2TypesPlatform, fmi2Version,
};
use std::any::Any;
use std::ffi::{CStr, CString, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::ptr::null_mut;

/// What `fmi2Component` points to.
struct Component<M: Model> {
    instance: Instance<M>,
    logger: Logger,
    /// Texts handed out by the last `fmi2GetString`, alive until the next.
    texts: Vec<CString>,
    /// A panic was caught: nothing works any more.
    fatal: bool,
}

/// The importer's logger.
struct Logger {
    callback: Option<fmi2CallbackLogger>,
    environment: fmi2ComponentEnvironment,
    instance_name: CString,
    wanted: Wanted,
}

impl Logger {
    /// One line, if its category is wanted.
    fn line(&self, status: fmi2Status, message: &str) {
        let category = category(status);
        if let Some(callback) = self.callback
            && self.wanted.contains(category)
        {
            // The message is a printf format without arguments.
            let message = text(&message.replace('%', "%%"));
            // SAFETY: the importer vouches for its callback; all texts outlive the call, and the
            // format asks for no further argument.
            unsafe {
                callback(
                    self.environment,
                    self.instance_name.as_ptr(),
                    status,
                    category.as_ptr(),
                    message.as_ptr(),
                );
            }
        }
    }
}

/// A C text; inner null characters are dropped.
fn text(message: &str) -> CString {
    let bytes: Vec<u8> = message.bytes().filter(|&byte| byte != 0).collect();
    CString::new(bytes).unwrap_or_default()
}

/// What a caught panic said.
fn panic_message(payload: &(dyn Any + Send)) -> String {
    let said = payload
        .downcast_ref::<&str>()
        .copied()
        .or(payload.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no message");
    format!("internal failure, the instance is unusable: {said}")
}

/// Runs `body` on the component; the only place where errors and panics become a status.
///
/// # Safety
/// See the module.
unsafe fn call<M: Model>(
    c: fmi2Component,
    body: impl FnOnce(&mut Component<M>) -> Result<(), Error>,
) -> fmi2Status {
    // SAFETY: by the module's contract c is NULL or the box of `instantiate`, used by no one else.
    let Some(component) = (unsafe { c.cast::<Component<M>>().as_mut() }) else {
        return fmi2Error;
    };
    if component.fatal {
        return fmi2Fatal;
    }
    let outcome = catch_unwind(AssertUnwindSafe(|| match body(component) {
        Ok(()) => fmi2OK,
        Err(error) => component.refuse(&error),
    }));
    outcome.unwrap_or_else(|payload| component.fail(payload.as_ref()))
}

impl<M: Model> Component<M> {
    #[cold]
    fn refuse(&self, error: &Error) -> fmi2Status {
        let status = error.status();
        self.logger.line(status, &error.to_string());
        status
    }

    #[cold]
    fn fail(&mut self, payload: &(dyn Any + Send)) -> fmi2Status {
        self.fatal = true;
        self.logger.line(fmi2Fatal, &panic_message(payload));
        fmi2Fatal
    }
}

/// # Safety
/// See the module.
unsafe fn slice<'a, T>(
    pointer: *const T,
    length: usize,
    argument: &'static str,
) -> Result<&'a [T], Error> {
    if length == 0 {
        Ok(&[])
    } else if pointer.is_null() {
        Err(Error::Null { argument })
    } else {
        // SAFETY: not null, and the importer vouches for `length` elements; numbers and pointers
        // may have any bits.
        Ok(unsafe { std::slice::from_raw_parts(pointer, length) })
    }
}

/// # Safety
/// See the module.
unsafe fn slice_mut<'a, T>(
    pointer: *mut T,
    length: usize,
    argument: &'static str,
) -> Result<&'a mut [T], Error> {
    if length == 0 {
        Ok(&mut [])
    } else if pointer.is_null() {
        Err(Error::Null { argument })
    } else {
        // SAFETY: as in `slice`; the importer lends the array for writing.
        Ok(unsafe { std::slice::from_raw_parts_mut(pointer, length) })
    }
}

/// # Safety
/// See the module.
unsafe fn str<'a>(pointer: fmi2String, argument: &'static str) -> Result<&'a str, Error> {
    if pointer.is_null() {
        return Err(Error::Null { argument });
    }
    // SAFETY: not null, and texts are null-terminated.
    unsafe { CStr::from_ptr(pointer) }
        .to_str()
        .map_err(|_| Error::NotUtf8 { argument })
}

/// # Safety
/// See the module.
unsafe fn strings(
    pointer: *const fmi2String,
    length: usize,
    argument: &'static str,
) -> Result<Vec<String>, Error> {
    // SAFETY: the module's contract.
    unsafe { slice(pointer, length, argument) }?
        .iter()
        // SAFETY: the module's contract.
        .map(|&pointer| unsafe { str(pointer, argument) }.map(str::to_owned))
        .collect()
}

/// Keeps panics off stderr: the message goes to the logger instead. The hook belongs to this
/// copy of the standard library, which in an FMU is the FMU's own.
pub fn silence_panics() {
    set_hook(Box::new(|_| {}));
}

/// `fmi2GetTypesPlatform`.
pub fn types_platform() -> fmi2String {
    fmi2TypesPlatform.as_ptr()
}

/// `fmi2GetVersion`.
pub fn version() -> fmi2String {
    fmi2Version.as_ptr()
}

/// `fmi2Instantiate`. A failure is logged whether logging is on or not: there is no instance for
/// which it could be turned on.
///
/// # Safety
/// See the module; `callbacks` is NULL or points to the callbacks.
#[expect(
    clippy::too_many_arguments,
    reason = "the standard's seven and the class"
)]
pub unsafe fn instantiate<M: Model>(
    shared: &Shared<M>,
    instance_name: fmi2String,
    fmu_type: fmi2Type,
    guid: fmi2String,
    resource_location: fmi2String,
    callbacks: *const fmi2CallbackFunctions,
    _visible: fmi2Boolean,
    logging_on: fmi2Boolean,
) -> fmi2Component {
    // SAFETY: NULL or valid by contract.
    let Some(callbacks) = (unsafe { callbacks.as_ref() }) else {
        return null_mut();
    };
    let mut logger = Logger {
        callback: callbacks.logger,
        environment: callbacks.componentEnvironment,
        instance_name: CString::default(),
        wanted: Wanted::All,
    };
    let made = catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: texts are null-terminated.
        let instance_name = unsafe { str(instance_name, "instanceName") }?;
        if instance_name.is_empty() {
            return Err(Error::NoName);
        }
        if fmu_type != fmi2CoSimulation {
            return Err(Error::NotCoSimulation { found: fmu_type });
        }
        // SAFETY: as above.
        let found = unsafe { str(guid, "fmuGUID") }?;
        let class = shared.class()?;
        if found != class.guid {
            return Err(Error::Guid {
                expected: class.guid.clone(),
                found: found.to_owned(),
            });
        }
        let resources = if resource_location.is_null() {
            None
        } else {
            // SAFETY: as above.
            resources::folder(unsafe { str(resource_location, "fmuResourceLocation") }?)?
        };
        let pristine = start::model(&class, resources.as_deref())?;
        Ok((text(instance_name), Instance::of(class, pristine)))
    }));
    match made {
        Ok(Ok((instance_name, instance))) => {
            logger.instance_name = instance_name;
            if logging_on == fmi2False {
                logger.wanted = Wanted::None;
            }
            let component = Component {
                instance,
                logger,
                texts: Vec::new(),
                fatal: false,
            };
            Box::into_raw(Box::new(component)).cast::<c_void>()
        }
        Ok(Err(error)) => {
            logger.line(fmi2Error, &error.to_string());
            shared.release();
            null_mut()
        }
        Err(payload) => {
            logger.line(fmi2Fatal, &panic_message(payload.as_ref()));
            shared.release();
            null_mut()
        }
    }
}

/// `fmi2FreeInstance`; legal in every state.
///
/// # Safety
/// See the module; `c` is not used again.
pub unsafe fn free_instance<M: Model>(shared: &Shared<M>, c: fmi2Component) {
    if !c.is_null() {
        // SAFETY: c is the box of `instantiate`, freed once.
        let component = unsafe { Box::from_raw(c.cast::<Component<M>>()) };
        // A model that panics on being dropped must not take the importer with it.
        let _ = catch_unwind(AssertUnwindSafe(move || drop(component)));
        shared.release();
    }
}

/// `fmi2SetDebugLogging`.
///
/// # Safety
/// See the module.
pub unsafe fn set_debug_logging<M: Model>(
    c: fmi2Component,
    on: fmi2Boolean,
    count: usize,
    categories: *const fmi2String,
) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe {
        call::<M>(c, |component| {
            component.instance.permit(Function::SetDebugLogging)?;
            let listed = strings(categories, count, "categories")?;
            let known = &component.instance.class().categories;
            component.logger.wanted = Wanted::new(on != fmi2False, listed, known)?;
            Ok(())
        })
    }
}

/// `fmi2SetupExperiment`.
///
/// # Safety
/// See the module.
pub unsafe fn setup_experiment<M: Model>(
    c: fmi2Component,
    tolerance_defined: fmi2Boolean,
    tolerance: fmi2Real,
    start_time: fmi2Real,
    stop_time_defined: fmi2Boolean,
    stop_time: fmi2Real,
) -> fmi2Status {
    let experiment = Experiment {
        start_time,
        stop_time: (stop_time_defined != fmi2False).then_some(stop_time),
        tolerance: (tolerance_defined != fmi2False).then_some(tolerance),
    };
    // SAFETY: the module's contract.
    unsafe {
        call::<M>(c, |component| {
            component.instance.setup_experiment(experiment)
        })
    }
}

/// Functions of `c` alone.
macro_rules! plain {
    ($($name:ident as $function:literal;)*) => {
        $(
            #[doc = concat!("`", $function, "`.")]
            ///
            /// # Safety
            /// See the module.
            pub unsafe fn $name<M: Model>(c: fmi2Component) -> fmi2Status {
                // SAFETY: the module's contract.
                unsafe { call::<M>(c, |component| component.instance.$name()) }
            }
        )*
    };
}

plain! {
    enter_initialization_mode as "fmi2EnterInitializationMode";
    exit_initialization_mode as "fmi2ExitInitializationMode";
    terminate as "fmi2Terminate";
    reset as "fmi2Reset";
}

/// `fmi2DoStep`.
///
/// # Safety
/// See the module.
pub unsafe fn do_step<M: Model>(
    c: fmi2Component,
    point: fmi2Real,
    h: fmi2Real,
    _no_set_fmu_state_prior_to_current_point: fmi2Boolean,
) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe { call::<M>(c, |component| component.instance.do_step(point, h)) }
}
