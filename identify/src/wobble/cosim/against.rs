//! What the controller is worth: `wobble cosim --against none`.

use crate::arguments::values;
use anyhow::Result;
use clap::Args;
use identify::cosim::{Cases, Coupling};
use identify::spectrum::{Line, Recipe};

/// What the rides with the controller are held against, and which.
#[derive(Args)]
pub struct StudyArguments {
    /// Ride every trail and load without and with the controller, and say what it is worth
    #[arg(long, value_name = "none", value_parser = ["none"], conflicts_with = "ssp")]
    against: Option<String>,
    /// Trails of the study [default: .13,.085,-.035]
    #[arg(
        long,
        value_name = "LENGTHS",
        value_delimiter = ',',
        requires = "against",
        allow_hyphen_values = true
    )]
    trails: Option<Vec<String>>,
    /// Loads of the study [default: 0,10kg,20kg,30kg]
    #[arg(
        long,
        value_name = "MASSES",
        value_delimiter = ',',
        requires = "against",
        allow_hyphen_values = true
    )]
    loads: Option<Vec<String>>,
    /// Rides of each case, each with a seed of its own [default: 4]
    #[arg(long, value_name = "NUMBER", requires = "against", value_parser = clap::value_parser!(u64).range(1..=1000))]
    rides: Option<u64>,
}

impl StudyArguments {
    /// Whether a study was asked for.
    pub fn is_asked(&self) -> bool {
        self.against.is_some()
    }

    /// The cases asked for, if a study is.
    pub fn cases(&self, recipe: Recipe) -> Result<Option<Cases>> {
        if !self.is_asked() {
            return Ok(None);
        }
        let default = Cases::default();
        Ok(Some(Cases {
            trails: match &self.trails {
                Some(texts) => values("--trails", texts, "trail")?,
                None => default.trails,
            },
            loads: match &self.loads {
                Some(texts) => values("--loads", texts, "rear_load")?,
                None => default.loads,
            },
            rides: self.rides.unwrap_or(default.rides),
            recipe,
            ..default
        }))
    }
}

/// Sees to it that something excites the bicycle, and that a slalom is not taken for a residual.
pub fn prepare(coupling: &mut Coupling, cases: &mut Cases) {
    if let Some(frequency) = coupling.slalom().filter(|_| cases.recipe.lines.is_empty()) {
        cases.recipe.lines.push(Line { frequency });
        eprintln!("note: --line {frequency:.4}Hz: the slalom is masked");
    }
    let course = coupling.has_course();
    let remnant = coupling
        .bicycle
        .as_ref()
        .map_or(0.0, |b| b.excitation.remnant_intensity);
    if course && remnant == 0.0 && cases.rides > 1 {
        cases.rides = 1;
        eprintln!("note: --rides 1: without a remnant all rides of a course are the same");
    }
    if let Some(bicycle) = coupling.bicycle.as_mut().filter(|_| !course)
        && bicycle.excitation.remnant_intensity == 0.0
    {
        bicycle.excitation.remnant_intensity = REMNANT;
        eprintln!("note: remnant_intensity = {REMNANT} N.m: nothing else excites the bicycle");
    }
}

/// Remnant of a ride in which nothing else was asked for [N m rms]: some 3° of steering.
const REMNANT: f64 = 1.2;
