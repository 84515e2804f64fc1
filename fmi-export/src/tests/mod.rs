//! A toy model driven through the C interface.

mod cart;
mod host;
mod life_cycle;
mod pack;
mod start;
mod states;
mod values;
