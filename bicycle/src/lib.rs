//! The bicycle with a rear load: one parameter table, the paper's nonlinear equations and the
//! four-body bicycle of the literature, a stepper.
//!
//! Signs are ISO 8855: x forward, y left, z up, origin at the rear contact point; roll > 0 leans
//! right, steer > 0 and yaw > 0 turn left. Units are SI. The equations, as printed and as coded,
//! stand side by side in `EQUATIONS.md`.
//!
//! The crate is pure: no files, clocks, threads or FMI words, and nothing in it can fail. What ends
//! a simulation early is a value ([`simulate::Stop`]), and so is a refusal to start
//! ([`simulate::Refusal`]).
//!
//! ```
//! use bicycle::{Formulation, Input, Parameters, simulate::Simulation};
//!
//! let parameters = Parameters { roll_start: 0.02, ..Parameters::default() };
//! let mut ride = Simulation::new(&parameters, Formulation::Repaired, Input::default(), 0.0)?;
//! ride.advance(5.0)?;
//! assert!(ride.state().roll.abs() < 0.01); // the rider law stands the bicycle up again
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]
#![allow(
    clippy::inline_always,
    reason = "lanes become vector instructions only where all is inlined into one function"
)]

pub mod batch;
pub mod cases;
pub mod course;
pub mod dynamics;
pub mod lanes;
pub mod linear;
pub mod mass;
pub mod modes;
pub mod parameters;
pub mod quantity;
pub mod real;
pub mod rider;
pub mod sensitivity;
pub mod simulate;
pub mod state;
pub mod tyre;
pub mod whipple;

pub use dynamics::{Bicycle, Formulation};
pub use parameters::{Excitation, Instruments, Parameters};
pub use quantity::{Quantity, Unit, Variability};
pub use real::Real;
pub use state::{Derived, Input, Output, Path, State};
