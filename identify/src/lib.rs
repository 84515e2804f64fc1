//! Rides in; parameters with their uncertainty and a report out.
#![deny(unsafe_code)]
#![allow(
    clippy::inline_always,
    reason = "lanes become vector instructions only where all is inlined into one function"
)]

pub mod assist;
pub mod batch;
pub mod bench;
pub mod bicycles;
pub mod checkpoint;
pub mod closed_loop;
pub mod compare;
pub mod cosim;
pub mod course;
mod csv;
mod distribution;
pub mod effort;
pub mod error;
pub mod figure;
pub mod file;
pub mod fit;
pub mod foreign;
pub mod free;
pub mod import;
pub mod inspect;
pub mod kernel;
pub mod map;
mod mat;
pub mod model;
pub mod objective;
mod parquet;
pub mod plan;
pub mod problem;
pub mod progress;
pub mod report;
pub mod ride;
pub mod run;
pub mod solver;
pub mod spectrum;
pub mod speed;
pub mod stability;
pub mod starts;
pub mod stop;
pub mod study;
pub mod synthesis;
pub mod trajectory;
pub mod trust;
pub mod unit;
pub mod validate;
pub mod variable;
pub mod verdict;
