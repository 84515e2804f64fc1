//! The C types of FMI 2.0.
