//! An importer in miniature, on the linked bicycle: brings an instance into a state, keeps the
//! log, and knows the state to the last bit.

use crate::symbols::{
    fmi2DeSerializeFMUstate, fmi2DoStep, fmi2EnterInitializationMode, fmi2ExitInitializationMode,
    fmi2FreeFMUstate, fmi2FreeInstance, fmi2GetFMUstate, fmi2GetReal, fmi2Instantiate, fmi2Reset,
    fmi2SerializeFMUstate, fmi2SerializedFMUstateSize, fmi2SetFMUstate, fmi2SetReal,
    fmi2SetRealInputDerivatives, fmi2SetupExperiment, fmi2Terminate,
};
use fmi2::{
    fmi2Byte, fmi2CallbackFunctions, fmi2CallbackLogger, fmi2CoSimulation, fmi2Component,
    fmi2ComponentEnvironment, fmi2Discard, fmi2FMUstate, fmi2OK, fmi2Status, fmi2String,
};
use model_description::ModelDescription;
use std::cell::RefCell;
use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut, without_provenance_mut};
use std::sync::LazyLock;

/// The bicycle's modelDescription.xml, read from the golden file: what an importer has.
pub fn bicycle() -> &'static ModelDescription {
    static DESCRIPTION: LazyLock<ModelDescription> = LazyLock::new(|| {
        ModelDescription::from_xml(include_str!("../../fmu/modelDescription.xml"))
            .expect("the golden file is a description")
    });
    &DESCRIPTION
}

/// The states of FMI 2.0 §4.2.4 that an instance stays in between two calls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// After `fmi2Instantiate`.
    Instantiated,
    /// After `fmi2EnterInitializationMode`.
    Initialization,
    /// After a step.
    StepComplete,
    /// After a step that ended early.
    StepFailed,
    /// After `fmi2Terminate`.
    Terminated,
}

impl State {
    /// All five, in the order of the standard's columns.
    pub const ALL: [Self; 5] = [
        Self::Instantiated,
        Self::Initialization,
        Self::StepComplete,
        Self::StepFailed,
        Self::Terminated,
    ];
}

/// A call of the logger. `None` is NULL, which there must not be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// Address of the environment.
    pub environment: usize,
    /// Name of the instance.
    pub instance: Option<String>,
    /// Status.
    pub status: fmi2Status,
    /// Category.
    pub category: Option<String>,
    /// Message.
    pub message: Option<String>,
}

thread_local! {
    static LOG: RefCell<Vec<Line>> = const { RefCell::new(Vec::new()) };
}

/// All that FMI hands to a logger but the variadic rest.
type FixedLogger =
    unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String);

/// The environment is never followed: it is only to arrive untouched.
unsafe extern "C" fn log(
    environment: fmi2ComponentEnvironment,
    instance: fmi2String,
    status: fmi2Status,
    category: fmi2String,
    message: fmi2String,
) {
    let text = |text: fmi2String| {
        if text.is_null() {
            return None;
        }
        // SAFETY: a text of the interface is null-terminated.
        let text = unsafe { CStr::from_ptr(text) };
        Some(text.to_string_lossy().into_owned())
    };
    let line = Line {
        environment: environment.addr(),
        instance: text(instance),
        status,
        category: text(category),
        message: text(message),
    };
    LOG.with_borrow_mut(|lines| lines.push(line));
}

/// An instance of the bicycle, and what its importer knows.
#[derive(Debug)]
pub struct Slave {
    /// The instance.
    pub c: fmi2Component,
    /// A state that was saved, or NULL.
    pub saved: fmi2FMUstate,
    /// The communication point \[s\].
    pub time: f64,
    /// Alive as long as the instance.
    _callbacks: Box<fmi2CallbackFunctions>,
}

impl Slave {
    /// What the logger must be given back.
    pub const ENVIRONMENT: usize = 0x5eed;

    /// What `fmi2Instantiate` takes.
    pub fn callbacks() -> Box<fmi2CallbackFunctions> {
        Box::new(fmi2CallbackFunctions {
            // SAFETY: Rust cannot define a variadic function; on the ABIs these tests run on, one
            // that takes only the fixed arguments may be called as one.
            logger: Some(unsafe { std::mem::transmute::<FixedLogger, fmi2CallbackLogger>(log) }),
            allocateMemory: None,
            freeMemory: None,
            stepFinished: None,
            componentEnvironment: without_provenance_mut(Self::ENVIRONMENT),
        })
    }

    /// A new instance, with logging on.
    pub fn new() -> Self {
        let callbacks = Self::callbacks();
        let guid = CString::new(&*bicycle().guid).expect("no inner null");
        // SAFETY: texts are null-terminated, and the callbacks live as long as the instance.
        let c = unsafe {
            fmi2Instantiate(
                c"slave".as_ptr(),
                fmi2CoSimulation,
                guid.as_ptr(),
                null(),
                &raw const *callbacks,
                0,
                1,
            )
        };
        Self::hear_panics();
        assert!(!c.is_null(), "{:?}", Self::lines());
        Self {
            c,
            saved: null_mut(),
            time: 0.0,
            _callbacks: callbacks,
        }
    }

    /// An FMU keeps panics of its own copy of the standard library quiet. Linked, it is ours too.
    pub fn hear_panics() {
        drop(std::panic::take_hook());
    }

    /// A new instance brought into `state`, leaning and turning.
    pub fn reach(state: State) -> Self {
        let mut slave = Self::new();
        slave.lead(state);
        slave
    }

    /// From *instantiated* into `state`, leaning and turning.
    pub fn lead(&mut self, state: State) {
        self.time = 0.0;
        let start = [("roll_start", 0.05), ("steer_start", -0.02)];
        for (name, value) in start {
            assert_eq!(self.set(name, value), fmi2OK);
        }
        if state == State::StepFailed {
            // a rider who pushes the bicycle over
            assert_eq!(self.set("rider_roll_gain", -2000.0), fmi2OK);
        }
        assert_eq!(self.setup(0.0, None), fmi2OK);
        if state == State::Instantiated {
            return;
        }
        // SAFETY: a live instance.
        unsafe {
            assert_eq!(fmi2EnterInitializationMode(self.c), fmi2OK);
            if state == State::Initialization {
                return;
            }
            assert_eq!(fmi2ExitInitializationMode(self.c), fmi2OK);
        }
        if state == State::StepFailed {
            assert_eq!(self.step(10.0), fmi2Discard);
        } else {
            // off the internal grid
            assert_eq!(self.step(1.0 / 60.0), fmi2OK);
        }
        if state == State::Terminated {
            // SAFETY: a live instance.
            assert_eq!(unsafe { fmi2Terminate(self.c) }, fmi2OK);
        }
        Self::lines();
    }

    /// What was logged in this thread since the last look.
    pub fn lines() -> Vec<Line> {
        LOG.take()
    }

    /// The value reference of the variable called `name`.
    pub fn reference(name: &str) -> u32 {
        let variable = bicycle().variable(name);
        variable.expect("a variable of the bicycle").value_reference
    }

    /// `fmi2SetupExperiment` without a tolerance.
    pub fn setup(&self, start: f64, stop: Option<f64>) -> fmi2Status {
        let defined = i32::from(stop.is_some());
        // SAFETY: a live instance.
        unsafe { fmi2SetupExperiment(self.c, 0, 0.0, start, defined, stop.unwrap_or(0.0)) }
    }

    /// `fmi2SetReal` for one variable.
    pub fn set(&self, name: &str, value: f64) -> fmi2Status {
        let reference = Self::reference(name);
        // SAFETY: one element each.
        unsafe { fmi2SetReal(self.c, &raw const reference, 1, &raw const value) }
    }

    /// `fmi2GetReal` for one variable.
    pub fn get(&self, name: &str) -> f64 {
        let (reference, mut value) = (Self::reference(name), f64::NAN);
        // SAFETY: one element each.
        let status = unsafe { fmi2GetReal(self.c, &raw const reference, 1, &raw mut value) };
        assert_eq!(status, fmi2OK, "{:?}", Self::lines());
        value
    }

    /// `fmi2SetRealInputDerivatives` of order 1 for one variable.
    pub fn ramp(&self, name: &str, slope: f64) -> fmi2Status {
        let (reference, order) = (Self::reference(name), 1);
        // SAFETY: one element each.
        unsafe {
            fmi2SetRealInputDerivatives(
                self.c,
                &raw const reference,
                1,
                &raw const order,
                &raw const slope,
            )
        }
    }

    /// `fmi2DoStep` from where the last ended.
    pub fn step(&mut self, h: f64) -> fmi2Status {
        let status = self.step_from(self.time, h);
        if status == fmi2OK {
            self.time += h;
        }
        status
    }

    /// `fmi2DoStep`.
    pub fn step_from(&self, point: f64, h: f64) -> fmi2Status {
        // SAFETY: a live instance.
        unsafe { fmi2DoStep(self.c, point, h, 0) }
    }

    /// `fmi2GetFMUstate`: another state each time.
    pub fn save(&self) -> fmi2FMUstate {
        let mut state = null_mut();
        // SAFETY: a live instance and a place.
        let status = unsafe { fmi2GetFMUstate(self.c, &raw mut state) };
        assert_eq!(status, fmi2OK, "{:?}", Self::lines());
        state
    }

    /// `fmi2SetFMUstate`.
    #[expect(
        clippy::not_unsafe_ptr_arg_deref,
        reason = "a state that is none is refused, not followed"
    )]
    pub fn restore(&self, state: fmi2FMUstate) -> fmi2Status {
        // SAFETY: a live instance; the state may be anything.
        unsafe { fmi2SetFMUstate(self.c, state) }
    }

    /// `fmi2Reset`.
    pub fn reset(&self) -> fmi2Status {
        // SAFETY: a live instance.
        unsafe { fmi2Reset(self.c) }
    }

    /// `fmi2FreeFMUstate`.
    pub fn forget(&self, mut state: fmi2FMUstate) {
        // SAFETY: a live instance and a place.
        let status = unsafe { fmi2FreeFMUstate(self.c, &raw mut state) };
        assert_eq!(status, fmi2OK, "{:?}", Self::lines());
    }

    /// The present state, to the last bit.
    pub fn bytes(&self) -> Vec<u8> {
        let state = self.save();
        let bytes = self.bytes_of(state);
        self.forget(state);
        bytes
    }

    /// A saved state in bytes.
    #[expect(
        clippy::not_unsafe_ptr_arg_deref,
        reason = "a state that is none is refused, not followed"
    )]
    pub fn bytes_of(&self, state: fmi2FMUstate) -> Vec<u8> {
        let mut size = 0;
        // SAFETY: a live instance, one of its states, and as much room as it asks for.
        unsafe {
            let status = fmi2SerializedFMUstateSize(self.c, state, &raw mut size);
            assert_eq!(status, fmi2OK, "{:?}", Self::lines());
            let mut bytes = vec![0_u8; size];
            let place = bytes.as_mut_ptr().cast::<fmi2Byte>();
            let status = fmi2SerializeFMUstate(self.c, state, place, size);
            assert_eq!(status, fmi2OK, "{:?}", Self::lines());
            bytes
        }
    }

    /// `fmi2DeSerializeFMUstate` into `state`.
    pub fn read(&self, bytes: &[u8], state: &mut fmi2FMUstate) -> fmi2Status {
        let place = bytes.as_ptr().cast::<fmi2Byte>();
        // SAFETY: a live instance, as many bytes as said, and a place.
        unsafe { fmi2DeSerializeFMUstate(self.c, place, bytes.len(), state) }
    }
}

impl Default for Slave {
    fn default() -> Self {
        Self::new()
    }
}

impl Drop for Slave {
    fn drop(&mut self) {
        // SAFETY: freed once, here; NULL is nothing to free.
        unsafe {
            fmi2FreeFMUstate(self.c, &raw mut self.saved);
            fmi2FreeInstance(self.c);
        }
    }
}
