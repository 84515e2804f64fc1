//! FMI 2.0 co-simulation FMUs of any maker, loaded and run.
//!
//! [`Archive`] unpacks an FMU and reads its description, and [`Archive::inspect`] says what is in
//! it and what is odd about it, without running its code; [`Fmu`] has its library loaded;
//! [`Instance`] calls it; [`simulate()`] runs one from start to end, [`master`] several coupled;
//! [`ssp`] writes and reads systems of FMUs.
//!
//! ```no_run
//! use fmi_import::{Error, Fmu, Plan, Step, Value, simulate};
//!
//! fn main() -> Result<(), Error> {
//!     let fmu = Fmu::open("spring.fmu".as_ref())?;
//!     for oddity in fmu.archive().inspect().oddities {
//!         eprintln!("{oddity}");
//!     }
//!     // from start to end
//!     let trajectory = simulate(&fmu, &Plan {
//!         start_values: vec![("mass".into(), Value::Real(2.0))],
//!         record: vec!["position".into()],
//!         start_time: 0.0,
//!         stop_time: 10.0,
//!         step: 0.01,
//!         tolerance: None,
//!     })?;
//!     eprintln!("{:?}", trajectory.columns[1].last());
//!
//!     // step by step, and back
//!     let mut spring = fmu.instantiate("spring")?;
//!     spring.setup_experiment(None, 0.0, None)?;
//!     spring.enter_initialization_mode()?;
//!     spring.exit_initialization_mode()?;
//!     let start = spring.get_fmu_state()?;
//!     if let Step::Discarded { log, .. } = spring.do_step(0.0, 0.01)? {
//!         eprintln!("{log:?}");
//!     }
//!     spring.set_fmu_state(&start)
//! }
//! ```
//!
//! The logger of FMI 2.0 is variadic; a C compiler is needed to build the one in `logger.c`.
//! Log lines come with their placeholders filled in and variables by name.
//!
//! Loading an FMU runs its code in this process: an FMU is to be trusted like a program.

mod archive;
mod error;
mod inspect;
mod instance;
mod library;
mod log;
pub mod master;
mod simulate;
pub mod ssp;

pub use archive::Archive;
pub use error::{Error, Status, nearest};
pub use inspect::{Capability, Inspection, Oddity, Severity, UnitRow, VariableRow};
pub use instance::{Instance, SavedState, Step, Value};
pub use library::Fmu;
pub use log::LogLine;
/// The types of [`Fmu::description`].
pub use model_description;
pub use simulate::{Plan, Trajectory, simulate, simulate_with};
