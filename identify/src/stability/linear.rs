//! The linear system of a bicycle upright, with names and units, in either sign convention: as
//! JSON, and as a MAT-file.

mod mat;

use super::{Plan, ready, words};
use crate::error::Result;
use crate::map::{Signs, is_turned};
use bicycle::linear::{Linear, linearize};
use bicycle::{Input, Output, Parameters, Quantity, State};
use nalgebra::DMatrix;
use serde_json::{Value, json};

/// ẋ = A x + B u, y = C x + D u of a bicycle upright, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct System {
    /// The four matrices, in the convention of `signs`.
    pub matrices: Linear,
    /// Speed [m/s].
    pub speed: f64,
    /// The sign convention.
    pub signs: Signs,
    /// What was left out.
    pub notes: Vec<String>,
}

/// The linear system of the first speed of `plan`; its sweep plays no part. Jumps (Coulomb
/// friction, sign θ) are left out.
pub fn system(plan: &Plan, signs: Signs) -> Result<System> {
    let speed = plan.speeds[0];
    let smooth = Parameters {
        coulomb_friction: 0.0,
        ..plan.parameters
    };
    let b = ready(plan, &smooth, (speed, speed))?;
    let input = Input {
        speed,
        ..Input::ZERO
    };
    let mut matrices = linearize(&b, &State::ZERO, &input);
    if signs == Signs::Literature {
        turn(&mut matrices);
    }
    Ok(System {
        matrices,
        speed,
        signs,
        notes: words::left_out(plan),
    })
}

/// What points to the left points to the right from here, and the other way round.
fn turn(linear: &mut Linear) {
    let sign = |row: &Quantity| if is_turned(row.name) { -1.0 } else { 1.0 };
    let turned = |m: &mut DMatrix<f64>, rows: &[Quantity], columns: &[Quantity]| {
        for (i, row) in rows.iter().enumerate() {
            for (j, column) in columns.iter().enumerate() {
                // + 0 turns −0 into 0
                m[(i, j)] = m[(i, j)] * sign(row) * sign(column) + 0.0;
            }
        }
    };
    let states = linear.states();
    turned(&mut linear.a, states, states);
    turned(&mut linear.b, states, Input::TABLE);
    turned(&mut linear.c, Output::TABLE, &states[..]);
    turned(&mut linear.d, Output::TABLE, Input::TABLE);
}

impl System {
    /// Matrices by name, `A` to `D`.
    fn matrices(&self) -> [(&'static str, &DMatrix<f64>); 4] {
        let m = &self.matrices;
        [("A", &m.a), ("B", &m.b), ("C", &m.c), ("D", &m.d)]
    }

    /// Rows by what they are of the system.
    fn rows(&self) -> [(&'static str, &'static [Quantity]); 3] {
        [
            ("state", self.matrices.states()),
            ("input", Input::TABLE),
            ("output", Output::TABLE),
        ]
    }

    fn convention(&self) -> &'static str {
        match self.signs {
            Signs::Iso8855 => "iso8855",
            Signs::Literature => "literature",
        }
    }

    /// `A` to `D` by rows; `states`, `inputs`, `outputs` and their `_units`; `speed`, `signs`,
    /// `notes`.
    pub fn to_json(&self) -> Value {
        let mut whole = serde_json::Map::new();
        for (name, matrix) in self.matrices() {
            let row = |row: nalgebra::RowDVector<f64>| row.iter().copied().collect::<Vec<_>>();
            let rows: Vec<_> = matrix.row_iter().map(|r| row(r.into_owned())).collect();
            whole.insert(name.into(), json!(rows));
        }
        for (name, rows) in self.rows() {
            let names: Vec<_> = rows.iter().map(|row| row.name).collect();
            let units: Vec<_> = rows.iter().map(|row| row.unit.symbol).collect();
            whole.insert(format!("{name}s"), json!(names));
            whole.insert(format!("{name}_units"), json!(units));
        }
        whole.insert("speed".into(), json!(self.speed));
        whole.insert("signs".into(), json!(self.convention()));
        whole.insert("notes".into(), json!(self.notes));
        Value::Object(whole)
    }

    /// The same as a MAT-file of level 5: matrices, cell arrays of names, a number and texts.
    pub fn to_mat(&self) -> Vec<u8> {
        let mut file = mat::File::new();
        for (name, matrix) in self.matrices() {
            file.matrix(name, matrix);
        }
        for (name, rows) in self.rows() {
            let names: Vec<_> = rows.iter().map(|row| row.name).collect();
            let units: Vec<_> = rows.iter().map(|row| row.unit.symbol).collect();
            file.texts(&format!("{name}s"), &names);
            file.texts(&format!("{name}_units"), &units);
        }
        file.matrix("speed", &DMatrix::from_element(1, 1, self.speed));
        file.text("signs", self.convention());
        file.into_bytes()
    }

    /// The four matrices as plain text.
    pub fn table(&self) -> String {
        use std::fmt::Write as _;
        let [(_, states), (_, inputs), (_, outputs)] = self.rows();
        let (speed, signs) = (self.speed, self.convention());
        let mut text = format!("upright at {speed} m/s, signs {signs}\n");
        let shapes = [
            (states, states),
            (states, inputs),
            (outputs, states),
            (outputs, inputs),
        ];
        for ((name, matrix), (rows, columns)) in self.matrices().into_iter().zip(shapes) {
            let _ = write!(text, "\n{name:26}");
            for column in columns {
                let _ = write!(text, " {:>19}", column.name);
            }
            text.push('\n');
            for (row, values) in rows.iter().zip(matrix.row_iter()) {
                let _ = write!(text, "{:26}", row.name);
                for value in values.iter() {
                    let _ = write!(text, " {value:>19.6}");
                }
                text.push('\n');
            }
        }
        text
    }
}
