//! Studies: several rides with their conditions, in one file.
//!
//! A study is TOML. Every key but `file` may stand at the top as well, where it holds for all rides
//! that do not say otherwise; `set` at the top comes before that of a ride. Paths are relative to
//! the file. Values are numbers in SI or texts with a unit.
//!
//! ```toml
//! name = "Three riders"
//! bicycle = "nominal"          # a name, or a file; the default
//! rate = "200 Hz"              # of rides without a time column
//!
//! [[ride]]
//! file = "second/trail85.csv"
//! rider = "53kg,1.68m"         # puts another rider on
//! load = "20 kg"               # on the rear carrier
//! trail = "85 mm"
//! speed = "8 km/h"             # where the ride does not record it
//! set = ["caster_angle=18deg"]
//! formulation = "repaired"
//! map = "logger.toml"          # or a name; what the columns mean
//! resample = true              # bridge gaps of up to ten samples
//! times = "2s:20s"             # the stretch to use
//! condition = "gravel"         # whatever else sets the ride apart
//! ```

#[cfg(test)]
mod tests;

use crate::bicycles::{self, Bicycle, Changes};
use crate::error::{self, Error, Result};
use crate::file;
use crate::import::Import;
use crate::map::{self, Map};
use crate::plan::Ridden;
use crate::ride::Ride;
use crate::run::Source;
use crate::unit::{self, Value};
use bicycle::quantity::{HZ, KG, M, M_PER_S, S};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;

/// Rides with their bicycles and conditions.
#[derive(Debug, Clone)]
pub struct Study {
    /// Its name; that of the file where it has none.
    pub name: String,
    /// The rides, in the order of the file.
    pub rides: Vec<Entry>,
}

/// A ride of a study.
#[derive(Debug, Clone)]
pub struct Entry {
    /// The ride, cut to its times.
    pub ride: Ride,
    /// The bicycle it was ridden on, with its rider and load.
    pub bicycle: Bicycle,
    /// What sets it apart.
    pub labels: Labels,
    /// Where the ride came from, for the record.
    pub source: Source,
}

/// What sets a ride of a study apart.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Labels {
    /// The rider as written, mass and height; empty where it is the bicycle's own.
    pub rider: String,
    /// Load on the rear carrier [kg].
    pub load: f64,
    /// Trail [m].
    pub trail: f64,
    /// Mean speed [m/s].
    pub speed: f64,
    /// Whatever else, as written; empty where nothing is.
    pub condition: String,
}

impl Entry {
    /// The ride as a fit takes it: those of one rider, load, trail and condition are of one
    /// condition.
    pub fn ridden(&self) -> Ridden<'_> {
        Ridden {
            ride: &self.ride,
            parameters: self.bicycle.parameters,
            speed: self.bicycle.input.speed,
            condition: self.labels.to_string(),
            windows: Vec::new(),
        }
    }
}

impl fmt::Display for Labels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.rider.is_empty() {
            write!(f, "rider {}, ", self.rider)?;
        }
        write!(f, "load {} kg, trail {} m", self.load, self.trail)?;
        if !self.condition.is_empty() {
            write!(f, ", {}", self.condition)?;
        }
        Ok(())
    }
}

/// What a file says, at its top and of each ride.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    name: Option<String>,
    ride: Option<Vec<Written>>,
    file: Option<String>,
    bicycle: Option<String>,
    rider: Option<String>,
    load: Option<Value>,
    trail: Option<Value>,
    speed: Option<Value>,
    #[serde(default)]
    set: Vec<String>,
    formulation: Option<String>,
    map: Option<String>,
    rate: Option<Value>,
    resample: Option<bool>,
    times: Option<String>,
    condition: Option<String>,
}

impl Study {
    /// Reads the study in the file at `path`, and all its rides.
    pub fn read(path: &Path) -> Result<Self> {
        let file = path.display().to_string();
        let text = file::read_text(path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::parse(&file, &text, folder)
    }

    /// The study written in `text`, whose paths are relative to `folder`; `file` is what errors
    /// call it.
    pub fn parse(file: &str, text: &str, folder: &Path) -> Result<Self> {
        let mut top: Written = ::toml::from_str(text).map_err(|e| error::toml(file, text, &e))?;
        let missing = |section, key| Error::Missing { section, key }.in_file(file);
        if top.file.is_some() {
            return Err(missing("[[ride]]", "file"));
        }
        let rides = top.ride.take().unwrap_or_default();
        if rides.is_empty() {
            return Err(missing("study", "[[ride]]"));
        }
        let rides = (1..).zip(rides).map(|(nth, written)| {
            written
                .or(&top)
                .open(folder)
                .map_err(|cause| cause.in_file(format!("{file}, ride {nth}")))
        });
        Ok(Self {
            rides: rides.collect::<Result<_>>()?,
            name: top.name.unwrap_or_else(|| file.into()),
        })
    }
}

impl Written {
    /// This ride, with what the `top` of the file says where it says nothing.
    fn or(self, top: &Self) -> Self {
        let top = top.clone();
        Self {
            name: self.name,
            ride: self.ride,
            file: self.file,
            bicycle: self.bicycle.or(top.bicycle),
            rider: self.rider.or(top.rider),
            load: self.load.or(top.load),
            trail: self.trail.or(top.trail),
            speed: self.speed.or(top.speed),
            set: [top.set, self.set].concat(),
            formulation: self.formulation.or(top.formulation),
            map: self.map.or(top.map),
            rate: self.rate.or(top.rate),
            resample: self.resample.or(top.resample),
            times: self.times.or(top.times),
            condition: self.condition.or(top.condition),
        }
    }

    fn open(self, folder: &Path) -> Result<Entry> {
        let none_of = [("name", self.name.is_some()), ("ride", self.ride.is_some())];
        if let Some((key, _)) = none_of.into_iter().find(|(_, there)| *there) {
            return Err(Error::Form {
                expected: "keys of a ride",
                found: key.into(),
            });
        }
        let file = self.file.as_deref().ok_or(Error::Missing {
            section: "[[ride]]",
            key: "file",
        })?;
        let bicycle = self.bicycle(folder)?;
        let map = self
            .map
            .as_deref()
            .map(|name| beside(folder, name, map::SHIPPED));
        let import = Import {
            map: map.as_deref().map(Map::open).transpose()?,
            rate: self
                .rate
                .as_ref()
                .map(|rate| rate.si(HZ, "rate"))
                .transpose()?,
            resample: self.resample.unwrap_or(false),
        };
        let mut ride = import.read(&folder.join(file))?;
        let times = self.times.as_deref().map(stretch).transpose()?;
        if let Some((start, stop)) = times {
            ride = ride.slice(start..stop)?;
        }
        ride.law_in_loop.get_or_insert(bicycle.law_in_loop);
        let source = Source {
            map,
            map_sha256: import.map.map(|map| map.sha256),
            rate: import.rate,
            resample: import.resample,
            times,
            ..Source::of(&ride)
        };
        let labels = Labels {
            rider: self.rider.unwrap_or_default(),
            load: bicycle.parameters.rear_load,
            trail: bicycle.parameters.trail,
            speed: ride.mean_speed(bicycle.input.speed),
            condition: self.condition.unwrap_or_default(),
        };
        Ok(Entry {
            ride,
            bicycle,
            labels,
            source,
        })
    }

    /// The bicycle with all that is written of it.
    fn bicycle(&self, folder: &Path) -> Result<Bicycle> {
        let value = |value: &Option<Value>, unit, name: &str| {
            value.as_ref().map(|value| value.si(unit, name)).transpose()
        };
        let load = value(&self.load, KG, "load")?;
        let rows = [
            ("trail", value(&self.trail, M, "trail")?),
            ("speed", value(&self.speed, M_PER_S, "speed")?),
        ];
        let set = rows
            .into_iter()
            .filter_map(|(name, v)| Some(format!("{name}={}", v?)));
        let changes = Changes {
            rider: self.rider.clone(),
            load: load.map(|mass| format!("{mass}kg")),
            set: set.chain(self.set.iter().cloned()).collect(),
            formulation: self.formulation.clone(),
        };
        let name = self.bicycle.as_deref().unwrap_or("nominal");
        Bicycle::open(&beside(folder, name, bicycles::SHIPPED), &changes)
    }
}

/// The name of one `shipped` with the program as it is, that of a file from `folder` on.
fn beside(folder: &Path, name: &str, shipped: &[(&str, &str)]) -> String {
    let path = folder.join(name);
    if shipped.iter().any(|(known, _)| *known == name) || !path.exists() {
        return name.into();
    }
    path.display().to_string()
}

/// `start:stop` [s].
fn stretch(text: &str) -> Result<(f64, f64)> {
    let (start, stop) = text.split_once(':').ok_or_else(|| Error::Form {
        expected: "times as START:STOP",
        found: text.into(),
    })?;
    Ok((
        unit::parse(start, S, "times")?,
        unit::parse(stop, S, "times")?,
    ))
}
