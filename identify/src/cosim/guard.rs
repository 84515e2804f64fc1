//! A run watched from another thread: it goes on showing where it is, and a participant that does
//! not come back is found out.

use super::Begun;
use fmi_import::master::Call;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Looks are that far apart.
const LOOK: Duration = Duration::from_millis(20);

/// An FMU that did not come back. Its thread is lost: the process has to end.
#[derive(Debug, thiserror::Error)]
#[error("{what}: expected an answer within {} s, found none", .timeout.as_secs_f64())]
pub struct Hung {
    /// What was called, and when.
    pub what: String,
    /// How long it was waited for.
    pub timeout: Duration,
    /// The run, and what was reached of it; none where an FMU hung while it was loaded.
    pub begun: Option<Begun>,
}

enum Told<T> {
    Begun(Begun),
    Done(T),
}

/// Does `work` on a thread of its own; `look` is told now and then how many runs have begun and
/// what is being called.
pub fn guarded<T: Send + 'static>(
    timeout: Duration,
    work: impl FnOnce(&mut dyn FnMut(Begun)) -> T + Send + 'static,
    mut look: impl FnMut(u64, &Call),
) -> Result<T, Hung> {
    let (sender, receiver) = channel();
    let worker = thread::spawn(move || {
        let tell: &Sender<Told<T>> = &sender;
        // the receiver lives until it was told that all is done
        let done = work(&mut |begun| drop(tell.send(Told::Begun(begun))));
        drop(tell.send(Told::Done(done)));
    });
    let mut runs = 0;
    let mut current: Option<Begun> = None;
    // the call that was seen last, and since when
    let mut last = (0, Instant::now());
    loop {
        match receiver.recv_timeout(LOOK) {
            Ok(Told::Done(done)) => return Ok(done),
            Ok(Told::Begun(begun)) => {
                runs += 1;
                current = Some(begun);
                last = (0, Instant::now());
            }
            Err(RecvTimeoutError::Timeout) => {
                let what = match &current {
                    None => "loading".to_owned(),
                    // between runs nothing is called
                    Some(begun) => match begun.watch.call() {
                        None => {
                            last = (0, Instant::now());
                            continue;
                        }
                        Some(call) => {
                            look(runs, &call);
                            if call.number != last.0 {
                                last = (call.number, Instant::now());
                            }
                            format!("{} at {} s", call.member, call.time)
                        }
                    },
                };
                if last.1.elapsed() > timeout {
                    let begun = current;
                    return Err(Hung {
                        what,
                        timeout,
                        begun,
                    });
                }
            }
            Err(RecvTimeoutError::Disconnected) => match worker.join() {
                Err(panic) => std::panic::resume_unwind(panic),
                Ok(()) => unreachable!("the worker tells that it is done"),
            },
        }
    }
}
