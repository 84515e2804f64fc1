//! FMI 2.0 co-simulation FMUs of any maker, loaded and run.
