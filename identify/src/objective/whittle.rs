//! `whittle`: the likelihood of the coefficients, −log L = Σ_k [log det S_k + Y_kᴴ S_k⁻¹ Y_k],
//! cross-spectra included. Whittle 1953; Fisher scoring, I_ij = Σ tr(S⁻¹ ∂_iS S⁻¹ ∂_jS).

use super::Information;
use super::spectral::{self, Spectral};
use crate::closed_loop::Bin;
use crate::closed_loop::Expansion;
use crate::error::{Error, Result};
use crate::solver::{Cost, Landscape, Quadratic};
use nalgebra::{Complex, DMatrix, DVector};

/// The problem.
#[derive(Clone)]
pub struct Whittle {
    /// Measured and expected spectra.
    pub spectral: Spectral,
}

impl Whittle {
    /// Mean of Yᴴ S⁻¹ Y per channel: 1 where the model is true.
    pub fn misfit(&self, z: &DVector<f64>) -> Result<f64> {
        let expected = self.spectral.expected(z)?;
        let channels = self.spectral.measured.channels.len();
        let count = (expected.len() * channels) as f64;
        let bins = expected
            .into_iter()
            .zip(&self.spectral.measured.coefficients);
        let sum: f64 = bins
            .map(|(bin, y)| {
                bin.cholesky()
                    .map_or(f64::INFINITY, |f| y.dotc(&f.solve(y)).re)
            })
            .sum();
        Ok(sum / count)
    }

    /// −log L of the measured coefficients.
    fn of(&self, expected: Vec<Bin>) -> f64 {
        let bins = expected
            .into_iter()
            .zip(&self.spectral.measured.coefficients);
        bins.map(|(bin, y)| term(bin, y)).sum()
    }

    /// What the coefficients know at `z`.
    pub fn information(&self, z: &DVector<f64>) -> Result<Information> {
        Ok(self.spectral.information(self.quadratic(z)?.curvature))
    }
}

impl Landscape for Whittle {
    /// −log L; infinite where the loop does not stand or a bin's matrix is not positive definite.
    fn cost(&self, z: &DVector<f64>) -> f64 {
        let expected = self.spectral.expected(z);
        expected.map_or(f64::INFINITY, |expected| self.of(expected))
    }

    fn excess(&self, z: &DVector<f64>) -> f64 {
        self.spectral.excess(z)
    }

    fn costs(&self, points: &[DVector<f64>]) -> Vec<Cost> {
        let expected = self.spectral.each_expected(points).into_iter();
        let cost = |expected: Result<Vec<Bin>>| match expected {
            Ok(expected) => Cost::new(self.of(expected), || 0.0),
            Err(error) => Cost::new(f64::INFINITY, || spectral::excess(&error)),
        };
        expected.map(cost).collect()
    }

    /// Fisher scoring as a problem of least squares: with S = L Lᴴ, w = L⁻¹ Y and the Hermitian
    /// M_i = L⁻¹ ∂_iS L⁻ᴴ, a gradient of tr M_i − wᴴ M_i w and a curvature of tr M_i M_j.
    fn quadratic(&self, z: &DVector<f64>) -> Result<Quadratic> {
        let Expansion {
            expected,
            mut slopes,
        } = self.spectral.expansion(z)?;
        let n = z.len();
        let (mut gradient, mut curvature) = (DVector::zeros(n), DMatrix::zeros(n, n));
        for (k, (bin, y)) in expected
            .into_iter()
            .zip(&self.spectral.measured.coefficients)
            .enumerate()
        {
            let factor = bin.cholesky().ok_or_else(|| {
                Error::Search("a bin's spectral matrix is not positive definite".into())
            })?;
            let lower = factor.l_dirty();
            let mut w = y.clone();
            lower.solve_lower_triangular_mut(&mut w);
            for i in 0..n {
                let slope = &mut slopes[i][k];
                lower.solve_lower_triangular_mut(slope);
                slope.adjoint_mut();
                lower.solve_lower_triangular_mut(slope);
                gradient[i] += slope.trace().re - (&*slope * &w).dotc(&w).re;
                for j in 0..=i {
                    let product = slopes[i][k].dotc(&slopes[j][k]).re;
                    curvature[(i, j)] += product;
                    if i != j {
                        curvature[(j, i)] += product;
                    }
                }
            }
        }
        Ok(Quadratic {
            gradient,
            curvature,
            blocks: Vec::new(),
        })
    }
}

fn term(bin: Bin, y: &DVector<Complex<f64>>) -> f64 {
    bin.cholesky().map_or(f64::INFINITY, |factor| {
        let log_det: f64 = factor
            .l_dirty()
            .diagonal()
            .iter()
            .map(|d| 2.0 * d.re.ln())
            .sum();
        log_det + y.dotc(&factor.solve(y)).re
    })
}
