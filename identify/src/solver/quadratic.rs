//! The local model of a cost: gradient and curvature, with blocks that can be eliminated.

use nalgebra::{DMatrix, DVector};

/// A block of variables that meets only itself and the shared ones: the initial state of a window.
#[derive(Debug, Clone)]
pub struct Block {
    /// Gradient over the block.
    pub gradient: DVector<f64>,
    /// What the block's observations add to the gradient over the shared variables.
    pub share: DVector<f64>,
    /// What they add to the curvature over the shared variables.
    pub own: DMatrix<f64>,
    /// Curvature of the block with itself.
    pub curvature: DMatrix<f64>,
    /// Curvature of the block (rows) with the shared variables (columns).
    pub cross: DMatrix<f64>,
}

/// A local model of a cost: gradient and positive semidefinite curvature (Gauss–Newton or
/// Fisher) over the shared variables and then the blocks.
#[derive(Debug, Clone)]
pub struct Quadratic {
    /// Gradient over the shared variables.
    pub gradient: DVector<f64>,
    /// Curvature of the shared variables.
    pub curvature: DMatrix<f64>,
    /// The blocks, in the order of the variables.
    pub blocks: Vec<Block>,
}

/// What is left of a [`Quadratic`] over the shared variables once the blocks are eliminated.
#[derive(Debug, Clone)]
pub struct Reduced {
    /// Gradient.
    pub gradient: DVector<f64>,
    /// Curvature: the Schur complement.
    pub curvature: DMatrix<f64>,
    /// What each block's observations add to both: clusters of a covariance.
    pub clusters: Vec<(DVector<f64>, DMatrix<f64>)>,
    /// (B + damping)⁻¹ [cross, gradient] of each block.
    solved: Vec<(DMatrix<f64>, DVector<f64>)>,
}

impl Reduced {
    /// Of what was eliminated before.
    #[cfg(test)]
    pub fn of(
        gradient: DVector<f64>,
        curvature: DMatrix<f64>,
        clusters: Vec<(DVector<f64>, DMatrix<f64>)>,
    ) -> Self {
        Self {
            gradient,
            curvature,
            clusters,
            solved: Vec::new(),
        }
    }
}

impl Quadratic {
    /// Eliminates the blocks, their diagonals increased by `damping` of themselves. None where a
    /// block is singular or not finite.
    pub fn reduce(&self, damping: f64) -> Option<Reduced> {
        let mut reduced = Reduced {
            gradient: self.gradient.clone(),
            curvature: self.curvature.clone(),
            clusters: Vec::with_capacity(self.blocks.len()),
            solved: Vec::with_capacity(self.blocks.len()),
        };
        for block in &self.blocks {
            let factor =
                damped(&block.curvature, &block.curvature.diagonal(), damping).cholesky()?;
            let (cross, gradient) = (factor.solve(&block.cross), factor.solve(&block.gradient));
            let bent = block.cross.transpose() * &cross;
            let eliminated = block.cross.transpose() * &gradient;
            reduced.curvature -= &bent;
            reduced.gradient -= &eliminated;
            let cluster = (&block.share - eliminated, &block.own - bent);
            reduced.clusters.push(cluster);
            reduced.solved.push((cross, gradient));
        }
        Some(reduced)
    }

    /// The step that minimises the damped model over all blocks and the shared variables, whose
    /// changes stay between `low` (≤ 0) and `high` (≥ 0): towards the free minimum as far as the
    /// box allows, from there along its face towards the minimum on it, and so on, so that the
    /// damped model falls on every leg. None where the damped model has no minimum.
    pub(super) fn step(
        &self,
        damping: f64,
        low: &DVector<f64>,
        high: &DVector<f64>,
    ) -> Option<DVector<f64>> {
        let reduced = self.reduce(damping)?;
        let curvature = damped(&reduced.curvature, &self.curvature.diagonal(), damping);
        let mut shared = DVector::zeros(low.len());
        let mut open: Vec<usize> = (0..low.len()).filter(|&i| low[i] < high[i]).collect();
        while !open.is_empty() {
            let slope = (&reduced.gradient + &curvature * &shared).select_rows(&open);
            let face = curvature.select_rows(&open).select_columns(&open);
            let leg = face.cholesky()?.solve(&-slope);
            let room = |k: usize| {
                let i = open[k];
                match leg[k] {
                    d if d < 0.0 => (low[i] - shared[i]) / d,
                    d if d > 0.0 => (high[i] - shared[i]) / d,
                    _ => f64::INFINITY,
                }
            };
            let nearest = (0..open.len()).min_by(|&a, &b| room(a).total_cmp(&room(b)))?;
            let part = room(nearest).min(1.0);
            for (&i, d) in open.iter().zip(leg.iter()) {
                shared[i] = (shared[i] + part * d).clamp(low[i], high[i]);
            }
            if part == 1.0 {
                break;
            }
            let i = open.remove(nearest);
            shared[i] = if leg[nearest] < 0.0 { low[i] } else { high[i] };
        }
        let mut step: Vec<f64> = shared.iter().copied().collect();
        for (cross, gradient) in &reduced.solved {
            step.extend((-gradient - cross * &shared).iter());
        }
        step.iter()
            .all(|v| v.is_finite())
            .then(|| DVector::from_vec(step))
    }

    /// By how much the undamped model falls along `step`.
    pub(super) fn fall(&self, step: &DVector<f64>) -> f64 {
        let n = self.gradient.len();
        let shared = step.rows(0, n);
        let mut fall = -self.gradient.dot(&shared) - 0.5 * shared.dot(&(&self.curvature * shared));
        let mut at = n;
        for block in &self.blocks {
            let own = step.rows(at, block.gradient.len());
            at += block.gradient.len();
            fall -= block.gradient.dot(&own)
                + own.dot(&(&block.cross * shared))
                + 0.5 * own.dot(&(&block.curvature * own));
        }
        fall
    }
}

/// `matrix`, what elimination left of one with the diagonal `before`, with its diagonal increased by
/// `damping` of itself. An entry that is but the rounding of the elimination counts as 1e-12 of what
/// it was; one that was empty, a variable without influence here, as the largest.
fn damped(matrix: &DMatrix<f64>, before: &DVector<f64>, damping: f64) -> DMatrix<f64> {
    let mut sum = matrix.clone();
    let largest = before.amax();
    for i in 0..matrix.nrows() {
        let own = if before[i] > 0.0 { before[i] } else { largest };
        sum[(i, i)] += damping * matrix[(i, i)].max(1e-12 * own) + f64::MIN_POSITIVE;
    }
    sum
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
    use super::*;

    #[test]
    fn blocks_are_eliminated_as_the_full_system_would() {
        // a random positive definite 2 + 2 × 3 arrow matrix
        let entry = |i: usize, j: usize| ((i * i * 7 + j * j * 3 + i * j + 1) as f64).sin();
        let jacobian = DMatrix::from_fn(20, 8, |i, j| {
            // rows 0..10 see the first block, 10..20 the second
            let block = if j < 2 { true } else { (j - 2) / 3 == i / 10 };
            if block { entry(i, j) } else { 0.0 }
        });
        let residual = DVector::from_fn(20, |i, _| entry(i, 11));
        let (h, g) = (
            jacobian.transpose() * &jacobian,
            jacobian.transpose() * &residual,
        );
        let block = |k: usize| Block {
            share: jacobian.view((10 * k, 0), (10, 2)).transpose() * residual.rows(10 * k, 10),
            own: jacobian
                .view((10 * k, 0), (10, 2))
                .tr_mul(&jacobian.view((10 * k, 0), (10, 2))),
            gradient: g.rows(2 + 3 * k, 3).into_owned(),
            curvature: h.view((2 + 3 * k, 2 + 3 * k), (3, 3)).into_owned(),
            cross: h.view((2 + 3 * k, 0), (3, 2)).into_owned(),
        };
        let model = Quadratic {
            gradient: g.rows(0, 2).into_owned(),
            curvature: h.view((0, 0), (2, 2)).into_owned(),
            blocks: vec![block(0), block(1)],
        };
        let far = DVector::from_element(2, 1e6);
        let full = h.clone().cholesky().unwrap().solve(&-&g);
        let step = model.step(0.0, &-&far, &far).unwrap();
        assert!((&step - &full).norm() < 1e-9 * full.norm());
        let fall = -g.dot(&full) - 0.5 * full.dot(&(&h * &full));
        assert!((model.fall(&step) / fall - 1.0).abs() < 1e-9);
        // and the clusters are the reduced model's parts
        let reduced = model.reduce(0.0).unwrap();
        let sum: DVector<f64> = reduced.clusters.iter().map(|(score, _)| score).sum();
        assert!((sum - reduced.gradient).norm() < 1e-9);
        let sum: DMatrix<f64> = reduced.clusters.iter().map(|(_, own)| own).sum();
        assert!((sum - reduced.curvature).norm() < 1e-9);
    }

    #[test]
    fn a_step_in_a_box_is_the_minimum_of_the_model_in_it() {
        // a narrow valley along (1, −1), as friction traded against friction makes it: the free
        // minimum (10, −9) is outside, and clamping it to (1, −9) would climb the valley's wall
        let curvature = DMatrix::from_row_slice(2, 2, &[1.0, 0.999, 0.999, 1.0]);
        let gradient = -&curvature * DVector::from_row_slice(&[10.0, -9.0]);
        let model = Quadratic {
            gradient: gradient.clone(),
            curvature: curvature.clone(),
            blocks: Vec::new(),
        };
        let box_of = |x: [f64; 2]| DVector::from_row_slice(&x);
        let step = model
            .step(0.0, &box_of([-1.0, -20.0]), &box_of([1.0, 20.0]))
            .unwrap();
        // with x = 1 the slope along y vanishes at y = −g_y − .999 x
        assert_eq!(step[0], 1.0);
        assert!((step[1] - (-gradient[1] - 0.999)).abs() < 1e-9, "{step}");
        let clamped = model.fall(&box_of([1.0, -9.0]));
        assert!(model.fall(&step) > 0.0 && clamped < 0.0, "{clamped}");
        // a variable without room stays, and the other goes to its minimum
        let held = model
            .step(0.0, &box_of([0.0, -20.0]), &box_of([0.0, 20.0]))
            .unwrap();
        assert_eq!(held[0], 0.0);
        assert!((held[1] + gradient[1]).abs() < 1e-9);
    }
}
