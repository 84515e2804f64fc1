//! The linear system of a bicycle upright or in a steady turn, with names and units, in either sign convention: as
//! JSON, and as a MAT-file.

mod mat;

use super::{Plan, ready, words};
use crate::error::{Error, Result};
use crate::map::{Signs, is_turned};
use bicycle::linear::{Linear, linearize, steady_turn};
use bicycle::{Input, Output, Parameters, Quantity, State};
use nalgebra::DMatrix;
use serde_json::{Value, json};

/// ẋ = A x + B u, y = C x + D u of changes from a steady motion, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct System {
    /// The four matrices, in the convention of `signs`.
    pub matrices: Linear,
    /// The steady motion, ISO 8855 in either convention.
    pub state: State,
    /// What holds it: its speed, and in a turn a steer torque.
    pub input: Input,
    /// The sign convention.
    pub signs: Signs,
    /// What was left out.
    pub notes: Vec<String>,
}

/// The linear system of the first speed of `plan`, upright or in the steady turn of the steer
/// angle `steer` [rad], left positive; its sweep plays no part. Jumps are left out: Coulomb
/// friction, and upright sign θ.
pub fn system(plan: &Plan, steer: f64, signs: Signs) -> Result<System> {
    let speed = plan.speeds[0];
    let smooth = Parameters {
        coulomb_friction: 0.0,
        ..plan.parameters
    };
    let b = ready(plan, &smooth, (speed, speed))?;
    let upright = Input {
        speed,
        ..Input::ZERO
    };
    let (state, input) = if steer == 0.0 {
        (State::ZERO, upright)
    } else {
        steady_turn(&b, speed, steer).ok_or_else(|| Error::Form {
            expected: "a steer angle of a steady turn short of lying down",
            found: format!("{steer} rad"),
        })?
    };
    let mut matrices = linearize(&b, &state, &input);
    if signs == Signs::Literature {
        turn(&mut matrices);
    }
    Ok(System {
        matrices,
        state,
        input,
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
    turned(&mut linear.c, Output::TABLE, states);
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

    /// The motion that changes are counted from, in the convention of the matrices.
    fn about(&self) -> [(&'static str, f64); 4] {
        let all = [
            ("speed", self.input.speed),
            ("roll", self.state.roll),
            ("steer", self.state.steer),
            ("steer_torque", self.input.steer_torque),
        ];
        let turned = |name| self.signs == Signs::Literature && is_turned(name);
        all.map(|(name, value)| (name, if turned(name) { 0.0 - value } else { value }))
    }

    fn convention(&self) -> &'static str {
        match self.signs {
            Signs::Iso8855 => "iso8855",
            Signs::Literature => "literature",
        }
    }

    /// `A` to `D` by rows; `states`, `inputs`, `outputs` and their `_units`; where the motion is
    /// (`speed`, `roll`, `steer`, `steer_torque`, in the convention); `signs`, `notes`.
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
        for (name, value) in self.about() {
            whole.insert(name.into(), json!(value));
        }
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
        for (name, value) in self.about() {
            file.matrix(name, &DMatrix::from_element(1, 1, value));
        }
        file.text("signs", self.convention());
        file.into_bytes()
    }

    /// The four matrices as plain text.
    pub fn table(&self) -> String {
        use std::fmt::Write as _;
        let [(_, states), (_, inputs), (_, outputs)] = self.rows();
        let mut text = format!("signs {}", self.convention());
        for (name, value) in self.about() {
            let _ = write!(text, ", {name} {value}");
        }
        text.push('\n');
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
