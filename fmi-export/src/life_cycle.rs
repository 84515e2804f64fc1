//! The life cycle: which function is legal in which state (FMI 2.0 §4.2.4).

use serde::{Deserialize, Serialize};
use std::fmt;

/// The states of a slave that steps synchronously. The standard's *step in progress* and *step
/// canceled* do not occur in one.
///
/// A refused call leaves the state as it is: the standard's state *error*, out of which only
/// reset, free and a saved state lead, is not used, so that an importer may correct the call and
/// repeat it. In particular `fmi2DoStep` may follow one that returned `fmi2Error`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum State {
    /// After `fmi2Instantiate` and `fmi2Reset`.
    Instantiated,
    /// Between `fmi2EnterInitializationMode` and `fmi2ExitInitializationMode`.
    Initialization,
    /// At a communication point.
    StepComplete,
    /// After a step that ended early.
    StepFailed,
    /// After `fmi2Terminate`.
    Terminated,
}

impl State {
    /// All of them, in the order of the table's columns.
    pub const ALL: [Self; 5] = [
        Self::Instantiated,
        Self::Initialization,
        Self::StepComplete,
        Self::StepFailed,
        Self::Terminated,
    ];
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Instantiated => "instantiated",
            Self::Initialization => "initialization mode",
            Self::StepComplete => "step complete",
            Self::StepFailed => "step failed",
            Self::Terminated => "terminated",
        })
    }
}

/// A function of the interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Function {
    /// Its name in the standard.
    pub name: &'static str,
    /// One column for each [`State`], in its order.
    legal: [bool; 5],
}

impl Function {
    /// Whether it may be called in `state`.
    #[inline]
    pub const fn is_legal_in(&self, state: State) -> bool {
        self.legal[state as usize]
    }
}

macro_rules! legality {
    (@ x) => { true };
    (@ -) => { false };
    ($($function:ident: $i:tt $m:tt $c:tt $f:tt $t:tt;)*) => {
        impl Function {
            $(
                #[doc = concat!("`fmi2", stringify!($function), "`.")]
                #[allow(non_upper_case_globals, reason = "the standard's names")]
                pub const $function: Self = Self {
                    name: concat!("fmi2", stringify!($function)),
                    legal: [
                        legality!(@ $i), legality!(@ $m), legality!(@ $c),
                        legality!(@ $f), legality!(@ $t),
                    ],
                };
            )*

            /// The table.
            pub const ALL: &'static [Self] = &[$(Self::$function),*];
        }
    };
}

// The table of FMI 2.0 §4.2.4. What Get and Set may touch also depends on the variable: `variables`.
legality! {
    // state                    Instantiated
    //                          | Initialization
    //                          | | StepComplete
    //                          | | | StepFailed
    //                          | | | | Terminated
    SetDebugLogging:            x x x x x;
    FreeInstance:               x x x x x;
    SetupExperiment:            x - - - -;
    EnterInitializationMode:    x - - - -;
    ExitInitializationMode:     - x - - -;
    Terminate:                  - - x x -;
    Reset:                      x x x x x;
    GetReal:                    - x x x x;
    GetInteger:                 - x x x x;
    GetBoolean:                 - x x x x;
    GetString:                  - x x x x;
    SetReal:                    x x x - -;
    SetInteger:                 x x x - -;
    SetBoolean:                 x x x - -;
    SetString:                  x x x - -;
    GetFMUstate:                x x x x x;
    SetFMUstate:                x x x x x;
    FreeFMUstate:               x x x x x;
    SerializedFMUstateSize:     x x x x x;
    SerializeFMUstate:          x x x x x;
    DeSerializeFMUstate:        x x x x x;
    GetDirectionalDerivative:   - x x x x;
    SetRealInputDerivatives:    x x x - -;
    GetRealOutputDerivatives:   - - x x x;
    DoStep:                     - - x - -;
    CancelStep:                 - - - - -;
    GetStatus:                  - - x x x;
    GetRealStatus:              - - x x x;
    GetIntegerStatus:           - - x x x;
    GetBooleanStatus:           - - x x x;
    GetStringStatus:            - - x x x;
}
