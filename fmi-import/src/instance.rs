//! One instance of an FMU, with safe calls: its life and its steps. Values, states and
//! derivatives have their own modules.

mod derivatives;
mod host;
mod state;
mod values;

pub use state::SavedState;
pub use values::Value;

use crate::library::Fmu;
use crate::{Error, LogLine, Status};
use fmi2::{
    fmi2Boolean, fmi2CoSimulation, fmi2Component, fmi2DoStepStatus, fmi2False,
    fmi2LastSuccessfulTime, fmi2Pending, fmi2Status, fmi2String, fmi2Terminated, fmi2True,
};
use host::Host;
use std::cell::Cell;
use std::ffi::CString;
use std::mem::ManuallyDrop;
use std::rc::Rc;
use std::sync::atomic::Ordering;
use std::time::Duration;

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

/// An instance; freed when it and all its [`SavedState`]s are dropped, before the library is
/// unloaded.
///
/// Calls that do not succeed return the FMU's log lines; [`Instance::log`] has those of the last
/// call in any case. After `fmi2Fatal` every call to any instance of the FMU is refused, and
/// dropping calls nothing either, as the standard wants it.
#[derive(Debug)]
pub struct Instance<'a> {
    core: Rc<Core<'a>>,
}

/// What an instance shares with its saved states, so that it outlives them.
#[derive(Debug)]
struct Core<'a> {
    fmu: &'a Fmu,
    component: fmi2Component,
    /// Not dropped before the component is freed: until then the FMU may call back.
    host: ManuallyDrop<Host>,
    /// A state was saved or read from bytes: time may go back.
    has_saved_states: Cell<bool>,
}

impl Fmu {
    /// A new instance called `name`, with logging on.
    pub fn instantiate(&self, name: &str) -> Result<Instance<'_>, Error> {
        const FUNCTION: &str = "fmi2Instantiate";
        if self.fatal.load(Ordering::Relaxed) {
            return Err(Error::Broken { function: FUNCTION });
        }
        let description = self.description();
        let name = c_text("instance name", name)?;
        let guid = c_text("guid", &description.guid)?;
        let resources = c_text("resource location", &self.archive().resource_location())?;
        let host = Host::new();
        // SAFETY: texts are null-terminated, callbacks valid until after fmi2FreeInstance: the host
        // lives in the core, whose drop frees first.
        let component = unsafe {
            (self.functions.instantiate)(
                name.as_ptr(),
                fmi2CoSimulation,
                guid.as_ptr(),
                resources.as_ptr(),
                host.callbacks(),
                fmi2False,
                fmi2True,
            )
        };
        if component.is_null() {
            return Err(Error::NotInstantiated {
                log: self.named(host.take_lines()),
            });
        }
        Ok(Instance {
            core: Rc::new(Core {
                fmu: self,
                component,
                host: ManuallyDrop::new(host),
                has_saved_states: Cell::new(false),
            }),
        })
    }

    fn named(&self, lines: Vec<LogLine>) -> Vec<LogLine> {
        let named = |line: LogLine| line.with_names(self.description());
        lines.into_iter().map(named).collect()
    }
}

impl Core<'_> {
    fn take_log(&self) -> Vec<LogLine> {
        self.fmu.named(self.host.take_lines())
    }

    fn is_broken(&self) -> bool {
        self.fmu.fatal.load(Ordering::Relaxed)
    }

    fn call(
        &self,
        function: &'static str,
        call: impl FnOnce(&Self) -> fmi2Status,
    ) -> Result<(), Error> {
        if self.is_broken() {
            return Err(Error::Broken { function });
        }
        drop(self.host.take_lines());
        self.check(function, call(self))
    }

    /// Turns a status into a result.
    fn check(&self, function: &'static str, status: fmi2Status) -> Result<(), Error> {
        match Status::from(status) {
            Status::Ok | Status::Warning => Ok(()),
            status => {
                if status == Status::Fatal {
                    self.fmu.fatal.store(true, Ordering::Relaxed);
                }
                Err(Error::Refused {
                    function,
                    status,
                    log: self.take_log(),
                })
            }
        }
    }
}

impl Drop for Core<'_> {
    fn drop(&mut self) {
        if !self.is_broken() {
            // SAFETY: the component is alive, and nobody uses it or the host after this.
            unsafe {
                (self.fmu.functions.free_instance)(self.component);
                ManuallyDrop::drop(&mut self.host);
            }
        }
    }
}

/// Calls without arguments.
macro_rules! plain {
    ($($(#[$doc:meta])* $name:ident = $function:literal;)*) => {
        $(
            $(#[$doc])*
            pub fn $name(&mut self) -> Result<(), Error> {
                self.core.call($function, |i| {
                    // SAFETY: the component is alive.
                    unsafe { (i.fmu.functions.$name)(i.component) }
                })
            }
        )*
    };
}

impl<'a> Instance<'a> {
    /// The FMU it is an instance of.
    pub fn fmu(&self) -> &'a Fmu {
        self.core.fmu
    }

    /// Log lines since before the last call, taken out.
    pub fn log(&mut self) -> Vec<LogLine> {
        self.core.take_log()
    }

    /// Turns logging on or off, for some of the description's log categories or, where none is
    /// named, for all.
    pub fn set_debug_logging(&mut self, on: bool, categories: &[&str]) -> Result<(), Error> {
        const FUNCTION: &str = "fmi2SetDebugLogging";
        let set_debug_logging = present(FUNCTION, self.core.fmu.functions.set_debug_logging)?;
        let texts = c_texts("log category", categories)?;
        let pointers: Vec<fmi2String> = texts.iter().map(|text| text.as_ptr()).collect();
        self.core.call(FUNCTION, |i| {
            // SAFETY: the component is alive, the array has the length given, and the texts outlive
            // the call.
            unsafe { set_debug_logging(i.component, on.into(), pointers.len(), pointers.as_ptr()) }
        })
    }

    /// Start time, stop time [s] and relative tolerance.
    pub fn setup_experiment(
        &mut self,
        tolerance: Option<f64>,
        start_time: f64,
        stop_time: Option<f64>,
    ) -> Result<(), Error> {
        self.core.call("fmi2SetupExperiment", |i| {
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

    /// Goes on from `point` by `h`, both in s. Waits where the FMU computes in the background.
    pub fn do_step(&mut self, point: f64, h: f64) -> Result<Step, Error> {
        // The FMU may forget the past where nothing was saved that could bring it back.
        let never_back = fmi2Boolean::from(!self.core.has_saved_states.get());
        let stepped = self.core.call("fmi2DoStep", |i| {
            let ask = i.fmu.functions.get_status;
            // SAFETY: the component is alive.
            let mut status =
                unsafe { (i.fmu.functions.do_step)(i.component, point, h, never_back) };
            while let Some(get_status) = ask.filter(|_| status == fmi2Pending) {
                std::thread::sleep(Duration::from_micros(100));
                // SAFETY: the component is alive, `status` a place for the answer.
                let asked = unsafe { get_status(i.component, fmi2DoStepStatus, &raw mut status) };
                match Status::from(asked) {
                    Status::Ok | Status::Warning => {}
                    // it cannot tell
                    Status::Discard => break,
                    _ => return asked,
                }
            }
            status
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

    fn last_successful_time(&self) -> Result<f64, Error> {
        const FUNCTION: &str = "fmi2GetRealStatus";
        let get_real_status = present(FUNCTION, self.core.fmu.functions.get_real_status)?;
        let mut time = f64::NAN;
        self.core.call(FUNCTION, |i| {
            // SAFETY: the component is alive, `time` a place for the answer.
            unsafe { get_real_status(i.component, fmi2LastSuccessfulTime, &raw mut time) }
        })?;
        Ok(time)
    }

    fn terminated(&self) -> Result<bool, Error> {
        const FUNCTION: &str = "fmi2GetBooleanStatus";
        let get_boolean_status = present(FUNCTION, self.core.fmu.functions.get_boolean_status)?;
        let mut terminated = fmi2False;
        self.core.call(FUNCTION, |i| {
            // SAFETY: the component is alive, `terminated` a place for the answer.
            unsafe { get_boolean_status(i.component, fmi2Terminated, &raw mut terminated) }
        })?;
        Ok(terminated != fmi2False)
    }
}

/// A function that every FMU should have.
fn present<T>(function: &'static str, pointer: Option<T>) -> Result<T, Error> {
    pointer.ok_or(Error::FunctionAbsent { function })
}

/// A function that an FMU need not provide unless its description has the `flag`.
fn capable<T>(
    function: &'static str,
    pointer: Option<T>,
    flag: &'static str,
    declared: bool,
) -> Result<T, Error> {
    if declared {
        present(function, pointer)
    } else {
        Err(Error::CapabilityAbsent { function, flag })
    }
}

/// As many values as references.
fn same_length(references: usize, values: usize) -> Result<(), Error> {
    if references == values {
        Ok(())
    } else {
        Err(Error::Length { references, values })
    }
}

/// A text as C wants it; `what` it is.
fn c_text(what: &'static str, text: &str) -> Result<CString, Error> {
    CString::new(text).map_err(|_| Error::Text {
        what,
        found: text.to_owned(),
    })
}

fn c_texts(what: &'static str, texts: &[&str]) -> Result<Vec<CString>, Error> {
    texts.iter().map(|text| c_text(what, text)).collect()
}
