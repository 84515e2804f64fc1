//! Looking on while a search runs: hearing how far it is, and asking it to stop.

use crate::stop;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What a search tells while it runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event<'a> {
    /// What is done next, in words.
    Phase(&'a str),
    /// A local search has taken a step.
    Iteration {
        /// Steps so far.
        iteration: u64,
        /// Cost where it stands.
        cost: f64,
    },
    /// Jobs, or the evaluations of a population, that are done; the time left follows from them.
    Done {
        /// So many.
        done: u64,
        /// Of so many.
        of: u64,
        /// Least cost so far, once there is one.
        best: Option<f64>,
    },
}

/// Who hears of events, from any thread.
type Listener = dyn Fn(Event<'_>) + Send + Sync;

/// A share in looking on. Clones share one listener and one wish to stop; the default is silent.
#[derive(Clone, Default)]
pub struct Watch {
    listener: Option<Arc<Listener>>,
    stopped: Arc<AtomicBool>,
}

impl Watch {
    /// Tells `listener` every event.
    pub fn new(listener: impl Fn(Event<'_>) + Send + Sync + 'static) -> Self {
        Self {
            listener: Some(Arc::new(listener)),
            ..Self::default()
        }
    }

    /// The same wish to stop without the listener: for one of many jobs.
    #[must_use]
    pub fn silent(&self) -> Self {
        Self {
            listener: None,
            stopped: Arc::clone(&self.stopped),
        }
    }

    /// Tells the listener.
    pub fn tell(&self, event: Event<'_>) {
        if let Some(listener) = &self.listener {
            listener(event);
        }
    }

    /// Asks the searches that share this watch to stop.
    pub fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    /// Whether to stop: asked here, or of the whole process ([`stop::asked`]).
    pub fn stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed) || stop::asked()
    }
}

impl fmt::Debug for Watch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Watch")
            .field("listens", &self.listener.is_some())
            .field("stopped", &self.stopped())
            .finish()
    }
}
