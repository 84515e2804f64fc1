//! What another thread can see of a run, and do about it.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Rows recorded so far and the call under way. Looking costs the run nothing; so whether a call
/// hangs is for the one who looks to find out: its number stays.
#[derive(Debug)]
pub struct Watch {
    members: Vec<String>,
    calls: AtomicU64,
    member: AtomicUsize,
    time: AtomicU64,
    stop: AtomicBool,
    running: AtomicBool,
    rows: Mutex<Vec<f64>>,
}

/// The call to a participant that is under way.
#[derive(Clone, Debug, PartialEq)]
pub struct Call {
    /// Its number, from 1.
    pub number: u64,
    /// Name of the participant.
    pub member: String,
    /// The communication point [s].
    pub time: f64,
}

impl Watch {
    pub(super) fn new(members: Vec<String>) -> Self {
        Self {
            members,
            calls: AtomicU64::new(0),
            member: AtomicUsize::new(0),
            time: AtomicU64::new(f64::NAN.to_bits()),
            stop: AtomicBool::new(false),
            running: AtomicBool::new(false),
            rows: Mutex::default(),
        }
    }

    /// What is being called, or was last; none where nothing runs.
    pub fn call(&self) -> Option<Call> {
        self.running.load(Relaxed).then_some(())?;
        Some(Call {
            number: self.calls.load(Relaxed),
            member: self.members.get(self.member.load(Relaxed))?.clone(),
            time: f64::from_bits(self.time.load(Relaxed)),
        })
    }

    /// Ends the run at its next communication point; a run that has not begun, at its start.
    pub fn stop(&self) {
        self.stop.store(true, Relaxed);
    }

    /// The rows recorded so far, one after the other: time, then each recorded variable.
    pub fn rows(&self) -> Vec<f64> {
        self.lock().clone()
    }

    fn lock(&self) -> MutexGuard<'_, Vec<f64>> {
        self.rows.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn is_running(&self, running: bool) {
        self.running.store(running, Relaxed);
        if !running {
            self.stop.store(false, Relaxed);
        }
    }

    pub(super) fn begin(&self, member: usize, time: f64) {
        self.member.store(member, Relaxed);
        self.time.store(time.to_bits(), Relaxed);
        self.calls.fetch_add(1, Relaxed);
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.stop.load(Relaxed)
    }

    pub(super) fn record(&self, time: f64, shown: &[f64], slots: &[usize]) {
        let mut rows = self.lock();
        rows.push(time);
        rows.extend(slots.iter().map(|&slot| shown[slot]));
    }

    pub(super) fn take_rows(&self) -> Vec<f64> {
        std::mem::take(&mut *self.lock())
    }
}
