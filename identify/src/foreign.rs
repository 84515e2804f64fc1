//! An FMU of any maker as the model of a fit.
//!
//! A TOML file says what is what, where names are not ours:
//!
//! ```toml
//! fmu = "Bike.fmu"                       # beside this file
//! step = "1ms"                           # else the step the FMU suggests, else a sample
//! rider = true                           # close our rider law on its outputs: it has no rider
//!
//! [inputs]
//! steer_torque = "T_delta"               # what acts besides the rider law
//! speed = "v"                            # an input or a parameter
//!
//! [outputs]                              # channels; a minus turns the sign round
//! steer = "-delta"
//!
//! [parameters]                           # rows of the bicycle's table
//! viscous_friction = "c_delta"
//!
//! [starts]                               # initial states, for `time`
//! roll = "phi_0"
//!
//! [set]                                  # whatever else it is to start with
//! tyre = "linear"
//! ```
//!
//! Names that are ours need no line: `steer_torque`, `speed`, the outputs, the rows of the table,
//! and `roll_start` and so on. Values are converted by the units that the FMU declares.
//!
//! Torque runs straight between samples and is held over a communication step at its value in the
//! middle; the rider law, where it is closed here, at its value at the beginning.

mod described;
mod runner;

use crate::bicycles::{Bicycle, FORMULATION};
use crate::error::{Error, Result};
use crate::file;
use crate::free::{Free, Tie};
use crate::objective::simulated::{Coefficients, Job, Record, WIDTH};
use bicycle::{Parameters, State};
use described::{Described, Written};
use fmi_import::{Archive, Fmu};
use runner::Runner;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub(crate) use runner::Request;
pub use runner::Spent;

/// Which FMU.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// Path of the FMU or of the file that describes it, as given.
    pub file: String,
    /// SHA-256 of its bytes.
    pub sha256: String,
    /// SHA-256 of the FMU that it describes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fmu_sha256: Option<String>,
}

/// An FMU, loaded, with one instance that is used again and again.
#[derive(Clone)]
pub struct Foreign {
    origin: Origin,
    described: Arc<Described>,
    runner: Arc<Runner>,
}

impl fmt::Debug for Foreign {
    /// What results depend on.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.origin.fmt(f)
    }
}

impl Foreign {
    /// Loads the FMU at `path`, or the one that the TOML file there describes. This runs its code.
    pub fn open(path: &Path) -> Result<Self> {
        let name = path.display().to_string();
        let is_fmu = path
            .extension()
            .is_some_and(|suffix| suffix.eq_ignore_ascii_case("fmu"));
        let (written, fmu) = if is_fmu {
            (Written::default(), path.to_owned())
        } else {
            let written = Written::read(path)?;
            let folder = path.parent().unwrap_or(Path::new(""));
            let fmu = folder.join(&written.fmu);
            (written, fmu)
        };
        let in_file = |cause: Error| cause.in_file(name.clone());
        let sha256 = |path: &PathBuf| Ok::<_, Error>(file::sha256(&file::read(path)?));
        let origin = Origin {
            sha256: sha256(&path.to_owned())?,
            fmu_sha256: if is_fmu { None } else { Some(sha256(&fmu)?) },
            file: name.clone(),
        };
        let archive = Archive::open(&fmu).map_err(|cause| in_file(cause.into()))?;
        let described = Described::new(&written, &archive).map_err(in_file)?;
        let described = Arc::new(described);
        let fmu = Fmu::load(archive).map_err(|cause| in_file(cause.into()))?;
        Ok(Self {
            origin,
            runner: Arc::new(Runner::new(fmu, described.clone())),
            described,
        })
    }

    /// Loads the FMU of a fit on record, which must be the same to the last byte.
    pub fn again(origin: &Origin) -> Result<Self> {
        let found = Self::open(Path::new(&origin.file))?;
        let changed = |what, expected: &str, found: &str| Error::OtherFile {
            file: origin.file.clone(),
            what,
            expected: expected.to_owned(),
            found: found.to_owned(),
        };
        let own = &found.origin;
        if own.sha256 != origin.sha256 {
            return Err(changed("model", &origin.sha256, &own.sha256));
        }
        match (&origin.fmu_sha256, &own.fmu_sha256) {
            (Some(expected), Some(found)) if expected != found => {
                Err(changed("FMU behind the model", expected, found))
            }
            _ => Ok(found),
        }
    }

    /// Which FMU it is.
    pub fn origin(&self) -> &Origin {
        &self.origin
    }

    /// The work it has done so far.
    pub fn spent(&self) -> Spent {
        self.runner.spent()
    }

    /// Gives `bicycle` what the FMU starts with, as far as it declares that.
    pub fn adopt(&self, bicycle: &mut Bicycle) {
        for (row, start) in self.described.parameter_starts() {
            bicycle.parameters.set(row, start);
        }
        if let Some(speed) = self.described.speed.start() {
            bicycle.input.speed = speed;
        }
        self.origin.file.clone_into(&mut bicycle.name);
    }

    /// Refuses what is free or tied without a counterpart in the FMU, and channels it does not
    /// show.
    pub fn check(&self, free: &[Free], ties: &[Tie], channels: &[&'static str]) -> Result<()> {
        let free = free.iter().map(|f| f.row.name);
        let tied = ties.iter().map(|tie| tie.follower().name);
        free.chain(tied).try_for_each(|name| self.check_row(name))?;
        channels
            .iter()
            .try_for_each(|channel| self.described.output(channel).map(drop))
    }

    /// Refuses the row `name` of the bicycle's table where the FMU has no counterpart of it, and its
    /// formulation, which is its own.
    pub fn check_row(&self, name: &str) -> Result<()> {
        let row = counterpart(name);
        let known = self.described.parameters.iter();
        let known = known.map(|(row, _)| Parameters::TABLE[*row].name);
        let ours = Parameters::index(row).is_some() || row == FORMULATION;
        if ours && known.clone().all(|known| known != row) {
            return Err(Error::unknown("parameter of the FMU", row, known));
        }
        Ok(())
    }

    /// `free` within what the FMU takes, a difference quotient's width inside.
    pub fn within(&self, free: Free) -> Result<Free> {
        let row = Parameters::index(counterpart(free.row.name));
        let mut known = self.described.parameters.iter();
        let Some((_, own)) = known.find(|(own, _)| Some(*own) == row) else {
            return Ok(free);
        };
        let (low, high) = own.range();
        let lower = free.lower.max(free.value(free.variable(low) + WIDTH));
        let upper = free.upper.min(free.value(free.variable(high) - WIDTH));
        if (lower, upper) == (free.lower, free.upper) {
            return Ok(free);
        }
        free.within(lower, upper)
    }

    /// How many rows of the state it can start from: the first ones of the table, roll and steer
    /// with their rates at least.
    pub fn order(&self) -> Result<usize> {
        let known = |row: usize| self.described.starts.iter().any(|(own, _)| *own == row);
        let order = (0..State::LEN).take_while(|row| known(*row)).count();
        if order >= 4 {
            return Ok(order);
        }
        let missing = (0..4).find(|row| !known(*row)).unwrap_or(0);
        let start = format!("{}_start", State::TABLE[missing].name);
        Err(Error::unknown(
            "start parameter of the FMU",
            &start,
            self.described.names(),
        ))
    }

    /// What the rides of `jobs` show of the channels of `record`.
    pub(crate) fn spectra(&self, record: &Record, jobs: &[Job]) -> Vec<Result<Coefficients>> {
        let request = |job: &Job| {
            let (parameters, drive) = job.setting;
            Request {
                parameters: *parameters,
                start: None,
                torque: record.torque(job),
                speed: vec![drive.speed; record.length()],
                step: record.step,
                samples: record.length(),
            }
        };
        let ridden = self.replay(&record.channels, jobs.iter().map(request).collect());
        let coefficients = |ridden: Result<Vec<Vec<f64>>>| Ok(record.coefficients(&ridden?));
        ridden.into_iter().map(coefficients).collect()
    }

    /// What the rides of `requests` show of `channels`.
    pub(crate) fn replay(
        &self,
        channels: &[&'static str],
        requests: Vec<Request>,
    ) -> Vec<Result<Vec<Vec<f64>>>> {
        self.runner.ride(channels, requests)
    }
}

/// The row that stands for `name` in an FMU: a free effective damping is its viscous friction.
fn counterpart(name: &str) -> &str {
    match name {
        "effective_damping" => "viscous_friction",
        name => name,
    }
}
