//! The door for units: the only place where units other than SI exist.
//!
//! A unit is a product of symbols with integer exponents and at most single symbols after each
//! slash: `km/h`, `N m`, `N.m.s/rad`, `m/s²`, `m s-2`. `g` is the standard acceleration of
//! gravity, not the gram.

use crate::error::{Error, Result};
use bicycle::quantity::Unit;
use serde::Deserialize;
use std::f64::consts::PI;

/// How a unit relates to SI: its dimension, and the two factors of `x_SI = x · up / down`.
///
/// Two factors, because 8 km/h must be 8 · 1000 / 3600 and 5 ms 5 / 1000 to the last bit, as the
/// nominal values of the tables are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// Exponents of kg, m, s, rad.
    dimension: [i8; 4],
    up: f64,
    down: f64,
}

/// Symbol, exponents of kg, m, s, rad, and the two factors.
const SYMBOLS: &[(&str, [i8; 4], f64, f64)] = &[
    ("1", [0, 0, 0, 0], 1.0, 1.0),
    ("%", [0, 0, 0, 0], 1.0, 100.0),
    ("kg", [1, 0, 0, 0], 1.0, 1.0),
    ("m", [0, 1, 0, 0], 1.0, 1.0),
    ("mm", [0, 1, 0, 0], 1.0, 1000.0),
    ("cm", [0, 1, 0, 0], 1.0, 100.0),
    ("km", [0, 1, 0, 0], 1000.0, 1.0),
    ("s", [0, 0, 1, 0], 1.0, 1.0),
    ("ms", [0, 0, 1, 0], 1.0, 1000.0),
    ("us", [0, 0, 1, 0], 1.0, 1e6),
    ("min", [0, 0, 1, 0], 60.0, 1.0),
    ("h", [0, 0, 1, 0], 3600.0, 1.0),
    ("Hz", [0, 0, -1, 0], 1.0, 1.0),
    ("kHz", [0, 0, -1, 0], 1000.0, 1.0),
    ("rad", [0, 0, 0, 1], 1.0, 1.0),
    ("mrad", [0, 0, 0, 1], 1.0, 1000.0),
    ("deg", [0, 0, 0, 1], PI / 180.0, 1.0),
    ("N", [1, 1, -2, 0], 1.0, 1.0),
    ("kN", [1, 1, -2, 0], 1000.0, 1.0),
    ("Nm", [1, 2, -2, 0], 1.0, 1.0),
    ("g", [0, 1, -2, 0], 9.80665, 1.0),
];

impl Scale {
    /// Reads a unit; none where a symbol is unknown or the form ambiguous.
    fn read(text: &str) -> Option<Self> {
        let text = text
            .replace(['·', '⋅', '*'], ".")
            .replace('°', "deg")
            .replace('^', "");
        let text = text.replace('²', "2").replace('³', "3");
        let mut scale = Self {
            dimension: [0; 4],
            up: 1.0,
            down: 1.0,
        };
        for (i, part) in text.split('/').enumerate() {
            let symbols: Vec<&str> = part
                .split(|c: char| c == '.' || c.is_whitespace())
                .filter(|s| !s.is_empty())
                .collect();
            let sign = match (i, symbols.len()) {
                (0, _) => 1,
                (_, 1) => -1,
                // `a/b c` is read both ways by different people, and `a/` by none
                _ => return None,
            };
            for symbol in symbols {
                scale.multiply(symbol, sign)?;
            }
        }
        Some(scale)
    }

    /// Multiplies by one symbol with its exponent, e.g. `s2` or `s-1`, times `sign`.
    fn multiply(&mut self, text: &str, sign: i8) -> Option<()> {
        // `1` and `%` are symbols themselves
        let end = text.len() - text.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        let (name, exponent) = if end == 0 || end == text.len() {
            (text, 1)
        } else {
            let (name, digits) = text.split_at(text.len() - end);
            let (name, minus) = name.strip_suffix('-').map_or((name, 1), |name| (name, -1));
            (name, minus * digits.parse::<i8>().ok()?)
        };
        let exponent = sign.checked_mul(exponent)?;
        let (_, dimension, up, down) = SYMBOLS.iter().find(|(symbol, ..)| *symbol == name)?;
        for (sum, d) in self.dimension.iter_mut().zip(dimension) {
            *sum = sum.checked_add(d.checked_mul(exponent)?)?;
        }
        let (up, down) = if exponent < 0 { (down, up) } else { (up, down) };
        for _ in 0..exponent.unsigned_abs() {
            self.up *= up;
            self.down *= down;
        }
        Some(())
    }

    /// The scale of the unit written as `text`, which must have the dimension of `unit`; `what`
    /// names the quantity in the error.
    pub fn of(text: &str, unit: Unit, what: &str) -> Result<Self> {
        let expected = unit.symbol;
        let scale = Self::read(text).ok_or_else(|| Error::UnknownUnit {
            what: what.into(),
            expected,
            found: text.into(),
        })?;
        if scale.dimension == [unit.kg, unit.m, unit.s, unit.rad] {
            Ok(scale)
        } else {
            Err(Error::WrongUnit {
                what: what.into(),
                expected,
                found: text.into(),
            })
        }
    }

    /// `value` in SI.
    pub fn to_si(self, value: f64) -> f64 {
        value * self.up / self.down
    }
}

/// Reads a quantity such as `8km/h`, `.1 deg/s` or `75` (a bare number is SI) and returns it in
/// `unit`; `what` names the quantity in the error.
pub fn parse(text: &str, unit: Unit, what: &str) -> Result<f64> {
    let text = text.trim();
    let numeric = text
        .find(|c: char| !(c.is_ascii_digit() || "+-.eE".contains(c)))
        .unwrap_or(text.len());
    // the longest number in front: `5e` is 5 with a unit `e`
    let number = (1..=numeric)
        .rev()
        .find_map(|end| Some((end, text[..end].parse::<f64>().ok()?)));
    let Some((end, value)) = number.filter(|(_, value)| value.is_finite()) else {
        return Err(Error::Number {
            what: what.into(),
            found: text.into(),
        });
    };
    match text[end..].trim() {
        "" => Ok(value),
        symbol => Ok(Scale::of(symbol, unit, what)?.to_si(value)),
    }
}

/// A value in a TOML file: a number in SI, or a text with a unit.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a number (SI) or a text with a unit such as \"20 deg\""
)]
pub enum Value {
    /// In SI.
    Number(f64),
    /// With its unit.
    Text(String),
}

impl Value {
    /// The value in `unit`; `what` names the quantity in the error.
    pub fn si(&self, unit: Unit, what: &str) -> Result<f64> {
        match self {
            Self::Number(value) if value.is_finite() => Ok(*value),
            Self::Number(value) => Err(Error::Number {
                what: what.into(),
                found: value.to_string(),
            }),
            Self::Text(text) => parse(text, unit, what),
        }
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed parse is a failed test")]
    use super::*;
    use bicycle::quantity::{self as q, UNITS};

    #[test]
    fn quantities_come_out_in_si() {
        let cases = [
            ("8km/h", q::M_PER_S, 8.0 / 3.6),
            ("8 km/h", q::M_PER_S, 8.0 / 3.6),
            ("5ms", q::S, 0.005),
            ("20deg", q::RAD, 20.0_f64.to_radians()),
            ("-5°", q::RAD, -(5.0_f64.to_radians())),
            ("75kg", q::KG, 75.0),
            ("1.78m", q::M, 1.78),
            ("178 cm", q::M, 1.78),
            ("200Hz", q::HZ, 200.0),
            (".1deg/s", q::RAD_PER_S, 0.1_f64.to_radians()),
            ("1e-3", q::RAD, 1e-3),
            ("2e3 mm", q::M, 2.0),
            ("9.81", q::M_PER_S2, 9.81),
            ("1g", q::M_PER_S2, 9.80665),
            ("60 1/min", q::HZ, 1.0),
            ("2/rad", q::PER_RAD, 2.0),
        ];
        for (text, unit, expected) in cases {
            assert_eq!(parse(text, unit, "x").unwrap(), expected, "{text}");
        }
    }

    #[test]
    fn units_have_many_spellings() {
        for text in [
            "Nm",
            "N m",
            "N.m",
            "N·m",
            "N*m",
            "kg m²/s²",
            "kg.m2.s-2",
            "kg m^2 / s^2",
        ] {
            assert_eq!(
                parse(&format!("3 {text}"), q::N_M, "x").unwrap(),
                3.0,
                "{text}"
            );
        }
        assert_eq!(parse("3 m/s/s", q::M_PER_S2, "x").unwrap(), 3.0);
    }

    #[test]
    fn every_unit_of_the_tables_is_read_as_written() {
        for &unit in UNITS {
            assert_eq!(
                Scale::of(unit.symbol, unit, "x").unwrap().to_si(1.5),
                1.5,
                "{}",
                unit.symbol
            );
        }
    }

    #[test]
    fn errors_name_expected_and_found() {
        let message = |text| parse(text, q::M_PER_S, "speed").unwrap_err().to_string();
        for (text, expected) in [
            (
                "8kg",
                "speed: expected a unit of the dimension of m/s, found `kg`",
            ),
            (
                "8km",
                "speed: expected a unit of the dimension of m/s, found `km`",
            ),
            ("8mph", "speed: expected a unit such as m/s, found `mph`"),
            ("8e", "speed: expected a unit such as m/s, found `e`"),
            ("8 m/", "speed: expected a unit such as m/s, found `m/`"),
            (
                "8 m/s s",
                "speed: expected a unit such as m/s, found `m/s s`",
            ),
            ("8 m999", "speed: expected a unit such as m/s, found `m999`"),
            (
                "fast",
                "speed: expected a number or a number with a unit, found `fast`",
            ),
            (
                "NaN",
                "speed: expected a number or a number with a unit, found `NaN`",
            ),
            (
                "1e999",
                "speed: expected a number or a number with a unit, found `1e999`",
            ),
            (
                "",
                "speed: expected a number or a number with a unit, found ``",
            ),
        ] {
            assert_eq!(message(text), expected);
        }
        // an angle is not a number here: 1 rad and 1 differ as FMI has them
        assert!(parse("3 deg", q::ONE, "x").is_err());
    }
}
