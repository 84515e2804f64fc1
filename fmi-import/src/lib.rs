//! FMI 2.0 co-simulation FMUs of any maker, loaded and run.
//!
//! [`Archive`] unpacks an FMU and reads its description; [`Fmu`] has its library loaded;
//! [`Instance`] calls it; [`simulate()`] runs one from start to end.
//!
//! Loading an FMU runs its code in this process: an FMU is to be trusted like a program.

mod archive;
mod error;
mod instance;
mod library;
mod simulate;

pub use archive::Archive;
pub use error::{Error, LogLine, Status};
pub use instance::{Instance, Step, Value};
pub use library::Fmu;
pub use simulate::{Plan, Trajectory, simulate};
