//! Any Rust model behind FMI 2.0 co-simulation.
//!
//! Implement [`Model`], write [`export!`]`(YourModel);` in a `cdylib`, and [`Package`] puts the
//! library and its modelDescription.xml into an FMU. The life cycle, the rules for each variable,
//! logging, and everything a caller can do wrong are handled here:
//!
//! - [`Instance`] is the safe life cycle; what is legal when stands in one table, `life_cycle`.
//! - `ffi` turns pointers into slices and errors into a status and one log line. It holds all
//!   unsafe code of this crate.
//!
//! An FMI value reference is a row number: variable `i` of the description (counted from 0) has
//! value reference `i`.

mod date;
mod error;
mod export;
#[doc(hidden)]
pub mod ffi;
mod instance;
mod life_cycle;
mod log;
mod model;
mod pack;
mod variables;

/// The C types, for the functions that [`export!`] makes.
#[doc(hidden)]
pub use fmi2;

pub use error::Error;
pub use instance::{Experiment, Instance, Scalar};
pub use life_cycle::{Function, State};
pub use log::log_categories;
pub use model::{Flow, Model, Value};
pub use pack::Package;

#[cfg(test)]
mod tests;
