//! What to look for in the samples of a channel.

/// Changes finer than this part of the rms are the rounding of printed numbers, not an encoder's.
const COARSE: f64 = 0.005;

/// How many single samples stick out, and the index of the farthest; none where none does.
///
/// A sample sticks out by the smaller of its distances to its neighbours, if both lie on the same
/// side; at an end, to the neighbour and to the line through the next two. Out of the ordinary is
/// what exceeds ten times the rms of the lower 99 % of these distances, and three times the
/// signal's rms: no band-limited signal does that.
pub(crate) fn glitches(x: &[f64], rms: f64) -> Option<(usize, usize)> {
    let n = x.len();
    if n < 4 {
        return None;
    }
    let out = |i: usize| {
        let (a, b) = match i {
            0 => (x[0] - x[1], x[0] - (2.0 * x[1] - x[2])),
            _ if i == n - 1 => (x[i] - x[i - 1], x[i] - (2.0 * x[i - 1] - x[i - 2])),
            _ => (x[i] - x[i - 1], x[i] - x[i + 1]),
        };
        if a * b > 0.0 {
            a.abs().min(b.abs())
        } else {
            0.0
        }
    };
    let distances: Vec<f64> = (0..n).map(out).collect();
    let mut sorted = distances.clone();
    sorted.sort_by(f64::total_cmp);
    let ordinary = &sorted[..(n - n.div_ceil(100))];
    let scale = (ordinary.iter().map(|d| d * d).sum::<f64>() / ordinary.len() as f64).sqrt();
    let threshold = (10.0 * scale).max(3.0 * rms);
    let count = distances.iter().filter(|d| **d > threshold).count();
    let farthest = (0..n).max_by(|&a, &b| distances[a].total_cmp(&distances[b]))?;
    (count > 0).then_some((count, farthest))
}

/// The step of a signal that moves in whole steps: the smallest change (but for one in fifty),
/// if nineteen in twenty of the changes up to three times as large are whole multiples of it.
/// (Printed numbers are rounded, so that ten steps need not be ten times one.)
pub(super) fn quantum(x: &[f64], rms: f64) -> Option<f64> {
    let mut changes: Vec<f64> = x
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .filter(|c| *c > COARSE * rms)
        .collect();
    changes.sort_by(f64::total_cmp);
    let step = *changes.get(changes.len() / 50)?;
    let few = &changes[..changes.partition_point(|change| *change < 3.5 * step)];
    let whole = |change: &&f64| (*change / step - (*change / step).round()).abs() < 0.1;
    let multiples = few.iter().filter(whole).count();
    (few.len() >= 10 && multiples * 20 >= few.len() * 19).then_some(step)
}

/// The longest stretch of at least ten samples at `extreme` into which the signal runs faster
/// than it usually changes, and by more than three steps of its `quantum`; first and last index.
pub(super) fn clipped(x: &[f64], extreme: f64, quantum: f64) -> Option<(usize, usize)> {
    let changes = x
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).powi(2))
        .sum::<f64>();
    let usual = (changes / x.len() as f64).sqrt();
    let fast = (0.5 * usual).max(3.0 * quantum);
    let mut longest: Option<(usize, usize)> = None;
    let mut i = 0;
    for run in x.chunk_by(|a, b| a == b) {
        let (first, last) = (i, i + run.len() - 1);
        i += run.len();
        let enters = first >= 2 && (x[first] - x[first - 2]).abs() > fast;
        if run[0] == extreme
            && run.len() >= 10
            && enters
            && longest.is_none_or(|(a, b)| last - first > b - a)
        {
            longest = Some((first, last));
        }
    }
    longest
}

/// Changes of this many times their usual size are jumps: none of Gaussian noise in 10⁸ is.
const JUMP: f64 = 6.0;

/// The stretches over which the recording of a signal with steps of `quantum` (or 0) stands still:
/// three samples or more that it enters and leaves by a jump, or ten or more that it leaves by one.
/// First and last index of each.
pub(super) fn dropouts(x: &[f64], quantum: f64) -> Vec<(usize, usize)> {
    let changes: Vec<f64> = x.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let mut sorted = changes.clone();
    sorted.sort_by(f64::total_cmp);
    let ordinary = &sorted[..sorted.len() - sorted.len().div_ceil(100)];
    let usual = (ordinary.iter().map(|d| d * d).sum::<f64>() / ordinary.len() as f64).sqrt();
    let jump = (JUMP * usual).max(3.5 * quantum);
    let mut found = Vec::new();
    let mut first = 0;
    for run in x.chunk_by(|a, b| a == b) {
        let last = first + run.len() - 1;
        let enters = first > 0 && changes[first - 1] > jump;
        let leaves = changes.get(last).is_some_and(|change| *change > jump);
        if leaves && (run.len() >= 10 || enters && run.len() >= 3) {
            found.push((first, last));
        }
        first = last + 1;
    }
    found
}

/// The stretches of five samples or more in which none of several `channels` changes: no bicycle
/// keeps still to the last bit in all of them. First and last index of each.
pub(super) fn freezes(channels: &[&[f64]]) -> Vec<(usize, usize)> {
    let Some(len) = channels
        .first()
        .map(|x| x.len())
        .filter(|_| channels.len() > 1)
    else {
        return Vec::new();
    };
    let mut found = Vec::new();
    let mut first = 0;
    for i in 1..=len {
        if i == len || channels.iter().any(|x| x[i] != x[i - 1]) {
            if i - first >= 5 {
                found.push((first, i - 1));
            }
            first = i;
        }
    }
    found
}

/// Parts of a ride over which a drift is looked for.
const PARTS: usize = 8;

/// By how much the mean wanders over the ride: where a straight line explains nine tenths of the
/// variance of the means of its eighths, and rises by more than half of the `rms`. (Of eight
/// independent means a line explains as much once in 4000 times: F with 1 and 6 degrees of freedom.)
pub(super) fn drift(x: &[f64], rms: f64) -> Option<f64> {
    let part = x.len() / PARTS;
    if part == 0 {
        return None;
    }
    let means: Vec<f64> = x
        .chunks_exact(part)
        .take(PARTS)
        .map(|part| part.iter().sum::<f64>() / part.len() as f64)
        .collect();
    let middle = 0.5 * (PARTS as f64 - 1.0);
    let mean = means.iter().sum::<f64>() / PARTS as f64;
    let at = |nth: usize| nth as f64 - middle;
    let spread: f64 = (0..PARTS).map(|nth| at(nth).powi(2)).sum();
    let slope = (0..PARTS).map(|nth| at(nth) * means[nth]).sum::<f64>() / spread;
    let explained = slope * slope * spread;
    let all: f64 = means.iter().map(|m| (m - mean).powi(2)).sum();
    let change = slope * PARTS as f64;
    (explained > 0.9 * all && change.abs() > 0.5 * rms).then_some(change)
}
