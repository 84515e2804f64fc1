//! The house from outside.

mod calibration;
mod cases;
mod claims;
mod controllers;
mod cosim;
mod coupling;
mod exported;
mod fmu;
mod foreign_model;
mod fuzz;
#[path = "../../bicycle/tests/it/marked.rs"]
mod marked;
mod packing;
mod program;
mod readme;
mod recorded;
mod recovery;
mod resume;
mod rides;
mod several;
mod spectra;
mod wobble;
