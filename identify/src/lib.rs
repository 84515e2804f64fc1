//! Rides in; parameters with their uncertainty and a report out.
#![deny(unsafe_code)]

pub mod bicycles;
pub mod closed_loop;
pub mod csv;
pub mod error;
pub mod file;
pub mod fit;
pub mod free;
pub mod inspect;
pub mod map;
pub mod objective;
pub mod ride;
pub mod run;
pub mod solver;
pub mod spectrum;
pub mod synthesis;
pub mod unit;
pub mod verdict;
