//! How far an estimate can be trusted, beyond its standard error: profiles of the cost, rides made
//! again from the fitted model, and which parameters the data can do without.

pub mod bootstrap;
pub mod distribution;
pub mod insensitivity;
pub mod profile;
