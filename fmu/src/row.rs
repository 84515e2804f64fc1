//! One numbering for all variables: the value references.

use bicycle::{Derived, Input, Output, Parameters, Quantity};

/// A variable of the FMU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Row {
    /// A row of the parameter table.
    Parameter(usize),
    /// How the equations are read.
    Formulation,
    /// A row of the input table.
    Input(usize),
    /// A row of the output table.
    Output(usize),
    /// A row of the table of derived quantities, a local variable.
    Derived(usize),
    /// Time.
    Time,
}

const FORMULATION: usize = Parameters::LEN;
const INPUTS: usize = FORMULATION + 1;
const OUTPUTS: usize = INPUTS + Input::LEN;
const DERIVED: usize = OUTPUTS + Output::LEN;
const TIME: usize = DERIVED + Derived::LEN;

impl Row {
    /// Number of rows.
    pub(crate) const COUNT: usize = TIME + 1;

    /// All rows in their order.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        (0..Self::COUNT).map(|number| Self::at(number as u32))
    }

    /// The row with this value reference.
    pub(crate) fn at(reference: u32) -> Self {
        match reference as usize {
            row @ ..FORMULATION => Self::Parameter(row),
            FORMULATION => Self::Formulation,
            row @ INPUTS..OUTPUTS => Self::Input(row - INPUTS),
            row @ OUTPUTS..DERIVED => Self::Output(row - OUTPUTS),
            row @ DERIVED..TIME => Self::Derived(row - DERIVED),
            _ => Self::Time,
        }
    }

    /// Its value reference.
    pub(crate) const fn reference(self) -> u32 {
        let row = match self {
            Self::Parameter(row) => row,
            Self::Formulation => FORMULATION,
            Self::Input(row) => INPUTS + row,
            Self::Output(row) => OUTPUTS + row,
            Self::Derived(row) => DERIVED + row,
            Self::Time => TIME,
        };
        row as u32
    }

    /// Its 1-based position among the variables of the description.
    pub(crate) fn index(self) -> u32 {
        self.reference() + 1
    }

    /// Its row in a table of `bicycle`, if it is one.
    pub(crate) fn quantity(self) -> Option<&'static Quantity> {
        match self {
            Self::Parameter(row) => Some(&Parameters::TABLE[row]),
            Self::Input(row) => Some(&Input::TABLE[row]),
            Self::Output(row) => Some(&Output::TABLE[row]),
            Self::Derived(row) => Some(&Derived::TABLE[row]),
            Self::Formulation | Self::Time => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbering_goes_both_ways() {
        for (number, row) in Row::all().enumerate() {
            assert_eq!(row.reference() as usize, number, "{row:?}");
        }
        assert_eq!(Row::all().last(), Some(Row::Time));
    }
}
