#![doc = include_str!("../README.md")]
//!
//! ## Where things are
//! - [`Model`] is what you implement, [`variables!`] and [`enumeration!`] the table, [`export!`] the C functions.
//! - [`Instance`] is the safe life cycle; what is legal when stands in one table, `life_cycle`.
//! - `ffi` turns pointers into slices and errors into a status and one log line. It holds all
//!   unsafe code of this crate.
//! - [`Package`] puts library, description and further files into an FMU.
//!
//! An FMI value reference is a row number: variable `i` of the description (counted from 0) has
//! value reference `i`.

mod class;
mod date;
mod error;
mod experiment;
mod export;
#[doc(hidden)]
pub mod ffi;
mod instance;
mod library;
mod life_cycle;
mod log;
mod model;
mod pack;
mod resources;
mod saved;
mod scalar;
mod start;
mod table;
mod variables;

/// The C types, for the functions that [`export!`] makes.
#[doc(hidden)]
pub use fmi2;
pub use model_description;
/// For the derives that [`variables!`] makes.
#[doc(hidden)]
pub use serde;

pub use error::Error;
pub use experiment::Experiment;
pub use instance::Instance;
pub use library::{Glibc, Library, Warning};
pub use life_cycle::{Function, State};
pub use log::log_categories;
pub use model::{Flow, Kind, Model, Value};
pub use pack::Package;
pub use scalar::{Choices, Scalar};
pub use table::{Row, co_simulation, describe, xml};

#[cfg(test)]
mod tests;
