//! A model's variables as a table: one row makes the field, its start value, its place in the
//! description, and how it is read and set.

use crate::{Choices, Value, log_categories};
use model_description::{
    BooleanVariable, Causality, CoSimulation, DefaultExperiment, EnumerationType,
    EnumerationVariable, Initial, IntegerVariable, Item, ModelDescription, ModelStructure,
    RealVariable, ScalarVariable, SimpleType, StringVariable, TypeDefinition, Unit, Unknown,
    Variability, VariableType,
};

/// Makes a struct whose fields are the variables of a model, in the order of their value
/// references.
///
/// ```
/// fmi_export::variables! {
///     /// A spring.
///     pub struct Spring {
///         stiffness: f64 = 100.0, Parameter Tunable, unit "N/m", in [0.0, 1e6], "Stiffness";
///         stretch: f64 = 0.0, Input Continuous, unit "m", "How far it is stretched";
///         force: f64 = 0.0, Output Continuous, unit "N", from [stretch], "Force";
///         broken: bool = false, Local Discrete, "Whether it broke";
///         time: f64 = 0.0, Independent Continuous, unit "s", "Time";
///     }
/// }
/// assert_eq!(Spring::default().stiffness, 100.0);
/// ```
///
/// A row is `name: type = start, causality variability, … "description";` with the names of
/// [`Causality`] and [`Variability`]. The type is `f64`, `i32`, `bool`, `String` or one made by
/// [`enumeration!`](crate::enumeration). In between may stand, in this order:
/// - `initial Exact`: an output or local whose start value can be set;
/// - `unit "…"`;
/// - `in [smallest, largest]`, for numbers;
/// - `derivative of name`: of a continuous state of this table;
/// - `from [names]`: what an output or derivative depends on at a communication point; without it, on
///   nothing.
///
/// The struct gets `Clone`, `Debug`, `Default`, serde's `Serialize` and `Deserialize`, and the
/// functions `rows`, `value` and `assign`, which are what a [`Model`](crate::Model) needs.
#[macro_export]
macro_rules! variables {
    (
        $(#[$outer:meta])*
        $vis:vis struct $Name:ident {
            $(
                $field:ident: $type:ty = $start:expr, $causality:ident $variability:ident,
                $(initial $initial:ident,)?
                $(unit $unit:literal,)?
                $(in [$min:expr, $max:expr],)?
                $(derivative of $state:ident,)?
                $(from [$($known:ident),*],)?
                $what:literal;
            )*
        }
    ) => {
        $(#[$outer])*
        #[derive(Clone, Debug, $crate::serde::Serialize, $crate::serde::Deserialize)]
        #[serde(crate = "fmi_export::serde")]
        $vis struct $Name {
            $(
                #[doc = $what]
                pub $field: $type,
            )*
        }

        impl Default for $Name {
            /// Start values.
            fn default() -> Self {
                Self { $($field: $start,)* }
            }
        }

        impl $Name {
            /// The rows of the table.
            pub fn rows() -> Vec<$crate::Row> {
                use $crate::model_description::{Causality, Initial, Variability};
                vec![$(
                    {
                        let start: $type = $start;
                        $crate::Row::new(
                            stringify!($field),
                            $crate::Scalar::into_value(start),
                            Causality::$causality,
                            Variability::$variability,
                            $what,
                        )
                        .choices(<$type as $crate::Scalar>::choices())
                        $(.initial(Initial::$initial))?
                        $(.unit($unit))?
                        $(.range($min, $max))?
                        $(.derivative_of(stringify!($state)))?
                        $(.from(&[$(stringify!($known)),*]))?
                    },
                )*]
            }

            /// The value of a row.
            #[inline]
            pub fn value(&self, reference: u32) -> $crate::Value {
                let mut row = 0..;
                $(
                    if row.next() == Some(reference) {
                        return $crate::Scalar::into_value(self.$field.clone());
                    }
                )*
                unreachable!("the instance refuses value reference {reference}")
            }

            /// Gives a row a value of its type.
            #[inline]
            pub fn assign(&mut self, reference: u32, value: $crate::Value) {
                let mut row = 0..;
                $(
                    if row.next() == Some(reference) {
                        if let Ok(value) = $crate::Scalar::from_value(value) {
                            self.$field = value;
                        }
                        return;
                    }
                )*
            }
        }
    };
}

/// Makes an enumeration that a row of [`variables!`](crate::variables) may have as its type; the
/// first choice is 1, and the default.
///
/// ```
/// fmi_export::enumeration! {
///     /// How it goes.
///     pub enum Gait {
///         Walk = "one foot on the ground",
///         Run = "sometimes none",
///     }
/// }
/// fmi_export::variables! {
///     /// A walker.
///     pub struct Walker {
///         gait: Gait = Gait::Walk, Parameter Fixed, "Gait";
///     }
/// }
/// assert_eq!(fmi_export::describe("Walker", "A walker", &Walker::rows()).types[0].name, "Gait");
/// ```
#[macro_export]
macro_rules! enumeration {
    (
        $(#[$outer:meta])*
        $vis:vis enum $Name:ident {
            $($choice:ident = $what:literal),* $(,)?
        }
    ) => {
        $(#[$outer])*
        #[derive(
            Clone, Copy, Debug, PartialEq, Eq, $crate::serde::Serialize, $crate::serde::Deserialize,
        )]
        #[serde(crate = "fmi_export::serde")]
        $vis enum $Name {
            $(
                #[doc = $what]
                $choice,
            )*
        }

        impl $crate::Scalar for $Name {
            const KIND: $crate::Kind = $crate::Kind::Integer;
            const GET: $crate::Function = $crate::Function::GetInteger;
            const SET: $crate::Function = $crate::Function::SetInteger;
            fn choices() -> Option<$crate::Choices> {
                Some((stringify!($Name), &[$((stringify!($choice), $what)),*]))
            }
            fn number(&self) -> Option<f64> {
                Some(f64::from(*self as i32 + 1))
            }
            fn into_value(self) -> $crate::Value {
                $crate::Value::Integer(self as i32 + 1)
            }
            fn from_value(value: $crate::Value) -> Result<Self, $crate::Value> {
                [$(Self::$choice),*]
                    .into_iter()
                    .find(|choice| $crate::Scalar::into_value(*choice) == value)
                    .ok_or(value)
            }
        }
    };
}

/// A row of a table that [`variables!`](crate::variables) makes.
#[derive(Clone, Debug)]
pub struct Row {
    name: &'static str,
    start: Value,
    causality: Causality,
    variability: Variability,
    what: &'static str,
    initial: Option<Initial>,
    unit: Option<&'static str>,
    range: Option<(f64, f64)>,
    derivative_of: Option<&'static str>,
    from: &'static [&'static str],
    choices: Option<Choices>,
}

impl Row {
    /// A row without what may be left out.
    pub fn new(
        name: &'static str,
        start: Value,
        causality: Causality,
        variability: Variability,
        what: &'static str,
    ) -> Self {
        Self {
            name,
            start,
            causality,
            variability,
            what,
            initial: None,
            unit: None,
            range: None,
            derivative_of: None,
            from: &[],
            choices: None,
        }
    }

    /// Of an enumeration.
    #[must_use]
    pub fn choices(self, choices: Option<Choices>) -> Self {
        Self { choices, ..self }
    }

    /// With another `initial` than its causality and variability imply.
    #[must_use]
    pub fn initial(self, initial: Initial) -> Self {
        Self {
            initial: Some(initial),
            ..self
        }
    }

    /// With a unit.
    #[must_use]
    pub fn unit(self, unit: &'static str) -> Self {
        Self {
            unit: Some(unit),
            ..self
        }
    }

    /// With a smallest and a largest value.
    #[must_use]
    pub fn range(self, min: impl Into<f64>, max: impl Into<f64>) -> Self {
        Self {
            range: Some((min.into(), max.into())),
            ..self
        }
    }

    /// The derivative of another row.
    #[must_use]
    pub fn derivative_of(self, state: &'static str) -> Self {
        Self {
            derivative_of: Some(state),
            ..self
        }
    }

    /// Depends on other rows at a communication point.
    #[must_use]
    pub fn from(self, known: &'static [&'static str]) -> Self {
        Self {
            from: known,
            ..self
        }
    }

    fn variable(&self, reference: u32, rows: &[Self]) -> ScalarVariable {
        let mut variable = ScalarVariable {
            name: self.name.to_owned(),
            value_reference: reference,
            description: Some(self.what.to_owned()),
            causality: self.causality,
            variability: self.variability,
            initial: self.initial,
            variable_type: VariableType::String(StringVariable::default()),
        };
        let starts = self.causality == Causality::Input
            || matches!(variable.initial(), Some(Initial::Exact | Initial::Approx));
        let whole = |bound: f64| bound as i32;
        variable.variable_type = match (self.start.clone(), self.choices) {
            (Value::Integer(start), Some((name, _))) => {
                VariableType::Enumeration(EnumerationVariable {
                    declared_type: name.to_owned(),
                    start: starts.then_some(start),
                    ..EnumerationVariable::default()
                })
            }
            (Value::Real(start), _) => VariableType::Real(RealVariable {
                unit: self.unit.map(str::to_owned),
                min: self.range.map(|(min, _)| min).filter(|min| min.is_finite()),
                max: self.range.map(|(_, max)| max).filter(|max| max.is_finite()),
                start: starts.then_some(start),
                derivative: self.derivative_of.map(|state| index(rows, state)),
                ..RealVariable::default()
            }),
            (Value::Integer(start), _) => VariableType::Integer(IntegerVariable {
                min: self.range.map(|(min, _)| whole(min)),
                max: self.range.map(|(_, max)| whole(max)),
                start: starts.then_some(start),
                ..IntegerVariable::default()
            }),
            (Value::Boolean(start), _) => VariableType::Boolean(BooleanVariable {
                start: starts.then_some(start),
                ..BooleanVariable::default()
            }),
            (Value::String(start), _) => VariableType::String(StringVariable {
                start: starts.then_some(start),
                ..StringVariable::default()
            }),
        };
        variable
    }
}

/// The 1-based position of the row called `name`.
fn index(rows: &[Row], name: &str) -> u32 {
    let row = rows.iter().position(|row| row.name == name);
    let row =
        row.unwrap_or_else(|| panic!("the table refers to {name}, which is none of its rows"));
    row as u32 + 1
}

/// What this crate provides for every model. Set `can_interpolate_inputs`,
/// `provides_directional_derivative` and `max_output_derivative_order` where the model overrides
/// the methods behind them.
pub fn co_simulation(model_identifier: &str) -> CoSimulation {
    CoSimulation {
        model_identifier: model_identifier.to_owned(),
        can_handle_variable_communication_step_size: true,
        can_not_use_memory_management_functions: true,
        can_get_and_set_fmu_state: true,
        can_serialize_fmu_state: true,
        ..CoSimulation::default()
    }
}

/// The description of a model called `name`, from its table.
pub fn describe(name: &str, what: &str, rows: &[Row]) -> ModelDescription {
    let variables: Vec<_> = (0..)
        .zip(rows)
        .map(|(reference, row)| row.variable(reference, rows))
        .collect();
    let mut enumerations: Vec<Choices> = rows.iter().filter_map(|row| row.choices).collect();
    enumerations.sort_unstable();
    enumerations.dedup();
    let mut units: Vec<&str> = rows.iter().filter_map(|row| row.unit).collect();
    units.sort_unstable();
    units.dedup();
    let unknowns = |wanted: &dyn Fn(&Row, &ScalarVariable) -> bool, known: bool| {
        (1..)
            .zip(rows.iter().zip(&variables))
            .filter(|(_, (row, variable))| wanted(row, variable))
            .map(|(position, (row, _))| Unknown {
                index: position,
                dependencies: known.then(|| {
                    let mut from: Vec<u32> =
                        row.from.iter().map(|name| index(rows, name)).collect();
                    from.sort_unstable();
                    from
                }),
                dependencies_kind: None,
            })
            .collect()
    };
    let is_state = |name: &str| rows.iter().any(|row| row.derivative_of == Some(name));
    let structure = ModelStructure {
        outputs: unknowns(&|row, _| row.causality == Causality::Output, true),
        derivatives: unknowns(&|row, _| row.derivative_of.is_some(), true),
        // They depend on anything: what a model makes of its parameters is its own affair.
        initial_unknowns: unknowns(
            &|row, variable| {
                matches!(
                    variable.initial(),
                    Some(Initial::Calculated | Initial::Approx)
                ) && (matches!(
                    row.causality,
                    Causality::Output | Causality::CalculatedParameter
                ) || row.derivative_of.is_some()
                    || is_state(row.name))
            },
            false,
        ),
    };
    ModelDescription {
        model_name: name.to_owned(),
        description: Some(what.to_owned()),
        generation_tool: Some(concat!("fmi-export ", env!("CARGO_PKG_VERSION")).to_owned()),
        co_simulation: Some(co_simulation(name)),
        units: units
            .into_iter()
            .map(|unit| Unit {
                name: unit.to_owned(),
                ..Unit::default()
            })
            .collect(),
        types: enumerations.into_iter().map(simple_type).collect(),
        log_categories: log_categories(),
        default_experiment: Some(DefaultExperiment {
            start_time: Some(0.0),
            ..DefaultExperiment::default()
        }),
        structure,
        variables,
        ..ModelDescription::default()
    }
}

fn simple_type((name, choices): Choices) -> SimpleType {
    let item = |(value, (name, what)): (i32, &(&str, &str))| Item {
        name: (*name).to_owned(),
        value,
        description: Some((*what).to_owned()),
    };
    SimpleType {
        name: name.to_owned(),
        description: None,
        definition: TypeDefinition::Enumeration(EnumerationType {
            quantity: None,
            items: (1..).zip(choices).map(item).collect(),
        }),
    }
}

/// modelDescription.xml of a model, guid included: what its golden file holds.
pub fn xml<M: crate::Model>() -> Result<String, crate::Error> {
    let mut description = M::description();
    description.guid = description.fingerprint();
    Ok(description.to_xml()?)
}
