//! Maps: what the columns of a foreign ride file mean.
//!
//! A map is TOML. For each of our channels it names the column, its unit, and a calibration:
//! **value = scale · x + offset**, x the cell in SI (converted from `unit` first), scale and
//! offset in SI, all still in the file's sign convention; last comes the sign of the convention.
//!
//! ```toml
//! name = "logger"
//! signs = "literature"        # or "iso8855", the default
//! law_in_loop = false         # optional, see `Ride::law_in_loop`
//! rate = "200 Hz"             # where the file has no time column
//!
//! [channels.steer]
//! column = "Lenkwinkel"
//! unit = "deg"                # default: the SI unit of the channel
//! scale = -1.0                # default 1
//! offset = 0.01               # default 0, in rad
//! ```

use crate::error::{self, Error, Result};
use crate::file;
use crate::ride::{TIME, quantity};
use crate::unit::{Scale, Value};
use bicycle::quantity::{HZ, Quantity, S, Unit};
use serde::Deserialize;
use std::collections::BTreeMap;

/// The maps inside the program: name and text.
pub const SHIPPED: &[(&str, &str)] = &[("sbw-delft", include_str!("../maps/sbw-delft.toml"))];

/// The channels whose sign differs between ISO 8855 (z up, y left) and the literature (z down,
/// y right; Meijaard et al. 2007): steer, yaw, and what points to the left.
const TURNED: &[&str] = &[
    "steer",
    "steer_rate",
    "steer_acceleration",
    "steer_torque",
    "assist_torque",
    "rider_torque",
    "yaw_rate",
    "yaw_acceleration",
    "heading",
    "y",
    "y_rate",
    "slip_angle",
    "lateral_force",
    "rear_lateral_force",
    "lateral_velocity",
    "lateral_velocity_rate",
    "front_lateral_force",
    "front_lateral_force_rate",
    "rear_lateral_force_rate",
    "lateral_offset",
];

/// Whether the row called `name` has the other sign in the literature.
pub fn is_turned(name: &str) -> bool {
    TURNED.contains(&name)
}

/// A sign convention.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Signs {
    /// Ours: z up; roll right +, steer and yaw left +.
    #[default]
    Iso8855,
    /// Meijaard et al. 2007: z down; roll, steer and yaw right +.
    Literature,
}

/// What the columns of a foreign file mean.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// Its name.
    pub name: String,
    /// SHA-256 of its text.
    pub sha256: String,
    /// See [`crate::ride::Ride::law_in_loop`].
    pub law_in_loop: Option<bool>,
    /// Sampling rate [Hz], where the file has no time column.
    pub rate: Option<f64>,
    /// The time column, where there is one, and the channels.
    pub columns: Vec<Column>,
}

/// A column of a file and how its cells become a channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Name of the column in the file.
    pub column: String,
    /// The row of its channel; none for time.
    pub channel: Option<&'static Quantity>,
    unit: Scale,
    scale: f64,
    offset: f64,
    turned: bool,
}

impl Column {
    /// A column of our own file form, `name` or `name[unit]`.
    pub(crate) fn own(header: &str) -> Result<Self> {
        let (name, unit) = match header.split_once('[') {
            Some((name, rest)) => (name.trim(), rest.trim_end().strip_suffix(']')),
            None => (header, None),
        };
        if unit.is_none() && header.contains('[') {
            return Err(Error::Form {
                expected: "a column as name[unit]",
                found: header.into(),
            });
        }
        let channel = if name == TIME {
            None
        } else {
            Some(quantity(name)?)
        };
        let si = channel.map_or(S, |row| row.unit);
        let unit = Scale::of(unit.unwrap_or(si.symbol), si, name)?;
        Ok(Self {
            column: header.into(),
            channel,
            unit,
            scale: 1.0,
            offset: NO_OFFSET,
            turned: false,
        })
    }

    /// Name of the channel, or of time.
    pub fn name(&self) -> &'static str {
        self.channel.map_or(TIME, |row| row.name)
    }

    /// The value of a cell that reads `x`, SI and ISO 8855.
    pub fn to_si(&self, x: f64) -> f64 {
        let value = self.scale * self.unit.to_si(x) + self.offset;
        if self.turned { -value } else { value }
    }

    /// Whether the sign was the other convention's.
    pub fn is_turned(&self) -> bool {
        self.turned
    }
}

/// x + (−0) is x to the last bit; x + 0 would turn −0 into 0.
const NO_OFFSET: f64 = -0.0;

/// A map as written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    name: String,
    #[serde(default, rename = "description")]
    _description: String,
    #[serde(default, rename = "source")]
    _source: String,
    #[serde(default)]
    signs: Signs,
    law_in_loop: Option<bool>,
    rate: Option<Value>,
    time: Option<WrittenColumn>,
    channels: BTreeMap<String, WrittenColumn>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenColumn {
    column: String,
    unit: Option<String>,
    #[serde(default = "one")]
    scale: f64,
    #[serde(default = "no_offset")]
    offset: f64,
}

fn one() -> f64 {
    1.0
}

fn no_offset() -> f64 {
    NO_OFFSET
}

impl WrittenColumn {
    fn read(
        self,
        name: &str,
        channel: Option<&'static Quantity>,
        si: Unit,
        turned: bool,
    ) -> Result<Column> {
        let Self {
            column,
            unit,
            scale,
            offset,
        } = self;
        if !(scale.is_finite() && scale != 0.0 && offset.is_finite()) {
            return Err(Error::Calibration {
                channel: name.into(),
                scale,
                offset,
            });
        }
        let unit = Scale::of(unit.as_deref().unwrap_or(si.symbol), si, name)?;
        Ok(Column {
            column,
            channel,
            unit,
            scale,
            offset,
            turned,
        })
    }
}

impl Map {
    /// The map called `name`: one inside the program, or a file.
    pub fn open(name: &str) -> Result<Self> {
        let (file, text) = file::named("map", SHIPPED, name)?;
        Self::parse(&file, &text)
    }

    /// The map written in `text`; `name` is what errors call it.
    pub fn parse(name: &str, text: &str) -> Result<Self> {
        let written: Written = ::toml::from_str(text).map_err(|e| error::toml(name, text, &e))?;
        let sha256 = file::sha256(text.as_bytes());
        written.read(sha256).map_err(|e| e.in_file(name))
    }
}

impl Written {
    fn read(self, sha256: String) -> Result<Map> {
        let rate = self.rate.map(|rate| rate.si(HZ, "rate")).transpose()?;
        let mut columns = Vec::new();
        if let Some(time) = self.time {
            columns.push(time.read(TIME, None, S, false)?);
        }
        for (name, column) in self.channels {
            let row = quantity(&name)?;
            let turned = self.signs == Signs::Literature && is_turned(row.name);
            columns.push(column.read(row.name, Some(row), row.unit, turned)?);
        }
        Ok(Map {
            name: self.name,
            sha256,
            law_in_loop: self.law_in_loop,
            rate,
            columns,
        })
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed parse is a failed test")]
    use super::*;
    use crate::ride::quantities;

    #[test]
    fn what_points_left_is_turned_and_what_points_right_is_not() {
        for row in quantities() {
            let turned = TURNED.contains(&row.name);
            assert!(!row.what.contains("left") || turned, "{}", row.name);
            assert!(!row.what.contains("right") || !turned, "{}", row.name);
        }
        for name in TURNED {
            quantity(name).unwrap();
        }
    }

    #[test]
    fn the_delft_map_gives_the_true_speed_and_turns_the_steer() {
        let map = Map::open("sbw-delft").unwrap();
        assert_eq!(map.law_in_loop, Some(true));
        let column = |name| map.columns.iter().find(|c| c.name() == name).unwrap();
        for x in [0.0, 2.5, 4.1828] {
            let error = column("speed").to_si(x) - (x + 0.128) / 1.066;
            assert!(
                error.abs() < 4.0 * f64::EPSILON * (1.0 + x),
                "{error}: more than round-off"
            );
        }
        assert_eq!(column("steer").to_si(0.03), -0.03);
        // turned once in the file, and back by the signs
        assert_eq!(column("steer_torque").to_si(-0.5), -0.5);
        assert_eq!(column("roll").to_si(0.03), 0.03);
        assert_eq!(column("time").to_si(0.03), 0.03);
    }

    #[test]
    fn the_unit_comes_first_the_calibration_second_the_sign_last() {
        let text = "name = 'x'\nsigns = 'literature'\n[channels.steer]\n\
                    column = 'a'\nunit = 'mrad'\nscale = 2\noffset = 0.5";
        let map = Map::parse("x.toml", text).unwrap();
        assert_eq!(map.columns[0].to_si(250.0), -(2.0 * 0.25 + 0.5));
    }

    #[test]
    fn mistakes_are_named() {
        let message = |rest: &str| {
            Map::parse("my.toml", &format!("name = 'my'\n{rest}"))
                .unwrap_err()
                .to_string()
        };
        for (rest, expected) in [
            (
                "[channels.ster]\ncolumn = 'a'",
                "my.toml: unknown channel `ster`; nearest: steer",
            ),
            (
                "[channels.steer]\ncolum = 'a'",
                "my.toml, row 3: unknown field `colum`, expected one of `column`, `unit`, `scale`, `offset`",
            ),
            (
                "[channels.steer]\ncolumn = 'a'\nunit = 'm'",
                "my.toml: steer: expected a unit of the dimension of rad, found `m`",
            ),
            (
                "[channels.steer]\ncolumn = 'a'\nscale = 0",
                "my.toml: steer: expected a finite scale other than 0 and a finite offset, found scale 0, offset -0",
            ),
            (
                "rate = '5 ms'\n[channels]",
                "my.toml: rate: expected a unit of the dimension of Hz, found `ms`",
            ),
            (
                "signs = 'nasa'\n[channels]",
                "my.toml, row 2: unknown variant `nasa`, expected `iso8855` or `literature`",
            ),
            ("", "my.toml, row 1: missing field `channels`"),
        ] {
            assert_eq!(message(rest), expected);
        }
        assert_eq!(
            Map::open("sbw-delf").unwrap_err().to_string(),
            "unknown map `sbw-delf`; nearest: sbw-delft"
        );
        assert!(matches!(
            Map::open("maps/none.toml"),
            Err(Error::Read { .. })
        ));
    }
}
