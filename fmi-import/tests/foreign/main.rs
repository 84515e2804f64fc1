//! An FMU that is not ours: C, compiled when the tests run.
#![cfg(unix)]

mod build;
mod calls;
mod described;
mod inspected;
mod life;
mod simulated;
mod states;
