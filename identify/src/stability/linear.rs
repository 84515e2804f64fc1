//! The linear system of a bicycle upright or in a steady turn, with names and units, in either sign
//! convention: as JSON, and as a MAT-file.

mod mat;

use super::{Plan, ready, words};
use crate::error::{Error, Result};
use crate::map::{Signs, is_turned};
use bicycle::linear::{Linear, linearize, steady_turn};
use bicycle::simulate;
use bicycle::{Formulation, Input, Output, Parameters, Path, Quantity, State};
use nalgebra::DMatrix;
use serde_json::{Value, json};

/// ẋ = A x + B u, y = C x + D u of changes from a steady motion, SI. Heading and place, integrals of
/// what is among the outputs, are no states here: the outputs that follow from them are left out.
#[derive(Debug, Clone, PartialEq)]
pub struct System {
    /// The four matrices, in the convention of `signs`.
    pub matrices: Linear,
    /// The steady motion, ISO 8855 in either convention.
    pub state: State,
    /// What holds it: its speed, and in a turn a steer torque.
    pub input: Input,
    /// What is seen of it.
    pub output: Output,
    /// The equations.
    pub formulation: Formulation,
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
    let seen: Vec<usize> = seen().map(|(i, _)| i).collect();
    (matrices.c, matrices.d) = (matrices.c.select_rows(&seen), matrices.d.select_rows(&seen));
    if signs == Signs::Literature {
        turn(&mut matrices);
    }
    Ok(System {
        matrices,
        state,
        input,
        output: simulate::output(&b, &state, &Path::default(), &input),
        formulation: plan.formulation,
        signs,
        notes: words::left_out(plan, steer == 0.0),
    })
}

/// The outputs that a linear system about a steady motion has, with their rows in the table: those
/// that do not hang on heading and place.
fn seen() -> impl Iterator<Item = (usize, &'static Quantity)> {
    let of_path = |name: &str| Path::index(name).is_some() || ["x_rate", "y_rate"].contains(&name);
    let rows = Output::TABLE.iter().enumerate();
    rows.filter(move |(_, row)| !of_path(row.name))
}

/// What points to the left points to the right from here, and the other way round.
fn turn(linear: &mut Linear) {
    let sign = |row: &Quantity| if is_turned(row.name) { -1.0 } else { 1.0 };
    let turned = |m: &mut DMatrix<f64>, rows: &[&Quantity], columns: &[&Quantity]| {
        for (i, row) in rows.iter().enumerate() {
            for (j, column) in columns.iter().enumerate() {
                // + 0 turns −0 into 0
                m[(i, j)] = m[(i, j)] * sign(row) * sign(column) + 0.0;
            }
        }
    };
    let [states, inputs, outputs] = rows(linear);
    turned(&mut linear.a, &states, &states);
    turned(&mut linear.b, &states, &inputs);
    turned(&mut linear.c, &outputs, &states);
    turned(&mut linear.d, &outputs, &inputs);
}

/// States, inputs and outputs of a system.
fn rows(linear: &Linear) -> [Vec<&'static Quantity>; 3] {
    [
        linear.states().iter().collect(),
        Input::TABLE.iter().collect(),
        seen().map(|(_, row)| row).collect(),
    ]
}

impl System {
    /// Matrices by name, `A` to `D`.
    fn matrices(&self) -> [(&'static str, &DMatrix<f64>); 4] {
        let m = &self.matrices;
        [("A", &m.a), ("B", &m.b), ("C", &m.c), ("D", &m.d)]
    }

    /// Rows by what they are of the system.
    fn rows(&self) -> [(&'static str, Vec<&'static Quantity>); 3] {
        let [states, inputs, outputs] = rows(&self.matrices);
        [("state", states), ("input", inputs), ("output", outputs)]
    }

    /// The motion that changes are counted from, in the convention of the matrices: `x0`, `u0`, `y0`
    /// in the order of states, inputs and outputs.
    fn about(&self) -> [(&'static str, Vec<f64>); 3] {
        let [states, inputs, outputs] = rows(&self.matrices);
        let signed = |rows: Vec<&'static Quantity>, values: &[f64]| {
            let turned = |name| self.signs == Signs::Literature && is_turned(name);
            let one = |(row, value): (&Quantity, &f64)| {
                if turned(row.name) {
                    0.0 - *value
                } else {
                    *value
                }
            };
            rows.into_iter().zip(values).map(one).collect()
        };
        let seen: Vec<f64> = seen().map(|(i, _)| self.output.get(i)).collect();
        [
            ("x0", signed(states, &self.state.to_array())),
            ("u0", signed(inputs, &self.input.to_array())),
            ("y0", signed(outputs, &seen)),
        ]
    }

    fn convention(&self) -> &'static str {
        match self.signs {
            Signs::Iso8855 => "iso8855",
            Signs::Literature => "literature",
        }
    }

    /// `A` to `D` by rows; `states`, `inputs`, `outputs` and their `_units`; the motion that changes
    /// are counted from, `x0`, `u0`, `y0`; `formulation`, `signs`, `notes`.
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
        whole.insert("formulation".into(), json!(self.formulation.name()));
        whole.insert("signs".into(), json!(self.convention()));
        whole.insert("notes".into(), json!(self.notes));
        Value::Object(whole)
    }

    /// The same as a MAT-file of level 5: matrices, columns, cell arrays of names, texts.
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
            file.matrix(name, &DMatrix::from_vec(value.len(), 1, value));
        }
        file.text("formulation", self.formulation.name());
        file.text("signs", self.convention());
        file.into_bytes()
    }

    /// The four matrices as plain text.
    pub fn table(&self) -> String {
        use std::fmt::Write as _;
        let [(_, states), (_, inputs), (_, outputs)] = self.rows();
        let mut text = format!("{}, signs {}\n", self.formulation.name(), self.convention());
        for ((name, values), rows) in self.about().iter().zip([&states, &inputs, &outputs]) {
            let _ = write!(text, "\n{name}");
            for (row, value) in rows.iter().zip(values).filter(|(_, value)| **value != 0.0) {
                let _ = write!(text, "  {} {value:.6} {}", row.name, row.unit.symbol);
            }
        }
        text.push('\n');
        let shapes = [
            (&states, &states),
            (&states, &inputs),
            (&outputs, &states),
            (&outputs, &inputs),
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
