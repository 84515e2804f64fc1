//! `amplitude`: expected amplitude against measured amplitude, bin by bin.
//!
//! The magnitude of a Gaussian coefficient of power S has mean √(πS/4) and standard deviation
//! √(4/π − 1) = .5227 times that; its correlation between channels is the squared coherence to a
//! few per cent. The weights come from the **model**, frozen during one search and renewed until
//! the parameters stay: weights from the measured amplitude pull every estimate down.

use super::Information;
use super::spectral::Spectral;
use crate::closed_loop::Bin;
use crate::closed_loop::Expansion;
use crate::error::Result;
use crate::solver::{Landscape, Quadratic};
use nalgebra::{Complex, DMatrix, DVector};
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
        Ok(self.weighted(&self.spectral.expected(z)?))
    }

    fn weighted(&self, expected: &[Bin]) -> DVector<f64> {
        let bins = self.spectral.measured.coefficients.iter().zip(expected);
        self.whitened(bins.map(|(y, bin)| y.map(Complex::norm) - mean(bin)))
    }

    /// One column of the vectors of all bins, whitened.
    fn whitened(&self, bins: impl Iterator<Item = DVector<f64>>) -> DVector<f64> {
        let mut column = Vec::new();
        for (w, bin) in self.whitening.iter().zip(bins) {
            column.extend((w * bin).iter());
        }
        DVector::from_vec(column)
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
        let Expansion { expected, slopes } = self.spectral.expansion(z)?;
        let residuals = self.weighted(&expected);
        let columns: Vec<DVector<f64>> = slopes
            .iter()
            .map(|slopes| {
                // ∂√(πS/4) = ½ m ∂S/S
                let change = |(bin, slope): (&Bin, &Bin)| {
                    let relative = slope
                        .diagonal()
                        .zip_map(&bin.diagonal(), |d, s| d.re / s.re);
                    mean(bin).component_mul(&relative) * -0.5
                };
                self.whitened(expected.iter().zip(slopes).map(change))
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
