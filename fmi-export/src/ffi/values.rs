//! Reading and setting variables.

use super::{call, slice, slice_mut, strings, text};
use crate::{Model, Scalar};
use fmi2::{fmi2Boolean, fmi2Component, fmi2False, fmi2Status, fmi2String, fmi2ValueReference};

/// `fmi2GetReal` and `fmi2GetInteger`.
///
/// # Safety
/// See the module [`super`].
pub unsafe fn get<M: Model, T: Scalar>(
    c: fmi2Component,
    references: *const fmi2ValueReference,
    count: usize,
    values: *mut T,
) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe {
        call::<M>(c, |component| {
            let references = slice(references, count, "vr")?;
            let values = slice_mut(values, count, "value")?;
            component.instance.get(references, values)
        })
    }
}

/// `fmi2GetBoolean`.
///
/// # Safety
/// See the module [`super`].
pub unsafe fn get_boolean<M: Model>(
    c: fmi2Component,
    references: *const fmi2ValueReference,
    count: usize,
    values: *mut fmi2Boolean,
) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe {
        call::<M>(c, |component| {
            let references = slice(references, count, "vr")?;
            let values = slice_mut(values, count, "value")?;
            let mut found = vec![false; count];
            component.instance.get(references, &mut found)?;
            for (value, found) in values.iter_mut().zip(found) {
                *value = fmi2Boolean::from(found);
            }
            Ok(())
        })
    }
}

/// `fmi2GetString`; the texts live until the next call of it, or until the instance is freed.
///
/// # Safety
/// See the module [`super`].
pub unsafe fn get_string<M: Model>(
    c: fmi2Component,
    references: *const fmi2ValueReference,
    count: usize,
    values: *mut fmi2String,
) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe {
        call::<M>(c, |component| {
            let references = slice(references, count, "vr")?;
            let values = slice_mut(values, count, "value")?;
            let mut found = vec![String::new(); count];
            component.instance.get(references, &mut found)?;
            component.texts = found.iter().map(|found| text(found)).collect();
            for (value, text) in values.iter_mut().zip(&component.texts) {
                *value = text.as_ptr();
            }
            Ok(())
        })
    }
}

/// `fmi2SetReal` and `fmi2SetInteger`.
///
/// # Safety
/// See the module [`super`].
pub unsafe fn set<M: Model, T: Scalar>(
    c: fmi2Component,
    references: *const fmi2ValueReference,
    count: usize,
    values: *const T,
) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe {
        call::<M>(c, |component| {
            let references = slice(references, count, "vr")?;
            let values = slice(values, count, "value")?;
            component.instance.set(references, values)
        })
    }
}

/// `fmi2SetBoolean`; any number but 0 is true.
///
/// # Safety
/// See the module [`super`].
pub unsafe fn set_boolean<M: Model>(
    c: fmi2Component,
    references: *const fmi2ValueReference,
    count: usize,
    values: *const fmi2Boolean,
) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe {
        call::<M>(c, |component| {
            let references = slice(references, count, "vr")?;
            let values: Vec<bool> = slice(values, count, "value")?
                .iter()
                .map(|&value| value != fmi2False)
                .collect();
            component.instance.set(references, &values)
        })
    }
}

/// `fmi2SetString`.
///
/// # Safety
/// See the module [`super`].
pub unsafe fn set_string<M: Model>(
    c: fmi2Component,
    references: *const fmi2ValueReference,
    count: usize,
    values: *const fmi2String,
) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe {
        call::<M>(c, |component| {
            let references = slice(references, count, "vr")?;
            let values = strings(values, count, "value")?;
            component.instance.set(references, &values)
        })
    }
}
