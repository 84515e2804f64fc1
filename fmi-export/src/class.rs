//! What all instances of a model in a process share: the description's rules, and saved states.

use crate::instance::Snapshot;
use crate::saved::Saved;
use crate::variables::Variables;
use crate::{Error, Model};
use model_description::Category;
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// A model as its description presents it, worked out once.
#[derive(Debug)]
pub(crate) struct Class<M> {
    pub(crate) guid: String,
    pub(crate) variables: Variables,
    pub(crate) categories: Vec<Category>,
    pub(crate) interpolates_inputs: bool,
    pub(crate) differentiates: bool,
    pub(crate) output_derivative_order: u32,
    pub(crate) saved: Saved<Snapshot<M>>,
}

impl<M: Model> Class<M> {
    pub(crate) fn new() -> Result<Arc<Self>, Error> {
        let description = M::description();
        let capabilities = description
            .co_simulation
            .as_ref()
            .ok_or_else(|| Error::Description("expected CoSimulation, found none".to_owned()))?;
        Ok(Arc::new(Self {
            guid: description.fingerprint(),
            variables: Variables::new(&description)?,
            interpolates_inputs: capabilities.can_interpolate_inputs,
            differentiates: capabilities.provides_directional_derivative,
            output_derivative_order: capabilities.max_output_derivative_order,
            categories: description.log_categories,
            saved: Saved::default(),
        }))
    }
}

/// Keeps the class from the first instance to the last, so that neither each instance nor an
/// unloaded library has to pay for it.
#[derive(Debug)]
pub struct Shared<M>(Mutex<Weak<Class<M>>>);

impl<M: Model> Shared<M> {
    /// Without instances.
    #[expect(
        clippy::new_without_default,
        reason = "a static needs a const function"
    )]
    pub const fn new() -> Self {
        Self(Mutex::new(Weak::new()))
    }

    /// The class, made if there is none.
    pub(crate) fn class(&self) -> Result<Arc<Class<M>>, Error> {
        let mut shared = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(class) = shared.upgrade() {
            return Ok(class);
        }
        let class = Class::new()?;
        *shared = Arc::downgrade(&class);
        Ok(class)
    }

    /// Lets go of what an unloaded library could not free, if no instance is left.
    pub(crate) fn release(&self) {
        let mut shared = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if shared.strong_count() == 0 {
            *shared = Weak::new();
        }
    }
}
