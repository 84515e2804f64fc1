//! Profile likelihood: the cost over one variable, all others sought anew at each of its values.
//! Where the cost is no parabola, its interval holds what the standard error's does not.
//!
//! Venzon & Moolgavkar 1988; Raue et al. 2009. The rise that a 95 % interval allows is that of the
//! parabola of the same covariance, ½ q² V_ii/(H⁻¹)_ii with q the half width of the standard error's
//! own interval: the taper's factor 35/18 or the sandwich are in it (Chandler & Bate 2007).

use crate::free::Variable;
use crate::solver::Limits;
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

/// Searches to a side at most.
const SEARCHES: u64 = 40;
/// Root of the relative rise that a step is to add.
const STRIDE: f64 = 0.35;
/// Error of the root of the rise at the end of an interval: 1 % of its half width.
const CLOSE: f64 = 0.01;

/// A point of a profile.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// All variables: one held, the others where the cost is least.
    pub z: DVector<f64>,
    /// Cost over that of the optimum; infinite where there is none.
    pub rise: f64,
}

/// The cost over one variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// From the lowest value to the highest, the optimum among them.
    pub points: Vec<Point>,
    /// Rise of the cost at the ends of a 95 % interval.
    pub level: f64,
    /// Lower end of the interval; none where the profile stays below the level down to the bound.
    pub lower: Option<f64>,
    /// Upper end; likewise.
    pub upper: Option<f64>,
    /// Searches it took.
    pub searches: u64,
}

/// The cost over a parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// The parameter, and of which ride or condition it is.
    pub name: String,
    /// Its estimate [SI].
    pub value: f64,
    /// Values [SI], rising, the estimate among them.
    pub values: Vec<f64>,
    /// Least cost at each of them over that of the estimate; none where there is no cost.
    pub rise: Vec<Option<f64>>,
    /// Rise at the ends of a 95 % interval.
    pub level: f64,
    /// Lower end [SI]; none where the profile is open down to the bound.
    pub lower: Option<f64>,
    /// Upper end [SI]; likewise.
    pub upper: Option<f64>,
    /// Searches it took.
    pub searches: u64,
    /// By how much the cost fell below that of the estimate, which was then not the least.
    pub fell: f64,
}

impl Profile {
    /// `curve` over variable `index`, in SI.
    pub fn new(variable: &Variable, index: usize, z: &DVector<f64>, curve: &Curve) -> Self {
        let value = |z: f64| variable.free.value(z);
        let rises = curve.points.iter().map(|p| p.rise);
        Self {
            name: variable.to_string(),
            value: value(z[index]),
            values: curve.points.iter().map(|p| value(p.z[index])).collect(),
            fell: -rises.clone().fold(0.0, f64::min),
            rise: rises.map(|r| r.is_finite().then_some(r)).collect(),
            level: curve.level,
            lower: curve.lower.map(value),
            upper: curve.upper.map(value),
            searches: curve.searches,
        }
    }

    /// Whether its interval, open ends included, holds `value` [SI].
    pub fn holds(&self, value: f64) -> bool {
        self.lower.is_none_or(|low| low <= value) && self.upper.is_none_or(|high| value <= high)
    }
}

/// From where a profile starts, and what the parabola there says.
#[derive(Debug, Clone)]
pub struct Optimum<'a> {
    /// The variables.
    pub z: &'a DVector<f64>,
    /// Their cost.
    pub cost: f64,
    /// Their box.
    pub limits: &'a Limits,
    /// Which of them is profiled.
    pub index: usize,
    /// Its standard error; none where it is infinite.
    pub std_error: Option<f64>,
    /// Change of all variables per change of this one along the floor of the valley.
    pub tangent: DVector<f64>,
    /// Variance over what the curvature alone would give: V_ii/(H⁻¹)_ii.
    pub inflation: f64,
    /// Half width of a 95 % interval in standard errors.
    pub quantile: f64,
}

/// Walks both sides. `conditional` seeks the least cost from a start, the profiled variable held,
/// and returns the cost and where it is; a cost that is not finite is a wall.
pub fn profile<E>(
    optimum: &Optimum,
    mut conditional: impl FnMut(&DVector<f64>) -> Result<(f64, DVector<f64>), E>,
) -> Result<Curve, E> {
    let level = 0.5 * optimum.quantile.powi(2) * optimum.inflation;
    let mut walk = Walk {
        optimum,
        level,
        searches: 0,
        conditional: &mut conditional,
    };
    let (mut points, lower) = walk.side(-1.0)?;
    points.reverse();
    points.push(Point {
        z: optimum.z.clone(),
        rise: 0.0,
    });
    let (above, upper) = walk.side(1.0)?;
    points.extend(above);
    Ok(Curve {
        searches: walk.searches,
        points,
        level,
        lower,
        upper,
    })
}

struct Walk<'a, F> {
    optimum: &'a Optimum<'a>,
    level: f64,
    searches: u64,
    conditional: &'a mut F,
}

/// A point of the walk: the held variable, the root of the rise over the level, all variables.
/// The root is straight where the cost is a parabola.
#[derive(Clone)]
struct Step {
    at: f64,
    rise: f64,
    root: f64,
    z: DVector<f64>,
}

impl<E, F: FnMut(&DVector<f64>) -> Result<(f64, DVector<f64>), E>> Walk<'_, F> {
    fn at(&mut self, at: f64, last: &Step, tangent: &DVector<f64>) -> Result<Step, E> {
        let Limits { lower, upper, .. } = self.optimum.limits;
        let mut start = &last.z + tangent * (at - last.at);
        for j in 0..lower.len().min(start.len()) {
            start[j] = start[j].clamp(lower[j], upper[j]);
        }
        start[self.optimum.index] = at;
        self.searches += 1;
        let (cost, z) = (self.conditional)(&start)?;
        let rise = cost - self.optimum.cost;
        // a cost below the optimum's is a search that had not quite arrived
        let root = if rise.is_finite() {
            (rise.max(0.0) / self.level).sqrt()
        } else {
            f64::INFINITY
        };
        Ok(Step { at, rise, root, z })
    }

    /// The points of one side, outwards, and the end of the interval.
    fn side(&mut self, sign: f64) -> Result<(Vec<Point>, Option<f64>), E> {
        let i = self.optimum.index;
        let Limits { lower, upper, .. } = self.optimum.limits;
        let bound = if sign > 0.0 { upper[i] } else { lower[i] };
        let mut last = Step {
            at: self.optimum.z[i],
            rise: 0.0,
            root: 0.0,
            z: self.optimum.z.clone(),
        };
        let mut tangent = self.optimum.tangent.clone();
        let room = (bound - last.at).abs();
        let quantile = self.optimum.quantile;
        let end = self.optimum.std_error.map_or(room, |s| s * quantile);
        let mut stride = (STRIDE * end).min(0.25 * room);
        let mut steps: Vec<Step> = Vec::new();
        let before = self.searches;
        while last.at != bound && self.searches - before < SEARCHES {
            let left = (bound - last.at).abs();
            let at = if stride < 0.99 * left {
                last.at + sign * stride
            } else {
                bound
            };
            let next = self.at(at, &last, &tangent)?;
            if next.root >= 1.0 {
                let end =
                    self.between(last, next, &tangent, (end.min(room), before), &mut steps)?;
                return Ok((Self::points(steps, sign), Some(end)));
            }
            let moved = (next.at - last.at).abs();
            let wanted = STRIDE * moved / (next.root - last.root).max(0.0);
            stride = wanted.clamp(0.25 * moved, 4.0 * moved);
            tangent = (&next.z - &last.z) / (next.at - last.at);
            last = next.clone();
            steps.push(next);
        }
        Ok((Self::points(steps, sign), None))
    }

    /// Where the rise crosses the level between `below` and `above`, on a side some `half` wide that
    /// has taken the searches since `before`.
    fn between(
        &mut self,
        mut below: Step,
        mut above: Step,
        tangent: &DVector<f64>,
        (half, before): (f64, u64),
        steps: &mut Vec<Step>,
    ) -> Result<f64, E> {
        let crossing = |below: &Step, above: &Step| {
            let part = (1.0 - below.root) / (above.root - below.root);
            below.at + (above.at - below.at) * part
        };
        steps.push(above.clone());
        while above.root - 1.0 > CLOSE && 1.0 - below.root > CLOSE {
            let width = above.at - below.at;
            if width.abs() < CLOSE * half || self.searches - before >= SEARCHES {
                break;
            }
            let at = if above.root.is_finite() {
                let part = (crossing(&below, &above) - below.at) / width;
                below.at + width * part.clamp(0.1, 0.9)
            } else {
                below.at + 0.5 * width
            };
            let next = self.at(at, &below, tangent)?;
            steps.push(next.clone());
            if next.root >= 1.0 {
                above = next;
            } else {
                below = next;
            }
        }
        Ok(if above.root.is_finite() {
            crossing(&below, &above)
        } else {
            above.at
        })
    }

    /// Outwards, as points of a curve.
    fn points(mut steps: Vec<Step>, sign: f64) -> Vec<Point> {
        steps.sort_by(|a, b| (sign * a.at).total_cmp(&(sign * b.at)));
        let point = |s: Step| Point {
            rise: s.rise,
            z: s.z,
        };
        steps.into_iter().map(point).collect()
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
    use super::*;
    use std::convert::Infallible;

    fn limits(lower: f64, upper: f64) -> Limits {
        let of = |v| DVector::from_element(2, v);
        Limits {
            lower: of(lower),
            upper: of(upper),
            reach: of(1.0),
        }
    }

    fn optimum<'a>(z: &'a DVector<f64>, limits: &'a Limits, std_error: Option<f64>) -> Optimum<'a> {
        Optimum {
            z,
            cost: 0.0,
            limits,
            index: 0,
            std_error,
            tangent: DVector::from_row_slice(&[1.0, 0.0]),
            inflation: 1.0,
            quantile: 1.959_964,
        }
    }

    /// Seeks y at the x of `start` in closed form.
    fn along(
        cost: impl Fn(f64, f64) -> f64,
        floor: impl Fn(f64) -> f64,
    ) -> impl FnMut(&DVector<f64>) -> Result<(f64, DVector<f64>), Infallible> {
        move |start| {
            let (x, y) = (start[0], floor(start[0]));
            Ok((cost(x, y), DVector::from_row_slice(&[x, y])))
        }
    }

    #[test]
    fn of_a_parabola_it_is_the_interval_of_the_standard_error() {
        // ½ (x² + 2 ρ x y + y²)/(1 − ρ²): unit variances
        let rho = 0.9;
        let cost = |x: f64, y: f64| 0.5 * (x * x - 2.0 * rho * x * y + y * y) / (1.0 - rho * rho);
        let (z, limits) = (DVector::zeros(2), limits(-10.0, 10.0));
        for inflation in [1.0, 35.0 / 18.0] {
            let optimum = Optimum {
                inflation,
                ..optimum(&z, &limits, Some(1.0))
            };
            let curve = profile(&optimum, along(cost, |x| rho * x)).unwrap();
            let expected = 1.959_964 * inflation.sqrt();
            assert!((curve.upper.unwrap() - expected).abs() < 0.01 * expected);
            assert!((curve.lower.unwrap() + expected).abs() < 0.01 * expected);
            assert!(curve.searches <= 12, "{}", curve.searches);
            assert!(curve.points.is_sorted_by(|a, b| a.z[0] < b.z[0]));
        }
    }

    #[test]
    fn a_crooked_cost_has_a_crooked_interval() {
        // of an exponential variable's mean m over n = 10 of mean 1: n (ln m + 1/m)
        let cost = |x: f64, _: f64| 10.0 * (x.ln() + 1.0 / x - 1.0);
        let z = DVector::from_row_slice(&[1.0, 0.0]);
        let limits = limits(0.01, 10.0);
        let optimum = optimum(&z, &limits, Some(0.3));
        let curve = profile(&optimum, along(cost, |_| 0.0)).unwrap();
        for end in [curve.lower.unwrap(), curve.upper.unwrap()] {
            // the rise at the ends is ½ χ²₁(.95), to twice the error of its root
            assert!((cost(end, 0.0) / 1.920_729 - 1.0).abs() < 0.02, "{end}");
        }
        assert!(curve.upper.unwrap() - 1.0 > 1.5 * (1.0 - curve.lower.unwrap()));
    }

    #[test]
    fn a_wall_at_the_optimum_ends_a_side() {
        let cost = |x: f64, _: f64| if x > 0.0 { f64::INFINITY } else { 0.5 * x * x };
        let (z, limits) = (DVector::zeros(2), limits(-10.0, 10.0));
        let optimum = optimum(&z, &limits, Some(1.0));
        let curve = profile(&optimum, along(cost, |_| 0.0)).unwrap();
        let upper = curve.upper.unwrap();
        assert!((0.0..0.02 * optimum.quantile).contains(&upper), "{upper}");
        assert!(curve.searches < 2 * SEARCHES, "{}", curve.searches);
    }

    #[test]
    fn what_never_rises_enough_is_open() {
        // a saturating cost: 1.5 below ½ χ²₁(.95) = 1.92
        let cost = |x: f64, _: f64| 1.5 * x * x / (1.0 + x * x);
        let (z, limits) = (DVector::zeros(2), limits(-5.0, 50.0));
        for std_error in [Some(0.58), None] {
            let optimum = optimum(&z, &limits, std_error);
            let curve = profile(&optimum, along(cost, |_| 0.0)).unwrap();
            assert_eq!((curve.lower, curve.upper), (None, None));
            assert_eq!(
                curve.points.first().unwrap().z[0],
                -5.0,
                "down to the bound"
            );
            assert_eq!(curve.points.last().unwrap().z[0], 50.0, "and up to it");
        }
    }

    #[test]
    fn a_wall_ends_an_interval() {
        // a loop that does not stand beyond x = 1 has no cost there
        let cost = |x: f64, _: f64| if x > 1.0 { f64::INFINITY } else { 0.5 * x * x };
        let (z, limits) = (DVector::zeros(2), limits(-10.0, 10.0));
        let optimum = optimum(&z, &limits, Some(1.0));
        let curve = profile(&optimum, along(cost, |_| 0.0)).unwrap();
        assert!(
            (curve.upper.unwrap() - 1.0).abs() < 0.02,
            "{:?}",
            curve.upper
        );
        assert!((curve.lower.unwrap() + 1.96).abs() < 0.02);
    }

    #[test]
    fn an_optimum_at_a_bound_is_open_there() {
        let cost = |x: f64, _: f64| x + x * x;
        let (z, limits) = (DVector::zeros(2), limits(0.0, 10.0));
        let optimum = optimum(&z, &limits, None);
        let curve = profile(&optimum, along(cost, |_| 0.0)).unwrap();
        assert_eq!(curve.lower, None);
        // x + x² = 1.9207 at x = .9742
        assert!((curve.upper.unwrap() - 0.9742).abs() < 0.01);
    }
}
