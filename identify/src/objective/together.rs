//! Several rides at once: each ride's landscape over its own part of the variables, and what was
//! known before.

use super::Information;
use crate::error::Result;
use crate::solver::{Landscape, Quadratic};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// One ride among several.
#[derive(Debug, Clone)]
pub struct Member<L> {
    /// Its landscape.
    pub landscape: L,
    /// Which of the shared variables are its own, in its order.
    pub variables: Vec<usize>,
}

/// The rides, over variables they share and then the blocks of each.
#[derive(Debug, Clone)]
pub struct Together<L> {
    /// The rides.
    pub members: Vec<Member<L>>,
    /// Mean and standard deviation of what was known before of each shared variable.
    pub priors: Vec<Option<(f64, f64)>>,
    /// By what the covariance of the estimates exceeds the inverse curvature: the weight of a
    /// prior against the rides.
    pub factor: f64,
}

impl<L: Landscape> Together<L> {
    /// Number of shared variables.
    pub fn shared(&self) -> usize {
        self.priors.len()
    }

    /// Each member with its part of the variables `z`.
    fn parts(&self, z: &DVector<f64>) -> Vec<(&Member<L>, DVector<f64>)> {
        let mut at = self.shared();
        let part = |member: &Member<L>, at: usize| {
            let own = member.variables.iter().map(|&i| z[i]);
            let blocks = z.rows(at, member.landscape.blocks());
            DVector::from_vec(own.chain(blocks.iter().copied()).collect())
        };
        let parts = self.members.iter().map(|member| {
            let own = part(member, at);
            at += member.landscape.blocks();
            (member, own)
        });
        parts.collect()
    }

    /// `work` done for each member at its part of `z`, on all cores.
    pub fn each<T: Send>(
        &self,
        z: &DVector<f64>,
        work: impl Fn(&L, &DVector<f64>) -> T + Sync,
    ) -> Vec<T> {
        let parts = self.parts(z);
        if let [(member, own)] = &parts[..] {
            return vec![work(&member.landscape, own)];
        }
        let work = |(member, own): &(&Member<L>, DVector<f64>)| work(&member.landscape, own);
        parts.par_iter().map(work).collect()
    }

    /// What the rides know at `z`, from what each knows.
    pub fn information(
        &self,
        z: &DVector<f64>,
        of: impl Fn(&L, &DVector<f64>) -> Result<Information> + Sync,
    ) -> Result<Information> {
        let n = self.shared();
        let mut sum = Information {
            curvature: DMatrix::zeros(n, n),
            meat: None,
            factor: self.factor,
        };
        for (member, own) in self.members.iter().zip(self.each(z, of)) {
            let own = own?;
            add(&mut sum.curvature, &own.curvature, &member.variables);
            if let Some(meat) = &own.meat {
                let total = sum.meat.get_or_insert_with(|| DMatrix::zeros(n, n));
                add(total, meat, &member.variables);
            }
        }
        for (i, prior) in self.priors.iter().enumerate() {
            let Some((_, deviation)) = prior else {
                continue;
            };
            let weight = self.factor / (deviation * deviation);
            sum.curvature[(i, i)] += weight;
            if let Some(meat) = &mut sum.meat {
                meat[(i, i)] += weight;
            }
        }
        Ok(sum)
    }
}

/// Adds `part` over the variables `of` to `sum`.
fn add(sum: &mut DMatrix<f64>, part: &DMatrix<f64>, of: &[usize]) {
    for (k, &i) in of.iter().enumerate() {
        for (l, &j) in of.iter().enumerate() {
            sum[(i, j)] += part[(k, l)];
        }
    }
}

impl<L: Landscape> Landscape for Together<L> {
    fn blocks(&self) -> usize {
        self.members.iter().map(|m| m.landscape.blocks()).sum()
    }

    fn cost(&self, z: &DVector<f64>) -> f64 {
        let rides: f64 = self.each(z, L::cost).into_iter().sum();
        let known = self.priors.iter().zip(z.iter()).filter_map(|(prior, z)| {
            let (mean, deviation) = (*prior)?;
            Some(0.5 * self.factor * ((z - mean) / deviation).powi(2))
        });
        rides + known.sum::<f64>()
    }

    fn quadratic(&self, z: &DVector<f64>) -> Result<Quadratic> {
        let n = self.shared();
        let mut sum = Quadratic {
            gradient: DVector::zeros(n),
            curvature: DMatrix::zeros(n, n),
            blocks: Vec::new(),
        };
        for (member, own) in self.members.iter().zip(self.each(z, L::quadratic)) {
            let own = own?;
            add(&mut sum.curvature, &own.curvature, &member.variables);
            let spread = |own: &DVector<f64>, all: &mut DVector<f64>| {
                for (&i, value) in member.variables.iter().zip(own.iter()) {
                    all[i] += value;
                }
            };
            spread(&own.gradient, &mut sum.gradient);
            sum.blocks.extend(own.blocks.into_iter().map(|mut block| {
                let mut share = DVector::zeros(n);
                spread(&block.share, &mut share);
                let mut cross = DMatrix::zeros(block.cross.nrows(), n);
                for (k, &i) in member.variables.iter().enumerate() {
                    let mut column = cross.column_mut(i);
                    column += block.cross.column(k);
                }
                (block.share, block.cross) = (share, cross);
                block
            }));
        }
        for (i, prior) in self.priors.iter().enumerate() {
            if let Some((mean, deviation)) = prior {
                let weight = self.factor / (deviation * deviation);
                sum.gradient[i] += weight * (z[i] - mean);
                sum.curvature[(i, i)] += weight;
            }
        }
        Ok(sum)
    }
}
