//! What is what in an FMU: which variable takes the torque, which shows a channel, in which unit.

use crate::error::{self, Error, Result};
use crate::unit::{self, Scale};
use crate::{file, variable};
use bicycle::quantity::{Quantity, S, Unit};
use bicycle::{Input, Output, Parameters, State};
use fmi_import::model_description::{self, ScalarVariable};
use fmi_import::{Archive, Value, VariableRow};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// The file as written.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Written {
    /// The FMU, beside the file.
    pub fmu: String,
    step: Option<unit::Value>,
    #[serde(default)]
    rider: bool,
    #[serde(default)]
    inputs: BTreeMap<String, String>,
    #[serde(default)]
    outputs: BTreeMap<String, String>,
    #[serde(default)]
    parameters: BTreeMap<String, String>,
    #[serde(default)]
    starts: BTreeMap<String, String>,
    #[serde(default)]
    set: BTreeMap<String, toml::Value>,
}

impl Written {
    /// Reads the file at `path`.
    pub fn read(path: &Path) -> Result<Self> {
        let text = file::read_text(path)?;
        let name = path.display().to_string();
        toml::from_str(&text).map_err(|cause| error::toml(&name, &text, &cause))
    }
}

/// A variable of the FMU that stands for a row of ours.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Counterpart {
    /// Its value reference.
    pub reference: u32,
    /// Whether it is set in initialization mode and later, else before.
    pub is_input: bool,
    /// In SI and with our sign the value is `factor` · its own + `offset`.
    factor: f64,
    offset: f64,
    start: Option<f64>,
    /// Its own numbers that it takes.
    range: (f64, f64),
}

impl Counterpart {
    /// The FMU's own number for `value` [SI].
    pub fn own(&self, value: f64) -> f64 {
        (value - self.offset) / self.factor
    }

    /// What the FMU's own number means [SI].
    pub fn si(&self, own: f64) -> f64 {
        self.factor * own + self.offset
    }

    /// Least and largest value it takes [SI].
    pub fn range(&self) -> (f64, f64) {
        let (a, b) = (self.si(self.range.0), self.si(self.range.1));
        (a.min(b), a.max(b))
    }

    /// What the FMU starts with [SI], if it says.
    pub fn start(&self) -> Option<f64> {
        Some(self.si(self.start?))
    }
}

/// All that a ride needs to know of an FMU.
#[derive(Debug)]
pub(super) struct Described {
    /// The torque besides the rider law.
    pub torque: Counterpart,
    /// The speed.
    pub speed: Counterpart,
    /// Channels by name.
    pub outputs: Vec<(&'static str, Counterpart)>,
    /// Rows of [`Parameters`].
    pub parameters: Vec<(usize, Counterpart)>,
    /// Rows of [`State`].
    pub starts: Vec<(usize, Counterpart)>,
    /// Whatever else it starts with.
    pub set: Vec<(ScalarVariable, Value)>,
    /// Whether the rider law is closed outside.
    pub rider: bool,
    /// Its communication step [s], and whether that was asked for.
    step: Option<(f64, bool)>,
    names: Vec<String>,
}

/// What the variables of an FMU are.
struct Variables<'a> {
    rows: Vec<VariableRow>,
    units: &'a [model_description::Unit],
}

impl Described {
    /// What `written` says of the FMU in `archive`, and what follows from names that are ours.
    pub fn new(written: &Written, archive: &Archive) -> Result<Self> {
        let description = archive.description();
        let variables = Variables {
            rows: archive.inspect().variables,
            units: &description.units,
        };
        let input = |name: &str| {
            let row = &Input::TABLE[Input::index(name).expect("a row")];
            let own = written.inputs.get(name).map_or(name, String::as_str);
            variables.counterpart(own, row, &["input", "parameter"])
        };
        known(
            "input",
            written.inputs.keys(),
            ["steer_torque", "speed"].into_iter(),
        )?;
        let (torque, speed) = (input("steer_torque")?, input("speed")?);
        if !torque.is_input {
            return Err(Error::Form {
                expected: "an input for steer_torque",
                found: written
                    .inputs
                    .get("steer_torque")
                    .cloned()
                    .unwrap_or_default(),
            });
        }
        let shown = ["output", "local"];
        let outputs = variables.table("output", &written.outputs, Output::TABLE, "", &shown)?;
        let settable = ["parameter"];
        let parameters = variables.table(
            "parameter",
            &written.parameters,
            Parameters::TABLE,
            "",
            &settable,
        )?;
        let starts =
            variables.table("state", &written.starts, State::TABLE, "_start", &settable)?;
        let set = written.set.iter().map(|(name, value)| {
            let text = match value {
                toml::Value::String(text) => text.clone(),
                other => other.to_string(),
            };
            let value = variable::value(variables.units, &variables.rows, name, &text)
                .map_err(|cause| cause.typed(format!("set {name}")))?;
            let own = description.variables.iter().find(|v| v.name == *name);
            Ok((own.expect("found by its name").clone(), value))
        });
        let set = set.collect::<Result<_>>()?;
        let step = if let Some(step) = &written.step {
            Some((step.si(S, "step")?, true))
        } else {
            let suggested = description.default_experiment.and_then(|e| e.step_size);
            suggested.map(|step| (step, false))
        };
        let described = Self {
            torque,
            speed,
            outputs: outputs
                .into_iter()
                .map(|(i, own)| (Output::TABLE[i].name, own))
                .collect(),
            parameters,
            starts,
            set,
            rider: written.rider,
            step: step.filter(|(step, asked)| *asked || *step > 0.0),
            names: variables.rows.iter().map(|row| row.name.clone()).collect(),
        };
        if described.rider {
            for name in ["roll", "roll_rate", "steer", "steer_rate"] {
                described.output(name)?;
            }
        }
        Ok(described)
    }

    /// The output called `channel`.
    pub fn output(&self, channel: &str) -> Result<&Counterpart> {
        let own = self.outputs.iter().find(|(name, _)| *name == channel);
        let known = || self.outputs.iter().map(|(name, _)| *name);
        own.map(|(_, own)| own)
            .ok_or_else(|| Error::unknown("output of the FMU", channel, known()))
    }

    /// Rows of the parameters with what the FMU starts with [SI].
    pub fn parameter_starts(&self) -> impl Iterator<Item = (usize, f64)> {
        let starts = self.parameters.iter();
        starts.filter_map(|(row, own)| Some((*row, own.start()?)))
    }

    /// The names of its variables.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str)
    }

    /// Communication steps between samples `interval` [s] apart.
    pub fn pieces(&self, interval: f64) -> Result<usize> {
        let Some((own, asked)) = self.step else {
            return Ok(1);
        };
        let pieces = (interval / own).round();
        if own > 0.0 && pieces >= 1.0 && (pieces * own - interval).abs() <= 1e-9 * interval {
            return Ok(pieces as usize);
        }
        if asked {
            return Err(Error::SampleTime {
                member: "the FMU".into(),
                own,
                step: interval,
            });
        }
        Ok(1)
    }
}

/// Refuses keys that mean nothing.
fn known<'a>(
    kind: &'static str,
    keys: impl Iterator<Item = &'a String>,
    names: impl Iterator<Item = &'static str> + Clone,
) -> Result<()> {
    for key in keys {
        if names.clone().all(|name| name != key) {
            return Err(Error::unknown(kind, key, names));
        }
    }
    Ok(())
}

impl Variables<'_> {
    /// Counterparts of the rows of a table: those written, else those whose name is ours with
    /// `suffix` behind.
    fn table(
        &self,
        kind: &'static str,
        written: &BTreeMap<String, String>,
        table: &'static [Quantity],
        suffix: &str,
        causalities: &[&str],
    ) -> Result<Vec<(usize, Counterpart)>> {
        known(kind, written.keys(), table.iter().map(|row| row.name))?;
        let mut found = Vec::new();
        for (i, row) in table.iter().enumerate() {
            let ours = format!("{}{suffix}", row.name);
            let is_there = |own: &VariableRow| {
                own.name == ours && own.type_name == "Real" && causalities.contains(&own.causality)
            };
            let name = match written.get(row.name) {
                Some(name) => name,
                None if self.rows.iter().any(is_there) => &ours,
                None => continue,
            };
            found.push((i, self.counterpart(name, row, causalities)?));
        }
        Ok(found)
    }

    /// The variable `name`, perhaps with a minus in front, that stands for `quantity`.
    fn counterpart(
        &self,
        name: &str,
        quantity: &Quantity,
        causalities: &[&str],
    ) -> Result<Counterpart> {
        let (name, sign) = match name.strip_prefix('-') {
            Some(name) => (name, -1.0),
            None => (name, 1.0),
        };
        let row = variable::row(&self.rows, name)?;
        if row.type_name != "Real" || !causalities.contains(&row.causality) {
            return Err(Error::Counterpart {
                row: quantity.name,
                expected: causalities.join(" or "),
                found: format!("{name}, {} {}", row.causality, row.type_name),
            });
        }
        let (factor, offset) = match &row.unit {
            None => (1.0, 0.0),
            Some(unit) => self.in_si(unit, quantity.unit, name)?,
        };
        Ok(Counterpart {
            reference: row.value_reference,
            is_input: row.causality == "input",
            factor: sign * factor,
            offset: sign * offset,
            start: match row.start {
                Some(Value::Real(start)) => Some(start),
                _ => None,
            },
            range: (
                row.min.unwrap_or(f64::NEG_INFINITY),
                row.max.unwrap_or(f64::INFINITY),
            ),
        })
    }

    /// Factor and offset from the FMU's unit `name` to SI, which must be of the dimension of
    /// `unit`: as the FMU defines it, else as we read it. An angle may be a number there.
    fn in_si(&self, name: &str, unit: Unit, what: &str) -> Result<(f64, f64)> {
        let defined = self.units.iter().find(|own| own.name == name);
        let Some(base) = defined.and_then(|own| own.base) else {
            return Ok((Scale::of(name, unit, what)?.to_si(1.0), 0.0));
        };
        let exponents = [
            base.kg,
            base.m,
            base.s,
            base.ampere,
            base.kelvin,
            base.mol,
            base.cd,
        ];
        let wanted = [unit.kg, unit.m, unit.s, 0, 0, 0, 0].map(i32::from);
        if exponents == wanted && base.factor != 0.0 {
            Ok((base.factor, base.offset))
        } else {
            Err(Error::WrongUnit {
                what: what.into(),
                expected: unit.symbol,
                found: name.into(),
            })
        }
    }
}

#[cfg(test)]
mod tests;
