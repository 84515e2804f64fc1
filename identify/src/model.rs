//! What stands for the bicycle in a fit.

use crate::error::{Error, Result};
use crate::foreign::{Foreign, Origin};
use crate::objective::Objective;
use serde::{Deserialize, Serialize};

/// Seeds for each ride that is fitted, where nobody says how many.
pub const SEEDS_PER_RIDE: usize = 16;

/// Which rides are simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Seeds {
    /// How many, at least 2; none: [`SEEDS_PER_RIDE`] for each ride that is fitted.
    pub count: Option<usize>,
    /// What their noise follows from.
    pub seed: u64,
}

impl Seeds {
    /// How many there are in a fit of `rides` rides. A single one would be fitted in place of the
    /// bicycle.
    pub fn of(&self, rides: usize) -> Result<usize> {
        match self.count {
            None => Ok(SEEDS_PER_RIDE * rides),
            Some(count) if count >= 2 => Ok(count),
            Some(found) => Err(Error::Form {
                expected: "simulated rides of at least 2 seeds",
                found: found.to_string(),
            }),
        }
    }

    /// By what the covariance of estimates from `rides` rides grows: the mean of K seeds scatters
    /// by a K-th of what a ride does, and is the same for all of them.
    pub fn covariance_factor(&self, rides: usize) -> Result<f64> {
        Ok(1.0 + rides as f64 / self.of(rides)? as f64)
    }
}

/// What stands for the bicycle in a fit.
#[derive(Debug, Clone, Default)]
pub enum Model {
    /// The equations, linearised for spectra.
    #[default]
    Equations,
    /// The equations, simulated for spectra.
    Simulated(Seeds),
    /// An FMU, simulated.
    Foreign(Foreign, Seeds),
}

/// A model on record.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Spec {
    /// The equations, linearised for spectra.
    #[default]
    Equations,
    /// The equations, simulated for spectra.
    Simulated(Seeds),
    /// An FMU, simulated.
    Fmu {
        /// Which.
        #[serde(flatten)]
        origin: Origin,
        /// The seeds of its rides.
        #[serde(flatten)]
        seeds: Seeds,
    },
}

impl Spec {
    /// The seeds of its simulated rides.
    pub fn seeds(&self) -> Option<Seeds> {
        match self {
            Self::Equations => None,
            Self::Simulated(seeds) | Self::Fmu { seeds, .. } => Some(*seeds),
        }
    }

    /// The model: an FMU is loaded, and must be the same to the last byte.
    pub fn open(&self) -> Result<Model> {
        Ok(match self {
            Self::Equations => Model::Equations,
            Self::Simulated(seeds) => Model::Simulated(*seeds),
            Self::Fmu { origin, seeds } => Model::Foreign(Foreign::again(origin)?, *seeds),
        })
    }
}

impl Model {
    /// The FMU, if it is one.
    pub fn foreign(&self) -> Option<&Foreign> {
        match self {
            Self::Equations | Self::Simulated(_) => None,
            Self::Foreign(foreign, _) => Some(foreign),
        }
    }

    /// The seeds of its simulated rides.
    pub fn seeds(&self) -> Option<Seeds> {
        self.spec().seeds()
    }

    /// As it goes on record.
    pub fn spec(&self) -> Spec {
        match self {
            Self::Equations => Spec::Equations,
            Self::Simulated(seeds) => Spec::Simulated(*seeds),
            Self::Foreign(foreign, seeds) => Spec::Fmu {
                origin: foreign.origin().clone(),
                seeds: *seeds,
            },
        }
    }

    /// Refuses an objective that it does not serve.
    pub(crate) fn check(&self, objective: Objective) -> Result<()> {
        use Objective::{Amplitude, Time};
        match self {
            Self::Equations => Ok(()),
            Self::Simulated(_) => objective.check("a simulated spectrum", &[Amplitude]),
            Self::Foreign(..) => objective.check("an FMU as the model", &[Amplitude, Time]),
        }
    }

    /// What a reader of a fit of spectra to `rides` rides should know of it.
    pub fn note(&self, rides: usize) -> Result<Option<String>> {
        let Some(seeds) = self.seeds() else {
            return Ok(None);
        };
        let (count, advised) = (seeds.of(rides)?, SEEDS_PER_RIDE * rides);
        let few = if count < advised {
            format!("; fewer than {advised} let single rides show through")
        } else {
            String::new()
        };
        Ok(Some(format!(
            "the expected spectrum is the mean of {count} simulated rides, whose scatter is in the \
             standard errors{few}"
        )))
    }
}
