//! Ranges as typed, and the rows of the table that can be swept.

use super::{MOST_POINTS, Plan};
use crate::bicycles::admit;
use crate::error::{Error, Result};
use crate::unit;
use bicycle::mass::{Body, compose};
use bicycle::{Parameters, Quantity, Unit};

/// A row of the parameter table and the values it takes.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// The row.
    pub row: &'static Quantity,
    /// Its values [SI].
    pub values: Vec<f64>,
}

impl Sweep {
    /// Reads `name=from:to:step`; the values must lie in the row's range.
    pub fn read(text: &str) -> Result<Self> {
        let form = || Error::Form {
            expected: "NAME=FROM:TO:STEP",
            found: text.into(),
        };
        let (name, range) = text.split_once('=').ok_or_else(form)?;
        let names = Parameters::TABLE.iter().map(|row| row.name);
        let elsewhere = match name.trim() {
            "speed" => Some("a row of the parameter table (speeds are --speed FROM:TO:STEP)"),
            "formulation" => Some("a row of the parameter table that is a number"),
            _ => None,
        };
        if let Some(expected) = elsewhere {
            let found = name.trim().into();
            return Err(Error::Form { expected, found });
        }
        let index = Parameters::index(name.trim())
            .ok_or_else(|| Error::unknown("parameter", name.trim(), names))?;
        let row = &Parameters::TABLE[index];
        let values = points(range, row.unit, row.name)?;
        // a range is inside if its ends are
        for end in values.first().into_iter().chain(values.last()) {
            admit(row, *end)?;
        }
        Ok(Self { row, values })
    }

    /// The row's index in the table.
    pub fn index(&self) -> usize {
        Parameters::index(self.row.name).expect("a row of the table")
    }

    /// `p` with the row at `value` [SI]. Where a mass or its place changes, the inertias about the
    /// centre of mass stay what they were.
    pub fn apply(&self, p: &Parameters, value: f64) -> Parameters {
        let mut p = *p;
        let body = p.lumps().body();
        let moved = match self.row.name {
            "total_mass" => Body {
                mass: value,
                ..body
            },
            "cog_to_rear" => Body { x: value, ..body },
            "cog_height" => Body { h: value, ..body },
            _ => {
                p.set(self.index(), value);
                return p;
            }
        };
        p.set_lumps(compose(&[moved]));
        p
    }
}

/// The values of the swept row with their bicycles, or the one bicycle.
pub(super) fn values(plan: &Plan) -> Result<Vec<(Option<f64>, Parameters)>> {
    let Some(sweep) = &plan.sweep else {
        return Ok(vec![(None, plan.parameters)]);
    };
    let one = |value: &f64| {
        let value = admit(sweep.row, *value)?;
        Ok((Some(value), sweep.apply(&plan.parameters, value)))
    };
    sweep.values.iter().map(one).collect()
}

/// `row = value unit`, as an error or a note names a point.
pub(super) fn at(row: &Quantity, value: Option<f64>) -> String {
    let value = value.map_or_else(String::new, |value| value.to_string());
    format!("{} = {value} {}", row.name, row.unit.symbol)
}

pub(super) fn too_many(found: String) -> Error {
    Error::Points {
        most: MOST_POINTS,
        found,
    }
}

/// The values of `from:to:step` or of a single value, SI in `unit`; `what` names the quantity in
/// errors. The last is `to` where a whole number of steps leads there.
pub fn points(text: &str, unit: Unit, what: &str) -> Result<Vec<f64>> {
    let form = |expected| Error::Form {
        expected,
        found: text.into(),
    };
    let parts: Vec<&str> = text.split(':').collect();
    let read = |text: &str| unit::parse(text, unit, what);
    let (from, to, step) = match parts[..] {
        [value] => return Ok(vec![read(value)?]),
        [from, to, step] => (read(from)?, read(to)?, read(step)?),
        _ => return Err(form("VALUE or FROM:TO:STEP")),
    };
    if step == 0.0 {
        return Err(form("a step other than 0"));
    }
    if (to - from) * step < 0.0 {
        return Err(form("a step in the direction from FROM to TO"));
    }
    // a hair more: .3/.1 is 2.9999999999999996
    let count = ((to - from) / step * (1.0 + 1e-12) + 1e-9).floor();
    if count >= MOST_POINTS as f64 {
        return Err(too_many(format!("`{text}`")));
    }
    // 3/10 is nearer to .3 than 3 · .1 is
    let parts_of_one = (1.0 / step).round();
    let divides = parts_of_one != 0.0 && (parts_of_one * step - 1.0).abs() < 1e-12;
    let value = |i: usize| {
        let i = i as f64;
        from + if divides { i / parts_of_one } else { i * step }
    };
    let mut values: Vec<f64> = (0..=count as usize).map(value).collect();
    if let Some(last) = values
        .last_mut()
        .filter(|v| (**v - to).abs() < 1e-9 * step.abs())
    {
        *last = to;
    }
    Ok(values)
}
