//! The rules of each variable: type, range, and when it may be set, read or differentiated
//! (FMI 2.0 §2.2.7, §4.2.4).

use crate::{Error, Kind, State, Value};
use model_description::{
    Causality, Initial, ModelDescription, RealVariable, ScalarVariable, TypeDefinition, Unknown,
    Variability, VariableType,
};

/// What must be known of a variable to judge a call.
#[derive(Clone, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts")]
struct Rule {
    name: String,
    causality: Causality,
    variability: Variability,
    kind: Kind,
    type_name: &'static str,
    min: f64,
    max: f64,
    /// After a space, or nothing.
    unit: String,
    /// One for each [`State`], in its order.
    settable: [bool; 5],
    /// The model computes its value; others hold what was set.
    computed: bool,
    /// Listed as an output or a state derivative.
    unknown: bool,
    /// Listed as an initial unknown.
    initial_unknown: bool,
    /// A listed state derivative is its derivative.
    continuous_state: bool,
}

/// The rules of all variables, by value reference.
#[derive(Clone, Debug)]
pub(crate) struct Variables(Vec<Rule>);

impl Variables {
    pub(crate) fn new(description: &ModelDescription) -> Result<Self, Error> {
        let mut rules = description
            .variables
            .iter()
            .enumerate()
            .map(|(row, variable)| {
                if variable.value_reference as usize == row {
                    Rule::new(variable, description)
                } else {
                    Err(Error::Description(format!(
                        "variable {}: expected value reference {row}, its row number, found {}",
                        variable.name, variable.value_reference
                    )))
                }
            })
            .collect::<Result<Vec<_>, _>>()?;
        let structure = &description.structure;
        let mut mark = |unknowns: &[Unknown], mark: fn(&mut Rule)| {
            for unknown in unknowns {
                mark(at(&mut rules, unknown.index)?);
            }
            Ok::<(), Error>(())
        };
        mark(&structure.outputs, |rule| rule.unknown = true)?;
        mark(&structure.derivatives, |rule| rule.unknown = true)?;
        mark(&structure.initial_unknowns, |rule| {
            rule.initial_unknown = true;
        })?;
        for unknown in &structure.derivatives {
            let derivative = description.variables.get(unknown.index as usize - 1);
            let Some(VariableType::Real(RealVariable {
                derivative: Some(state),
                ..
            })) = derivative.map(|variable| &variable.variable_type)
            else {
                return Err(Error::Description(format!(
                    "derivative {}: expected a Real variable that is the derivative of another",
                    unknown.index
                )));
            };
            at(&mut rules, *state)?.continuous_state = true;
        }
        Ok(Self(rules))
    }

    #[inline]
    fn rule(&self, reference: u32) -> Result<&Rule, Error> {
        match self.0.get(reference as usize) {
            Some(rule) => Ok(rule),
            None => Err(self.unknown_reference(reference)),
        }
    }

    #[cold]
    fn unknown_reference(&self, found: u32) -> Error {
        let count = self.0.len();
        Error::UnknownReference { found, count }
    }

    /// The value reference of the variable called `name`.
    pub(crate) fn find(&self, name: &str) -> Option<u32> {
        let row = self.0.iter().position(|rule| rule.name == name)?;
        u32::try_from(row).ok()
    }

    /// Whether the variable is a `Real`.
    pub(crate) fn is_real(&self, reference: u32) -> bool {
        self.rule(reference)
            .is_ok_and(|rule| rule.kind == Kind::Real)
    }

    /// Whether the variable may be read as one of `kind`; whether the model computes it.
    #[inline]
    pub(crate) fn check_get(&self, reference: u32, kind: Kind) -> Result<bool, Error> {
        let rule = self.rule(reference)?;
        rule.check_kind(kind)?;
        Ok(rule.computed)
    }

    /// Whether the variable may be set in `state` to a value of `kind`, if a number to `number`.
    #[inline]
    pub(crate) fn check_set(
        &self,
        reference: u32,
        kind: Kind,
        number: Option<f64>,
        state: State,
    ) -> Result<(), Error> {
        let rule = self.rule(reference)?;
        rule.check_kind(kind)?;
        if !rule.settable[state as usize] {
            return Err(rule.not_settable(state));
        }
        number.map_or(Ok(()), |found| rule.check_range(found, ""))
    }

    /// Whether the variable is an input whose slope may be set to `slope`, a derivative of `order`.
    pub(crate) fn check_slope(&self, reference: u32, order: i32, slope: f64) -> Result<(), Error> {
        let rule = self.rule(reference)?;
        rule.check_kind(Kind::Real)?;
        if rule.causality != Causality::Input || rule.variability != Variability::Continuous {
            return Err(Error::NoDerivative {
                name: rule.name.clone(),
                expected: "a continuous input",
            });
        }
        rule.check_order(order)?;
        if slope.is_finite() {
            Ok(())
        } else {
            Err(rule.not_finite(slope))
        }
    }

    /// Whether a ramp may reach `end` within a step.
    pub(crate) fn check_ramp(&self, reference: u32, end: f64) -> Result<(), Error> {
        self.rule(reference)?
            .check_range(end, " at the end of the step")
    }

    /// Whether the variable is an output whose derivative of `order` can be read.
    pub(crate) fn check_rate(&self, reference: u32, order: i32) -> Result<(), Error> {
        let rule = self.rule(reference)?;
        rule.check_kind(Kind::Real)?;
        if rule.causality != Causality::Output || rule.variability != Variability::Continuous {
            return Err(Error::NoDerivative {
                name: rule.name.clone(),
                expected: "a continuous output",
            });
        }
        rule.check_order(order)
    }

    /// Whether directional derivatives of the variable exist in `state` (FMI 2.0 §2.1.9).
    pub(crate) fn check_unknown(&self, reference: u32, state: State) -> Result<(), Error> {
        let rule = self.rule(reference)?;
        rule.check_kind(Kind::Real)?;
        let (listed, expected) = if state == State::Initialization {
            (rule.initial_unknown, "an initial unknown")
        } else {
            (rule.unknown, "an output or a state derivative")
        };
        if listed {
            Ok(())
        } else {
            Err(Error::NoDerivative {
                name: rule.name.clone(),
                expected,
            })
        }
    }

    /// Whether directional derivatives by the variable exist in `state` (FMI 2.0 §2.1.9).
    pub(crate) fn check_known(&self, reference: u32, state: State) -> Result<(), Error> {
        let rule = self.rule(reference)?;
        rule.check_kind(Kind::Real)?;
        let (known, expected) = if state == State::Initialization {
            let known = rule.settable[State::Initialization as usize];
            (known, "an input or a variable with an exact start value")
        } else {
            let known = rule.causality == Causality::Input || rule.continuous_state;
            (known, "an input or a continuous state")
        };
        if known {
            Ok(())
        } else {
            Err(Error::NoDerivative {
                name: rule.name.clone(),
                expected,
            })
        }
    }

    /// Whether a derivative may be asked for along so much of the variable.
    pub(crate) fn check_seed(&self, reference: u32, seed: f64) -> Result<(), Error> {
        if seed.is_finite() {
            Ok(())
        } else {
            Err(self.rule(reference)?.not_finite(seed))
        }
    }

    /// Whether each variable that could be set, read by `get`, has a value that could be.
    pub(crate) fn check_all(&self, get: impl Fn(u32) -> Value) -> Result<(), Error> {
        for (reference, rule) in (0..).zip(&self.0) {
            if rule.settable[State::Instantiated as usize] {
                let value = get(reference);
                rule.check_kind(value.kind())?;
                value
                    .number()
                    .map_or(Ok(()), |found| rule.check_range(found, ""))?;
            }
        }
        Ok(())
    }

    /// The error for a model whose value is not of the described type.
    pub(crate) fn mistyped(&self, reference: u32, value: &Value) -> Error {
        let name = self.rule(reference).map_or("?", |rule| &rule.name);
        Error::Description(format!(
            "variable {name}: the model gives {value:?}, which is of another type"
        ))
    }
}

/// The rule of the variable at the 1-based position `index`.
fn at(rules: &mut [Rule], index: u32) -> Result<&mut Rule, Error> {
    let count = rules.len();
    rules
        .get_mut((index as usize).wrapping_sub(1))
        .ok_or_else(|| {
            Error::Description(format!(
                "model structure: expected an index from 1 to {count}, found {index}"
            ))
        })
}

impl Rule {
    fn new(variable: &ScalarVariable, description: &ModelDescription) -> Result<Self, Error> {
        let unbounded = (f64::NEG_INFINITY, f64::INFINITY);
        let (kind, (min, max)) = match &variable.variable_type {
            VariableType::Real(real) => {
                let declared = real.declared_type.as_deref();
                let declared = declared.and_then(|name| description.simple_type(name));
                let (min, max) = match declared.map(|simple| &simple.definition) {
                    Some(TypeDefinition::Real(declared)) => (declared.min, declared.max),
                    _ => (None, None),
                };
                (
                    Kind::Real,
                    (
                        real.min.or(min).unwrap_or(unbounded.0),
                        real.max.or(max).unwrap_or(unbounded.1),
                    ),
                )
            }
            VariableType::Integer(integer) => (
                Kind::Integer,
                (
                    integer.min.map_or(unbounded.0, f64::from),
                    integer.max.map_or(unbounded.1, f64::from),
                ),
            ),
            VariableType::Enumeration(enumeration) => {
                match description
                    .simple_type(&enumeration.declared_type)
                    .map(|simple| &simple.definition)
                {
                    // The items of an enumeration exported here are numbered without gaps.
                    Some(TypeDefinition::Enumeration(choices)) => (
                        Kind::Integer,
                        choices
                            .items
                            .iter()
                            .map(|item| f64::from(item.value))
                            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                                (low.min(value), high.max(value))
                            }),
                    ),
                    _ => {
                        return Err(Error::Description(format!(
                            "variable {}: expected an enumeration type, found {}",
                            variable.name, enumeration.declared_type
                        )));
                    }
                }
            }
            VariableType::Boolean(_) => (Kind::Boolean, unbounded),
            VariableType::String(_) => (Kind::String, unbounded),
        };
        let initial = variable.initial();
        Ok(Self {
            name: variable.name.clone(),
            causality: variable.causality,
            variability: variable.variability,
            kind,
            type_name: variable.variable_type.name(),
            min,
            max,
            unit: variable
                .unit()
                .map_or_else(String::new, |unit| format!(" {unit}")),
            settable: State::ALL.map(|state| is_settable(variable, initial, state)),
            computed: matches!(initial, Some(Initial::Calculated | Initial::Approx))
                || variable.causality == Causality::Independent,
            unknown: false,
            initial_unknown: false,
            continuous_state: false,
        })
    }

    #[inline]
    fn check_kind(&self, kind: Kind) -> Result<(), Error> {
        if self.kind == kind {
            Ok(())
        } else {
            Err(self.mistaken_for(kind))
        }
    }

    #[cold]
    fn mistaken_for(&self, found: Kind) -> Error {
        Error::WrongType {
            name: self.name.clone(),
            expected: self.type_name,
            found,
        }
    }

    fn check_order(&self, order: i32) -> Result<(), Error> {
        if order == 1 {
            Ok(())
        } else {
            Err(Error::Order {
                name: self.name.clone(),
                found: order,
            })
        }
    }

    /// `whereabouts` follows the name in the message.
    #[inline]
    fn check_range(&self, found: f64, whereabouts: &'static str) -> Result<(), Error> {
        if (self.min..=self.max).contains(&found) && found.is_finite() {
            Ok(())
        } else {
            Err(self.out_of_range(found, whereabouts))
        }
    }

    #[cold]
    fn out_of_range(&self, found: f64, whereabouts: &'static str) -> Error {
        if !found.is_finite() {
            return self.not_finite(found);
        }
        Error::OutOfRange {
            name: format!("{}{whereabouts}", self.name),
            min: self.min,
            max: self.max,
            unit: self.unit.clone(),
            found,
        }
    }

    fn not_finite(&self, found: f64) -> Error {
        Error::NotFinite {
            name: self.name.clone(),
            found,
        }
    }

    #[cold]
    fn not_settable(&self, state: State) -> Error {
        Error::NotSettable {
            name: self.name.clone(),
            causality: self.causality,
            variability: self.variability,
            state,
        }
    }
}

/// The footnotes of the table of FMI 2.0 §4.2.4. Inputs in *instantiated* are our leniency:
/// importers set them there.
fn is_settable(variable: &ScalarVariable, initial: Option<Initial>, state: State) -> bool {
    let input = variable.causality == Causality::Input;
    let constant = variable.variability == Variability::Constant;
    match state {
        State::Instantiated => {
            input || !constant && matches!(initial, Some(Initial::Exact | Initial::Approx))
        }
        State::Initialization => input || !constant && initial == Some(Initial::Exact),
        State::StepComplete => {
            input
                || variable.causality == Causality::Parameter
                    && variable.variability == Variability::Tunable
        }
        State::StepFailed | State::Terminated => false,
    }
}
