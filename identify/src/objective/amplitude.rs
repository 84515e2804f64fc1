//! `amplitude`: expected amplitude against measured amplitude, bin by bin.
//!
//! The magnitude of a Gaussian coefficient of power S has mean √(πS/4) and standard deviation
//! √(4/π − 1) = .5227 times that; its correlation between channels is the squared coherence to a
//! few per cent. The weights come from the **model**, frozen during one search and renewed until
//! the parameters stay: weights from the measured amplitude pull every estimate down.

use super::Information;
use super::spectral::{Bin, Spectral};
use crate::error::Result;
use crate::solver::{Landscape, Quadratic};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

/// Standard deviation over mean of a Rayleigh variable.
fn scatter() -> f64 {
    (4.0 / PI - 1.0).sqrt()
}

/// The problem, its weights frozen.
#[derive(Clone)]
pub struct Amplitude {
    spectral: Spectral,
    /// Inverse Cholesky factor of the amplitudes' covariance, a bin each.
    whitening: Vec<DMatrix<f64>>,
}

/// Mean amplitudes of a bin of expected powers.
fn mean(bin: &Bin) -> DVector<f64> {
    bin.diagonal().map(|s| (0.25 * PI * s.re).sqrt())
}

impl Amplitude {
    /// With weights from the model at the variables `z`.
    pub fn new(spectral: Spectral, z: &DVector<f64>) -> Result<Self> {
        let whitening = spectral
            .expected(z)?
            .iter()
            .map(|bin| {
                let m = mean(bin);
                let covariance = DMatrix::from_fn(m.len(), m.len(), |i, j| {
                    let coherence = bin[(i, j)].norm_sqr() / (bin[(i, i)].re * bin[(j, j)].re);
                    scatter() * scatter() * m[i] * m[j] * coherence
                });
                // noise keeps the coherence below 1, and the matrix regular
                let factor = covariance.cholesky().map(nalgebra::Cholesky::unpack);
                factor
                    .and_then(DMatrix::try_inverse)
                    .unwrap_or_else(|| DMatrix::from_diagonal(&m.map(|m| 1.0 / (scatter() * m))))
            })
            .collect();
        Ok(Self {
            spectral,
            whitening,
        })
    }

    /// Weighted residuals, measured minus expected: unit variance where the model is true.
    pub fn residuals(&self, z: &DVector<f64>) -> Result<DVector<f64>> {
        let expected = self.spectral.expected(z)?;
        let measured = &self.spectral.measured.coefficients;
        let parts = expected
            .iter()
            .zip(measured)
            .zip(&self.whitening)
            .flat_map(|((bin, y), w)| {
                let residual = w * (y.map(nalgebra::Complex::norm) - mean(bin));
                residual.iter().copied().collect::<Vec<_>>()
            });
        Ok(DVector::from_vec(parts.collect()))
    }

    /// What the amplitudes know at `z`, weighted by the model there.
    pub fn information(&self, z: &DVector<f64>) -> Result<Information> {
        Ok(self
            .spectral
            .information(Self::new(self.spectral.clone(), z)?.quadratic(z)?.curvature))
    }
}

impl Landscape for Amplitude {
    /// ½ Σ r²; a loop that does not stand has no spectrum: infinitely far away, and no error.
    fn cost(&self, z: &DVector<f64>) -> f64 {
        self.residuals(z)
            .map_or(f64::INFINITY, |r| 0.5 * r.norm_squared())
    }

    fn quadratic(&self, z: &DVector<f64>) -> Result<Quadratic> {
        let residuals = self.residuals(z)?;
        let expected = self.spectral.expected(z)?;
        let columns: Vec<DVector<f64>> = self
            .spectral
            .slopes(z)?
            .iter()
            .map(|slopes| {
                let parts = expected.iter().zip(slopes).zip(&self.whitening).flat_map(
                    |((bin, slope), w)| {
                        let m = mean(bin);
                        // ∂√(πS/4) = ½ m ∂S/S
                        let change = DVector::from_fn(m.len(), |i, _| {
                            -0.5 * m[i] * slope[(i, i)].re / bin[(i, i)].re
                        });
                        (w * change).iter().copied().collect::<Vec<_>>()
                    },
                );
                DVector::from_vec(parts.collect())
            })
            .collect();
        let jacobian = DMatrix::from_columns(&columns);
        Ok(Quadratic {
            gradient: jacobian.transpose() * residuals,
            curvature: jacobian.transpose() * jacobian,
            blocks: Vec::new(),
        })
    }
}
