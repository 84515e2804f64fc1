//! Which outputs depend on which parameters and inputs: the equations are run on a scalar that
//! remembers what went into it.

use crate::row::Row;
use bicycle::dynamics::output;
use bicycle::{Bicycle, Formulation, Input, Output, Parameters, Path, Real, State};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A set of rows, one bit each by value reference.
type Rows = u128;
const _: () = assert!(Row::COUNT <= Rows::BITS as usize);

/// A number and the rows it was computed from.
#[derive(Clone, Copy)]
struct Traced {
    value: f64,
    from: Rows,
}

impl Traced {
    /// The value of a row.
    fn of(row: Row, value: f64) -> Self {
        Self {
            value,
            from: 1 << row.reference(),
        }
    }

    /// What two numbers make together.
    fn join(self, other: Self, value: f64) -> Self {
        Self {
            value,
            from: self.from | other.from,
        }
    }
}

impl From<f64> for Traced {
    fn from(value: f64) -> Self {
        Self { value, from: 0 }
    }
}

impl Neg for Traced {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            value: -self.value,
            ..self
        }
    }
}

macro_rules! binary {
    ($($Trait:ident $method:ident;)*) => {
        $(
            impl $Trait for Traced {
                type Output = Self;
                fn $method(self, other: Self) -> Self {
                    self.join(other, $Trait::$method(self.value, other.value))
                }
            }
        )*
    };
}
binary! {
    Add add;
    Sub sub;
    Mul mul;
    Div div;
}

impl Real for Traced {
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = Real::sin_cos(self.value);
        (Self { value: sin, ..self }, Self { value: cos, ..self })
    }
    fn atan(self) -> Self {
        Self {
            value: Real::atan(self.value),
            ..self
        }
    }
    fn sqrt(self) -> Self {
        Self {
            value: self.value.sqrt(),
            ..self
        }
    }
}

/// For each output the 1-based indices of the inputs it depends on at a communication point,
/// where the state is what it is.
pub(crate) fn at_communication_points() -> Vec<Vec<u32>> {
    let mut parameters = Parameters::default();
    start_aslant(&mut parameters);
    let state = state(&parameters).map(Traced::from);
    collect(&parameters.map(Traced::from), &state)
        .map(|rows| indices(rows & !(1 << Row::Formulation.reference())))
        .collect()
}

/// For each output the 1-based indices of the parameters and inputs it depends on at the start.
pub(crate) fn at_the_start() -> Vec<Vec<u32>> {
    let mut parameters = Parameters::default();
    start_aslant(&mut parameters);
    let mut row = (0..).map(Row::Parameter);
    let parameters = parameters.map(|value| {
        let row = row.next().expect("an endless sequence");
        Traced::of(row, value)
    });
    collect(&parameters, &state(&parameters))
        .map(indices)
        .collect()
}

/// A start where no formulation agrees with another by symmetry.
fn start_aslant(parameters: &mut Parameters) {
    parameters.roll_rate_start = 0.1;
    parameters.steer_rate_start = 0.2;
    parameters.roll_start = 0.3;
    parameters.steer_start = 0.4;
    parameters.yaw_rate_start = 0.5;
}

/// The state at the start.
fn state<T: Copy>(p: &Parameters<T>) -> State<T> {
    State {
        roll_rate: p.roll_rate_start,
        steer_rate: p.steer_rate_start,
        roll: p.roll_start,
        steer: p.steer_start,
        yaw_rate: p.yaw_rate_start,
    }
}

/// What each output is made of in any formulation, and whether the formulation matters.
fn collect(
    parameters: &Parameters<Traced>,
    state: &State<Traced>,
) -> impl Iterator<Item = Rows> + use<> {
    let mut row = (0..).map(Row::Input);
    let input = Input::default().map(|value: f64| {
        let row = row.next().expect("an endless sequence");
        Traced::of(row, value)
    });
    let path = Path::default();
    let outputs = Formulation::ALL.map(|formulation| {
        let bicycle = Bicycle::new(parameters, formulation);
        output(&bicycle, state, &path, &input).to_array()
    });
    (0..Output::LEN).map(move |row| {
        let of = outputs.map(|output| output[row]);
        let rows = of.iter().fold(0, |rows, traced| rows | traced.from);
        if of.iter().any(|traced| traced.value != of[0].value) {
            rows | 1 << Row::Formulation.reference()
        } else {
            rows
        }
    })
}

fn indices(rows: Rows) -> Vec<u32> {
    Row::all()
        .filter(|row| rows >> row.reference() & 1 == 1)
        .map(Row::index)
        .collect()
}

#[cfg(test)]
#[path = "dependencies/tests.rs"]
mod tests;
