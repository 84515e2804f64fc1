//! Free parameters: rows of the tables as variables of a search.

use crate::error::{Error, Result};
use bicycle::{Excitation, Formulation, Parameters, Quantity};
use nalgebra::DVector;

/// The remnant's intensity is searched by its logarithm, so its lower bound cannot be 0.
const LEAST_INTENSITY: f64 = 1e-3;

/// The names behind `--free all`.
pub const ALL: [&str; 4] = [
    "cornering_stiffness",
    "camber_stiffness",
    "viscous_friction",
    "coulomb_friction",
];

/// Those of them that a formulation has: wheels that do not slip have no tyres.
pub fn all(formulation: Formulation) -> Vec<&'static str> {
    let slips = formulation != Formulation::Whipple;
    let known = |name: &&str| slips || !name.ends_with("_stiffness");
    ALL.into_iter().filter(known).collect()
}

/// Where the value of a free parameter goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    /// Row of [`Parameters`].
    Bicycle(usize),
    /// Row of [`Excitation`].
    Excitation(usize),
}

/// A free parameter: its row and bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Free {
    /// The row of the table.
    pub row: &'static Quantity,
    place: Place,
    /// Lower bound [SI].
    pub lower: f64,
    /// Upper bound [SI].
    pub upper: f64,
}

impl Free {
    /// The row called `name`, free within its range.
    pub fn new(name: &str) -> Result<Self> {
        let place = Parameters::index(name)
            .map(Place::Bicycle)
            .or_else(|| Excitation::index(name).map(Place::Excitation))
            .ok_or_else(|| {
                let rows = Parameters::TABLE.iter().chain(Excitation::TABLE);
                Error::unknown("parameter", name, rows.map(|row| row.name))
            })?;
        let row = match place {
            Place::Bicycle(index) => &Parameters::TABLE[index],
            Place::Excitation(index) => &Excitation::TABLE[index],
        };
        let mut free = Self {
            row,
            place,
            lower: row.min,
            upper: row.max,
        };
        if free.logarithmic() {
            free.lower = free.lower.max(LEAST_INTENSITY);
        }
        Ok(free)
    }

    /// The same within `lower` to `upper` [SI].
    pub fn within(self, lower: f64, upper: f64) -> Result<Self> {
        let Self { row, .. } = self;
        if lower < upper && row.admits(lower) && row.admits(upper) {
            let lower = if self.logarithmic() {
                lower.max(LEAST_INTENSITY)
            } else {
                lower
            };
            return Ok(Self {
                lower,
                upper,
                ..self
            });
        }
        let (name, unit) = (row.name.to_owned(), row.unit.symbol);
        Err(Error::Bounds {
            name,
            lower,
            upper,
            min: row.min,
            max: row.max,
            unit,
        })
    }

    /// Whether the search runs over the logarithm of the value.
    fn logarithmic(&self) -> bool {
        self.row.name == "remnant_intensity"
    }

    /// Whether it is a nuisance: estimated for the others' sake, judged by no yardstick.
    pub fn nuisance(&self) -> bool {
        self.logarithmic()
    }

    /// A change of the value that counts as one in the search.
    fn scale(&self) -> f64 {
        match self.row.nominal {
            0.0 => self.upper - self.lower,
            nominal => nominal.abs(),
        }
    }

    /// Its row in [`Parameters`], if it is one of the bicycle's.
    pub fn bicycle_index(&self) -> Option<usize> {
        match self.place {
            Place::Bicycle(index) => Some(index),
            Place::Excitation(_) => None,
        }
    }

    /// Variable of the search from a value [SI].
    pub fn variable(&self, value: f64) -> f64 {
        if self.logarithmic() {
            value.ln()
        } else {
            value / self.scale()
        }
    }

    /// Value [SI] from a variable of the search.
    pub fn value(&self, variable: f64) -> f64 {
        if self.logarithmic() {
            variable.exp()
        } else {
            variable * self.scale()
        }
    }

    /// Change of the value per change of the variable, at a value [SI].
    pub fn slope(&self, value: f64) -> f64 {
        if self.logarithmic() {
            value
        } else {
            self.scale()
        }
    }

    /// Width of the interval the literature measured, or of the bounds where it measured none.
    pub fn yardstick(&self) -> f64 {
        self.row
            .measured
            .map_or(self.upper - self.lower, |(low, high)| high - low)
    }
}

/// A bicycle and what drives it, some of it free.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The bicycle.
    pub parameters: Parameters,
    /// What drives it.
    pub excitation: Excitation,
}

impl Candidate {
    /// The value of a free parameter [SI].
    pub fn get(&self, free: &Free) -> f64 {
        match free.place {
            Place::Bicycle(index) => self.parameters.get(index),
            Place::Excitation(index) => self.excitation.get(index),
        }
    }

    /// Sets a free parameter [SI].
    pub fn set(&mut self, free: &Free, value: f64) {
        match free.place {
            Place::Bicycle(index) => self.parameters.set(index, value),
            Place::Excitation(index) => self.excitation.set(index, value),
        }
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
