//! What the tests from outside share: an importer in miniature, and what the fuzzer and its
//! corpus's replay do with bytes.

pub mod fuzz;
mod slave;
pub mod symbols;

pub use slave::{Line, Slave, State, bicycle};
