//! How well a fitted model foretells what it was not fitted to.

pub mod criteria;
pub mod residual;
