//! Free parameters: rows of the tables as variables of a search.

use crate::error::{Error, Result};
use crate::ride::base;
use crate::solver::Limits;
use bicycle::{Excitation, Formulation, Instruments, Parameters, Quantity};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Lower bound of a logarithm over the upper one, where the row's own is not positive.
const LEAST: f64 = 5e-5;

/// The names behind `--free all`.
pub const ALL: [&str; 4] = [
    "cornering_stiffness",
    "camber_stiffness",
    "viscous_friction",
    "coulomb_friction",
];

/// Whether the equations of a formulation have the row called `name`: wheels that do not slip have
/// no tyres.
pub fn has(formulation: Formulation, name: &str) -> bool {
    formulation != Formulation::Whipple || !name.ends_with("_stiffness")
}

/// Those of [`ALL`] that a formulation has.
pub fn all(formulation: Formulation) -> Vec<&'static str> {
    let known = ALL.into_iter().filter(|name| has(formulation, name));
    known.collect()
}

/// Where the value of a free parameter goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    /// Row of [`Parameters`].
    Bicycle(usize),
    /// Row of [`Excitation`].
    Excitation(usize),
    /// Row of [`Instruments`].
    Instruments(usize),
}

impl Place {
    fn of(name: &str) -> Result<Self> {
        Parameters::index(name)
            .map(Self::Bicycle)
            .or_else(|| Excitation::index(name).map(Self::Excitation))
            .or_else(|| Instruments::index(name).map(Self::Instruments))
            .ok_or_else(|| Error::unknown("parameter", name, rows().map(|row| row.name)))
    }

    fn row(self) -> &'static Quantity {
        match self {
            Self::Bicycle(index) => &Parameters::TABLE[index],
            Self::Excitation(index) => &Excitation::TABLE[index],
            Self::Instruments(index) => &Instruments::TABLE[index],
        }
    }
}

/// The rows that can be free, in the order of the tables.
pub fn rows() -> impl Iterator<Item = &'static Quantity> {
    [Parameters::TABLE, Excitation::TABLE, Instruments::TABLE]
        .into_iter()
        .flatten()
}

/// Of how many rides a free parameter is one and the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scope {
    /// Of all.
    Shared,
    /// Of those of one condition.
    Condition,
    /// Of one: each has its own.
    Ride,
}

/// On which scale a parameter is searched, and its interval symmetric.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scale {
    /// Its value.
    Linear,
    /// The logarithm of its value.
    Logarithmic,
}

/// What was known before the ride: a normal distribution of the value.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Prior {
    /// Mean [SI].
    pub mean: f64,
    /// Standard deviation [SI].
    pub deviation: f64,
}

/// Longest change of a free parameter in one step of a search, in variables.
const REACH: f64 = 0.7;

/// The box of a search for `free`, and how far it steps.
pub fn limits<'a>(free: impl IntoIterator<Item = &'a Free>) -> Limits {
    let bounds = |f: &Free| (f.variable(f.lower), f.variable(f.upper));
    let (lower, upper): (Vec<f64>, Vec<f64>) = free.into_iter().map(bounds).unzip();
    Limits {
        reach: DVector::from_element(lower.len(), REACH),
        lower: DVector::from_vec(lower),
        upper: DVector::from_vec(upper),
    }
}

/// A free parameter: its row, its bounds and how it is sought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Free {
    /// The row of the table.
    pub row: &'static Quantity,
    place: Place,
    /// Lower bound [SI].
    pub lower: f64,
    /// Upper bound [SI].
    pub upper: f64,
    /// Of how many rides it is one and the same.
    pub scope: Scope,
    /// The scale of the search.
    pub scale: Scale,
    /// What was known before: normal on the scale of the search.
    pub prior: Option<Prior>,
}

impl Free {
    /// The row called `name`, free within its range.
    pub fn new(name: &str) -> Result<Self> {
        let place = Place::of(name)?;
        let row = place.row();
        let free = Self {
            row,
            place,
            lower: row.min,
            upper: row.max,
            scope: Scope::Shared,
            scale: Scale::Linear,
            prior: None,
        };
        match place {
            Place::Excitation(_) if free.nuisance() => {
                Ok(free.on(Scale::Logarithmic)?.per(Scope::Ride))
            }
            Place::Instruments(_) => Ok(free.per(Scope::Ride)),
            Place::Bicycle(_) | Place::Excitation(_) => Ok(free),
        }
    }

    /// The same, one and the same of other rides.
    #[must_use]
    pub fn per(self, scope: Scope) -> Self {
        Self { scope, ..self }
    }

    /// The same sought on another scale. A logarithm is of what is positive.
    pub fn on(self, scale: Scale) -> Result<Self> {
        if scale == Scale::Logarithmic && self.upper <= 0.0 {
            return Err(self.bounds_error(self.lower, self.upper));
        }
        let least = match scale {
            Scale::Linear => self.lower,
            Scale::Logarithmic => self.lower.max(LEAST * self.upper),
        };
        Ok(Self {
            lower: least,
            scale,
            ..self
        })
    }

    /// The same within `lower` to `upper` [SI].
    pub fn within(self, lower: f64, upper: f64) -> Result<Self> {
        let fits = lower < upper && self.row.admits(lower) && self.row.admits(upper);
        if !fits {
            return Err(self.bounds_error(lower, upper));
        }
        Self {
            lower,
            upper,
            ..self
        }
        .on(self.scale)
    }

    fn bounds_error(&self, lower: f64, upper: f64) -> Error {
        Error::Bounds {
            name: self.row.name.into(),
            lower,
            upper,
            min: self.row.min,
            max: self.row.max,
            unit: self.row.unit.symbol,
        }
    }

    /// The same with `prior`, whose mean lies within the bounds; without one, that of the interval
    /// the literature measured: its middle, and the deviation of a uniform distribution over it.
    pub fn with_prior(self, prior: Option<Prior>) -> Result<Self> {
        let measured = || {
            let (low, high) = self.row.measured?;
            Some(Prior {
                mean: 0.5 * (low + high),
                deviation: (high - low) / 12f64.sqrt(),
            })
        };
        let prior = prior.or_else(measured).ok_or(Error::NoPrior {
            name: self.row.name,
        })?;
        let (mean, deviation) = (prior.mean, prior.deviation);
        let fits = (self.lower..=self.upper).contains(&mean);
        if !(fits && deviation > 0.0 && deviation.is_finite()) {
            return Err(Error::Prior {
                name: self.row.name,
                mean,
                deviation,
                lower: self.lower,
                upper: self.upper,
                unit: self.row.unit.symbol,
            });
        }
        Ok(Self {
            prior: Some(prior),
            ..self
        })
    }

    /// Mean and standard deviation of the prior in the variable of the search.
    pub fn prior_variable(&self) -> Option<(f64, f64)> {
        let prior = self.prior?;
        Some((
            self.variable(prior.mean),
            prior.deviation / self.slope(prior.mean),
        ))
    }

    /// Whether it is a nuisance: estimated for the others' sake, judged by no yardstick.
    pub fn nuisance(&self) -> bool {
        matches!(self.place, Place::Instruments(_)) || self.row.name == "remnant_intensity"
    }

    /// Whether `value` [SI] is at a bound, to a millionth of their distance.
    pub fn at_bound(&self, value: f64) -> bool {
        let edge = 1e-6 * (self.upper - self.lower);
        value - self.lower < edge || self.upper - value < edge
    }

    /// Whether the search runs over the logarithm of the value.
    fn logarithmic(&self) -> bool {
        self.scale == Scale::Logarithmic
    }

    /// A change of the value that counts as one in the search.
    fn unit(&self) -> f64 {
        match self.row.nominal {
            // of an offset a hundredth of its range
            0.0 => 0.01 * (self.row.max - self.row.min),
            nominal => nominal.abs(),
        }
    }

    /// Its row in [`Parameters`], if it is one of the bicycle's.
    pub fn bicycle_index(&self) -> Option<usize> {
        match self.place {
            Place::Bicycle(index) => Some(index),
            Place::Excitation(_) | Place::Instruments(_) => None,
        }
    }

    /// Variable of the search from a value [SI].
    pub fn variable(&self, value: f64) -> f64 {
        if self.logarithmic() {
            value.ln()
        } else {
            value / self.unit()
        }
    }

    /// Value [SI] from a variable of the search.
    pub fn value(&self, variable: f64) -> f64 {
        if self.logarithmic() {
            variable.exp()
        } else {
            variable * self.unit()
        }
    }

    /// Change of the value per change of the variable, at a value [SI].
    pub fn slope(&self, value: f64) -> f64 {
        if self.logarithmic() {
            value
        } else {
            self.unit()
        }
    }

    /// Width of the interval the literature measured, or of the bounds where it measured none.
    pub fn yardstick(&self) -> f64 {
        self.row
            .measured
            .map_or(self.upper - self.lower, |(low, high)| high - low)
    }
}

/// A row that keeps its ratio to a free one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tie {
    follower: Place,
    /// The free row it follows.
    pub leader: &'static Quantity,
}

impl Tie {
    /// `follower` tied to `leader`.
    pub fn new(follower: &str, leader: &str) -> Result<Self> {
        let (follower, leader) = (Place::of(follower)?, Place::of(leader)?);
        if follower == leader {
            return Err(Error::Form {
                expected: "a row tied to another",
                found: format!("{0}={0}", leader.row().name),
            });
        }
        Ok(Self {
            follower,
            leader: leader.row(),
        })
    }

    /// The row that follows.
    pub fn follower(&self) -> &'static Quantity {
        self.follower.row()
    }
}

/// A bicycle, what drives it and what records it, some of it free.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Candidate {
    /// The bicycle.
    pub parameters: Parameters,
    /// What drives it.
    pub excitation: Excitation,
    /// What records it.
    pub instruments: Instruments,
}

impl Candidate {
    /// The value of a free parameter [SI].
    pub fn get(&self, free: &Free) -> f64 {
        self.value(free.place)
    }

    /// Sets a free parameter [SI].
    pub fn set(&mut self, free: &Free, value: f64) {
        self.put(free.place, value);
    }

    fn value(&self, place: Place) -> f64 {
        match place {
            Place::Bicycle(index) => self.parameters.get(index),
            Place::Excitation(index) => self.excitation.get(index),
            Place::Instruments(index) => self.instruments.get(index),
        }
    }

    fn put(&mut self, place: Place, value: f64) {
        match place {
            Place::Bicycle(index) => self.parameters.set(index, value),
            Place::Excitation(index) => self.excitation.set(index, value),
            Place::Instruments(index) => self.instruments.set(index, value),
        }
    }

    /// What `tie` leads from this candidate on: its follower at the ratio that `start` has.
    pub(crate) fn follow(&mut self, tie: &Tie, start: &Self) {
        let leader = Place::of(tie.leader.name).expect("a row");
        let ratio = start.value(tie.follower) / start.value(leader);
        self.put(tie.follower, ratio * self.value(leader));
    }

    /// The same with the free parameters at the variables `z`.
    #[must_use]
    pub fn at(&self, free: &[Free], z: &DVector<f64>) -> Self {
        let mut candidate = self.clone();
        for (free, variable) in free.iter().zip(z.iter()) {
            candidate.set(free, free.value(*variable));
        }
        candidate
    }

    /// The variables of its own values.
    pub fn variables(&self, free: &[Free]) -> DVector<f64> {
        DVector::from_iterator(
            free.len(),
            free.iter()
                .map(|f| f.variable(self.get(f).clamp(f.lower, f.upper))),
        )
    }
}

/// A free parameter of a fit: of all rides, of a condition's or of one ride.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// The free parameter.
    pub free: Free,
    /// The condition or the ride it is of; none: of all.
    pub of: Option<String>,
}

impl fmt::Display for Variable {
    /// `viscous_friction`, or `remnant_intensity of monday.csv`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.free.row.name)?;
        let mut of = self.of.iter().map(|of| base(of));
        of.try_for_each(|of| write!(f, " of {of}"))
    }
}
