//! An FMU as a participant.

use super::{Direction, Kind, Participant, Port};
use crate::simulate::start_values;
use crate::{Error, Fmu, Instance, SavedState, Step, Value};
use model_description::{
    Causality, ModelDescription, ScalarVariable, TypeDefinition, Unit, VariableType,
};

/// An instance of an FMU with its start values.
pub struct Foreign<'a> {
    instance: Instance<'a>,
    ports: Vec<Port>,
    /// For each port.
    references: Vec<u32>,
    starts: Vec<(&'a ScalarVariable, Value)>,
    kept: Option<SavedState<'a>>,
    can_vary_step: bool,
    can_keep: bool,
    /// Its life began; only reset takes it back.
    initialized: bool,
    lists: Lists,
}

/// Space for calls, one for each type.
#[derive(Default)]
struct Lists {
    references: Vec<u32>,
    places: Vec<usize>,
    reals: Vec<f64>,
    integers: Vec<i32>,
    booleans: Vec<bool>,
}

impl<'a> Foreign<'a> {
    /// An instance called `name` that will start with `starts`, names of variables and values.
    pub fn new(fmu: &'a Fmu, name: &str, starts: &[(String, Value)]) -> Result<Self, Error> {
        let starts = start_values(fmu, starts)?
            .into_iter()
            .map(|(variable, value)| (variable, value.clone()))
            .collect();
        let (ports, references) = ports(fmu.description());
        let capable = fmu.description().co_simulation.as_ref();
        Ok(Self {
            instance: fmu.instantiate(name)?,
            ports,
            references,
            starts,
            kept: None,
            can_vary_step: capable.is_some_and(|c| c.can_handle_variable_communication_step_size),
            can_keep: capable.is_some_and(|c| c.can_get_and_set_fmu_state),
            initialized: false,
            lists: Lists::default(),
        })
    }

    /// The instance.
    pub fn instance(&mut self) -> &mut Instance<'a> {
        &mut self.instance
    }

    fn set_starts(&mut self, inputs: bool) -> Result<(), Error> {
        self.starts
            .iter()
            .filter(|(variable, _)| (variable.causality == Causality::Input) == inputs)
            .try_for_each(|(variable, value)| self.instance.set(variable, value))
    }

    /// Whether all `ports` are real numbers: most are, and go in one call.
    fn all_real(&self, ports: &[usize]) -> bool {
        ports
            .iter()
            .all(|&port| self.ports[port].kind == Kind::Real)
    }

    /// Notes value references and places of those of `ports` that are of `kind`.
    fn list(&mut self, ports: &[usize], kind: Kind) {
        let Lists {
            references, places, ..
        } = &mut self.lists;
        references.clear();
        places.clear();
        for (place, &port) in ports.iter().enumerate() {
            if self.ports[port].kind == kind {
                references.push(self.references[port]);
                places.push(place);
            }
        }
    }
}

/// The variables that are numbers, and their value references.
fn ports(description: &ModelDescription) -> (Vec<Port>, Vec<u32>) {
    // ports of the variables, which ModelStructure counts from 1
    let mut port_of = vec![None; description.variables.len()];
    let mut ports = Vec::new();
    let mut references = Vec::new();
    for (place, variable) in port_of.iter_mut().zip(&description.variables) {
        let kind = match variable.variable_type {
            VariableType::Real(_) => Kind::Real,
            VariableType::Integer(_) | VariableType::Enumeration(_) => Kind::Integer,
            VariableType::Boolean(_) => Kind::Boolean,
            VariableType::String(_) => continue,
        };
        *place = Some(ports.len());
        references.push(variable.value_reference);
        ports.push(Port {
            name: variable.name.clone(),
            direction: match variable.causality {
                Causality::Input => Direction::Input,
                Causality::Output => Direction::Output,
                _ => Direction::Other,
            },
            kind,
            // a unit that is named and not defined is one all the same
            unit: description.unit(variable).cloned().or_else(|| {
                let name = variable.unit()?.to_owned();
                Some(Unit {
                    name,
                    ..Unit::default()
                })
            }),
            depends_on: Some(Vec::new()),
            nominal: nominal(variable, description),
        });
    }
    let port_at = |index: &u32| port_of.get((*index as usize).wrapping_sub(1)).copied()?;
    for unknown in &description.structure.outputs {
        if let Some(output) = port_at(&unknown.index) {
            let known = unknown.dependencies.as_ref();
            ports[output].depends_on =
                known.map(|known| known.iter().filter_map(port_at).collect());
        }
    }
    (ports, references)
}

/// Typical size of a variable, its own or its type's; 1 where none is stated (FMI 2.0 §2.2.7).
fn nominal(variable: &ScalarVariable, description: &ModelDescription) -> f64 {
    let VariableType::Real(real) = &variable.variable_type else {
        return 1.0;
    };
    let of_type = || {
        let declared = description.simple_type(real.declared_type.as_deref()?)?;
        match &declared.definition {
            TypeDefinition::Real(declared) => declared.nominal,
            _ => None,
        }
    };
    let stated = real.nominal.or_else(of_type).unwrap_or(1.0).abs();
    if stated > 0.0 && stated.is_finite() {
        stated
    } else {
        1.0
    }
}

impl Participant for Foreign<'_> {
    fn ports(&self) -> &[Port] {
        &self.ports
    }

    fn enter_initialization(&mut self, start: f64, stop: f64) -> Result<(), Error> {
        if self.initialized {
            self.kept = None;
            self.instance.reset()?;
        }
        self.initialized = true;
        self.instance.setup_experiment(None, start, Some(stop))?;
        self.set_starts(false)?;
        self.instance.enter_initialization_mode()?;
        self.set_starts(true)
    }

    fn exit_initialization(&mut self) -> Result<(), Error> {
        self.instance.exit_initialization_mode()
    }

    fn read(&mut self, ports: &[usize], values: &mut [f64]) -> Result<(), Error> {
        if ports.is_empty() {
            return Ok(());
        }
        if self.all_real(ports) {
            self.list(ports, Kind::Real);
            return self.instance.get_real(&self.lists.references, values);
        }
        self.list(ports, Kind::Real);
        let l = &mut self.lists;
        l.reals.resize(l.references.len(), 0.0);
        self.instance.get_real(&l.references, &mut l.reals)?;
        for (&place, &value) in l.places.iter().zip(&l.reals) {
            values[place] = value;
        }
        self.list(ports, Kind::Integer);
        let l = &mut self.lists;
        l.integers.resize(l.references.len(), 0);
        self.instance.get_integer(&l.references, &mut l.integers)?;
        for (&place, &value) in l.places.iter().zip(&l.integers) {
            values[place] = value.into();
        }
        self.list(ports, Kind::Boolean);
        let l = &mut self.lists;
        l.booleans.resize(l.references.len(), false);
        self.instance.get_boolean(&l.references, &mut l.booleans)?;
        for (&place, &value) in l.places.iter().zip(&l.booleans) {
            values[place] = f64::from(u8::from(value));
        }
        Ok(())
    }

    fn write(&mut self, ports: &[usize], values: &[f64]) -> Result<(), Error> {
        if ports.is_empty() {
            return Ok(());
        }
        if self.all_real(ports) {
            self.list(ports, Kind::Real);
            return self.instance.set_real(&self.lists.references, values);
        }
        self.list(ports, Kind::Real);
        let l = &mut self.lists;
        l.reals.clear();
        l.reals.extend(l.places.iter().map(|&place| values[place]));
        self.instance.set_real(&l.references, &l.reals)?;
        self.list(ports, Kind::Integer);
        let l = &mut self.lists;
        l.integers.clear();
        l.integers
            .extend(l.places.iter().map(|&place| values[place] as i32));
        self.instance.set_integer(&l.references, &l.integers)?;
        self.list(ports, Kind::Boolean);
        let l = &mut self.lists;
        l.booleans.clear();
        l.booleans
            .extend(l.places.iter().map(|&place| values[place] != 0.0));
        self.instance.set_boolean(&l.references, &l.booleans)
    }

    fn step(&mut self, point: f64, h: f64) -> Result<Step, Error> {
        self.instance.do_step(point, h)
    }

    fn can_vary_step(&self) -> bool {
        self.can_vary_step
    }

    fn can_keep(&self) -> bool {
        self.can_keep
    }

    fn keep(&mut self) -> Result<(), Error> {
        if let Some(kept) = &mut self.kept {
            return self.instance.get_fmu_state_into(kept);
        }
        self.kept = Some(self.instance.get_fmu_state()?);
        Ok(())
    }

    fn go_back(&mut self) -> Result<(), Error> {
        match &self.kept {
            Some(kept) => self.instance.set_fmu_state(kept),
            None => Err(Error::NothingKept),
        }
    }

    fn terminate(&mut self) -> Result<(), Error> {
        self.instance.terminate()
    }
}
