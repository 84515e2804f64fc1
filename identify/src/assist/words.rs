//! A study in sentences and as plain text.

use super::{Comparison, JUDGED, Known, Outcome, Pair, Study, Worth};
use crate::compare::{BANDS, Change};
use crate::report::number::{significant, with_unit};
use crate::report::table::{NOTHING, aligned, wrapped};
use crate::report::words::capitalised;
use std::fmt;

/// What the study found, a sentence each: in how many cases the judged band falls and rises, where
/// it does harm, what happens to the other bands, who falls.
pub fn headline(study: &Study) -> Vec<String> {
    let rows = &study.rows;
    let changed = |change| move |row: &Worth| row.judged().is_some_and(|c| c.verdict == change);
    let count = |holds: &dyn Fn(&Worth) -> bool| rows.iter().filter(|row| holds(row)).count();
    let lost = count(&|row| row.judged().is_none());
    let lost = match lost {
        0 => String::new(),
        n => format!(", and cannot be compared in {n}"),
    };
    let (low, high) = BANDS[JUDGED];
    let mut sentences = vec![format!(
        "With {} the residual steering between {low} and {high} Hz falls in {} of {}, rises in {}, \
         does not change in {}{lost}.",
        study.controller,
        count(&changed(Change::Falls)),
        cases(rows.len()),
        count(&changed(Change::Rises)),
        count(&changed(Change::None)),
    )];
    let harm = named(rows, |row| {
        let c = row.judged().filter(|c| c.verdict == Change::Rises)?;
        Some(format!("to {} of what it was", ratio(c)))
    });
    let thrown = named(rows, |row| {
        (row.outcome == Outcome::Thrown).then(|| row.fell())
    });
    let saved = named(rows, |row| {
        (row.outcome == Outcome::Saved).then(|| row.fell())
    });
    let sooner = named(rows, |row| {
        let times = row.falls.map(|falls| falls.median_time.value().copied());
        let (without, with) = (times.without?, times.with?);
        (with < without).then(|| {
            let [without, with] = [without, with].map(|time| significant(time, 3));
            format!("half had fallen after {without} → {with} s")
        })
    });
    if harm.is_none()
        && thrown.is_none()
        && sooner.is_none()
        && rows.iter().any(|row| row.judged().is_some())
    {
        sentences
            .push("In no case does this band rise, do more rides fall with it, or sooner.".into());
    }
    let said = [
        ("It does harm where this band rises", harm),
        (
            "It does harm where more rides fall with it than without",
            thrown,
        ),
        ("It does harm where rides fall sooner with it", sooner),
        ("Fewer rides fall with it than without", saved),
    ];
    for (what, list) in said {
        sentences.extend(list.map(|list| format!("{what}: {list}.")));
    }
    let strays = named(rows, |row| {
        let of = row.path.map(|path| path.value().map(|path| path.rms));
        let (without, with) = (of.without?, of.with?);
        let [a, b] = [without, with].map(|rms| significant(rms, 3));
        (with > without).then(|| format!("{a} → {b} m rms"))
    });
    sentences.extend(strays.map(|list| format!("It leads further from the course: {list}.")));
    for (nth, (low, high)) in BANDS.iter().enumerate().filter(|(nth, _)| *nth != JUDGED) {
        let rises = |row: &Worth| {
            let change = row.bands[nth].change.value();
            change.is_some_and(|c| c.verdict == Change::Rises)
        };
        if let n @ 1.. = count(&rises) {
            sentences.push(format!(
                "Between {low} and {high} Hz it rises in {}.",
                cases(n)
            ));
        }
    }
    sentences
}

fn cases(count: usize) -> String {
    format!("{count} case{}", if count == 1 { "" } else { "s" })
}

/// The cases of which `what` says something, with it; none where there is no such case.
fn named(rows: &[Worth], what: impl Fn(&Worth) -> Option<String>) -> Option<String> {
    let named = |row: &Worth| Some(format!("{} ({})", row.case, what(row)?));
    let all: Vec<String> = rows.iter().filter_map(named).collect();
    (!all.is_empty()).then(|| all.join("; "))
}

impl Worth {
    /// `0 → 3 of 8 fell`.
    pub(crate) fn fell(&self) -> String {
        let count = self.falls.map(|falls| falls.count);
        format!(
            "{} of {} fell",
            changed(&count, usize::to_string),
            self.pairs
        )
    }
}

/// How many fell and, where half of them did, after how long.
fn fell(row: &Worth) -> String {
    let times = row.falls.map(|falls| falls.median_time.value().copied());
    let time = |time: &Option<f64>| time.map_or_else(|| NOTHING.into(), |t| significant(t, 3));
    match changed(&times, time) {
        none if none == NOTHING => row.fell(),
        times => format!("{}, half after {times} s", row.fell()),
    }
}

/// `without → with`, each in words; – where neither is known.
pub(super) fn changed<T>(pair: &Pair<T>, words: impl FnMut(&T) -> String) -> String {
    let Pair { without, with } = pair.map(words);
    if without == NOTHING && with == NOTHING {
        NOTHING.into()
    } else {
        format!("{without} → {with}")
    }
}

/// A value in words; – where there is none.
pub(super) fn or_nothing<T>(known: &Known<T>, words: impl FnOnce(&T) -> String) -> String {
    known.value().map_or_else(|| NOTHING.into(), words)
}

/// Decimals of a ratio: two, or three where its interval is narrow.
fn decimals(c: &Comparison) -> usize {
    if c.interval.1 - c.interval.0 < 0.05 {
        3
    } else {
        2
    }
}

/// `0.71`.
fn ratio(c: &Comparison) -> String {
    format!("{:.1$}", c.ratio, decimals(c))
}

impl fmt::Display for Comparison {
    /// `0.71 falls`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", ratio(self), self.verdict)
    }
}

/// `0.62 to 0.81`.
pub(super) fn interval(c: &Comparison) -> String {
    let (low, high) = c.interval;
    format!("{low:.0$} to {high:.0$}", decimals(c))
}

/// Frequency and damping ratio of the least damped oscillation.
pub(super) fn oscillation(row: &Worth) -> String {
    changed(&row.modes, |modes| {
        let least = modes.value().map(|modes| &modes.least_damped);
        least.map_or_else(
            || NOTHING.into(),
            |least| {
                or_nothing(least, |o| {
                    let frequency = with_unit(o.frequency, "Hz", 3);
                    format!("{} at {frequency}", significant(o.damping_ratio, 2))
                })
            },
        )
    })
}

/// Why something has no value, a sentence each with its cases: what stands behind every –.
pub(super) fn reasons(study: &Study) -> Vec<String> {
    let mut found: Vec<(String, Vec<String>)> = Vec::new();
    for row in &study.rows {
        let sides = |what: &str, reasons: Pair<Option<&str>>| match (reasons.without, reasons.with)
        {
            (Some(a), Some(b)) if a == b => vec![format!("{what}: {a}")],
            (a, b) => {
                let said = |side, reason: Option<&str>| {
                    reason.map(|reason| format!("{what} {side} the assist: {reason}"))
                };
                said("without", a)
                    .into_iter()
                    .chain(said("with", b))
                    .collect()
            }
        };
        let mut all: Vec<String> = row
            .bands
            .iter()
            .filter_map(|band| Some(format!("change by band: {}", band.change.reason()?)))
            .chain(row.motor.reason().map(|reason| format!("motor: {reason}")))
            .chain(sides("way beside the course", reasons_of(&row.path)))
            .chain(sides("closed loop", reasons_of(&row.modes)))
            .collect();
        all.dedup();
        for reason in all {
            let case = row.case.to_string();
            match found.iter_mut().find(|(known, _)| *known == reason) {
                Some((_, cases)) => cases.push(case),
                None => found.push((reason, vec![case])),
            }
        }
    }
    let sentence = |(reason, cases): (String, Vec<String>)| {
        let whole = cases.len() == study.rows.len();
        let at = if whole {
            String::new()
        } else {
            format!(" ({})", cases.join("; "))
        };
        format!("{}{at}.", capitalised(&reason))
    };
    found.into_iter().map(sentence).collect()
}

fn reasons_of<T>(pair: &Pair<Known<T>>) -> Pair<Option<&str>> {
    Pair {
        without: pair.without.reason(),
        with: pair.with.reason(),
    }
}

/// The study as plain text: the headline, a line a case, why something is missing, notes.
pub fn table(study: &Study) -> String {
    let band = |(low, high): (f64, f64)| format!("{low} to {high} Hz");
    let [slow, judged, fast] = BANDS.map(band);
    let heads = [
        "case",
        &slow,
        &judged,
        "95 % interval",
        &fast,
        "peak, rms [N m]",
        "delivered, net [J]",
        "mean [W]",
        "beside course [m]",
        "fell",
        "least damping ratio",
    ];
    let row = |row: &Worth| {
        let [slow, judged, fast] =
            std::array::from_fn(|nth| or_nothing(&row.bands[nth].change, Comparison::to_string));
        let number = |value: f64| significant(value, 3);
        let two = |a: f64, b: f64| format!("{}, {}", number(a), number(b));
        let path = |path: &Known<_>| or_nothing(path, |p: &super::PathError| number(p.rms));
        [
            row.case.to_string(),
            slow,
            judged,
            row.judged().map_or_else(|| NOTHING.into(), interval),
            fast,
            or_nothing(&row.motor, |m| two(m.peak_torque, m.rms_torque)),
            or_nothing(&row.motor, |m| two(m.delivered_energy, m.net_energy)),
            or_nothing(&row.motor, |m| number(m.mean_power)),
            changed(&row.path, path),
            fell(row),
            oscillation(row),
        ]
    };

    let mut rows = vec![heads.map(str::to_owned)];
    rows.extend(study.rows.iter().map(row));
    let mut text = wrapped(&headline(study).join(" ")) + "\n" + &aligned(&rows);
    for said in reasons(study) {
        text += &wrapped(&format!("{NOTHING} {said}"));
    }
    for note in &study.notes {
        text += &wrapped(&format!("note: {note}"));
    }
    text
}
