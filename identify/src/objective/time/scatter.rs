//! What windows know: how their estimates scatter.
//!
//! Errors within a window hang together, windows are independent: the covariance is that of
//! clusters (Liang & Zeger 1986), each scored against the estimate without it, which is the jackknife
//! to first order (CR3: Bell & McCaffrey 2002; MacKinnon, Nielsen & Webb 2023). Scores against the
//! estimate with it, times n/(n − p), call a window that decides a parameter nearly alone certain of
//! it.

use super::Time;
use crate::error::{Error, Result};
use crate::objective::Information;
use crate::objective::together::Together;
use crate::solver::{Landscape, Reduced};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Relative eigenvalue of the scaled curvature below which the windows say nothing: that of a
/// singular value of 1e-6.
const UNSEEN: f64 = 1e-12;
/// The most that a window may decide of any direction; more is all of it.
const ALL: f64 = 1.0 - 1e-6;

/// What the windows of `rides` know at `z`.
pub fn information(rides: &Together<Time>, z: &DVector<f64>) -> Result<Information> {
    let quadratic = rides.quadratic(z)?;
    // a state that no channel sees leaves its block singular: a trace of damping
    let reduced = quadratic
        .reduce(0.0)
        .or_else(|| quadratic.reduce(1e-9))
        .ok_or_else(|| Error::Search("the curvature of a window is not finite".into()))?;
    let (windows, free) = (reduced.clusters.len() as f64, rides.shared() as f64);
    Ok(Information {
        meat: Some(scatter(&reduced) + rides.known_scatter()),
        curvature: reduced.curvature,
        freedom: Some((windows - free).max(1.0)),
        factor: 1.0,
    })
}

/// Covariance of the gradient.
fn scatter(reduced: &Reduced) -> DMatrix<f64> {
    let h = &reduced.curvature;
    let n = h.nrows();
    let scale = h.diagonal().map(|d| d.max(f64::MIN_POSITIVE).sqrt());
    let scaled = DMatrix::from_fn(n, n, |i, j| h[(i, j)] / scale[i] / scale[j]);
    let eigen = SymmetricEigen::new(scaled);
    let largest = eigen.eigenvalues.amax();
    // directions that are seen, such that the curvature along each is 1
    let seen: Vec<usize> = (0..n)
        .filter(|&k| eigen.eigenvalues[k] > UNSEEN * largest)
        .collect();
    let direction = |i: usize, k: usize| eigen.eigenvectors[(i, seen[k])];
    let root = |k: usize| eigen.eigenvalues[seen[k]].sqrt();
    let to = DMatrix::from_fn(seen.len(), n, |k, i| direction(i, k) / root(k) / scale[i]);
    let from = DMatrix::from_fn(n, seen.len(), |i, k| scale[i] * direction(i, k) * root(k));
    let mut sum = DMatrix::zeros(n, n);
    for (score, own) in &reduced.clusters {
        // what of each direction this window decides
        let mut share = SymmetricEigen::new(&to * own * to.transpose());
        let left = share.eigenvalues.map(|part| 1.0 / (1.0 - part.min(ALL)));
        let turned = share.eigenvectors.tr_mul(&(&to * score));
        share.eigenvectors *= DMatrix::from_diagonal(&left);
        let without = &from * (share.eigenvectors * turned);
        sum += &without * without.transpose();
    }
    let windows = reduced.clusters.len() as f64;
    sum * ((windows - 1.0) / windows)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
    use super::*;

    /// Straight lines through the origin, y = x · slope, a cluster of three points each.
    fn clusters() -> Vec<(DVector<f64>, DVector<f64>)> {
        (0..7)
            .map(|c: usize| {
                let entry = |k: usize| (c * 3 + k + 1) as f64;
                let x = DVector::from_fn(3, |k, _| (1.7 * entry(k)).sin() + 0.3 * c as f64);
                let y = DVector::from_fn(3, |k, _| 2.0 * x[k] + (5.1 * entry(k)).cos());
                (x, y)
            })
            .collect()
    }

    #[test]
    fn it_is_the_jackknife_of_a_line() {
        let clusters = clusters();
        let slope = |left_out: Option<usize>| {
            let kept = clusters.iter().enumerate();
            let kept = kept.filter(|(c, _)| Some(*c) != left_out);
            let (up, down) = kept.fold((0.0, 0.0), |(up, down), (_, (x, y))| {
                (up + x.dot(y), down + x.norm_squared())
            });
            up / down
        };
        let all = slope(None);
        let n = clusters.len() as f64;
        let squares = (0..clusters.len()).map(|c| (slope(Some(c)) - all).powi(2));
        let jackknife = (n - 1.0) / n * squares.sum::<f64>();

        let part = |(x, y): &(DVector<f64>, DVector<f64>)| {
            let score = -x.dot(&(y - x * all));
            (
                DVector::from_element(1, score),
                DMatrix::from_element(1, 1, x.norm_squared()),
            )
        };
        let parts: Vec<_> = clusters.iter().map(part).collect();
        let curvature: DMatrix<f64> = parts.iter().map(|(_, own)| own).sum();
        let reduced = Reduced::of(DVector::zeros(1), curvature.clone(), parts);
        let inverse = curvature.try_inverse().unwrap();
        let variance = (&inverse * scatter(&reduced) * &inverse)[(0, 0)];
        assert!(
            (variance / jackknife - 1.0).abs() < 1e-12,
            "{variance} {jackknife}"
        );
    }

    #[test]
    fn what_no_window_sees_scatters_by_nothing_and_what_one_decides_by_much() {
        let seen = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0]);
        let score = |s: f64| DVector::from_row_slice(&[s, s]);
        let parts = vec![(score(1.0), seen.clone()), (score(-1.0), seen.clone())];
        let reduced = Reduced::of(score(0.0), &seen * 2.0, parts);
        let meat = scatter(&reduced);
        // without either the other's estimate: scores ±2, n − 1 over n
        assert!((meat - &seen * 4.0).amax() < 1e-9);
        let lone = vec![(score(1e-3), seen.clone())];
        let meat = scatter(&Reduced::of(score(0.0), seen.clone(), lone));
        assert_eq!(meat.amax(), 0.0, "one cluster says nothing of scatter");
    }
}
