//! A study's rides with a load against those without, rider by rider and trail by trail: the
//! question of the paper's Figs. 8 to 10.

use super::{BANDS, CONFIDENCE, Change, about, gamma_limits, noise_limits, within};
use crate::distribution::{normal_half_width, student_half_width, trigamma};
use crate::error::{Error, Result};
use crate::ride::{Ride, quantity};
use crate::spectrum::{Analysis, Recipe};
use crate::study::{Entry, Labels};
use serde::Serialize;

/// Width of a slice of the spectrum [Hz]: the paper reads its spectra to a tenth of a hertz, which
/// a record of 24 s resolves into two bins; twice that holds five, and an interval worth telling.
pub const SLICE: f64 = 0.2;

/// What loads do to the spectrum of a channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Loads {
    /// Name of the channel.
    pub channel: String,
    /// Its unit.
    pub unit: &'static str,
    /// Frequencies [Hz] that were left out.
    pub lines: Vec<f64>,
    /// Each load against the smallest one of the same rider, trail and condition.
    pub cells: Vec<Cell>,
    /// Rides that have nothing to be held against, in words.
    pub notes: Vec<String>,
}

/// A load against the smallest load of the same rider, trail and condition.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cell {
    /// The rider as written.
    pub rider: String,
    /// Trail [m].
    pub trail: f64,
    /// Whatever else the study says of the rides.
    pub condition: String,
    /// The load [kg].
    pub load: f64,
    /// The smallest load [kg]: mostly none.
    pub reference: f64,
    /// Files with the smallest load.
    pub without: Vec<String>,
    /// Files with the load.
    pub with: Vec<String>,
    /// Each of [`BANDS`] in which a bin is left.
    pub bands: Vec<Shift>,
    /// The same in slices of [`SLICE`] over the band of the recipe.
    pub slices: Vec<Shift>,
}

/// What becomes of the residual in a band.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Shift {
    /// Low end [Hz].
    pub low: f64,
    /// High end [Hz].
    pub high: f64,
    /// Root mean square with the smallest load [SI].
    pub without: Level,
    /// With the load [SI].
    pub with: Level,
    /// The second over the first.
    pub ratio: f64,
    /// 95 % interval of the ratio.
    pub interval: (f64, f64),
    /// What the interval says.
    pub verdict: Change,
}

/// The residual of one or more rides in a band.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Level {
    /// Root mean square over the rides [SI].
    pub rms: f64,
    /// 95 % interval [SI]: the residual taken for noise, and where there are several rides, for
    /// what they differ by if that is more.
    pub interval: (f64, f64),
}

/// Rides of one kind in a band.
struct Rides {
    /// Their mean squares [SI²].
    powers: Vec<f64>,
    /// Bins of all of them together.
    bins: usize,
}

/// Variance of the logarithm of a root mean square of a ride among others.
#[derive(Clone, Copy)]
struct Scatter {
    variance: f64,
    /// Degrees of freedom behind it.
    freedom: f64,
}

/// Variance of the logarithm of a root mean square over rides.
#[derive(Clone, Copy)]
struct Spread {
    /// As noise has it.
    noise: f64,
    /// All of it.
    whole: f64,
    /// whole²/freedom: infinite freedom of noise, whose variance is known.
    doubt: f64,
}

impl Rides {
    fn rms(&self) -> f64 {
        (self.powers.iter().sum::<f64>() / self.powers.len() as f64).sqrt()
    }

    /// What the rides differ by; none of a ride alone.
    fn scatter(&self) -> Option<Scatter> {
        let n = self.powers.len() as f64;
        let logs: Vec<f64> = self.powers.iter().map(|power| 0.5 * power.ln()).collect();
        let mean = logs.iter().sum::<f64>() / n;
        let square: f64 = logs.iter().map(|log| (log - mean).powi(2)).sum();
        (n > 1.0).then(|| Scatter {
            variance: square / (n - 1.0),
            freedom: n - 1.0,
        })
    }

    /// What the root mean square may be off by where a ride scatters by `scatter`: by that or by
    /// noise, whichever is more.
    fn spread(&self, scatter: Option<Scatter>) -> Spread {
        let noise = 0.25 * trigamma(self.bins);
        let of_mean = |s: Scatter| (s.variance / self.powers.len() as f64, s.freedom);
        match scatter.map(of_mean) {
            Some((variance, freedom)) if variance > noise => Spread {
                noise,
                whole: variance,
                doubt: variance * variance / freedom,
            },
            _ => Spread {
                noise,
                whole: noise,
                doubt: 0.0,
            },
        }
    }

    fn level(&self) -> Level {
        let (low, high) = gamma_limits(self.bins as f64);
        let rms = self.rms();
        Level {
            rms,
            interval: about(rms, (-high, -low), self.spread(self.scatter()).stretch()),
        }
    }
}

impl Spread {
    /// By how much it widens an interval of noise: Student's t with the degrees of freedom of
    /// Satterthwaite 1946, *Biometrics Bulletin* 2, 110.
    fn stretch(self) -> f64 {
        if self.doubt == 0.0 {
            return 1.0;
        }
        let freedom = self.whole * self.whole / self.doubt;
        let quantiles = student_half_width(freedom, CONFIDENCE) / normal_half_width(CONFIDENCE);
        (self.whole / self.noise).sqrt() * quantiles
    }
}

/// 95 % interval of the ratio of the second's root mean square to the first's. Rides may differ by
/// more than noise: a ride alone is taken to scatter as those it is held against do, and two alone
/// by noise only, since nothing tells.
fn interval([without, with]: [&Rides; 2]) -> (f64, f64) {
    let ratio = with.rms() / without.rms();
    let scatter = [without.scatter(), with.scatter()];
    let alone = scatter.iter().any(Option::is_none);
    let of = |side: usize| scatter[side].or(scatter[1 - side]);
    let [a, b] = [without.spread(of(0)), with.spread(of(1))];
    let doubt = if alone {
        // one and the same scatter in both
        (a.doubt.sqrt() + b.doubt.sqrt()).powi(2)
    } else {
        a.doubt + b.doubt
    };
    let both = Spread {
        noise: a.noise + b.noise,
        whole: a.whole + b.whole,
        doubt,
    };
    about(ratio, noise_limits(with.bins, without.bins), both.stretch())
}

impl Shift {
    /// What the band of `recipe` holds with and without; none where no bin is left in it.
    fn of(sides: [&[&Ride]; 2], channel: &str, recipe: &Recipe) -> Result<Option<Self>> {
        let [without, with] = sides.map(|rides| residuals(rides, channel, recipe));
        let (Some(without), Some(with)) = (without?, with?) else {
            return Ok(None);
        };
        let interval = interval([&without, &with]);
        Ok(Some(Self {
            low: recipe.band.0,
            high: recipe.band.1,
            ratio: with.rms() / without.rms(),
            without: without.level(),
            with: with.level(),
            interval,
            verdict: Change::of(interval),
        }))
    }
}

/// The residual of `rides` in the band of `recipe`; none where lines cover it.
fn residuals(rides: &[&Ride], channel: &str, recipe: &Recipe) -> Result<Option<Rides>> {
    let (mut powers, mut bins) = (Vec::new(), 0);
    for ride in rides {
        let analysis = match Analysis::new(recipe, ride.step(), ride.len()) {
            Ok(analysis) => analysis,
            Err(Error::NoBins { .. }) => return Ok(None),
            Err(cause) => return Err(cause.in_file(ride.name())),
        };
        powers.push(super::mean_square(&analysis, ride.signal(channel)?));
        bins += analysis.frequencies().len();
    }
    Ok(Some(Rides { powers, bins }))
}

/// The slices of `band` [Hz].
fn slices((low, high): (f64, f64)) -> Vec<(f64, f64)> {
    let count = ((high - low) / SLICE).round().max(1.0);
    let edge = |nth: f64| low + (high - low) * nth / count;
    (0..count as usize)
        .map(|nth| (edge(nth as f64), edge(nth as f64 + 1.0)))
        .collect()
}

/// Each load of a study against the smallest one with the same rider, trail and condition, in the
/// order of the study.
pub fn loads(entries: &[Entry], channel: &str, recipe: &Recipe) -> Result<Loads> {
    let alike = |a: &Labels, b: &Labels| {
        a.rider == b.rider && a.trail == b.trail && a.condition == b.condition
    };
    let rides = |of: &Labels, load: f64| -> Vec<&Ride> {
        let is_of = |entry: &&Entry| alike(&entry.labels, of) && entry.labels.load == load;
        let found = entries.iter().filter(is_of);
        found.map(|entry| &entry.ride).collect()
    };
    let names = |rides: &[&Ride]| rides.iter().map(|ride| ride.name()).collect();
    let (mut cells, mut notes) = (Vec::<Cell>::new(), Vec::new());
    for labels in entries.iter().map(|entry| &entry.labels) {
        let loads = || {
            let alike = entries.iter().filter(|entry| alike(&entry.labels, labels));
            alike.map(|entry| entry.labels.load)
        };
        let reference = loads().fold(f64::INFINITY, f64::min);
        let is_seen = |cell: &Cell| {
            (&cell.rider, cell.trail, &cell.condition, cell.load)
                == (&labels.rider, labels.trail, &labels.condition, labels.load)
        };
        if labels.load == reference {
            if loads().all(|load| load == reference) {
                let names: Vec<String> = names(&rides(labels, reference));
                let note = format!("no other load to hold {} against", names.join(", "));
                if !notes.contains(&note) {
                    notes.push(note);
                }
            }
            continue;
        }
        if cells.iter().any(is_seen) {
            continue;
        }
        let (without, with) = (rides(labels, reference), rides(labels, labels.load));
        let sides = [without.as_slice(), with.as_slice()];
        let shifts = |bands: &[(f64, f64)]| -> Result<Vec<Shift>> {
            let shift = |band: &(f64, f64)| Shift::of(sides, channel, &within(recipe, *band));
            bands
                .iter()
                .filter_map(|band| shift(band).transpose())
                .collect()
        };
        cells.push(Cell {
            rider: labels.rider.clone(),
            trail: labels.trail,
            condition: labels.condition.clone(),
            load: labels.load,
            reference,
            bands: shifts(&BANDS)?,
            slices: shifts(&slices(recipe.band))?,
            without: names(&without),
            with: names(&with),
        });
    }
    if cells.is_empty() {
        return Err(Error::Incomparable {
            what: "study".into(),
            expected: "rides of one rider and trail with different loads".into(),
            found: "none".into(),
        });
    }
    Ok(Loads {
        channel: channel.into(),
        unit: quantity(channel)?.unit.symbol,
        lines: recipe.lines.iter().map(|line| line.frequency).collect(),
        cells,
        notes,
    })
}

impl Cell {
    /// What goes down and what goes across in tables and figures, in words.
    pub fn labels(&self) -> (String, String) {
        let rider = match self.rider.as_str() {
            "" => "rider of the bicycle".into(),
            rider => format!("rider {}", rider.replace(',', ", ")),
        };
        let mut down = vec![rider];
        if !self.condition.is_empty() {
            down.push(self.condition.clone());
        }
        down.push(format!("{} kg", crate::report::number::exact(self.load)));
        (down.join(", "), format!("trail {:.3} m", self.trail))
    }
}

impl Loads {
    /// What goes down and what goes across, each once and in the order of the study.
    pub fn labels(&self) -> (Vec<String>, Vec<String>) {
        let (mut down, mut across) = (Vec::new(), Vec::new());
        for (of_down, of_across) in self.cells.iter().map(Cell::labels) {
            for (all, label) in [(&mut down, of_down), (&mut across, of_across)] {
                if !all.contains(&label) {
                    all.push(label);
                }
            }
        }
        (down, across)
    }

    /// The cell with these labels.
    pub fn at(&self, down: &str, across: &str) -> Option<&Cell> {
        let mut cells = self.cells.iter();
        cells.find(|cell| cell.labels() == (down.to_owned(), across.to_owned()))
    }

    /// As plain text: a line a cell and band, and below how many of all rise and fall.
    pub fn table(&self) -> String {
        use std::fmt::Write as _;
        let mut text = format!(
            "{:34} {:15} {:9} {:>10} {:>10}  {:>5}  95 % interval  verdict\n",
            "rider and load", "", "band [Hz]", "without", "with", "ratio"
        );
        for cell in &self.cells {
            let (down, across) = cell.labels();
            for Shift {
                low,
                high,
                without,
                with,
                ratio,
                interval,
                verdict,
            } in &cell.bands
            {
                let _ = writeln!(
                    text,
                    "{down:34} {across:15} {:9} {:>10.6} {:>10.6}  {ratio:>5.2}  {:>5.2}–{:<6.2}  {verdict}",
                    format!("{low}–{high}"),
                    without.rms,
                    with.rms,
                    interval.0,
                    interval.1
                );
            }
        }
        let _ = writeln!(
            text,
            "root mean squares of the residual {} in {}",
            self.channel, self.unit
        );
        for (low, high) in BANDS {
            let count = |change: Change| {
                let bands = self.cells.iter().flat_map(|cell| &cell.bands);
                let those = bands.filter(|s| (s.low, s.high) == (low, high) && s.verdict == change);
                those.count()
            };
            let _ = writeln!(
                text,
                "{low} to {high} Hz: rises in {}, falls in {}, no change in {} of {}",
                count(Change::Rises),
                count(Change::Falls),
                count(Change::None),
                self.cells.len()
            );
        }
        text
    }
}

#[cfg(test)]
mod tests;
