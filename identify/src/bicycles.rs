//! Named bicycles: TOML inside the program, and files in the same form.
//!
//! A bicycle file has a `name`, and its masses as exactly one of
//!
//! - `[lumps]`: the six lumped rows of the parameter table, `about = "cog"` or `"rear_contact"`;
//! - `[bodies.bicycle]` (`mass`, `x`, `h`, own `roll_inertia`, `yaw_inertia`, `cross_inertia`; x
//!   forward of the rear contact, h up), perhaps with `[bodies.rider]` (`mass`, `height`);
//! - `[bodies.literature]`: the 25 parameters of Meijaard et al. 2007, **z down**, with
//!   `rider_included`; perhaps a rider besides.
//!
//! Further `[parameters]` (any other row), `[inputs]` (start values), `formulation`,
//! `law_in_loop`, `description`, `source`. Values are numbers in SI or texts with a unit. A row
//! that is not given has its nominal value.

mod export;
#[cfg(test)]
mod tests;
mod written;

use crate::error::{self, Error, Result};
use crate::file;
use crate::unit;
use bicycle::mass::Body;
use bicycle::quantity::{KG, M, Quantity};
use bicycle::simulate;
use bicycle::{Excitation, Formulation, Input, Parameters};
use written::Written;

/// The bicycles inside the program: name and text.
pub const SHIPPED: &[(&str, &str)] = &[
    ("nominal", include_str!("../bicycles/nominal.toml")),
    ("section3", include_str!("../bicycles/section3.toml")),
    ("sbw-delft", include_str!("../bicycles/sbw-delft.toml")),
    ("benchmark", include_str!("../bicycles/benchmark.toml")),
    (
        "balanceassistv1",
        include_str!("../bicycles/balanceassistv1.toml"),
    ),
    ("browser", include_str!("../bicycles/browser.toml")),
    (
        "browser-jason",
        include_str!("../bicycles/browser-jason.toml"),
    ),
    ("rigidcl", include_str!("../bicycles/rigidcl.toml")),
    (
        "rigidcl-luke",
        include_str!("../bicycles/rigidcl-luke.toml"),
    ),
    ("fisher", include_str!("../bicycles/fisher.toml")),
    ("pista", include_str!("../bicycles/pista.toml")),
    ("silver", include_str!("../bicycles/silver.toml")),
    ("yellow", include_str!("../bicycles/yellow.toml")),
];

/// Share of the weight on the front wheel below which that is said.
const LIGHT: f64 = 0.05;

/// A bicycle ready to ride.
#[derive(Debug, Clone, PartialEq)]
pub struct Bicycle {
    /// Its name.
    pub name: String,
    /// What it is.
    pub description: String,
    /// Where its values come from.
    pub source: String,
    /// The parameters.
    pub parameters: Parameters,
    /// What excites it where nobody measured the torque.
    pub excitation: Excitation,
    /// The start values of the inputs.
    pub input: Input,
    /// The equations it moves by.
    pub formulation: Formulation,
    /// Whether a recorded steer torque acts besides the rider law, which closes on the simulated
    /// state (true), or is the whole torque (false). A ride that says so itself is right.
    pub law_in_loop: bool,
    /// What was changed in a way that may surprise, in words.
    pub notes: Vec<String>,
}

/// What is changed of a bicycle on the command line, as typed; applied in this order.
#[derive(Debug, Clone, Default)]
pub struct Changes {
    /// `--rider 75kg,1.78m`.
    pub rider: Option<String>,
    /// `--load 20kg`.
    pub load: Option<String>,
    /// `--set name=value`, in the order typed.
    pub set: Vec<String>,
    /// `--formulation whipple`.
    pub formulation: Option<String>,
}

impl Changes {
    /// Makes them, but for the rider's.
    fn apply(&self, bicycle: &mut Bicycle) -> Result<()> {
        if let Some(typed) = &self.load {
            let assigned = bicycle.assign("rear_load", typed);
            assigned.map_err(|e| e.typed(format!("--load {typed}")))?;
        }
        for typed in &self.set {
            let set = bicycle.set(typed);
            set.map_err(|e| e.typed(format!("--set {typed}")))?;
        }
        if let Some(typed) = &self.formulation {
            let known = formulation(typed);
            bicycle.formulation = known.map_err(|e| e.typed(format!("--formulation {typed}")))?;
        }
        let checked = bicycle.check();
        checked.map_err(|e| {
            let typed = self.words();
            if typed.is_empty() { e } else { e.typed(typed) }
        })
    }

    /// As they were typed.
    fn words(&self) -> String {
        let flag = |flag: &str, value: &String| format!("{flag} {value}");
        let load = self.load.iter().map(|value| flag("--load", value));
        let set = self.set.iter().map(|value| flag("--set", value));
        let formulation = self.formulation.iter();
        let formulation = formulation.map(|value| flag("--formulation", value));
        load.chain(set)
            .chain(formulation)
            .collect::<Vec<_>>()
            .join(" ")
    }
}

impl Bicycle {
    /// The bicycle called `name`, one inside the program or a file, with `changes`.
    pub fn open(name: &str, changes: &Changes) -> Result<Self> {
        let (file, text) = file::named("bicycle", SHIPPED, name)?;
        Self::parse(&file, &text, changes)
    }

    /// The bicycle written in `text`, with `changes`; `file` names it in errors.
    pub fn parse(file: &str, text: &str, changes: &Changes) -> Result<Self> {
        let written: Written = ::toml::from_str(text).map_err(|e| error::toml(file, text, &e))?;
        let rider = match &changes.rider {
            Some(typed) => {
                let body = rider(typed).map_err(|e| e.typed(format!("--rider {typed}")))?;
                Some((body, format!("--rider {typed}")))
            }
            None => None,
        };
        let mut bicycle = Self::build(written, rider).map_err(|e| match e {
            e @ Error::Argument { .. } => e,
            e => e.in_file(file),
        })?;
        bicycle.change(changes)?;
        Ok(bicycle)
    }

    fn build(mut written: Written, rider: Option<(Body, String)>) -> Result<Self> {
        let mut masses = written.masses()?;
        if let Some((rider, argument)) = rider {
            masses.put_on(rider).map_err(|why| {
                Error::Rider {
                    bicycle: written.name.clone(),
                    why,
                }
                .typed(argument)
            })?;
        }
        let mut bicycle = Self {
            name: written.name,
            description: written.description,
            source: written.source,
            parameters: Parameters::default(),
            excitation: Excitation::default(),
            input: Input::default(),
            formulation: Formulation::default(),
            law_in_loop: written.law_in_loop,
            notes: Vec::new(),
        };
        if let Some(name) = &written.formulation {
            bicycle.formulation = formulation(name)?;
        }
        // the rows the masses determine are those they write
        let mut determined = Parameters::from_array([f64::NAN; Parameters::LEN]);
        masses.write(&mut determined);
        masses.write(&mut bicycle.parameters);
        for (index, row) in Parameters::TABLE.iter().enumerate() {
            let value = determined.get(index);
            if value.is_nan() {
                continue;
            }
            if written.parameters.contains_key(row.name) {
                return Err(Error::Overdetermined {
                    name: row.name,
                    by: masses.section(),
                });
            }
            admit(row, value)?;
        }
        for (name, value) in &written.parameters {
            let index = Parameters::index(name)
                .ok_or_else(|| Error::unknown("parameter", name, names(Parameters::TABLE)))?;
            let row = &Parameters::TABLE[index];
            bicycle
                .parameters
                .set(index, admit(row, value.si(row.unit, row.name)?)?);
        }
        for (name, value) in &written.inputs {
            let index = Input::index(name)
                .ok_or_else(|| Error::unknown("input", name, names(Input::TABLE)))?;
            let row = &Input::TABLE[index];
            bicycle
                .input
                .set(index, admit(row, value.si(row.unit, row.name)?)?);
        }
        Ok(bicycle)
    }

    /// Makes changes, but for another rider, and checks what comes of them.
    pub fn change(&mut self, changes: &Changes) -> Result<()> {
        changes.apply(self)
    }

    /// Applies `name=value`: a parameter, a row of the excitation, the start value of an input, or
    /// `formulation`. The value is SI unless it carries a unit.
    pub fn set(&mut self, assignment: &str) -> Result<()> {
        let form = || Error::Form {
            expected: "name=value",
            found: assignment.into(),
        };
        let (name, value) = assignment.split_once('=').ok_or_else(form)?;
        self.assign(name.trim(), value.trim())
    }

    fn assign(&mut self, name: &str, text: &str) -> Result<()> {
        let read = |row: &Quantity| admit(row, unit::parse(text, row.unit, row.name)?);
        if let Some(index) = Parameters::index(name) {
            let row = &Parameters::TABLE[index];
            self.parameters.set(index, read(row)?);
            if ["total_mass", "cog_to_rear", "cog_height"].contains(&name) {
                self.notes.push(format!(
                    "{name} alone was set to {text}: the inertias about the rear contact stay what they were",
                ));
            }
        } else if let Some(index) = Excitation::index(name) {
            self.excitation.set(index, read(&Excitation::TABLE[index])?);
        } else if let Some(index) = Input::index(name) {
            self.input.set(index, read(&Input::TABLE[index])?);
        } else if name == FORMULATION {
            self.formulation = formulation(text)?;
        } else {
            let tables = [Parameters::TABLE, Excitation::TABLE, Input::TABLE];
            let known = tables.into_iter().flat_map(names).chain([FORMULATION]);
            return Err(Error::unknown("parameter", name, known));
        }
        Ok(())
    }

    /// Refuses a bicycle that cannot be, for single rows may be set to that: a body that no matter
    /// makes, a lifted wheel, a speed its formulation does not know. Notes one whose front wheel
    /// carries little.
    pub fn check(&mut self) -> Result<()> {
        let p = &self.parameters;
        let bicycle = bicycle::Bicycle::new(p, self.formulation);
        simulate::check(&bicycle, self.input.speed)?;
        self.notes.extend(light_front(&bicycle, ""));
        Ok(())
    }
}

/// Says so where the front wheel carries little; `place` says where, ` at rear_load = 30 kg`.
pub(crate) fn light_front(bicycle: &bicycle::Bicycle, place: &str) -> Option<String> {
    let load = bicycle.front_load;
    let share = load / (load + bicycle.rear_wheel_load);
    (share < LIGHT).then(|| {
        format!(
            "the front wheel carries {:.1} % of the weight ({load:.0} N){place}: little is left to \
             steer with",
            100.0 * share
        )
    })
}

/// The row that chooses the equations: of a file, of the command line, of the FMU.
pub(crate) const FORMULATION: &str = "formulation";

fn names(table: &'static [Quantity]) -> impl Iterator<Item = &'static str> {
    table.iter().map(|row| row.name)
}

/// The formulation called `name`.
pub fn formulation(name: &str) -> Result<Formulation> {
    name.parse()
        .map_err(|_| Error::unknown(FORMULATION, name, Formulation::ALL.map(Formulation::name)))
}

/// A rider as typed: mass and height, `75kg,1.78m`.
fn rider(typed: &str) -> Result<Body> {
    let form = || Error::Form {
        expected: "mass,height such as 75kg,1.78m",
        found: typed.into(),
    };
    let (mass, height) = typed.split_once(',').ok_or_else(form)?;
    written::rider(
        unit::parse(mass, KG, "mass of the rider")?,
        unit::parse(height, M, "height of the rider")?,
    )
}

/// `value` [SI], if the row lets it in.
pub fn admit(row: &Quantity, value: f64) -> Result<f64> {
    if row.admits(value) {
        return Ok(value);
    }
    let Quantity { name, min, max, .. } = *row;
    Err(Error::OutOfRange {
        name: name.into(),
        value,
        min,
        max,
        unit: row.unit.symbol,
    })
}
