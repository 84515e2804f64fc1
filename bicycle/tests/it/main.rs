//! The laws of the model, its numbers and its documents.

mod cases;
mod course;
mod draw;
mod equations;
mod follow;
mod grid;
mod jumps;
mod laws;
mod linear;
mod marked;
mod mass;
mod modes;
mod preview;
mod published;
mod ramp;
mod saved;
mod section3;
mod sensitivity;
mod stepper;
mod stops;
mod tables;
mod tyre;
mod whipple;
