//! A ride: a uniformly sampled recording in SI, signs as ISO 8855 (z up: roll right +, steer and
//! yaw left +). It does not know whether it was ridden or simulated.

#[cfg(test)]
mod tests;

use crate::error::{Error, Result};
use crate::file;
use bicycle::course::LATERAL_OFFSET;
use bicycle::quantity::Quantity;
use bicycle::state::{Input, Output};
use std::fmt;
use std::fmt::Write as _;
use std::ops::Range;
use std::path::Path;

/// The name of the time column in ride files.
pub const TIME: &str = "time";

/// The channel that tells whether the bicycle moves.
pub(crate) const SPEED: &str = "speed";

/// Below this speed a bicycle stands [m/s]: neither the model nor a balancing rider lives there.
pub const STANDSTILL: f64 = 0.5;

/// The rows a channel may have: the outputs and inputs of the bicycle, in the order of the tables,
/// and where it is beside a course.
pub fn quantities() -> impl Iterator<Item = &'static Quantity> {
    Output::TABLE
        .iter()
        .chain(Input::TABLE)
        .chain([&LATERAL_OFFSET])
}

/// The row called `name`, or an error with the nearest names.
pub fn quantity(name: &str) -> Result<&'static Quantity> {
    quantities()
        .find(|row| row.name == name)
        .ok_or_else(|| Error::unknown("channel", name, quantities().map(|row| row.name)))
}

/// Where a ride was read from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Origin {
    /// Path of the file, as given.
    pub file: String,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
    /// The line of the file behind each sample (of a resampled one, the line before it), from 1.
    pub rows: Vec<usize>,
}

/// A stretch of a ride, both ends included.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Span {
    /// Time of the first sample [s].
    pub start: f64,
    /// Time of the last sample [s].
    pub stop: f64,
    /// Lines of the file, where the ride comes from one.
    pub rows: Option<(usize, usize)>,
}

impl fmt::Display for Span {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { start, stop, rows } = self;
        match rows {
            Some((first, last)) if first == last => write!(f, "row {first} ({start} s)"),
            Some((first, last)) => write!(f, "rows {first} to {last} ({start} to {stop} s)"),
            None if start == stop => write!(f, "{start} s"),
            None => write!(f, "{start} to {stop} s"),
        }
    }
}

/// A uniformly sampled recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Ride {
    start: f64,
    step: f64,
    len: usize,
    channels: Vec<(&'static Quantity, Vec<f64>)>,
    /// Whether the steer torque is what acts besides a steering law that is still to be closed on
    /// the simulated state (true), or the whole torque (false); none where nobody said.
    pub law_in_loop: Option<bool>,
    /// The file it was read from, if it was.
    pub origin: Option<Origin>,
    /// What was done to it at the door, e.g. resampling, in words.
    pub notes: Vec<String>,
}

impl Ride {
    /// A ride of `len` samples, `step` [s] apart, the first at time `start` [s]; no channel yet.
    pub fn new(start: f64, step: f64, len: usize) -> Self {
        debug_assert!(step > 0.0 && step.is_finite(), "step {step} s");
        Self {
            start,
            step,
            len,
            channels: Vec::new(),
            law_in_loop: None,
            origin: None,
            notes: Vec::new(),
        }
    }

    /// Puts `samples` [SI] into the channel `name`, replacing what was there.
    pub fn insert(&mut self, name: &str, samples: Vec<f64>) -> Result<()> {
        let row = quantity(name)?;
        if samples.len() != self.len {
            let (expected, found) = (self.len, samples.len());
            return Err(Error::Length {
                name: name.into(),
                expected,
                found,
            });
        }
        if let Some(sample) = samples.iter().position(|x| !x.is_finite()) {
            let found = samples[sample];
            return Err(Error::NotFinite {
                name: name.into(),
                sample,
                found,
            });
        }
        match self
            .channels
            .iter_mut()
            .find(|(known, _)| known.name == name)
        {
            Some((_, old)) => *old = samples,
            None => self.channels.push((row, samples)),
        }
        Ok(())
    }

    /// Step [s].
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Sampling rate [Hz].
    pub fn rate(&self) -> f64 {
        1.0 / self.step
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is no sample at all.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Number of samples × step [s].
    pub fn duration(&self) -> f64 {
        self.len as f64 * self.step
    }

    /// Time of sample `i` on the clock of the recording [s], to the nanosecond.
    pub fn time(&self, i: usize) -> f64 {
        nanoseconds(self.start + i as f64 * self.step)
    }

    /// The channels: row of the table and samples [SI].
    pub fn channels(&self) -> impl Iterator<Item = (&'static Quantity, &[f64])> {
        self.channels
            .iter()
            .map(|(row, samples)| (*row, samples.as_slice()))
    }

    /// Whether there is a channel `name`.
    pub fn has(&self, name: &str) -> bool {
        self.channels.iter().any(|(row, _)| row.name == name)
    }

    /// The samples of the channel `name` [SI].
    pub fn channel(&self, name: &str) -> Result<&[f64]> {
        // a name no ride can have is another mistake than a channel this ride lacks
        quantity(name)?;
        self.channels()
            .find(|(row, _)| row.name == name)
            .map(|(_, samples)| samples)
            .ok_or_else(|| Error::NoChannel {
                ride: self.name(),
                name: name.into(),
                has: self.channels().map(|(row, _)| row.name).collect(),
            })
    }

    /// The samples of the channel `name` [SI], which must not be one and the same value
    /// throughout: there would be nothing to fit.
    pub fn signal(&self, name: &str) -> Result<&[f64]> {
        let samples = self.channel(name)?;
        match samples {
            [first, rest @ ..] if rest.iter().all(|x| x == first) => Err(Error::Constant {
                ride: self.name(),
                name: name.into(),
                value: *first,
                unit: quantity(name)?.unit.symbol,
            }),
            _ => Ok(samples),
        }
    }

    /// Mean speed [m/s]; `fallback` where it is not recorded.
    pub fn mean_speed(&self, fallback: f64) -> f64 {
        self.channel("speed")
            .map_or(fallback, |v| v.iter().sum::<f64>() / v.len() as f64)
    }

    /// The stretches in which the bicycle stands; none where the speed is not recorded.
    pub fn standstill(&self) -> Vec<Span> {
        self.channel(SPEED).map_or_else(
            |_| Vec::new(),
            |speed| self.spans(|i| speed[i].abs() < STANDSTILL),
        )
    }

    /// The lowest speed [m/s] of a bicycle that rides backwards by its record; none where it never
    /// does. Below [`STANDSTILL`] a sensor that is off by a little says so of one that stands.
    pub fn backwards(&self) -> Option<f64> {
        let speed = self.channel(SPEED).ok()?;
        let least = speed.iter().copied().fold(f64::INFINITY, f64::min);
        (least <= -STANDSTILL).then_some(least)
    }

    /// An error where one of `rides` is not sampled as the first is.
    pub fn check_sampled_alike<'a>(rides: impl IntoIterator<Item = &'a Self>) -> Result<()> {
        let mut rides = rides.into_iter();
        let Some(first) = rides.next() else {
            return Ok(());
        };
        rides.try_for_each(|ride| ride.check_sampled(first.rate(), &first.name()))
    }

    /// An error where this ride is not sampled at `expected` [Hz] as `other` is, but for what the
    /// clocks of two loggers differ by.
    pub fn check_sampled(&self, expected: f64, other: &str) -> Result<()> {
        /// A crystal is good to a part in 10⁴, a time column in milliseconds to one in 10³.
        const CLOCKS: f64 = 1e-3;
        let found = self.rate();
        if (found / expected - 1.0).abs() <= CLOCKS {
            return Ok(());
        }
        Err(Error::Sampling {
            ride: self.name(),
            found,
            other: other.into(),
            expected,
        })
    }

    /// An error where the bicycle stands, or rides backwards.
    pub fn check_moving(&self) -> Result<()> {
        if let Some(found) = self.backwards() {
            return Err(Error::Backwards {
                ride: self.name(),
                found,
            });
        }
        match self.standstill().first() {
            Some(&span) => Err(Error::Standstill {
                ride: self.name(),
                threshold: STANDSTILL,
                span,
            }),
            None => Ok(()),
        }
    }

    /// The samples at times start ≤ t < stop [s] on the clock of the recording, at least two; an
    /// error where the recording does not cover them.
    pub fn slice(&self, times: Range<f64>) -> Result<Self> {
        // a millionth of a step forgives the rounding of times in files
        let index =
            |t: f64| (((t - self.start) / self.step - 1e-6).ceil().max(0.0) as usize).min(self.len);
        let samples = index(times.start)..index(times.end);
        // a stop one step behind the last sample takes all; half a step more forgives rounding
        let covered = times.start >= self.start - 0.5 * self.step
            && times.end <= self.start + (self.len as f64 + 0.5) * self.step;
        if samples.len() < 2 || !covered {
            return Err(Error::Window {
                ride: self.name(),
                start: times.start,
                stop: times.end,
                from: self.time(0),
                to: self.time(self.len.saturating_sub(1)),
            });
        }
        let mut slice = Self::new(
            self.start + samples.start as f64 * self.step,
            self.step,
            samples.len(),
        );
        slice.channels = self
            .channels()
            .map(|(row, x)| (row, x[samples.clone()].to_vec()))
            .collect();
        slice.law_in_loop = self.law_in_loop;
        slice.origin = self.origin.as_ref().map(|origin| Origin {
            rows: origin.rows[samples].to_vec(),
            ..origin.clone()
        });
        slice.notes.clone_from(&self.notes);
        slice.notes.push(format!(
            "cut to {} to {} s",
            slice.time(0),
            slice.time(slice.len - 1)
        ));
        Ok(slice)
    }

    /// What the ride is called in messages: its file.
    pub fn name(&self) -> String {
        self.origin
            .as_ref()
            .map_or_else(|| "ride".into(), |origin| origin.file.clone())
    }

    /// The stretch from sample `first` to sample `last`.
    pub(crate) fn span(&self, first: usize, last: usize) -> Span {
        Span {
            start: self.time(first),
            stop: self.time(last),
            rows: self
                .origin
                .as_ref()
                .map(|origin| (origin.rows[first], origin.rows[last])),
        }
    }

    /// The stretches of samples for which `holds`.
    pub(crate) fn spans(&self, holds: impl Fn(usize) -> bool) -> Vec<Span> {
        let mut spans = Vec::new();
        let mut first = None;
        for i in 0..=self.len {
            match (i < self.len && holds(i), first) {
                (true, None) => first = Some(i),
                (false, Some(from)) => {
                    spans.push(self.span(from, i - 1));
                    first = None;
                }
                _ => {}
            }
        }
        spans
    }

    /// The ride as CSV: `time[s],steer[rad],…`, every number such that reading gives it back to
    /// the last bit; before it `# law_in_loop = …` where that is known.
    pub fn to_csv(&self) -> String {
        let mut text = self
            .law_in_loop
            .map_or_else(String::new, |law| format!("# law_in_loop = {law}\n"));
        write!(text, "{TIME}[s]").expect("a string takes all");
        for (row, _) in self.channels() {
            write!(text, ",{}[{}]", row.name, row.unit.symbol).expect("a string takes all");
        }
        for i in 0..self.len {
            write!(text, "\n{}", self.time(i)).expect("a string takes all");
            for (_, samples) in self.channels() {
                write!(text, ",{}", samples[i]).expect("a string takes all");
            }
        }
        text.push('\n');
        text
    }

    /// Writes the ride as CSV to `path`, all or nothing.
    pub fn write(&self, path: &Path) -> Result<()> {
        file::write(path, self.to_csv())
    }
}

/// The last part of a path: what a ride is called beside others.
pub(crate) fn base(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or_default()
}

/// `seconds` to the nanosecond: what a clock means by 0.1 + 0.2.
pub(crate) fn nanoseconds(seconds: f64) -> f64 {
    (seconds * 1e9).round() / 1e9
}
