//! An importer in miniature: calls the C functions by name and keeps the log.

use super::cart::Cart;
use crate::{Model, ffi};
use fmi2::{
    fmi2CallbackFunctions, fmi2CallbackLogger, fmi2CoSimulation, fmi2Component,
    fmi2ComponentEnvironment, fmi2Discard, fmi2Error, fmi2FMUstate, fmi2Fatal, fmi2OK, fmi2Status,
    fmi2String,
};
use std::ffi::{CStr, CString, c_void};
use std::ptr::{null, null_mut};
use std::sync::Mutex;

/// As `export!` makes one for each library.
pub(super) static SHARED: ffi::Shared<Cart> = ffi::Shared::new();

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
    /// The saved state that the words are about.
    pub(super) saved: fmi2FMUstate,
    /// The time when it was saved [s].
    saved_time: f64,
    /// The importer's idea of the time [s].
    pub(super) time: f64,
}

impl Host {
    pub(super) fn new(logging: bool) -> Self {
        let log = Box::default();
        let guid = text(&Cart::description().fingerprint());
        // SAFETY: all texts are null-terminated, the callbacks valid.
        let c = unsafe {
            ffi::instantiate(
                &SHARED,
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
        Self::of(c, log)
    }

    /// Of an instance made elsewhere.
    pub(super) fn of(c: fmi2Component, log: Box<Log>) -> Self {
        Self {
            c,
            log,
            saved: null_mut(),
            saved_time: 0.0,
            time: 0.0,
        }
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

    /// The saved state in bytes.
    pub(super) fn bytes(&self) -> Vec<i8> {
        let mut size = 0;
        // SAFETY: a live instance, a buffer of the size asked for.
        unsafe {
            let status = ffi::serialized_fmu_state_size::<Cart>(self.c, self.saved, &raw mut size);
            assert_eq!(status, fmi2OK, "{:?}", self.log());
            let mut bytes = vec![0; size];
            let status =
                ffi::serialize_fmu_state::<Cart>(self.c, self.saved, bytes.as_mut_ptr(), size);
            assert_eq!(status, fmi2OK, "{:?}", self.log());
            bytes
        }
    }

    /// Takes bytes as the saved state.
    pub(super) fn take_bytes(&mut self, bytes: &[i8]) -> fmi2Status {
        // SAFETY: a live instance, a buffer of the length said.
        unsafe {
            ffi::deserialize_fmu_state::<Cart>(
                self.c,
                bytes.as_ptr(),
                bytes.len(),
                &raw mut self.saved,
            )
        }
    }

    /// The saved state to bytes and back, in its place.
    fn copy_state(&mut self) -> fmi2Status {
        let bytes = self.bytes();
        self.take_bytes(&bytes)
    }

    /// ∂acceleration/∂known.
    pub(super) fn derivative(&self, known: u32) -> (fmi2Status, f64) {
        let (unknown, seed, mut found) = (super::cart::ACCELERATION, 1.0, f64::NAN);
        // SAFETY: one element each.
        let status = unsafe {
            ffi::get_directional_derivative::<Cart>(
                self.c,
                &raw const unknown,
                1,
                &raw const known,
                1,
                &raw const seed,
                &raw mut found,
            )
        };
        (status, found)
    }

    /// Calls what `word` names.
    pub(super) fn call(&mut self, word: &str) -> fmi2Status {
        let c = self.c;
        let (mut real, mut integer, mut string) = (0.0, 0, null());
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
                "set-heavy" => self.set(super::cart::MASS, 1000.0),
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
                "get-state" => {
                    self.saved_time = self.time;
                    ffi::get_fmu_state::<Cart>(c, &raw mut self.saved)
                }
                "set-state" => {
                    self.time = self.saved_time;
                    ffi::set_fmu_state::<Cart>(c, self.saved)
                }
                "free-state" => ffi::free_fmu_state::<Cart>(c, &raw mut self.saved),
                "copy-state" => self.copy_state(),
                "derivative" => self.derivative(super::cart::FORCE).0,
                "derivative-fixed" => self.derivative(super::cart::MASS).0,
                "input-derivative" => {
                    let (force, order, slope) = (super::cart::FORCE, 1, 2.0);
                    ffi::set_real_input_derivatives::<Cart>(
                        c,
                        &raw const force,
                        1,
                        &raw const order,
                        &raw const slope,
                    )
                }
                "output-derivative" => {
                    let (position, order) = (super::cart::POSITION, 1);
                    ffi::get_real_output_derivatives::<Cart>(
                        c,
                        &raw const position,
                        1,
                        &raw const order,
                        &raw mut real,
                    )
                }
                _ => panic!("no call is named {word}"),
            }
        }
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: freed once, here.
        unsafe { ffi::free_instance(&SHARED, self.c) }
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
