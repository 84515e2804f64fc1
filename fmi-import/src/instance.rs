//! One instance of an FMU, with safe calls.

use crate::library::Fmu;
use crate::{Error, LogLine, Status};
use fmi2::{
    fmi2Boolean, fmi2CallbackFunctions, fmi2CallbackLogger, fmi2CoSimulation, fmi2Component,
    fmi2ComponentEnvironment, fmi2False, fmi2LastSuccessfulTime, fmi2Status, fmi2String,
    fmi2Terminated, fmi2True,
};
use std::ffi::{CStr, CString, c_void};
use std::ptr::null;
use std::sync::{Mutex, PoisonError};

/// A value of any of the five types; an enumeration travels as its integer.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `Real`
    Real(f64),
    /// `Integer` or `Enumeration`
    Integer(i32),
    /// `Boolean`
    Boolean(bool),
    /// `String`
    String(String),
}

/// How a step went.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// It arrived.
    Complete,
    /// It ended early.
    Discarded {
        /// The end of the last successful step [s], where the FMU can tell.
        last_successful_time: Option<f64>,
        /// The FMU wants the simulation to end.
        terminated: bool,
        /// What the FMU said.
        log: Vec<LogLine>,
    },
}

type Log = Mutex<Vec<LogLine>>;

/// What the FMU holds pointers to until it is freed (FMI 2.0 §2.1.5): raw ones here too, for a
/// `Box` that moves would end them.
#[derive(Debug)]
struct Host {
    callbacks: *mut fmi2CallbackFunctions,
    log: *mut Log,
}

impl Host {
    fn new() -> Self {
        let log = Box::into_raw(Box::<Log>::default());
        Self {
            callbacks: Box::into_raw(Box::new(callbacks(log))),
            log,
        }
    }

    fn log(&self) -> &Log {
        // SAFETY: from Box::into_raw, alive until drop, shared only behind its lock.
        unsafe { &*self.log }
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: both from Box::into_raw and freed once; the FMU's instance is freed by then.
        unsafe {
            drop(Box::from_raw(self.callbacks));
            drop(Box::from_raw(self.log));
        }
    }
}

/// An instance; freed when dropped, before the library is unloaded.
///
/// Calls that do not succeed return the FMU's log lines; [`Instance::log`] has those of the last
/// call in any case.
#[derive(Debug)]
pub struct Instance<'a> {
    fmu: &'a Fmu,
    component: fmi2Component,
    host: Host,
    /// After `fmi2Fatal` no function may be called, `fmi2FreeInstance` included.
    fatal: bool,
}

impl Fmu {
    /// A new instance called `name`, with logging on.
    pub fn instantiate(&self, name: &str) -> Result<Instance<'_>, Error> {
        let description = self.description();
        let text = |what, found: &str| {
            CString::new(found).map_err(|_| Error::Text {
                what,
                found: found.to_owned(),
            })
        };
        let name = text("instance name", name)?;
        let guid = text("guid", &description.guid)?;
        let resources = text("resource location", &self.archive().resource_location())?;
        let host = Host::new();
        // SAFETY: texts are null-terminated, callbacks valid until after fmi2FreeInstance: the host
        // lives in the instance, whose drop frees first.
        let component = unsafe {
            (self.functions.instantiate)(
                name.as_ptr(),
                fmi2CoSimulation,
                guid.as_ptr(),
                resources.as_ptr(),
                host.callbacks,
                fmi2False,
                fmi2True,
            )
        };
        if component.is_null() {
            return Err(Error::NotInstantiated {
                log: take(host.log()),
            });
        }
        Ok(Instance {
            fmu: self,
            component,
            host,
            fatal: false,
        })
    }
}

/// Calls without arguments.
macro_rules! plain {
    ($($(#[$doc:meta])* $name:ident = $function:literal;)*) => {
        $(
            $(#[$doc])*
            pub fn $name(&mut self) -> Result<(), Error> {
                self.call($function, |i| {
                    // SAFETY: the component is alive.
                    unsafe { (i.fmu.functions.$name)(i.component) }
                })
            }
        )*
    };
}

/// Calls that hand over the importer's array as it is.
macro_rules! numbers {
    ($($(#[$doc:meta])* $name:ident($values:ident: $type:ty) = $function:literal, $pointer:ident;)*) => {
        $(
            $(#[$doc])*
            pub fn $name(&mut self, references: &[u32], $values: $type) -> Result<(), Error> {
                same_length(references, $values)?;
                self.call($function, |i| {
                    // SAFETY: the component is alive, both arrays have the length given.
                    unsafe {
                        (i.fmu.functions.$name)(
                            i.component,
                            references.as_ptr(),
                            references.len(),
                            $values.$pointer(),
                        )
                    }
                })
            }
        )*
    };
}

impl Instance<'_> {
    /// The FMU it is an instance of.
    pub fn fmu(&self) -> &Fmu {
        self.fmu
    }

    /// Log lines since before the last call, taken out.
    pub fn log(&mut self) -> Vec<LogLine> {
        take(self.host.log())
    }

    fn call(
        &mut self,
        function: &'static str,
        call: impl FnOnce(&Self) -> fmi2Status,
    ) -> Result<(), Error> {
        if self.fatal {
            let (status, log) = (Status::Fatal, Vec::new());
            return Err(Error::Refused {
                function,
                status,
                log,
            });
        }
        take(self.host.log());
        let status = Status::from(call(self));
        self.fatal = status == Status::Fatal;
        match status {
            Status::Ok | Status::Warning => Ok(()),
            _ => Err(Error::Refused {
                function,
                status,
                log: take(self.host.log()),
            }),
        }
    }

    /// Start time, stop time [s] and relative tolerance.
    pub fn setup_experiment(
        &mut self,
        tolerance: Option<f64>,
        start_time: f64,
        stop_time: Option<f64>,
    ) -> Result<(), Error> {
        self.call("fmi2SetupExperiment", |i| {
            // SAFETY: the component is alive.
            unsafe {
                (i.fmu.functions.setup_experiment)(
                    i.component,
                    fmi2Boolean::from(tolerance.is_some()),
                    tolerance.unwrap_or(0.0),
                    start_time,
                    fmi2Boolean::from(stop_time.is_some()),
                    stop_time.unwrap_or(0.0),
                )
            }
        })
    }

    plain! {
        /// Enters initialization mode.
        enter_initialization_mode = "fmi2EnterInitializationMode";
        /// Leaves initialization mode.
        exit_initialization_mode = "fmi2ExitInitializationMode";
        /// Ends the simulation.
        terminate = "fmi2Terminate";
        /// Back to the state after instantiation.
        reset = "fmi2Reset";
    }

    /// Goes on from `point` by `h`, both in s.
    pub fn do_step(&mut self, point: f64, h: f64) -> Result<Step, Error> {
        let stepped = self.call("fmi2DoStep", |i| {
            // SAFETY: the component is alive. No state before `point` is ever set.
            unsafe { (i.fmu.functions.do_step)(i.component, point, h, fmi2True) }
        });
        match stepped {
            Err(Error::Refused {
                status: Status::Discard,
                log,
                ..
            }) => Ok(Step::Discarded {
                last_successful_time: self.last_successful_time().ok(),
                terminated: self.terminated().unwrap_or(false),
                log,
            }),
            other => other.map(|()| Step::Complete),
        }
    }

    fn last_successful_time(&mut self) -> Result<f64, Error> {
        let mut time = f64::NAN;
        self.call("fmi2GetRealStatus", |i| {
            // SAFETY: the component is alive, `time` a place for the answer.
            unsafe {
                (i.fmu.functions.get_real_status)(
                    i.component,
                    fmi2LastSuccessfulTime,
                    &raw mut time,
                )
            }
        })?;
        Ok(time)
    }

    fn terminated(&mut self) -> Result<bool, Error> {
        let mut terminated = fmi2False;
        self.call("fmi2GetBooleanStatus", |i| {
            // SAFETY: the component is alive, `terminated` a place for the answer.
            unsafe {
                (i.fmu.functions.get_boolean_status)(
                    i.component,
                    fmi2Terminated,
                    &raw mut terminated,
                )
            }
        })?;
        Ok(terminated != fmi2False)
    }

    numbers! {
        /// Reads `Real` variables into `values`, one for each value reference.
        get_real(values: &mut [f64]) = "fmi2GetReal", as_mut_ptr;
        /// Reads `Integer` and `Enumeration` variables into `values`.
        get_integer(values: &mut [i32]) = "fmi2GetInteger", as_mut_ptr;
        /// Sets `Real` variables.
        set_real(values: &[f64]) = "fmi2SetReal", as_ptr;
        /// Sets `Integer` and `Enumeration` variables.
        set_integer(values: &[i32]) = "fmi2SetInteger", as_ptr;
    }

    /// Reads `Boolean` variables into `values`.
    pub fn get_boolean(&mut self, references: &[u32], values: &mut [bool]) -> Result<(), Error> {
        same_length(references, values)?;
        let mut found = vec![fmi2False; values.len()];
        self.call("fmi2GetBoolean", |i| {
            // SAFETY: the component is alive, both arrays have the length given.
            unsafe {
                (i.fmu.functions.get_boolean)(
                    i.component,
                    references.as_ptr(),
                    references.len(),
                    found.as_mut_ptr(),
                )
            }
        })?;
        for (value, found) in values.iter_mut().zip(found) {
            *value = found != fmi2False;
        }
        Ok(())
    }

    /// Reads `String` variables into `values`; bytes that are not UTF-8 are replaced.
    pub fn get_string(&mut self, references: &[u32], values: &mut [String]) -> Result<(), Error> {
        same_length(references, values)?;
        let mut found: Vec<fmi2String> = vec![null(); values.len()];
        self.call("fmi2GetString", |i| {
            // SAFETY: the component is alive, both arrays have the length given.
            unsafe {
                (i.fmu.functions.get_string)(
                    i.component,
                    references.as_ptr(),
                    references.len(),
                    found.as_mut_ptr(),
                )
            }
        })?;
        for (value, found) in values.iter_mut().zip(found) {
            // SAFETY: the FMU keeps its texts until its next function is called.
            *value = unsafe { owned(found) };
        }
        Ok(())
    }

    /// Sets `Boolean` variables.
    pub fn set_boolean(&mut self, references: &[u32], values: &[bool]) -> Result<(), Error> {
        same_length(references, values)?;
        let values: Vec<fmi2Boolean> = values.iter().map(|&value| value.into()).collect();
        self.call("fmi2SetBoolean", |i| {
            // SAFETY: the component is alive, both arrays have the length given.
            unsafe {
                (i.fmu.functions.set_boolean)(
                    i.component,
                    references.as_ptr(),
                    references.len(),
                    values.as_ptr(),
                )
            }
        })
    }

    /// Sets `String` variables.
    pub fn set_string(&mut self, references: &[u32], values: &[&str]) -> Result<(), Error> {
        same_length(references, values)?;
        let texts = values
            .iter()
            .map(|&value| {
                CString::new(value).map_err(|_| Error::Text {
                    what: "value",
                    found: value.to_owned(),
                })
            })
            .collect::<Result<Vec<_>, _>>()?;
        let pointers: Vec<fmi2String> = texts.iter().map(|text| text.as_ptr()).collect();
        self.call("fmi2SetString", |i| {
            // SAFETY: the component is alive, both arrays have the length given, and the texts
            // outlive the call.
            unsafe {
                (i.fmu.functions.set_string)(
                    i.component,
                    references.as_ptr(),
                    references.len(),
                    pointers.as_ptr(),
                )
            }
        })
    }
}

impl Drop for Instance<'_> {
    fn drop(&mut self) {
        if !self.fatal {
            // SAFETY: the component is alive, and nobody uses it after this.
            unsafe { (self.fmu.functions.free_instance)(self.component) }
        }
    }
}

fn same_length<T>(references: &[u32], values: &[T]) -> Result<(), Error> {
    if references.len() == values.len() {
        Ok(())
    } else {
        Err(Error::Length {
            references: references.len(),
            values: values.len(),
        })
    }
}

fn take(log: &Log) -> Vec<LogLine> {
    std::mem::take(&mut *log.lock().unwrap_or_else(PoisonError::into_inner))
}

/// # Safety
/// `text` is NULL or null-terminated.
unsafe fn owned(text: fmi2String) -> String {
    if text.is_null() {
        return String::new();
    }
    // SAFETY: by contract.
    unsafe { CStr::from_ptr(text) }
        .to_string_lossy()
        .into_owned()
}

unsafe extern "C" {
    /// As in `stdlib.h`.
    fn calloc(count: usize, size: usize) -> *mut c_void;
    /// As in `stdlib.h`.
    fn free(memory: *mut c_void);
}

/// The callbacks, and the one place where the variadic logger is handed over.
///
/// The standard's logger is variadic, `(environment, name, status, category, message, …)`. Rust can
/// call such a function but not define one, so what the FMU gets is [`logger`], which takes the
/// five fixed arguments only. On the C ABIs of all platforms FMI 2.0 names, fixed arguments travel
/// the same way whether further ones follow or not, and the caller clears the stack. The price:
/// the further arguments cannot be read, and placeholders stay in the message.
fn callbacks(log: *mut Log) -> fmi2CallbackFunctions {
    type Fixed = unsafe extern "C" fn(
        fmi2ComponentEnvironment,
        fmi2String,
        fmi2Status,
        fmi2String,
        fmi2String,
    );
    fmi2CallbackFunctions {
        // SAFETY: as said above.
        logger: Some(unsafe { std::mem::transmute::<Fixed, fmi2CallbackLogger>(logger) }),
        allocateMemory: Some(calloc),
        freeMemory: Some(free),
        stepFinished: None,
        componentEnvironment: log.cast::<c_void>(),
    }
}

/// Keeps a log line. The FMU may call this from any thread.
unsafe extern "C" fn logger(
    environment: fmi2ComponentEnvironment,
    _name: fmi2String,
    status: fmi2Status,
    category: fmi2String,
    message: fmi2String,
) {
    // SAFETY: the environment is the box in the instance; `as_ref` guards against FMUs that hand
    // over NULL instead. Texts are NULL or null-terminated.
    let (log, category, message) = unsafe {
        (
            environment.cast::<Log>().as_ref(),
            owned(category),
            owned(message),
        )
    };
    if let Some(log) = log {
        let line = LogLine {
            status: status.into(),
            category,
            message: message.replace("%%", "%"),
        };
        log.lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push(line);
    }
}
