//! Saved states: kept here under a number that travels as `fmi2FMUstate`, and their form in bytes.
//!
//! An importer holds numbers, not addresses: one that was made up, freed or left uninitialised is
//! refused and never followed.

use crate::Error;
use fmi2::fmi2FMUstate;
use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::ptr::without_provenance_mut;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// No number is given twice, not even by different classes.
static NEXT: AtomicUsize = AtomicUsize::new(1);

/// A number for an instance or a state.
pub(crate) fn next() -> usize {
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// The saved states of a class, each with its owner.
#[derive(Debug)]
pub(crate) struct Saved<S>(Mutex<BTreeMap<usize, (usize, S)>>);

impl<S> Default for Saved<S> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<S> Saved<S> {
    fn states(&self) -> MutexGuard<'_, BTreeMap<usize, (usize, S)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Forgets all states of an owner.
    pub(crate) fn free_all(&self, owner: usize) {
        self.states().retain(|_, (of, _)| *of != owner);
    }
}

impl<S: Clone> Saved<S> {
    /// Keeps `snapshot` in `state`: where it is NULL in a new one, else in its place.
    pub(crate) fn keep(
        &self,
        owner: usize,
        snapshot: &S,
        state: &mut fmi2FMUstate,
    ) -> Result<(), Error> {
        if !state.is_null() && !self.states().contains_key(&state.addr()) {
            return Err(Error::UnknownState);
        }
        self.make(owner, snapshot, state);
        Ok(())
    }

    /// Keeps `snapshot` in `state`: where it is none in a new one, else in its place.
    pub(crate) fn make(&self, owner: usize, snapshot: &S, state: &mut fmi2FMUstate) {
        let mut states = self.states();
        if let Some((_, place)) = states.get_mut(&state.addr()) {
            place.clone_from(snapshot);
        } else {
            let number = next();
            states.insert(number, (owner, snapshot.clone()));
            *state = without_provenance_mut(number);
        }
    }

    /// What `see` makes of a saved state.
    pub(crate) fn with<T>(
        &self,
        state: fmi2FMUstate,
        see: impl FnOnce(&S) -> T,
    ) -> Result<T, Error> {
        if state.is_null() {
            let argument = "FMUstate";
            return Err(Error::Null { argument });
        }
        self.states()
            .get(&state.addr())
            .map(|(_, saved)| see(saved))
            .ok_or(Error::UnknownState)
    }

    /// Forgets a saved state and makes it NULL; NULL is none.
    pub(crate) fn free(&self, state: &mut fmi2FMUstate) -> Result<(), Error> {
        if !state.is_null() {
            let freed = self.states().remove(&state.addr());
            freed.ok_or(Error::UnknownState)?;
            *state = std::ptr::null_mut();
        }
        Ok(())
    }
}

const MAGIC: &[u8; 8] = b"FMUSTATE";
/// Changes with the layout of these bytes. That of the model's own is tied to its guid only as far
/// as its variables go, so they are checked on reading.
const VERSION: u32 = 1;
const CHECKSUM: usize = 32;

/// `snapshot` in bytes: magic, version, length of the guid, guid, snapshot, SHA-256 of all before.
pub(crate) fn to_bytes(guid: &str, snapshot: &impl Serialize) -> Result<Vec<u8>, Error> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend((guid.len() as u32).to_le_bytes());
    bytes.extend(guid.as_bytes());
    let mut bytes = postcard::to_extend(snapshot, bytes)
        .map_err(|error| Error::Bytes(format!("the state cannot be written: {error}")))?;
    let checksum = Sha256::digest(&bytes);
    bytes.extend(checksum);
    Ok(bytes)
}

/// The snapshot that `bytes` hold.
pub(crate) fn from_bytes<S: DeserializeOwned>(guid: &str, bytes: &[u8]) -> Result<S, Error> {
    let refuse = |why: String| Err(Error::Bytes(why));
    let Some((body, checksum)) = bytes.split_last_chunk::<CHECKSUM>() else {
        return refuse(format!(
            "expected a saved state, found {} bytes",
            bytes.len()
        ));
    };
    let Some(rest) = body.strip_prefix(MAGIC) else {
        return refuse("expected a saved state, found other bytes".to_owned());
    };
    let Some((version, rest)) = rest.split_first_chunk() else {
        return refuse("expected a version, found the end".to_owned());
    };
    let version = u32::from_le_bytes(*version);
    if version != VERSION {
        return refuse(format!("expected version {VERSION}, found {version}"));
    }
    let length = rest.split_first_chunk();
    let Some((found, snapshot)) = length
        .and_then(|(length, rest)| rest.split_at_checked(u32::from_le_bytes(*length) as usize))
    else {
        return refuse("expected a guid, found the end".to_owned());
    };
    if found != guid.as_bytes() {
        // as much as a guid has, and nothing that breaks a line
        let found = String::from_utf8_lossy(&found[..found.len().min(guid.len())]);
        return refuse(format!("expected a state of guid {guid}, found {found:?}"));
    }
    if Sha256::digest(body)[..] != checksum[..] {
        return refuse("the checksum does not fit: the bytes were damaged".to_owned());
    }
    match postcard::take_from_bytes(snapshot) {
        Ok((snapshot, [])) => Ok(snapshot),
        Ok((_, rest)) => refuse(format!("expected the end, found {} bytes", rest.len())),
        Err(error) => refuse(format!("the state cannot be read: {error}")),
    }
}
