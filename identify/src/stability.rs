//! Stability of riding upright: eigenvalues by mode over speed and over any row of the parameter
//! table, and the speeds at which weave and capsize change between growth and decay.

pub mod linear;
mod page;
mod sweep;
pub mod words;

pub use page::html;
pub use sweep::{Sweep, points};

use crate::bicycles::{self, Bicycle};
use crate::error::Result;
use bicycle::modes::{self, Root};
use bicycle::simulate::check;
use bicycle::{Formulation, Input, Parameters, Quantity};

/// Points a sweep or a map may have: some seconds of work, tens of MB of JSON.
pub const MOST_POINTS: usize = 100_000;
/// Speeds [m/s] between which weave and capsize speed are looked for where one speed is asked for.
const SEARCHED: (f64, f64) = (0.1, 20.0);

/// What is asked.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The bicycle.
    pub parameters: Parameters,
    /// Its equations.
    pub formulation: Formulation,
    /// Speeds [m/s].
    pub speeds: Vec<f64>,
    /// The row that is swept besides, and its values.
    pub sweep: Option<Sweep>,
    /// Whether the rider law of the bicycle acts.
    pub rider_law: bool,
}

impl Plan {
    /// The bicycle of `set`, hands off.
    pub fn new(set: &Bicycle, speeds: Vec<f64>) -> Self {
        Self {
            parameters: set.parameters,
            formulation: set.formulation,
            speeds,
            sweep: None,
            rider_law: false,
        }
    }

    /// The bicycle of `parameters` as the plan rides it.
    fn bicycle(&self, parameters: &Parameters) -> bicycle::Bicycle {
        let p = if self.rider_law {
            *parameters
        } else {
            parameters.riderless()
        };
        bicycle::Bicycle::new(&p, self.formulation)
    }
}

/// The eigenvalues of a bicycle at one speed.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Value of the swept row [SI].
    pub value: Option<f64>,
    /// Speed [m/s].
    pub speed: f64,
    /// Eigenvalues with their modes, in the order of [`modes::over_speeds`].
    pub roots: Vec<Root>,
}

impl Point {
    /// Largest real part [1/s]: growth of what grows fastest.
    pub fn growth(&self) -> f64 {
        let parts = self.roots.iter().map(|root| root.value.re);
        parts.fold(f64::NEG_INFINITY, f64::max)
    }
}

/// The weave and the capsize speed of one bicycle, and where it is stable.
#[derive(Debug, Clone, PartialEq)]
pub struct Crossing {
    /// Value of the swept row [SI].
    pub value: Option<f64>,
    /// Lowest speed [m/s] from which weave, unstable below, decays; none in the range.
    pub weave_speed: Option<f64>,
    /// Lowest speed [m/s] from which capsize, stable below, grows; none in the range.
    pub capsize_speed: Option<f64>,
    /// Speeds [m/s], from and to, at which every mode decays.
    pub stable_speeds: Vec<[f64; 2]>,
}

/// What was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Stability {
    /// The row that was swept.
    pub row: Option<&'static Quantity>,
    /// A point for each speed of each value, speeds fastest.
    pub points: Vec<Point>,
    /// One for each value of the row, or one.
    pub crossings: Vec<Crossing>,
    /// Between which speeds [m/s] the crossings were looked for.
    pub searched: (f64, f64),
    /// What the numbers rest on and what is odd about them, a clause each.
    pub notes: Vec<String>,
}

/// Eigenvalues by mode at every speed, for every value of the swept row. Jumps (Coulomb friction,
/// sign θ) have no linear part and are left out. An error names the value at which the bicycle
/// cannot be: its front wheel in the air, a body of no matter, a speed its equations divide by.
pub fn stability(plan: &Plan) -> Result<Stability> {
    let count = plan.speeds.len() * plan.sweep.as_ref().map_or(1, |sweep| sweep.values.len());
    if count == 0 || count > MOST_POINTS {
        return Err(sweep::too_many(format!("{count} points")));
    }
    let fold = |f: fn(f64, f64) -> f64| plan.speeds.iter().copied().reduce(f).unwrap_or(0.0);
    let (slowest, fastest) = (fold(f64::min), fold(f64::max));
    let searched = if slowest < fastest {
        (slowest, fastest)
    } else {
        SEARCHED
    };
    let mut found = Stability {
        row: plan.sweep.as_ref().map(|sweep| sweep.row),
        points: Vec::with_capacity(count),
        crossings: Vec::new(),
        searched,
        notes: Vec::new(),
    };
    let values = sweep::values(plan)?;
    let mut ridden = Vec::with_capacity(values.len());
    for (value, parameters) in &values {
        let b = ready(plan, parameters, (slowest, fastest)).map_err(|cause| match found.row {
            Some(row) => cause.typed(sweep::at(row, *value)),
            None => cause,
        })?;
        ridden.push(b);
    }
    let all = match &plan.sweep {
        None => vec![modes::over_speeds(&ridden[0], &plan.speeds)],
        Some(sweep) => {
            let at = |value| plan.bicycle(&sweep.apply(&plan.parameters, value));
            let own = plan.parameters.get(sweep.index());
            modes::over_values(&at, own, &sweep.values, &plan.speeds)
        }
    };
    for (((value, _), b), rows) in values.iter().zip(&ridden).zip(all) {
        let value = *value;
        let points = plan.speeds.iter().zip(rows);
        found.points.extend(points.map(|(speed, roots)| Point {
            value,
            speed: *speed,
            roots,
        }));
        let speeds = modes::crossings(b, searched.0, searched.1);
        found.crossings.push(Crossing {
            value,
            weave_speed: speeds.weave,
            capsize_speed: speeds.capsize,
            stable_speeds: modes::stable_speeds(b, searched.0, searched.1),
        });
    }
    found.notes = words::notes(plan, &found);
    // of a bicycle alone it is said when it is opened
    if let Some(row) = found.row {
        let loads = values.iter().zip(&ridden);
        let lightest = loads.min_by(|a, b| a.1.front_load.total_cmp(&b.1.front_load));
        let said = lightest.and_then(|((value, _), b)| {
            bicycles::light_front(b, &format!(" at {}", sweep::at(row, *value)))
        });
        found.notes.extend(said);
    }
    Ok(found)
}

/// The bicycle, if it can be ridden at these speeds.
fn ready(
    plan: &Plan,
    parameters: &Parameters,
    (slowest, fastest): (f64, f64),
) -> Result<bicycle::Bicycle> {
    let b = plan.bicycle(parameters);
    check(&b, slowest)?;
    let row = &Input::TABLE[Input::index("speed").expect("an input")];
    bicycles::admit(row, fastest)?;
    Ok(b)
}

#[cfg(test)]
mod tests;
