//! A bicycle as a file that gives it back to the last bit.

use super::Bicycle;
use bicycle::{Input, Parameters, Quantity};
use std::fmt::Write as _;

/// The rows that masses determine, and that a file gives as `[lumps]`.
const LUMPS: [&str; 6] = [
    "total_mass",
    "cog_to_rear",
    "cog_height",
    "roll_inertia",
    "yaw_inertia",
    "cross_inertia",
];

impl Bicycle {
    /// The text of a bicycle file with all rows; its masses are lumps about the rear contact, for
    /// the bodies they were composed of are no longer known. Reading it gives the same bicycle,
    /// but for its notes and its excitation, which bicycle files have none of.
    pub fn to_toml(&self) -> String {
        let text = |text: &str| ::toml::Value::from(text);
        let mut file = format!(
            "name = {}\ndescription = {}\nsource = {}\nlaw_in_loop = {}\nformulation = {}\n",
            text(&self.name),
            text(&self.description),
            text(&self.source),
            self.law_in_loop,
            text(self.formulation.name()),
        );
        let parameters = || Parameters::TABLE.iter().zip(self.parameters.to_array());
        let is_lump = |row: &Quantity| LUMPS.contains(&row.name);
        file += "\n[lumps]\nabout = \"rear_contact\"\n";
        write(&mut file, parameters().filter(|(row, _)| is_lump(row)));
        file += "\n[parameters]\n";
        write(&mut file, parameters().filter(|(row, _)| !is_lump(row)));
        file += "\n[inputs]\n";
        write(&mut file, Input::TABLE.iter().zip(self.input.to_array()));
        file
    }
}

/// One line for each row. The shortest digits that give the same number back, and always a point
/// or an exponent: TOML tells numbers from integers.
fn write(file: &mut String, rows: impl Iterator<Item = (&'static Quantity, f64)>) {
    for (row, value) in rows {
        let _ = writeln!(file, "{} = {value:?} # {}", row.name, row.unit.symbol);
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
    use super::super::{Changes, SHIPPED};
    use super::*;

    fn back(bicycle: &Bicycle) -> Bicycle {
        Bicycle::parse("x.toml", &bicycle.to_toml(), &Changes::default()).unwrap()
    }

    /// All that a file holds, numbers as bits: -0 is not 0.
    fn held(b: &Bicycle) -> (Vec<u64>, [String; 4], bool) {
        let parameters = b.parameters.to_array().map(f64::to_bits);
        let inputs = b.input.to_array().map(f64::to_bits);
        let texts = [&b.name, &b.description, &b.source, b.formulation.name()];
        (
            parameters.into_iter().chain(inputs).collect(),
            texts.map(str::to_owned),
            b.law_in_loop,
        )
    }

    #[test]
    fn every_bicycle_comes_back_with_its_changes() {
        let changes = Changes {
            load: Some("20 kg".to_owned()),
            set: vec!["trail=-35mm".to_owned(), "speed=8km/h".to_owned()],
            ..Changes::default()
        };
        for (name, _) in SHIPPED {
            for changes in [Changes::default(), changes.clone()] {
                let bicycle = Bicycle::open(name, &changes).unwrap();
                assert_eq!(held(&back(&bicycle)), held(&bicycle), "{name}");
            }
        }
    }

    #[test]
    fn texts_come_back_whatever_is_in_them() {
        let mut bicycle = Bicycle::open("nominal", &Changes::default()).unwrap();
        bicycle.description = "a \"quoted\"\nline \\ θ'''".to_owned();
        assert_eq!(held(&back(&bicycle)), held(&bicycle));
    }

    #[test]
    fn numbers_come_back_whether_sensible_or_not() {
        let mut bicycle = Bicycle::open("nominal", &Changes::default()).unwrap();
        for share in [0.0, 0.1, 1.0 / 3.0, 0.7, 1.0] {
            for (index, row) in Parameters::TABLE.iter().enumerate() {
                let value = row.min + share * (row.max - row.min);
                if value.is_finite() {
                    bicycle.parameters.set(index, value);
                }
            }
            bicycle.input.speed = share * 1e-310;
            let written: ::toml::Table = bicycle.to_toml().parse().unwrap();
            let check = |section: &str, name: &str, value: f64| {
                let found = written[section][name].as_float().unwrap();
                assert_eq!(found.to_bits(), value.to_bits(), "{name}");
            };
            for (row, value) in Parameters::TABLE.iter().zip(bicycle.parameters.to_array()) {
                let is_lump = LUMPS.contains(&row.name);
                check(
                    if is_lump { "lumps" } else { "parameters" },
                    row.name,
                    value,
                );
            }
            check("inputs", "speed", bicycle.input.speed);
        }
    }
}
