//! Derivatives: of outputs with respect to inputs, and of inputs and outputs with respect to time
//! (FMI 2.0 §2.1.9, §4.2.1).

use super::{Instance, capable, same_length};
use crate::Error;
use model_description::CoSimulation;

impl Instance<'_> {
    /// Writes into `sensitivity`, one for each of `unknowns`, how these change when `knowns` change
    /// by `seed`. Needs `providesDirectionalDerivative`.
    pub fn get_directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        sensitivity: &mut [f64],
    ) -> Result<(), Error> {
        const FUNCTION: &str = "fmi2GetDirectionalDerivative";
        let get_directional_derivative = capable(
            FUNCTION,
            self.core.fmu.functions.get_directional_derivative,
            "providesDirectionalDerivative",
            self.declares(|c| c.provides_directional_derivative),
        )?;
        same_length(knowns.len(), seed.len())?;
        same_length(unknowns.len(), sensitivity.len())?;
        self.core.call(FUNCTION, |i| {
            // SAFETY: the component is alive, the arrays have the lengths given.
            unsafe {
                get_directional_derivative(
                    i.component,
                    unknowns.as_ptr(),
                    unknowns.len(),
                    knowns.as_ptr(),
                    knowns.len(),
                    seed.as_ptr(),
                    sensitivity.as_mut_ptr(),
                )
            }
        })
    }

    /// Sets derivatives of inputs with respect to time, each of its order, 1 or higher, for the
    /// next step. Needs `canInterpolateInputs`.
    pub fn set_real_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Result<(), Error> {
        const FUNCTION: &str = "fmi2SetRealInputDerivatives";
        let set_real_input_derivatives = capable(
            FUNCTION,
            self.core.fmu.functions.set_real_input_derivatives,
            "canInterpolateInputs",
            self.declares(|c| c.can_interpolate_inputs),
        )?;
        same_length(references.len(), orders.len())?;
        same_length(references.len(), values.len())?;
        self.core.call(FUNCTION, |i| {
            // SAFETY: the component is alive, the three arrays have the length given.
            unsafe {
                set_real_input_derivatives(
                    i.component,
                    references.as_ptr(),
                    references.len(),
                    orders.as_ptr(),
                    values.as_ptr(),
                )
            }
        })
    }

    /// Reads derivatives of outputs with respect to time, each of its order, 1 or higher. Needs
    /// `maxOutputDerivativeOrder` above 0.
    pub fn get_real_output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &mut [f64],
    ) -> Result<(), Error> {
        const FUNCTION: &str = "fmi2GetRealOutputDerivatives";
        let get_real_output_derivatives = capable(
            FUNCTION,
            self.core.fmu.functions.get_real_output_derivatives,
            "maxOutputDerivativeOrder",
            self.declares(|c| c.max_output_derivative_order > 0),
        )?;
        same_length(references.len(), orders.len())?;
        same_length(references.len(), values.len())?;
        self.core.call(FUNCTION, |i| {
            // SAFETY: the component is alive, the three arrays have the length given.
            unsafe {
                get_real_output_derivatives(
                    i.component,
                    references.as_ptr(),
                    references.len(),
                    orders.as_ptr(),
                    values.as_mut_ptr(),
                )
            }
        })
    }

    /// Whether the description declares a capability.
    pub(super) fn declares(&self, capability: impl FnOnce(&CoSimulation) -> bool) -> bool {
        let description = self.core.fmu.description();
        description.co_simulation.as_ref().is_some_and(capability)
    }
}
