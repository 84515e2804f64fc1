//! The rear-load bicycle as an FMU.
