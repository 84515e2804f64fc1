//! Arguments that several commands share, and what they mean.

use anyhow::Result;
use bicycle::Parameters;
use bicycle::quantity::{HZ, S};
use clap::Args;
use identify::bicycles::{Bicycle, Changes, admit};
use identify::error::{Error, Result as Typed};
use identify::foreign::Foreign;
use identify::import::Import;
use identify::map::Map;
use identify::ride::Ride;
use identify::run::Source;
use identify::spectrum::{Line, Recipe};
use identify::unit;
use std::path::Path;

/// Which bicycle.
#[derive(Args)]
pub struct BicycleArguments {
    /// Named set (nominal, section3, sbw-delft, benchmark, browser, browser-jason, ...) or TOML
    /// file [default: nominal]
    #[arg(long, value_name = "NAME|FILE")]
    bicycle: Option<String>,
    /// Set a row of the table, the start value of an input, or formulation
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// Load on the rear carrier
    #[arg(long, value_name = "MASS", allow_hyphen_values = true)]
    load: Option<String>,
    /// Put another rider on: mass and height, e.g. 75kg,1.78m
    #[arg(long, value_name = "MASS,HEIGHT", allow_hyphen_values = true)]
    rider: Option<String>,
    /// The equations: printed, minimal, repaired, whipple, whipple_slip
    #[arg(long, value_name = "NAME")]
    formulation: Option<String>,
}

impl BicycleArguments {
    /// What `--set` said.
    pub fn assignments(&self) -> &[String] {
        &self.set
    }

    /// Whether `name` was set on the command line.
    pub fn sets(&self, name: &str) -> bool {
        self.set
            .iter()
            .any(|text| text.split('=').next() == Some(name))
    }

    fn changes(&self) -> Changes {
        Changes {
            rider: self.rider.clone(),
            load: self.load.clone(),
            set: self.set.clone(),
            formulation: self.formulation.clone(),
        }
    }

    /// The set or the file meant, as it was typed.
    pub fn name(&self) -> &str {
        self.bicycle.as_deref().unwrap_or("nominal")
    }

    /// The bicycle meant; its notes are told on stderr.
    pub fn open(&self) -> Result<Bicycle> {
        let bicycle = Bicycle::open(self.name(), &self.changes())
            .map_err(|cause| misnamed(cause, "--bicycle", self.name()))?;
        tell(&bicycle);
        Ok(bicycle)
    }

    /// The bicycle that an FMU starts with, as `--set` changes it.
    pub fn of_fmu(&self, fmu: &Foreign) -> Result<Bicycle> {
        let flags = [
            ("--bicycle", self.bicycle.as_ref()),
            ("--formulation", self.formulation.as_ref()),
            ("--load", self.load.as_ref()),
            ("--rider", self.rider.as_ref()),
        ];
        for (flag, given) in flags {
            if let Some(given) = given {
                let form = Error::Form {
                    expected: "the bicycle of the FMU, its parameters changed with --set",
                    found: given.clone(),
                };
                return Err(form.typed(format!("{flag} {given}")).into());
            }
        }
        for text in &self.set {
            let name = text.split('=').next().unwrap_or_default();
            fmu.check_row(name)
                .map_err(|cause| cause.typed(format!("--set {text}")))?;
        }
        let mut bicycle = Bicycle::open("nominal", &Changes::default())?;
        fmu.adopt(&mut bicycle);
        self.change(&mut bicycle)?;
        Ok(bicycle)
    }

    /// Changes a bicycle that does not come from `--bicycle`; its notes are told on stderr.
    pub fn change(&self, bicycle: &mut Bicycle) -> Result<()> {
        bicycle.change(&self.changes())?;
        tell(bicycle);
        Ok(())
    }
}

/// Which bicycle was ridden; by which equations it is read says the fit.
#[derive(Args)]
pub struct RiddenArguments {
    /// Bicycle of the rides, where it is another than that of the fit: named set or TOML file
    #[arg(long, value_name = "NAME|FILE")]
    bicycle: Option<String>,
    /// Set a row of its table
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// Load on its rear carrier
    #[arg(long, value_name = "MASS", allow_hyphen_values = true)]
    load: Option<String>,
    /// Put another rider on: mass and height, e.g. 75kg,1.78m
    #[arg(long, value_name = "MASS,HEIGHT", allow_hyphen_values = true)]
    rider: Option<String>,
}

impl RiddenArguments {
    /// Whether none was given.
    pub fn is_empty(&self) -> bool {
        let single = [&self.bicycle, &self.load, &self.rider];
        self.set.is_empty() && single.into_iter().all(Option::is_none)
    }

    /// The bicycle meant; its notes are told on stderr.
    pub fn open(&self) -> Result<Bicycle> {
        let arguments = BicycleArguments {
            bicycle: self.bicycle.clone(),
            set: self.set.clone(),
            load: self.load.clone(),
            rider: self.rider.clone(),
            formulation: None,
        };
        arguments.open()
    }
}

fn tell(bicycle: &Bicycle) {
    for note in &bicycle.notes {
        eprintln!("note: {note}");
    }
}

/// How ride files are read.
#[derive(Args)]
pub struct RideArguments {
    /// Meaning of a foreign file's columns: sbw-delft or a TOML file
    #[arg(long, value_name = "NAME|FILE")]
    map: Option<String>,
    /// Sampling rate of a file without a time column
    #[arg(long, value_name = "FREQUENCY")]
    rate: Option<String>,
    /// Bridge gaps of up to ten samples by straight lines
    #[arg(long)]
    resample: bool,
}

impl RideArguments {
    /// Reads a ride; what was done to it at the door is told on stderr.
    pub fn read(&self, path: &Path) -> Result<Ride> {
        let ride = self.import()?.read(path)?;
        for note in &ride.notes {
            eprintln!("note: {}: {note}", path.display());
        }
        Ok(ride)
    }

    fn import(&self) -> Result<Import> {
        let open = |name: &str| Map::open(name).map_err(|cause| misnamed(cause, "--map", name));
        let map = self.map.as_deref().map(open).transpose()?;
        let rate = self
            .rate
            .as_deref()
            .map(|text| quantity("--rate", text, HZ))
            .transpose()?;
        Ok(Import {
            map,
            rate,
            resample: self.resample,
        })
    }

    /// For `inspect`, which wants to see everything.
    pub fn read_bridging_gaps(&self, path: &Path) -> Result<Ride> {
        Ok(Import {
            resample: true,
            ..self.import()?
        }
        .read(path)?)
    }

    /// Where `ride` came from, for the record.
    pub fn source(&self, ride: &Ride, times: Option<(f64, f64)>) -> Result<Source> {
        let import = self.import()?;
        Ok(Source {
            map: self.map.clone(),
            map_sha256: import.map.map(|map| map.sha256),
            rate: import.rate,
            resample: self.resample,
            times,
            ..Source::of(ride)
        })
    }
}

/// How spectra are taken.
#[derive(Args)]
pub struct SpectrumArguments {
    /// Lowest and highest frequency
    #[arg(long, value_name = "LOW:HIGH", default_value = "0.3:3")]
    band: String,
    /// Length of the moving average that is taken off
    #[arg(long, value_name = "TIME", default_value = "5s")]
    average: String,
    /// Frequency of a slalom or pedalling line to mask
    #[arg(long, value_name = "FREQUENCY")]
    line: Vec<String>,
}

impl SpectrumArguments {
    /// The recipe meant.
    pub fn recipe(&self) -> Result<Recipe> {
        let (low, high) = pair("--band", &self.band, HZ)?;
        let line = |text: &String| {
            Ok(Line {
                frequency: quantity("--line", text, HZ)?,
            })
        };
        Ok(Recipe {
            average: quantity("--average", &self.average, S)?,
            band: (low, high),
            lines: self.line.iter().map(line).collect::<Typed<_>>()?,
            ..Recipe::default()
        })
    }
}

/// A name behind `flag` that nothing has was typed wrong; what is wrong in a file was not.
fn misnamed(cause: Error, flag: &str, name: &str) -> Error {
    match cause {
        Error::Unknown { .. } => cause.typed(format!("{flag} {name}")),
        _ => cause,
    }
}

/// `text` behind `flag` in SI.
pub fn quantity(flag: &str, text: &str, unit: bicycle::Unit) -> Typed<f64> {
    unit::parse(text, unit, flag.trim_start_matches('-'))
        .map_err(|cause| cause.typed(format!("{flag} {text}")))
}

/// Values of the parameter called `name` behind `flag`, each in its row's range.
pub fn values(flag: &str, texts: &[String], name: &str) -> Typed<Vec<f64>> {
    let row = &Parameters::TABLE[Parameters::index(name).expect("a row")];
    let value = |text: &String| admit(row, unit::parse(text, row.unit, row.name)?);
    let read = |text: &String| value(text).map_err(|e| e.typed(format!("{flag} {text}")));
    texts.iter().map(read).collect()
}

/// `low:high` behind `flag` in SI.
pub fn pair(flag: &str, text: &str, unit: bicycle::Unit) -> Typed<(f64, f64)> {
    let Some((low, high)) = text.split_once(':') else {
        let form = Error::Form {
            expected: "LOW:HIGH",
            found: text.into(),
        };
        return Err(form.typed(format!("{flag} {text}")));
    };
    Ok((quantity(flag, low, unit)?, quantity(flag, high, unit)?))
}

/// `name=rest` behind `flag`.
pub fn assignment<'a>(flag: &str, text: &'a str) -> Typed<(&'a str, &'a str)> {
    text.split_once('=').ok_or_else(|| {
        let form = Error::Form {
            expected: "NAME=VALUE",
            found: text.into(),
        };
        form.typed(format!("{flag} {text}"))
    })
}
