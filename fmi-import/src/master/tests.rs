//! The master over native participants with closed solutions.

mod lag;
mod runs;
mod wires;
