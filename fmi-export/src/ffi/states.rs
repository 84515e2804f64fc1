//! Saving and restoring.

use super::{call, slice, slice_mut};
use crate::{Error, Function, Model};
use fmi2::{fmi2Byte, fmi2Component, fmi2FMUstate, fmi2Status};

/// `fmi2GetFMUstate`.
///
/// # Safety
/// See the module [`super`].
pub unsafe fn get_fmu_state<M: Model>(c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe {
        call::<M>(c, |component| {
            let state = slice_mut(state, 1, "FMUstate")?;
            component.instance.save(&mut state[0])
        })
    }
}

/// `fmi2SetFMUstate`.
///
/// # Safety
/// See the module [`super`]; `state` may be anything.
pub unsafe fn set_fmu_state<M: Model>(c: fmi2Component, state: fmi2FMUstate) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe { call::<M>(c, |component| component.instance.restore(state)) }
}

/// `fmi2FreeFMUstate`; NULL, and a pointer to NULL, are nothing to free.
///
/// # Safety
/// See the module [`super`].
pub unsafe fn free_fmu_state<M: Model>(c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe {
        call::<M>(c, |component| match state.as_mut() {
            Some(state) => component.instance.forget(state),
            None => component.instance.permit(Function::FreeFMUstate),
        })
    }
}

/// `fmi2SerializedFMUstateSize`.
///
/// # Safety
/// See the module [`super`].
pub unsafe fn serialized_fmu_state_size<M: Model>(
    c: fmi2Component,
    state: fmi2FMUstate,
    size: *mut usize,
) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe {
        call::<M>(c, |component| {
            let size = slice_mut(size, 1, "size")?;
            size[0] = component.instance.serialized_size(state)?;
            Ok(())
        })
    }
}

/// `fmi2SerializeFMUstate`.
///
/// # Safety
/// See the module [`super`].
pub unsafe fn serialize_fmu_state<M: Model>(
    c: fmi2Component,
    state: fmi2FMUstate,
    bytes: *mut fmi2Byte,
    size: usize,
) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe {
        call::<M>(c, |component| {
            let found = component.instance.serialize(state)?;
            if size < found.len() {
                let expected = found.len();
                return Err(Error::Bytes(format!(
                    "expected room for {expected} bytes, found {size}"
                )));
            }
            let bytes = slice_mut(bytes.cast::<u8>(), size, "serializedState")?;
            bytes[..found.len()].copy_from_slice(&found);
            Ok(())
        })
    }
}

/// `fmi2DeSerializeFMUstate`.
///
/// # Safety
/// See the module [`super`].
pub unsafe fn deserialize_fmu_state<M: Model>(
    c: fmi2Component,
    bytes: *const fmi2Byte,
    size: usize,
    state: *mut fmi2FMUstate,
) -> fmi2Status {
    // SAFETY: the module's contract.
    unsafe {
        call::<M>(c, |component| {
            let state = slice_mut(state, 1, "FMUstate")?;
            let bytes = slice(bytes.cast::<u8>(), size, "serializedState")?;
            component.instance.deserialize(bytes, &mut state[0])
        })
    }
}
