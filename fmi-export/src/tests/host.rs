//! An importer in miniature: calls the C functions by name and keeps the log.

use super::cart::Cart;
use crate::{Model, ffi};
use fmi2::{
    fmi2CallbackFunctions, fmi2CallbackLogger, fmi2CoSimulation, fmi2Component,
    fmi2ComponentEnvironment, fmi2Discard, fmi2Error, fmi2Fatal, fmi2OK, fmi2Status, fmi2String,
};
use std::ffi::{CStr, CString, c_void};
use std::ptr::{null, null_mut};
use std::sync::Mutex;

/// Log lines as `instance status category message`.
pub(super) type Log = Mutex<Vec<String>>;

/// Everything FMI hands to a logger but the variadic rest.
type FixedLogger =
    unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String);

unsafe extern "C" fn log(
    environment: fmi2ComponentEnvironment,
    instance: fmi2String,
    status: fmi2Status,
    category: fmi2String,
    message: fmi2String,
) {
    // SAFETY: the environment is the log, and the FMU gives null-terminated texts: that it does
    // is what these tests are about.
    let (log, texts) = unsafe {
        (
            &*environment.cast::<Log>(),
            [instance, category, message].map(|text| {
                assert!(!text.is_null(), "a null text in the log");
                CStr::from_ptr(text).to_string_lossy()
            }),
        )
    };
    let [instance, category, message] = texts;
    let line = format!("{instance} {status} {category} {message}");
    log.lock().expect("one thread").push(line);
}

pub(super) fn callbacks(environment: &Log) -> fmi2CallbackFunctions {
    fmi2CallbackFunctions {
        // SAFETY: Rust cannot define a variadic function; on the ABIs these tests run on, one
        // that takes only the fixed arguments may be called as one.
        logger: Some(unsafe { std::mem::transmute::<FixedLogger, fmi2CallbackLogger>(log) }),
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: std::ptr::from_ref(environment).cast_mut().cast::<c_void>(),
    }
}

/// An instance of the cart, and what it logged.
pub(super) struct Host {
    pub(super) c: fmi2Component,
    log: Box<Log>,
    /// The importer's idea of the time [s].
    pub(super) time: f64,
}

impl Host {
    pub(super) fn new(logging: bool) -> Self {
        let log = Box::default();
        let guid = text(&Cart::description().fingerprint());
        // SAFETY: all texts are null-terminated, the callbacks valid.
        let c = unsafe {
            ffi::instantiate::<Cart>(
                c"cart".as_ptr(),
                fmi2CoSimulation,
                guid.as_ptr(),
                null(),
                &raw const *Box::new(callbacks(&log)),
                0,
                i32::from(logging),
            )
        };
        assert!(!c.is_null());
        Self { c, log, time: 0.0 }
    }

    /// The log since the last call.
    pub(super) fn log(&self) -> Vec<String> {
        std::mem::take(&mut *self.log.lock().expect("one thread"))
    }

    pub(super) fn get(&self, reference: u32) -> f64 {
        let mut value = f64::NAN;
        // SAFETY: one element each.
        let status =
            unsafe { ffi::get::<Cart, f64>(self.c, &raw const reference, 1, &raw mut value) };
        assert_eq!(status, fmi2OK, "{:?}", self.log());
        value
    }

    pub(super) fn set(&self, reference: u32, value: f64) -> fmi2Status {
        // SAFETY: one element each.
        unsafe { ffi::set::<Cart, f64>(self.c, &raw const reference, 1, &raw const value) }
    }

    pub(super) fn set_integer(&self, reference: u32, value: i32) -> fmi2Status {
        // SAFETY: one element each.
        unsafe { ffi::set::<Cart, i32>(self.c, &raw const reference, 1, &raw const value) }
    }

    pub(super) fn setup(&self, start: f64, stop: Option<f64>) -> fmi2Status {
        let stop_defined = i32::from(stop.is_some());
        // SAFETY: a live instance.
        unsafe {
            ffi::setup_experiment::<Cart>(self.c, 0, 0.0, start, stop_defined, stop.unwrap_or(0.0))
        }
    }

    pub(super) fn step(&mut self, h: f64) -> fmi2Status {
        // SAFETY: a live instance.
        let status = unsafe { ffi::do_step::<Cart>(self.c, self.time, h, 1) };
        if status == fmi2OK {
            self.time += h;
        }
        status
    }

    /// Calls what `word` names.
    pub(super) fn call(&mut self, word: &str) -> fmi2Status {
        let c = self.c;
        let (mut real, mut integer, mut string, mut size) = (0.0, 0, null(), 0);
        let mut state = null_mut();
        // SAFETY: a live instance, and pointers to locals of one element.
        unsafe {
            match word {
                "debug" => ffi::set_debug_logging::<Cart>(c, 1, 0, null()),
                "setup" => self.setup(0.0, None),
                "enter" => ffi::enter_initialization_mode::<Cart>(c),
                "exit" => ffi::exit_initialization_mode::<Cart>(c),
                "terminate" => ffi::terminate::<Cart>(c),
                "reset" => {
                    self.time = 0.0;
                    ffi::reset::<Cart>(c)
                }
                "get" => ffi::get::<Cart, f64>(c, &super::cart::POSITION, 1, &raw mut real),
                "set-fixed" => self.set(super::cart::MASS, 3.0),
                "set-tunable" => self.set(super::cart::DRAG, 0.5),
                "set-input" => self.set(super::cart::FORCE, 5.0),
                "set-output" => self.set(super::cart::POSITION, 1.0),
                "step" => self.step(0.5),
                "leap" => self.step(1e3),
                "cancel" => ffi::cancel_step::<Cart>(c),
                "time-status" => ffi::get_real_status::<Cart>(c, 2, &raw mut real),
                "ended-status" => ffi::get_boolean_status::<Cart>(c, 3, &raw mut integer),
                "status" => ffi::get_status::<Cart>(c, 0, &raw mut integer),
                "integer-status" => ffi::get_integer_status::<Cart>(c, 0, &raw mut integer),
                "string-status" => ffi::get_string_status::<Cart>(c, 1, &raw mut string),
                "get-state" => ffi::get_fmu_state::<Cart>(c, &raw mut state),
                "set-state" => ffi::set_fmu_state::<Cart>(c, state),
                "free-state" => ffi::free_fmu_state::<Cart>(c, &raw mut state),
                "state-size" => ffi::serialized_fmu_state_size::<Cart>(c, state, &raw mut size),
                "serialize" => ffi::serialize_fmu_state::<Cart>(c, state, null_mut(), 0),
                "deserialize" => ffi::deserialize_fmu_state::<Cart>(c, null(), 0, &raw mut state),
                "derivative" => ffi::get_directional_derivative::<Cart>(
                    c,
                    null(),
                    0,
                    null(),
                    0,
                    null(),
                    null_mut(),
                ),
                "input-derivative" => {
                    ffi::set_real_input_derivatives::<Cart>(c, null(), 0, null(), null())
                }
                "output-derivative" => {
                    ffi::get_real_output_derivatives::<Cart>(c, null(), 0, null(), null_mut())
                }
                _ => panic!("no call is named {word}"),
            }
        }
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: freed once, here.
        unsafe { ffi::free_instance::<Cart>(self.c) }
    }
}

pub(super) fn text(text: &str) -> CString {
    CString::new(text).expect("no inner null")
}

/// A life cycle in words, each with a mark where the call is not obeyed: `!` for an error, `?` for
/// a discard, `#` for fatal. Whatever is not obeyed logs exactly one line, and nothing else does.
#[track_caller]
pub(super) fn check(calls: &str) -> Host {
    let mut host = Host::new(true);
    run(&mut host, calls);
    host
}

#[track_caller]
pub(super) fn run(host: &mut Host, calls: &str) {
    for call in calls.split_whitespace() {
        let word = call.trim_end_matches(['!', '?', '#']);
        let expected = match &call[word.len()..] {
            "!" => fmi2Error,
            "?" => fmi2Discard,
            "#" => fmi2Fatal,
            _ => fmi2OK,
        };
        let status = host.call(word);
        let log = host.log();
        assert_eq!(status, expected, "{call} in \"{calls}\": {log:?}");
        assert_eq!(
            log.len(),
            usize::from(expected != fmi2OK),
            "{call} in \"{calls}\": {log:?}"
        );
    }
}
