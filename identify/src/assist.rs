//! What a steering assist is worth: rides of the same seed without and with it, held against each
//! other. Where the rides come from does not matter here.

mod interval;
mod modes;
mod motor;
mod page;
mod rides;
#[cfg(test)]
mod tests;
mod words;

pub use modes::{Modes, Oscillation};
pub use motor::Motor;
pub use page::html;
pub use words::{headline, table};

use crate::compare::{BANDS, Change, within};
use crate::error::Result;
use crate::report::number::exact_with_unit;
use crate::ride::Ride;
use crate::spectrum::Recipe;
use bicycle::Quantity;
use nalgebra::Complex;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::fmt;

/// The band of [`BANDS`] that an assist is judged by: the oscillation.
pub const JUDGED: usize = 1;
/// The channel that is held against each other.
pub(crate) const STEER: &str = "steer";

/// The same thing without and with the assist.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Pair<T> {
    /// Without the assist.
    pub without: T,
    /// With it.
    pub with: T,
}

impl<T> Pair<T> {
    /// `f` of both.
    pub fn map<U>(&self, mut f: impl FnMut(&T) -> U) -> Pair<U> {
        Pair {
            without: f(&self.without),
            with: f(&self.with),
        }
    }

    /// `f` of both; an error says of which it is.
    fn of_each<U>(&self, mut f: impl FnMut(&T) -> Result<U>) -> Result<Pair<U>> {
        Ok(Pair {
            without: f(&self.without).map_err(|e| e.in_file("without the assist"))?,
            with: f(&self.with).map_err(|e| e.in_file("with the assist"))?,
        })
    }
}

/// A value, or why there is none. In JSON `{"value": …}` or `{"value": null, "reason": "…"}`.
#[derive(Debug, Clone, PartialEq)]
pub enum Known<T> {
    /// The value.
    Value(T),
    /// Why there is none, a clause.
    Null(String),
}

impl<T> Known<T> {
    /// The value, if there is one.
    pub fn value(&self) -> Option<&T> {
        match self {
            Self::Value(value) => Some(value),
            Self::Null(_) => None,
        }
    }

    /// Why there is none.
    pub fn reason(&self) -> Option<&str> {
        match self {
            Self::Value(_) => None,
            Self::Null(reason) => Some(reason),
        }
    }
}

impl<T: Serialize> Serialize for Known<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("value", &self.value())?;
        if let Some(reason) = self.reason() {
            map.serialize_entry("reason", reason)?;
        }
        map.end()
    }
}

/// How a ride ended before its time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fall {
    /// When [s].
    pub time: f64,
    /// Why, a clause.
    pub why: String,
}

/// A finished ride: `steer`, with an assist `steer_rate` and `assist_torque` as well, on a course
/// `lateral_offset`. One that fell is shorter.
#[derive(Debug, Clone, PartialEq)]
pub struct Ridden {
    /// The record.
    pub ride: Ride,
    /// Its fall, if it fell.
    pub fell: Option<Fall>,
}

/// What sets a case apart: rows of the tables with their values [SI]. In figures the last one goes
/// across, the others down.
#[derive(Debug, Clone, PartialEq)]
pub struct Case(pub Vec<(&'static Quantity, f64)>);

impl Case {
    /// What goes down and what goes across, in words: `trail 0.13 m` and `rear load 10 kg`.
    pub fn labels(&self) -> (String, String) {
        let label = |(row, value): &(&Quantity, f64)| {
            let name = crate::report::words::words(row.name);
            format!("{name} {}", exact_with_unit(*value, row.unit.symbol))
        };
        let mut labels: Vec<String> = self.0.iter().map(label).collect();
        let across = labels.pop().unwrap_or_default();
        (labels.join(", "), across)
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (down, across) = self.labels();
        let comma = if down.is_empty() { "" } else { ", " };
        write!(f, "{down}{comma}{across}")
    }
}

impl Serialize for Case {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(row, value)| (row.name, value)))
    }
}

/// How many rides stayed up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Every ride.
    Stood,
    /// More with the assist than without.
    Saved,
    /// Fewer.
    Thrown,
    /// As many, not all.
    Fell,
}

impl Outcome {
    /// The name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stood => "stood",
            Self::Saved => "saved",
            Self::Thrown => "thrown",
            Self::Fell => "fell",
        }
    }
}

impl Outcome {
    /// Of rides of which so many fell.
    fn of(falls: Pair<usize>) -> Self {
        match (falls.without, falls.with) {
            (0, 0) => Self::Stood,
            (without, with) if with < without => Self::Saved,
            (without, with) if with > without => Self::Thrown,
            _ => Self::Fell,
        }
    }
}

/// The rides that fell.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Falls {
    /// How many.
    pub count: usize,
    /// Time by which half of all rides had fallen [s].
    pub median_time: Known<f64>,
    /// Each of them, in the order of the seeds.
    pub each: Vec<Fall>,
}

/// Mean power of the residual steering over the rides, as amplitude of a sine on each bin.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Spectra {
    /// Frequencies of the bins [Hz]; none where every ride fell.
    pub frequency: Vec<f64>,
    /// One-sided amplitudes [rad].
    pub amplitude: Pair<Known<Vec<f64>>>,
}

/// The residual steering in a band.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Band {
    /// Low end [Hz].
    pub low: f64,
    /// High end [Hz].
    pub high: f64,
    /// What the assist does to it.
    pub change: Known<Comparison>,
}

/// The residual steering in a band without and with the assist.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Comparison {
    /// Root of the mean power over the seeds [rad].
    pub rms: Pair<f64>,
    /// With over without.
    pub ratio: f64,
    /// 95 % interval of the ratio, from how it scatters from seed to seed; of one seed, both rides
    /// taken for noise of their own, which is wider than the truth where they share a remnant.
    pub interval: (f64, f64),
    /// What the interval says.
    pub verdict: Change,
}

/// How far the bicycle was beside its course.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PathError {
    /// Root mean square over the rides [m].
    pub rms: f64,
    /// The largest [m].
    pub largest: f64,
}

/// What the assist is worth in one case.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Worth {
    /// The case.
    pub case: Case,
    /// Pairs of rides.
    pub pairs: usize,
    /// Those of which neither ride fell. Only these are compared. Where there is none, spectrum,
    /// motor and path are of the rides of either side that did not fall.
    pub upright: usize,
    /// Who stayed up.
    pub outcome: Outcome,
    /// Who fell.
    pub falls: Pair<Falls>,
    /// The residual steering over frequency.
    pub spectra: Spectra,
    /// The same by band, in the order of [`BANDS`].
    pub bands: Vec<Band>,
    /// The work of the motor.
    pub motor: Known<Motor>,
    /// The way beside the course.
    pub path: Pair<Known<PathError>>,
    /// The linear system of bicycle, rider and controller.
    pub modes: Pair<Known<Modes>>,
}

impl Worth {
    /// What the assist does to the band it is judged by.
    pub fn judged(&self) -> Option<&Comparison> {
        self.bands[JUDGED].change.value()
    }
}

/// What a controller is worth in every case.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Study {
    /// Name of the controller.
    pub controller: String,
    /// How the spectra were taken.
    pub recipe: Recipe,
    /// The cases.
    pub rows: Vec<Worth>,
    /// What the numbers rest on, a clause each.
    pub notes: Vec<String>,
}

impl Study {
    /// The labels of the cases down and across, each once, in their order.
    pub(crate) fn labels(&self) -> (Vec<String>, Vec<String>) {
        let (mut down, mut across) = (Vec::new(), Vec::new());
        for row in &self.rows {
            let labels = row.case.labels();
            for (known, label) in [(&mut down, labels.0), (&mut across, labels.1)] {
                if !known.contains(&label) {
                    known.push(label);
                }
            }
        }
        (down, across)
    }

    /// The case at these labels.
    pub(crate) fn at(&self, down: &str, across: &str) -> Option<&Worth> {
        let here = |row: &&Worth| {
            let labels = row.case.labels();
            (labels.0.as_str(), labels.1.as_str()) == (down, across)
        };
        self.rows.iter().find(here)
    }
}

/// What the assist is worth in a case: `pairs` of rides of the same seed, and the eigenvalues [1/s]
/// of the closed loop or why there are none. An error where there is no pair, where rides that did
/// not fall differ in length or step, and where a channel is missing.
pub fn worth(
    case: Case,
    pairs: &[Pair<Ridden>],
    recipe: &Recipe,
    modes: &Pair<std::result::Result<Vec<Complex<f64>>, String>>,
) -> Result<Worth> {
    let sampling = rides::sampling(pairs)?;
    let sides = Pair {
        without: pairs.iter().map(|pair| &pair.without).collect::<Vec<_>>(),
        with: pairs.iter().map(|pair| &pair.with).collect(),
    };
    let falls = sides.of_each(|side| Falls::of(side))?;
    let both = |pair: &Pair<Ridden>| pair.without.fell.is_none() && pair.with.fell.is_none();
    let both: Vec<bool> = pairs.iter().map(both).collect();
    let upright = both.iter().filter(|both| **both).count();
    let rides = sides.map(|side| {
        let compared = |ridden: &Ridden, both| both || (upright == 0 && ridden.fell.is_none());
        let side = side.iter().zip(&both);
        side.filter(|(ridden, both)| compared(ridden, **both))
            .map(|(ridden, _)| &ridden.ride)
            .collect::<Vec<_>>()
    });
    let band = |(low, high)| {
        let change = if upright == 0 {
            Known::Null(format!(
                "of {} rides {} fell without the assist and {} with it, in no pair none: what is \
                 left of a ride that fell compares with no other",
                pairs.len(),
                falls.without.count,
                falls.with.count
            ))
        } else {
            rides::change(&rides, &within(recipe, (low, high)))?
        };
        Ok(Band { low, high, change })
    };
    Ok(Worth {
        outcome: Outcome::of(falls.map(|falls| falls.count)),
        spectra: rides::spectra(&rides, recipe, sampling)?,
        bands: BANDS.into_iter().map(band).collect::<Result<_>>()?,
        motor: rides::unless_all_fell(&rides.with, Motor::of)
            .map_err(|cause| cause.in_file("with the assist"))?,
        path: rides.of_each(|rides| rides::path(rides))?,
        modes: modes.of_each(Modes::of)?,
        case,
        pairs: pairs.len(),
        upright,
        falls,
    })
}
