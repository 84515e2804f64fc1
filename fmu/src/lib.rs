//! The rear-load bicycle as an FMU: `RearLoadBicycle.fmu`.
//!
//! Everything an importer sees comes from the tables of `bicycle`: a value reference is a row
//! number, counted through parameters, formulation, inputs, outputs, locals and time.
//! As a shared library this crate is the binary of the FMU; as a Rust library it packs it.

mod dependencies;
mod description;
mod documentation;
mod model;
mod package;
mod row;

pub use description::{MODEL_IDENTIFIER, Starts, unit};
/// What packs any model.
pub use fmi_export::{Library, Package};
pub use model::RearLoadBicycle;
pub use package::{Error, built_library, pack, package};

fmi_export::export!(RearLoadBicycle);
