//! The laws of the model, its numbers and its documents.

mod draw;
mod equations;
mod grid;
mod jumps;
mod laws;
mod linear;
mod marked;
mod mass;
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
