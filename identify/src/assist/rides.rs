//! Rides held against each other: what must be alike, who fell, spectra, bands, the way.

use super::{Comparison, Fall, Falls, Known, Pair, PathError, Ridden, STEER, Spectra, interval};
use crate::compare::{Change, mean_square, noise_interval};
use crate::error::{Error, Result};
use crate::ride::Ride;
use crate::spectrum::{Analysis, Recipe};
use bicycle::course::LATERAL_OFFSET;

/// Step [s] and number of samples of the rides that did not fall, which must be the same.
pub(super) fn sampling(pairs: &[Pair<Ridden>]) -> Result<Option<(f64, usize)>> {
    let wrong = |what, expected, found| {
        Err(Error::Incomparable {
            what,
            expected,
            found,
        })
    };
    if pairs.is_empty() {
        let expected = "a pair of rides, without and with the assist".into();
        return wrong("rides".into(), expected, "none".into());
    }
    let mut first: Option<(String, f64, usize)> = None;
    for (nth, pair) in (1..).zip(pairs) {
        for (side, ridden) in [("without", &pair.without), ("with", &pair.with)] {
            if ridden.fell.is_some() {
                continue;
            }
            let name = format!("pair {nth}, {side} the assist");
            let (step, len) = (ridden.ride.step(), ridden.ride.len());
            match &first {
                None if len == 0 => return wrong(name, "a ride".into(), "no sample".into()),
                None => first = Some((name, step, len)),
                // a millionth of a step forgives the rounding of times in files
                Some((_, s, n)) if *n == len && (step - s).abs() < 1e-6 * s => {}
                Some((other, s, n)) => {
                    let expected = format!("{n} samples, {s} s apart, as in {other}");
                    return wrong(name, expected, format!("{len}, {step} s apart"));
                }
            }
        }
    }
    Ok(first.map(|(_, step, len)| (step, len)))
}

/// `f` of the rides, of which there must be one.
pub(super) fn unless_all_fell<T>(
    rides: &[&Ride],
    f: impl FnOnce(&[&Ride]) -> Result<T>,
) -> Result<Known<T>> {
    Ok(match rides {
        [] => Known::Null("every ride fell".into()),
        some => Known::Value(f(some)?),
    })
}

impl Falls {
    /// Those among `rides`.
    pub(super) fn of(rides: &[&Ridden]) -> Result<Self> {
        let each: Vec<Fall> = rides.iter().filter_map(|ride| ride.fell.clone()).collect();
        let mut times: Vec<f64> = each.iter().map(|fall| fall.time).collect();
        if let Some(found) = times.iter().find(|time| !time.is_finite()) {
            return Err(Error::Incomparable {
                what: "time of a fall".into(),
                expected: "a finite number".into(),
                found: format!("{found} s"),
            });
        }
        times.sort_by(f64::total_cmp);
        let half = rides.len().div_ceil(2);
        let median_time = times.get(half - 1).map_or_else(
            || Known::Null(format!("{} of {} rides fell", each.len(), rides.len())),
            |time| Known::Value(*time),
        );
        Ok(Self {
            count: each.len(),
            median_time,
            each,
        })
    }
}

/// Spectra of rides of one `sampling`.
pub(super) fn spectra(
    rides: &Pair<Vec<&Ride>>,
    recipe: &Recipe,
    sampling: Option<(f64, usize)>,
) -> Result<Spectra> {
    let analysis = sampling.map(|(step, len)| Analysis::new(recipe, step, len));
    let analysis = analysis.transpose()?;
    let amplitude = |rides: &[&Ride], analysis: &Analysis| {
        let mut power = vec![0.0; analysis.frequencies().len()];
        for ride in rides {
            let coefficients = analysis.coefficients(ride.signal(STEER)?);
            for (sum, y) in power.iter_mut().zip(coefficients) {
                *sum += y.norm_sqr() / rides.len() as f64;
            }
        }
        let unit = analysis.to_amplitude();
        Ok(power.iter().map(|mean| unit * mean.sqrt()).collect())
    };
    Ok(Spectra {
        frequency: analysis
            .as_ref()
            .map_or_else(Vec::new, Analysis::frequencies),
        amplitude: rides.of_each(|rides| match &analysis {
            Some(analysis) => unless_all_fell(rides, |rides| amplitude(rides, analysis)),
            None => Ok(Known::Null("every ride fell".into())),
        })?,
    })
}

/// What the assist does to the band of `recipe`, the rides in pairs.
pub(super) fn change(rides: &Pair<Vec<&Ride>>, recipe: &Recipe) -> Result<Known<Comparison>> {
    let ride = rides.with[0];
    let analysis = match Analysis::new(recipe, ride.step(), ride.len()) {
        Ok(analysis) => analysis,
        // lines may cover a whole band
        Err(cause @ Error::NoBins { .. }) => return Ok(Known::Null(cause.to_string())),
        Err(cause) => return Err(cause),
    };
    let power = |ride: &&Ride| Ok(mean_square(&analysis, ride.signal(STEER)?));
    let powers = rides.of_each(|rides| rides.iter().map(power).collect::<Result<Vec<_>>>())?;
    let mean = powers.map(|powers| powers.iter().sum::<f64>() / powers.len() as f64);
    let rms = mean.map(|mean| mean.sqrt());
    let ratio = rms.with / rms.without;
    let bins = analysis.frequencies().len();
    let interval = interval::paired(&powers).unwrap_or_else(|| noise_interval(ratio, bins, bins));
    Ok(Known::Value(Comparison {
        rms,
        ratio,
        interval,
        verdict: Change::of(interval),
    }))
}

/// The way beside the course.
pub(super) fn path(rides: &[&Ride]) -> Result<Known<PathError>> {
    if !rides.is_empty() && !rides.iter().any(|ride| ride.has(LATERAL_OFFSET.name)) {
        return Ok(Known::Null("no course was ridden".into()));
    }
    unless_all_fell(rides, |rides| {
        let (mut square, mut largest) = (0.0, 0.0_f64);
        for ride in rides {
            let offset = ride.channel(LATERAL_OFFSET.name)?;
            square += mean(offset.iter().map(|y| y * y)) / rides.len() as f64;
            largest = offset.iter().fold(largest, |most, y| most.max(y.abs()));
        }
        Ok(PathError {
            rms: square.sqrt(),
            largest,
        })
    })
}

/// Mean of the samples of a ride.
pub(super) fn mean(samples: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = samples.len() as f64;
    samples.sum::<f64>() / count
}
