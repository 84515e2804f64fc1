//! Any Rust model behind FMI 2.0 co-simulation.
