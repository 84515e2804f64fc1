//! States saved and restored (FMI 2.0 §2.1.8).

use super::{Core, Instance, capable};
use crate::Error;
use fmi2::{fmi2Byte, fmi2FMUstate};
use std::ptr::null_mut;
use std::rc::Rc;

const SAVES: &str = "canGetAndSetFMUstate";
const SERIALIZES: &str = "canSerializeFMUstate";

/// A state of an instance, freed when dropped. It keeps its instance from being freed; another
/// instance takes it only as bytes.
#[derive(Debug)]
pub struct SavedState<'a> {
    core: Rc<Core<'a>>,
    state: fmi2FMUstate,
}

impl Drop for SavedState<'_> {
    fn drop(&mut self) {
        let free = self.core.fmu.functions.free_fmu_state;
        if let Some(free) = free.filter(|_| !self.core.is_broken() && !self.state.is_null()) {
            // SAFETY: the component is alive, for the core is; the state is this instance's and
            // not used after this. A refusal leaks what only the FMU could free.
            unsafe { free(self.core.component, &raw mut self.state) };
        }
    }
}

impl<'a> Instance<'a> {
    /// The state it is in. Needs `canGetAndSetFMUstate`.
    pub fn get_fmu_state(&mut self) -> Result<SavedState<'a>, Error> {
        let mut saved = self.no_state();
        self.get_fmu_state_into(&mut saved)?;
        Ok(saved)
    }

    /// The state it is in, in place of another that was saved before.
    pub fn get_fmu_state_into(&mut self, saved: &mut SavedState<'a>) -> Result<(), Error> {
        const FUNCTION: &str = "fmi2GetFMUstate";
        let get_fmu_state = self.saving(FUNCTION, self.core.fmu.functions.get_fmu_state)?;
        self.check_own(saved)?;
        self.core.has_saved_states.set(true);
        self.core.call(FUNCTION, |i| {
            // SAFETY: the component is alive; the state is NULL or one of its own.
            unsafe { get_fmu_state(i.component, &raw mut saved.state) }
        })
    }

    /// Back to a saved state.
    pub fn set_fmu_state(&mut self, saved: &SavedState<'a>) -> Result<(), Error> {
        const FUNCTION: &str = "fmi2SetFMUstate";
        let set_fmu_state = self.saving(FUNCTION, self.core.fmu.functions.set_fmu_state)?;
        self.check_own(saved)?;
        self.core.call(FUNCTION, |i| {
            // SAFETY: the component is alive, the state one of its own.
            unsafe { set_fmu_state(i.component, saved.state) }
        })
    }

    /// A saved state as bytes, which other instances and processes can read. Needs
    /// `canSerializeFMUstate`.
    pub fn serialize_fmu_state(&mut self, saved: &SavedState<'a>) -> Result<Vec<u8>, Error> {
        const SIZE: &str = "fmi2SerializedFMUstateSize";
        const SERIALIZE: &str = "fmi2SerializeFMUstate";
        let functions = &self.core.fmu.functions;
        let size_of = self.serializing(SIZE, functions.serialized_fmu_state_size)?;
        let serialize = self.serializing(SERIALIZE, functions.serialize_fmu_state)?;
        self.check_own(saved)?;
        let mut size = 0;
        self.core.call(SIZE, |i| {
            // SAFETY: the component is alive, the state one of its own, `size` a place.
            unsafe { size_of(i.component, saved.state, &raw mut size) }
        })?;
        let mut bytes = Vec::new();
        bytes
            .try_reserve_exact(size)
            .map_err(|_| Error::StateSize { bytes: size })?;
        bytes.resize(size, 0_u8);
        self.core.call(SERIALIZE, |i| {
            // SAFETY: the component is alive, the state one of its own, and there are `size` bytes.
            unsafe {
                serialize(
                    i.component,
                    saved.state,
                    bytes.as_mut_ptr().cast::<fmi2Byte>(),
                    size,
                )
            }
        })?;
        Ok(bytes)
    }

    /// A state from the bytes of one, still to be set.
    pub fn deserialize_fmu_state(&mut self, bytes: &[u8]) -> Result<SavedState<'a>, Error> {
        const FUNCTION: &str = "fmi2DeSerializeFMUstate";
        let functions = &self.core.fmu.functions;
        let deserialize = self.serializing(FUNCTION, functions.deserialize_fmu_state)?;
        let mut saved = self.no_state();
        self.core.has_saved_states.set(true);
        self.core.call(FUNCTION, |i| {
            // SAFETY: the component is alive, there are as many bytes as said, and `state` is a
            // place.
            unsafe {
                deserialize(
                    i.component,
                    bytes.as_ptr().cast::<fmi2Byte>(),
                    bytes.len(),
                    &raw mut saved.state,
                )
            }
        })?;
        Ok(saved)
    }

    fn no_state(&self) -> SavedState<'a> {
        SavedState {
            core: Rc::clone(&self.core),
            state: null_mut(),
        }
    }

    fn saving<T>(&self, function: &'static str, pointer: Option<T>) -> Result<T, Error> {
        capable(
            function,
            pointer,
            SAVES,
            self.declares(|c| c.can_get_and_set_fmu_state),
        )
    }

    fn serializing<T>(&self, function: &'static str, pointer: Option<T>) -> Result<T, Error> {
        capable(
            function,
            pointer,
            SERIALIZES,
            self.declares(|c| c.can_serialize_fmu_state),
        )
    }

    fn check_own(&self, saved: &SavedState<'a>) -> Result<(), Error> {
        if Rc::ptr_eq(&self.core, &saved.core) {
            Ok(())
        } else {
            Err(Error::ForeignState)
        }
    }
}
