//! Journals: what long work has finished, so that a killed run goes on where it was.
//!
//! A text file: a header that says whose journal it is, then a line a finished job: a checksum, the
//! job's number, its result as JSON. Lines are appended, so nothing written is ever at risk. A line
//! cut short or damaged fails its checksum and its job is done again. What goes on with the run is
//! what was read back from the line, so a resumed run has the same numbers to the last bit.

use crate::error::{Error, Result};
use crate::file::sha256;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read as _, Seek as _, SeekFrom, Write as _};
use std::marker::PhantomData;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// The first line of a journal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Header {
    /// Version of the lines, and of the program whose numbers they hold.
    journal: String,
    /// Kind of work.
    kind: String,
    /// SHA-256 of what decides the results.
    identity: String,
}

/// Version of the lines; the program's own version counts as well, for its numbers may differ.
const VERSION: &str = concat!("1, wobble ", env!("CARGO_PKG_VERSION"));

/// Digits of a line's SHA-256 that are written: 64 bits.
const DIGITS: usize = 16;

/// The finished jobs of one run, by number, in memory and in a file if it has one. Shared by the
/// threads that do the jobs; a process that has the file open keeps others out.
#[derive(Debug)]
pub struct Journal<J> {
    inner: Mutex<Inner>,
    jobs: PhantomData<fn() -> J>,
}

#[derive(Debug, Default)]
struct Inner {
    /// Results as JSON.
    done: BTreeMap<u64, String>,
    /// Where they go, and its name.
    file: Option<(File, String)>,
}

impl<J: Serialize + DeserializeOwned> Journal<J> {
    /// A journal that ends with the process.
    pub fn in_memory() -> Self {
        Self::of(Inner::default())
    }

    /// Opens the journal at `path`, or begins one where there is none or an empty file.
    ///
    /// `kind` names the work, `identity` is the SHA-256 of everything that decides a job's result:
    /// rides, plan, seed, instruction set; not the budget, the number of jobs, which may grow.
    /// A file cut short anywhere is taken up where it ends. Refused are the journal of another run,
    /// kind or version, a file that is no journal, and one that another process has open.
    pub fn open(path: &Path, kind: &str, identity: &str) -> Result<Self> {
        let name = path.display().to_string();
        let expected = Header {
            journal: VERSION.into(),
            kind: kind.into(),
            identity: identity.into(),
        };
        let read = |cause| Error::Read {
            file: name.clone(),
            cause,
        };
        let write = |cause| Error::Write {
            file: name.clone(),
            cause,
        };
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .map_err(write)?;
        lock(&file, &name)?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(read)?;
        let line = serde_json::to_string(&expected).expect("three texts") + "\n";
        let (done, whole) = if line.as_bytes().starts_with(&bytes) {
            (BTreeMap::new(), 0)
        } else {
            let mut lines = bytes.split_inclusive(|&byte| byte == b'\n');
            let header = lines.next().unwrap_or_default();
            expected.check(header, &name)?;
            let whole = bytes.iter().rposition(|&byte| byte == b'\n');
            (
                lines.filter_map(finished).collect(),
                whole.map_or(0, |i| i + 1),
            )
        };
        file.set_len(whole as u64).map_err(write)?;
        file.seek(SeekFrom::End(0)).map_err(write)?;
        if whole == 0 {
            file.write_all(line.as_bytes()).map_err(write)?;
            file.sync_all().map_err(write)?;
        }
        Ok(Self::of(Inner {
            done,
            file: Some((file, name)),
        }))
    }

    fn of(inner: Inner) -> Self {
        Self {
            inner: Mutex::new(inner),
            jobs: PhantomData,
        }
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        // every change under the lock is whole
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The result of `job`, once it has one that is a `J`.
    pub fn get(&self, job: u64) -> Option<J> {
        let text = self.inner().done.get(&job).cloned()?;
        serde_json::from_str(&text).ok()
    }

    /// The job of the highest number, with its result.
    pub fn last(&self) -> Option<(u64, J)> {
        let inner = self.inner();
        let mut jobs = inner.done.iter().rev();
        jobs.find_map(|(&job, text)| Some((job, serde_json::from_str(text).ok()?)))
    }

    /// Number of finished jobs.
    pub fn len(&self) -> usize {
        self.inner().done.len()
    }

    /// Whether no job has finished.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Writes down the result of `job` and gives it back as it will be read: go on with that. It
    /// outlives the process at once, and a failure of the power once the system has written it out.
    /// A result with a number that is not finite cannot be written.
    pub fn put(&self, job: u64, result: &J) -> Result<J> {
        let lost = |cause: serde_json::Error| Error::Unwritable {
            job,
            cause: cause.to_string(),
        };
        let text = serde_json::to_string(result).map_err(lost)?;
        let read = serde_json::from_str(&text).map_err(lost)?;
        let mut inner = self.inner();
        if let Some((file, name)) = &mut inner.file {
            file.write_all(line(job, &text).as_bytes())
                .map_err(|cause| Error::Write {
                    file: name.clone(),
                    cause,
                })?;
        }
        inner.done.insert(job, text);
        Ok(read)
    }
}

/// Keeps other processes out of `file` while it is open here.
fn lock(file: &File, name: &str) -> Result<()> {
    // a process that this one is starting holds the lock of a file just closed until it has
    // become another program, which takes it milliseconds
    const TRIES: usize = 50;
    const PAUSE: Duration = Duration::from_millis(5);
    for _ in 0..TRIES {
        match file.try_lock() {
            Ok(()) => return Ok(()),
            Err(TryLockError::WouldBlock) => std::thread::sleep(PAUSE),
            // a file system without locks cannot keep others out
            Err(TryLockError::Error(cause)) if cause.kind() == ErrorKind::Unsupported => {
                return Ok(());
            }
            Err(TryLockError::Error(cause)) => {
                return Err(Error::Read {
                    file: name.into(),
                    cause,
                });
            }
        }
    }
    Err(Error::JournalInUse { file: name.into() })
}

impl Header {
    /// Refuses the file `name` whose first line is not this one.
    fn check(&self, line: &[u8], name: &str) -> Result<()> {
        let refuse = |what, expected: &str, found: String| {
            Err(Error::Journal {
                file: name.into(),
                what,
                expected: expected.into(),
                found,
            })
        };
        let Ok(found) = serde_json::from_slice::<Self>(line) else {
            let start: String = String::from_utf8_lossy(line).chars().take(40).collect();
            return refuse(
                "version",
                &self.journal,
                format!("no journal: `{}`", start.trim_end()),
            );
        };
        if found.journal != self.journal {
            return refuse("version", &self.journal, found.journal);
        }
        if found.kind != self.kind {
            return refuse("kind", &self.kind, found.kind);
        }
        if found.identity != self.identity {
            return Err(Error::OtherRun { file: name.into() });
        }
        Ok(())
    }
}

/// The line of a finished job.
fn line(job: u64, text: &str) -> String {
    let record = format!("{job} {text}");
    format!("{} {record}\n", &sha256(record.as_bytes())[..DIGITS])
}

/// The job and its result in a line, if the line is whole.
fn finished(found: &[u8]) -> Option<(u64, String)> {
    let found = std::str::from_utf8(found).ok()?;
    let (_, record) = found.strip_suffix('\n')?.split_once(' ')?;
    let (job, text) = record.split_once(' ')?;
    let job = job.parse().ok()?;
    (line(job, text) == found).then(|| (job, text.to_owned()))
}

#[cfg(test)]
mod tests;
