//! Derivatives of outputs and of inputs.

use super::{call, slice, slice_mut};
use crate::Model;
use fmi2::{fmi2Component, fmi2Integer, fmi2Real, fmi2Status, fmi2ValueReference};

/// `fmi2GetDirectionalDerivative`.
///
/// # Safety
/// See the module [`super`].
pub unsafe fn get_directional_derivative<M: Model>(
    c: fmi2Component,
    unknown: *const fmi2ValueReference,
    unknowns: usize,
    known: *const fmi2ValueReference,
    knowns: usize,
    seeds: *const fmi2Real,
    derivatives: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe {
        call::<M>(c, |component| {
            component.instance.directional_derivative(
                slice(unknown, unknowns, "vUnknown_ref")?,
                slice(known, knowns, "vKnown_ref")?,
                slice(seeds, knowns, "dvKnown")?,
                slice_mut(derivatives, unknowns, "dvUnknown")?,
            )
        })
    }
}

/// `fmi2SetRealInputDerivatives`.
///
/// # Safety
/// See the module [`super`].
pub unsafe fn set_real_input_derivatives<M: Model>(
    c: fmi2Component,
    references: *const fmi2ValueReference,
    count: usize,
    orders: *const fmi2Integer,
    values: *const fmi2Real,
) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe {
        call::<M>(c, |component| {
            component.instance.set_input_slopes(
                slice(references, count, "vr")?,
                slice(orders, count, "order")?,
                slice(values, count, "value")?,
            )
        })
    }
}

/// `fmi2GetRealOutputDerivatives`.
///
/// # Safety
/// See the module [`super`].
pub unsafe fn get_real_output_derivatives<M: Model>(
    c: fmi2Component,
    references: *const fmi2ValueReference,
    count: usize,
    orders: *const fmi2Integer,
    values: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe {
        call::<M>(c, |component| {
            component.instance.output_rates(
                slice(references, count, "vr")?,
                slice(orders, count, "order")?,
                slice_mut(values, count, "value")?,
            )
        })
    }
}
