//! What an instance is given of its importer: memory, and an ear for its log.

use crate::{LogLine, Status};
use fmi2::{fmi2CallbackFunctions, fmi2ComponentEnvironment, fmi2Status, fmi2String};
use std::ffi::{CStr, c_void};
use std::sync::{Mutex, PoisonError};

unsafe extern "C" {
    /// As in `stdlib.h`.
    fn calloc(count: usize, size: usize) -> *mut c_void;
    /// As in `stdlib.h`.
    fn free(memory: *mut c_void);
    /// `logger.c`: fills in the placeholders and calls [`Environment::line`].
    fn fmi_import_logger(
        environment: fmi2ComponentEnvironment,
        name: fmi2String,
        status: fmi2Status,
        category: fmi2String,
        format: fmi2String,
        ...
    );
}

/// Where log lines go. `logger.c` knows the first member: handing the function over by a pointer
/// spares a symbol that a shared library would export.
#[derive(Debug)]
#[repr(C)]
struct Environment {
    line: unsafe extern "C" fn(*const Environment, fmi2Status, fmi2String, fmi2String),
    /// Behind a lock: the FMU may log from any thread.
    lines: Mutex<Vec<LogLine>>,
}

/// What the FMU holds pointers to until it is freed (FMI 2.0 §2.1.5): raw ones here too, for a
/// `Box` that moves would end them.
#[derive(Debug)]
pub(super) struct Host {
    callbacks: *mut fmi2CallbackFunctions,
    environment: *mut Environment,
}

impl Host {
    pub(super) fn new() -> Self {
        let environment = Box::into_raw(Box::new(Environment {
            line,
            lines: Mutex::default(),
        }));
        let callbacks = Box::into_raw(Box::new(fmi2CallbackFunctions {
            logger: Some(fmi_import_logger),
            allocateMemory: Some(calloc),
            freeMemory: Some(free),
            // Steps that are still being computed are asked for, see `do_step`.
            stepFinished: None,
            componentEnvironment: environment.cast::<c_void>(),
        }));
        Self {
            callbacks,
            environment,
        }
    }

    pub(super) fn callbacks(&self) -> *const fmi2CallbackFunctions {
        self.callbacks
    }

    /// The lines that came since this was last called.
    pub(super) fn take_lines(&self) -> Vec<LogLine> {
        // SAFETY: from Box::into_raw, alive until drop, shared only behind its lock.
        let lines = unsafe { &(*self.environment).lines };
        std::mem::take(&mut lines.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: both from Box::into_raw and freed once; the FMU's instance is freed by then.
        unsafe {
            drop(Box::from_raw(self.callbacks));
            drop(Box::from_raw(self.environment));
        }
    }
}

/// The text, empty for NULL; bytes that are not UTF-8 are replaced.
///
/// # Safety
/// `text` is NULL or null-terminated.
pub(super) unsafe fn owned(text: fmi2String) -> String {
    if text.is_null() {
        return String::new();
    }
    // SAFETY: by contract.
    unsafe { CStr::from_ptr(text) }
        .to_string_lossy()
        .into_owned()
}

/// Keeps a log line.
///
/// # Safety
/// Called by `logger.c` only: the environment is alive, texts are NULL or null-terminated.
unsafe extern "C" fn line(
    environment: *const Environment,
    status: fmi2Status,
    category: fmi2String,
    text: fmi2String,
) {
    // SAFETY: by contract.
    let (lines, category, message) =
        unsafe { (&(*environment).lines, owned(category), owned(text)) };
    lines
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .push(LogLine {
            status: Status::from(status),
            category,
            message,
        });
}
