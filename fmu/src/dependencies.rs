//! Which outputs depend on which parameters and inputs: the equations are run on a scalar that
//! remembers what went into it.

use crate::row::Row;
use bicycle::dynamics::output;
use bicycle::{Bicycle, Formulation, Input, Output, Parameters, Path, Quantity, Real, State};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A set of rows, one bit each by value reference.
type Rows = u128;
const _: () = assert!(Row::COUNT <= Rows::BITS as usize);

/// A number and the rows it was computed from.
#[derive(Clone, Copy)]
struct Traced {
    value: f64,
    from: Rows,
    /// Zero wherever we are: the heading at the start turns no speed sideways.
    naught: bool,
}

impl Traced {
    const NAUGHT: Self = Self {
        value: 0.0,
        from: 0,
        naught: true,
    };

    /// The value of a row.
    fn of(row: Row, value: f64) -> Self {
        Self {
            value,
            from: 1 << row.reference(),
            naught: false,
        }
    }

    /// The values of rows that are outputs of the same name.
    fn each<const N: usize>(table: &[Quantity], values: &[f64; N]) -> [Self; N] {
        std::array::from_fn(|row| {
            let output = Output::index(table[row].name).expect("every state is an output");
            Self::of(Row::Output(output), values[row])
        })
    }

    /// What two numbers make together.
    fn join(self, other: Self, value: f64) -> Self {
        Self {
            value,
            from: self.from | other.from,
            naught: false,
        }
    }
}

impl From<f64> for Traced {
    fn from(value: f64) -> Self {
        Self {
            value,
            from: 0,
            naught: value == 0.0,
        }
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
}

impl Mul for Traced {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        if self.naught || other.naught {
            Self::NAUGHT
        } else {
            self.join(other, self.value * other.value)
        }
    }
}

impl Div for Traced {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        if self.naught {
            Self::NAUGHT
        } else {
            self.join(other, self.value / other.value)
        }
    }
}

impl Real for Traced {
    fn is_zero(&self) -> bool {
        self.value == 0.0
    }
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = Real::sin_cos(self.value);
        let cos = Self {
            value: cos,
            naught: false,
            ..self
        };
        (Self { value: sin, ..self }, cos)
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

/// For each output the 1-based indices of the inputs and continuous states it depends on at a
/// communication point.
pub(crate) fn at_communication_points() -> Vec<Vec<u32>> {
    let mut parameters = Parameters::default();
    start_aslant(&mut parameters);
    let state = Traced::each(State::TABLE, &parameters.start().to_array());
    let path = Traced::each(Path::TABLE, &[0.0; Path::LEN]);
    // a parameter that is 0 here need not be elsewhere
    let parameters = parameters.map(|value| Traced {
        naught: false,
        ..Traced::from(value)
    });
    collect(
        &parameters,
        &State::from_array(state),
        &Path::from_array(path),
    )
    .map(|rows| indices(rows & !(FORMULATION | RELAXATION)))
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
    let path = Path::from_array([Traced::NAUGHT; Path::LEN]);
    collect(&parameters, &parameters.start(), &path)
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

/// Rows that are not computed with but decide how it is done.
const FORMULATION: Rows = 1 << Row::Formulation.reference();
const RELAXATION: Rows = {
    let row = Parameters::index("relaxation_length").expect("a row");
    1 << Row::Parameter(row).reference()
};

/// What each output is made of in any formulation, with and without relaxing tyres, and whether
/// these choices matter.
fn collect(
    parameters: &Parameters<Traced>,
    state: &State<Traced>,
    path: &Path<Traced>,
) -> impl Iterator<Item = Rows> + use<> {
    let mut row = (0..).map(Row::Input);
    let input = Input::default().map(|value: f64| {
        let row = row.next().expect("an endless sequence");
        Traced::of(row, value)
    });
    let seen = |parameters: &Parameters<Traced>, formulation| {
        let bicycle = Bicycle::new(parameters, formulation);
        output(&bicycle, state, path, &input).to_array()
    };
    let outputs = Formulation::ALL.map(|formulation| seen(parameters, formulation));
    let stiff = Parameters {
        relaxation_length: Traced::from(0.0),
        ..*parameters
    };
    let relaxed = seen(parameters, Formulation::WhippleSlip);
    let unrelaxed = seen(&stiff, Formulation::WhippleSlip);
    (0..Output::LEN).map(move |row| {
        let of = outputs.map(|output| output[row]);
        let mut rows = of
            .iter()
            .fold(unrelaxed[row].from, |rows, traced| rows | traced.from);
        if of.iter().any(|traced| traced.value != of[0].value) {
            rows |= FORMULATION;
        }
        if relaxed[row].value != unrelaxed[row].value {
            rows |= RELAXATION;
        }
        rows
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
