//! From time stamps to a uniform grid.

use crate::error::{Error, Result};

/// A step longer than this many usual steps is a gap.
const GAP: f64 = 1.5;

/// A gap longer than this many usual steps is not bridged: the line would be most of the signal.
const BRIDGE: f64 = 10.0;

/// A stamp this close to the grid, in steps, is on it: the rounding of printed times.
const ON_GRID: f64 = 1e-3;

/// The uniform grid of a ride, and how samples come onto it.
#[derive(Debug)]
pub(super) struct Clock {
    /// Time of the first sample [s].
    pub(super) start: f64,
    /// Step [s].
    pub(super) step: f64,
    /// What was done, in words.
    pub(super) notes: Vec<String>,
    samples: Samples,
}

/// Where the samples of the grid come from.
#[derive(Debug)]
enum Samples {
    /// As recorded: how many.
    Recorded(usize),
    /// Each between recorded sample i and i + 1, at this fraction of the way.
    Between(Vec<(usize, f64)>),
}

impl Clock {
    /// A clock that nobody recorded: `len` samples at `rate` [Hz] from time 0.
    pub(super) fn steady(rate: f64, len: usize) -> Self {
        let notes = vec![format!("no time column: sampled at {rate} Hz as given")];
        Self {
            start: 0.0,
            step: 1.0 / rate,
            notes,
            samples: Samples::Recorded(len),
        }
    }

    /// The clock behind the stamps `times` [s] in lines `rows` of `file`. A rate given [Hz] must
    /// be theirs within 1 %. Jitter is resampled; short
    /// gaps are, if `bridge`, else refused.
    pub(super) fn of(
        file: &str,
        rows: &[usize],
        times: &[f64],
        rate: Option<f64>,
        bridge: bool,
    ) -> Result<Self> {
        for (pair, &row) in times.windows(2).zip(&rows[1..]) {
            if pair[1] <= pair[0] {
                let (previous, found) = (pair[0], pair[1]);
                return Err(Error::TimeOrder {
                    file: file.into(),
                    row,
                    found,
                    previous,
                });
            }
        }
        let (start, last) = (times[0], times[times.len() - 1]);
        let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let usual = usual(&steps);
        if let Some(expected) = rate
            && (usual * expected - 1.0).abs() > 0.01
        {
            let found = round(1.0 / usual, 6);
            return Err(Error::Rate {
                file: file.into(),
                expected,
                found,
            });
        }

        // the longest lever gives the best step
        let n = steps.len() as f64;
        let step = plain((last - start) / n, ON_GRID / n);
        let on_grid =
            |(i, t): (usize, &f64)| (t - (start + i as f64 * step)).abs() <= ON_GRID * step;
        if times.iter().enumerate().all(on_grid) {
            return Ok(Self {
                start,
                step,
                notes: vec![],
                samples: Samples::Recorded(times.len()),
            });
        }

        let is_gap = |&step: &f64| step > GAP * usual;
        let longest_let_in = if bridge { BRIDGE } else { GAP } * usual;
        if let Some(i) = steps.iter().position(|&step| step > longest_let_in) {
            let hint = if bridge || steps[i] > BRIDGE * usual {
                "too long to bridge: cut the record there"
            } else {
                "--resample bridges gaps of up to 10 steps by straight lines"
            };
            return Err(Error::TimeStep {
                file: file.into(),
                row: rows[i + 1],
                found: round(steps[i], 6),
                expected: round(usual, 6),
                hint,
            });
        }
        let step = rate.map_or_else(|| plain(usual, 5e-3), |rate| 1.0 / rate);
        let samples = between(times, step);
        let mut notes = Vec::new();
        let regular = || steps.iter().filter(|step| !is_gap(step));
        let shortest = regular().fold(f64::INFINITY, |a, &b| a.min(b));
        let longest = regular().fold(0.0, |a: f64, &b| a.max(b));
        notes.push(format!(
            "time steps of {} to {} s: resampled to {} Hz by linear interpolation",
            round(shortest, 9),
            round(longest, 9),
            round(1.0 / step, 6),
        ));
        let gaps = steps.iter().filter(|step| is_gap(step)).count();
        if gaps > 0 {
            let widest = (0..steps.len())
                .max_by(|&a, &b| steps[a].total_cmp(&steps[b]))
                .expect("two stamps make a step");
            notes.push(format!(
                "{gaps} gap{} bridged by straight lines, the longest of {} s before row {}",
                if gaps == 1 { "" } else { "s" },
                round(steps[widest], 9),
                rows[widest + 1],
            ));
        }
        Ok(Self {
            start,
            step,
            notes,
            samples: Samples::Between(samples),
        })
    }

    /// Number of samples on the grid.
    pub(super) fn len(&self) -> usize {
        match &self.samples {
            Samples::Recorded(len) => *len,
            Samples::Between(samples) => samples.len(),
        }
    }

    /// The recorded samples `x` on the grid.
    pub(super) fn sample(&self, x: Vec<f64>) -> Vec<f64> {
        match &self.samples {
            Samples::Recorded(_) => x,
            Samples::Between(samples) => samples
                .iter()
                .map(|&(i, w)| x[i] + w * (x[i + 1] - x[i]))
                .collect(),
        }
    }

    /// The line behind each sample of the grid.
    pub(super) fn rows(&self, rows: &[usize]) -> Vec<usize> {
        match &self.samples {
            Samples::Recorded(_) => rows.to_vec(),
            Samples::Between(samples) => samples.iter().map(|&(i, _)| rows[i]).collect(),
        }
    }
}

/// The usual step: the mean of those that are no gap against the median. (The median alone is
/// wrong where stamps are rounded: 60 Hz in milliseconds has steps of 16, 17 and 17 ms.)
fn usual(steps: &[f64]) -> f64 {
    let mut sorted = steps.to_vec();
    sorted.sort_by(f64::total_cmp);
    let median = sorted[(sorted.len() - 1) / 2];
    let regular = &sorted[..sorted.partition_point(|&step| step <= GAP * median)];
    regular.iter().sum::<f64>() / regular.len() as f64
}

/// The grid of `step` [s] over `times`, each point between two of them.
fn between(times: &[f64], step: f64) -> Vec<(usize, f64)> {
    let (start, last) = (times[0], times[times.len() - 1]);
    let len = ((last - start) / step + ON_GRID).floor() as usize + 1;
    let mut i = 0;
    (0..len)
        .map(|k| {
            let t = start + k as f64 * step;
            while i + 2 < times.len() && times[i + 1] <= t {
                i += 1;
            }
            (i, ((t - times[i]) / (times[i + 1] - times[i])).min(1.0))
        })
        .collect()
}

/// The step [s] of a whole number of hertz, or else of nanoseconds, if one lies within `tolerance`
/// (relative): what a person would have set.
fn plain(step: f64, tolerance: f64) -> f64 {
    let hertz = 1.0 / (1.0 / step).round();
    let nanoseconds = round(step, 9);
    [hertz, nanoseconds]
        .into_iter()
        .find(|near| near.is_finite() && (near / step - 1.0).abs() <= tolerance)
        .unwrap_or(step)
}

/// `x` to `digits` decimals, for messages.
fn round(x: f64, digits: i32) -> f64 {
    let scale = 10_f64.powi(digits);
    (x * scale).round() / scale
}
