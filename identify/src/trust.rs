//! How far an estimate can be trusted, beyond its standard error: profiles of the cost, fits of data
//! made again, and which parameters the data can do without.

pub mod bootstrap;
pub mod insensitivity;
pub mod profile;

use crate::error::Result;
use crate::objective::Information;
use crate::problem::Problem;
use crate::solver::Limits;
use crate::verdict::spread;
use insensitivity::{Dropped, Reduction, Rule, sensitivities, worst};
use nalgebra::DVector;
use profile::{Optimum, Profile};
use rayon::prelude::*;

/// Somebody asked to stop.
struct Stopped;

/// A problem and its optimum.
pub struct Solved<'a> {
    /// The problem.
    pub problem: &'a Problem,
    /// The shared variables of the optimum.
    pub z: DVector<f64>,
    /// All variables there, the rides' blocks behind the shared ones.
    point: DVector<f64>,
    /// Its cost, with the weights of `amplitude` as the model has them there.
    pub cost: f64,
    /// What the data know there.
    pub information: Information,
    limits: Limits,
}

impl<'a> Solved<'a> {
    /// The optimum that the search from the shared variables at `z` ends in: near `z`, where a
    /// search has ended before.
    pub fn new(problem: &'a Problem, z: &DVector<f64>) -> Result<Self> {
        let start = z.rows(0, problem.shared()).into_owned();
        let outcome = problem.search_weighted(&start, &start, &[])?.outcome;
        Ok(Self {
            problem,
            z: outcome.point.rows(0, problem.shared()).into_owned(),
            cost: outcome.cost,
            information: problem.information(&outcome.point)?,
            point: outcome.point,
            limits: problem.limits(),
        })
    }

    /// The profile of variable `i`; none where somebody asked to stop.
    pub fn profile(&self, i: usize) -> Option<Profile> {
        let n = self.z.len();
        let own = spread(&self.information);
        let plain = spread(&self.information.plain());
        let variance = own.covariance[(i, i)];
        let regular = own.singular[i].is_none() && variance > 0.0;
        let optimum = Optimum {
            z: &self.z,
            cost: self.cost,
            limits: &self.limits,
            index: i,
            quantile: self.information.quantile(),
            std_error: regular.then(|| variance.sqrt()),
            tangent: if regular {
                plain.covariance.column(i) / plain.covariance[(i, i)]
            } else {
                DVector::from_fn(n, |j, _| f64::from(u8::from(j == i)))
            },
            inflation: if regular {
                variance / plain.covariance[(i, i)]
            } else {
                self.information.factor
            },
        };
        let curve = profile::profile(&optimum, |start| {
            // where nothing can be evaluated there is a wall
            match self.problem.search_weighted(&self.z, start, &[i]) {
                // not the least cost there
                Ok(found) if found.outcome.stopped => Err(Stopped),
                Ok(found) => {
                    let point = found.outcome.point.rows(0, n).into_owned();
                    Ok((found.outcome.cost, point))
                }
                Err(_) => Ok((f64::INFINITY, start.clone())),
            }
        });
        let of = |curve| Profile::new(&self.problem.variables[i], i, &self.z, &curve);
        curve.ok().map(of)
    }

    /// The profiles of all variables, on all cores; those only that ended before somebody asked to
    /// stop.
    pub fn profiles(&self) -> Vec<Profile> {
        let all = (0..self.z.len()).into_par_iter();
        all.filter_map(|i| self.profile(i)).collect()
    }

    /// Leaves out parameters at a bound, then by CIFER's rule, each fixed where the search starts, until all that
    /// are left pass; nuisances stay. `caution` as in [`sensitivities`]. None where somebody asked to
    /// stop.
    pub fn reduce(&self, caution: f64) -> Result<Option<Reduction>> {
        let variables = &self.problem.variables;
        let start = self.problem.start();
        let (mut point, mut cost) = (self.point.clone(), self.cost);
        let mut held: Vec<usize> = Vec::new();
        let mut dropped = Vec::new();
        loop {
            let kept: Vec<usize> = (0..self.z.len()).filter(|i| !held.contains(i)).collect();
            let information = self.problem.information(&point)?.of(&kept);
            let left: Vec<_> = kept.iter().map(|&i| variables[i].clone()).collect();
            let values = self.problem.values(&point);
            let own: Vec<f64> = kept.iter().map(|&i| values[i]).collect();
            let sensitivities = sensitivities(&left, &own, &information, caution);
            let may = |k: usize| !left[k].free.nuisance();
            // at its bound a parameter is no estimate, however sharp the data hold it there
            let at_bound = |&k: &usize| may(k) && left[k].free.at_bound(own[k]);
            let bound = (0..left.len()).find(at_bound);
            let next = bound
                .map(|k| (k, Rule::Bound))
                .or_else(|| worst(&sensitivities, may));
            let Some((k, rule)) = next else {
                return Ok(Some(Reduction {
                    kept: sensitivities,
                    values: own,
                    dropped,
                    cost,
                }));
            };
            let i = kept[k];
            held.push(i);
            let mut from = point.rows(0, self.z.len()).into_owned();
            from[i] = start[i];
            let outcome = self.problem.search_weighted(&self.z, &from, &held)?.outcome;
            if outcome.stopped {
                return Ok(None);
            }
            dropped.push(Dropped {
                sensitivity: sensitivities[k].clone(),
                rule,
                fixed_at: variables[i].free.value(start[i]),
                cost_rise: outcome.cost - cost,
            });
            (point, cost) = (outcome.point, outcome.cost);
        }
    }
}

#[cfg(test)]
mod tests;
