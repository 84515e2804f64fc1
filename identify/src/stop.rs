//! Asking a long search to stop: one flag for the process, raised by Ctrl-C.
//!
//! Whatever loops polls [`asked`] between jobs and iterations and returns its best so far. A search
//! that must be stopped alone has its own flag, [`Watch::stop`](crate::progress::Watch::stop).

use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// Exit code of a program that a second Ctrl-C ended: 128 + SIGINT, as shells say it.
pub const KILLED: i32 = 130;

/// Lets Ctrl-C ask for the stop, and a second one end the process at once with [`KILLED`]. Called
/// by a program that has a search ahead, once or more; where the system refuses a signal handler,
/// Ctrl-C keeps its usual meaning.
pub fn on_interrupt() {
    // the one refusal left to a program is that a handler is there already: this one
    let _ = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(KILLED);
        }
    });
}

/// Asks every search of this process to stop.
pub fn ask() {
    ASKED.store(true, Ordering::Relaxed);
}

/// Whether somebody asked.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
