//! The house from outside.

mod cases;
mod claims;
mod coupling;
mod fmu;
mod fuzz;
mod packing;
mod program;
mod readme;
mod recorded;
mod recovery;
mod spectra;
mod wobble;
