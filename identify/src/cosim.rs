//! The bicycle's FMU coupled with others, and ridden: what [`fmi_import::master`] runs, from what
//! was typed to what was recorded.
//!
//! Participants have names. `plant` is the bicycle; where its FMU has the rows of our tables it is
//! known natively too, and a native participant `rider` takes part, who gives `speed` and
//! `steer_torque`: following a course, with a remnant, or holding what the bicycle starts with.

mod archive;
mod coupling;
mod derivatives;
mod guard;
mod modes;
mod opening;
mod page;
mod plant;
mod realization;
mod record;
mod rider;
mod setup;
mod study;
mod wires;

pub use archive::write_ssp;
pub use coupling::{Begun, Coupling, Ran, Variation};
pub use guard::{Hung, guarded};
pub use modes::Modes;
pub use page::html;
pub use setup::{Setup, Typed, algorithm};
pub use study::{Cases, study};

/// Name of the participant that is the bicycle.
pub const PLANT: &str = "plant";
/// Name of the participant that is the native rider.
pub const RIDER: &str = "rider";
