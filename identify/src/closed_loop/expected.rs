//! What the bins of a record are expected to show of a loop, and how that changes with it.

use super::response::{Motion, response};
use super::{Change, ClosedLoop, Drive, torque};
use crate::error::Result;
use crate::spectrum::Kernel;
use bicycle::Parameters;
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;

/// One bin of several channels: a Hermitian matrix of cross-powers [unit²/Hz].
pub type Bin = DMatrix<Complex<f64>>;

/// Expected cross-powers and their derivatives.
#[derive(Debug, Clone)]
pub struct Expansion {
    /// Expected cross-powers, one Hermitian matrix a bin.
    pub expected: Vec<Bin>,
    /// Their derivatives: for each variable one matrix a bin.
    pub slopes: Vec<Vec<Bin>>,
}

/// The loop's states counted in their own standard deviations, so that no row of its equations is
/// large for its unit alone.
struct Scaled<'a> {
    closed_loop: &'a ClosedLoop,
    units: DVector<f64>,
}

impl Scaled<'_> {
    fn state(&self, a: &DMatrix<f64>) -> DMatrix<f64> {
        let d = &self.units;
        DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * d[j] / d[i])
    }

    fn torque(&self, b: &DVector<f64>) -> DVector<f64> {
        b.component_div(&self.units)
    }

    fn seen(&self, c: &DMatrix<f64>, channels: &[usize]) -> DMatrix<f64> {
        c.select_rows(channels) * DMatrix::from_diagonal(&self.units)
    }

    /// Motion of the states under torque of density 1.
    fn motion(&self, omega: &[f64]) -> Motion {
        let ClosedLoop { gains, state, .. } = self.closed_loop;
        let all = DMatrix::identity(self.units.len(), self.units.len());
        let torque = self.torque(&torque(gains));
        response(&all, &self.state(state), &torque, omega)
    }

    /// Derivatives of what is seen in `channels` of the motion `x`: `dC x + C (iω − A)⁻¹
    /// (dA x + dB)`, without those of the size of the torque.
    fn slopes(
        &self,
        channels: &[usize],
        omega: &[f64],
        x: &Motion,
        changes: &[Change],
    ) -> Vec<Motion> {
        let ClosedLoop { gains, state, .. } = self.closed_loop;
        // rows of C (iω − A)⁻¹: responses of the transposed system
        let all = DMatrix::identity(self.units.len(), self.units.len());
        let back = self.state(state).transpose();
        let seen = self.seen(&gains.parts.seen, channels);
        let back: Vec<Motion> = seen
            .row_iter()
            .map(|row| response(&all, &back, &row.transpose(), omega))
            .collect();
        let slope = |change: &Change| {
            let mut slope = x.through(&self.seen(&change.seen, channels));
            let mut push = x.through(&self.state(&change.state));
            for (mut column, b) in push.re.column_iter_mut().zip(&self.torque(&change.torque)) {
                column.add_scalar_mut(*b);
            }
            for (channel, back) in back.iter().enumerate() {
                let (mut re, mut im) = (slope.re.column_mut(channel), slope.im.column_mut(channel));
                let (re, im) = (re.as_mut_slice(), im.as_mut_slice());
                for i in 0..push.re.ncols() {
                    add_product((re, im), column(back, i), column(&push, i), 1.0);
                }
            }
            slope
        };
        changes.iter().map(slope).collect()
    }
}

/// A complex column.
type Column<'a> = (&'a [f64], &'a [f64]);

fn column(motion: &Motion, index: usize) -> Column<'_> {
    let rows = motion.re.nrows();
    let place = index * rows..(index + 1) * rows;
    (
        &motion.re.as_slice()[place.clone()],
        &motion.im.as_slice()[place],
    )
}

/// Adds u v, or for `sign` −1 u v̄.
fn add_product((re, im): (&mut [f64], &mut [f64]), u: Column, v: Column, sign: f64) {
    // equal lengths, said once: no check is left in the loop
    let count = re.len();
    let (re, im) = (&mut re[..count], &mut im[..count]);
    let (ur, ui, vr, vi) = (&u.0[..count], &u.1[..count], &v.0[..count], &v.1[..count]);
    for k in 0..count {
        let vi = sign * vi[k];
        re[k] += ur[k] * vr[k] - ui[k] * vi;
        im[k] += ur[k] * vi + ui[k] * vr[k];
    }
}

/// Densities y_i ȳ_j of the pairs i ≥ j, or their derivatives with a slope of y; of the parts the
/// imaginary only where i > j.
fn densities(y: &Motion, slope: Option<&Motion>) -> (Vec<f64>, Vec<f64>) {
    let (rows, channels) = y.re.shape();
    let (mut real, mut imaginary) = (Vec::new(), Vec::new());
    for i in 0..channels {
        for j in 0..=i {
            let (mut re, mut im) = (vec![0.0; rows], vec![0.0; rows]);
            if let Some(slope) = slope {
                add_product((&mut re, &mut im), column(slope, i), column(y, j), -1.0);
                add_product((&mut re, &mut im), column(y, i), column(slope, j), -1.0);
            } else {
                add_product((&mut re, &mut im), column(y, i), column(y, j), -1.0);
            }
            real.append(&mut re);
            if i > j {
                imaginary.append(&mut im);
            }
        }
    }
    (real, imaginary)
}

impl ClosedLoop {
    /// Two-sided spectral density [(N m)²/Hz] of the remnant, and its relative derivative over the
    /// corner [s], at the angular frequency `omega` [1/s].
    fn remnant_density(&self, omega: f64) -> (f64, f64) {
        let rate = self.drive.rate();
        let square = rate * rate + omega * omega;
        (
            self.drive.remnant_intensity.powi(2) * 2.0 * rate / square,
            1.0 / rate - 2.0 * rate / square,
        )
    }

    /// Expected cross-powers of the rows `channels` of the state in each bin of `kernel`, white
    /// noise of standard deviation `noise` [SI] and step `step` [s] added: one Hermitian matrix a
    /// bin.
    pub fn expected(
        &self,
        kernel: &Kernel,
        channels: &[usize],
        noise: &[f64],
        step: f64,
    ) -> Vec<Bin> {
        self.expand(kernel, channels, noise, step, &[]).expected
    }

    /// The same with the derivatives along `variables`: of each the parameters and the drive on
    /// both sides of this loop's, `width` units of the variable apart.
    pub fn expansion(
        &self,
        kernel: &Kernel,
        channels: &[usize],
        noise: &[f64],
        step: f64,
        (variables, width): (&[[(Parameters, Drive); 2]], f64),
    ) -> Result<Expansion> {
        let changes = self.changes(variables, width)?;
        Ok(self.expand(kernel, channels, noise, step, &changes))
    }

    fn expand(
        &self,
        kernel: &Kernel,
        channels: &[usize],
        noise: &[f64],
        step: f64,
        changes: &[Change],
    ) -> Expansion {
        let omega: Vec<f64> = kernel.frequencies.iter().map(|f| TAU * f).collect();
        let scaled = Scaled {
            closed_loop: self,
            units: self.covariance.diagonal().map(f64::sqrt),
        };
        let x = scaled.motion(&omega);
        let y = x.through(&scaled.seen(&self.gains.parts.seen, channels));
        let (mut real, mut imaginary) = densities(&y, None);
        if !changes.is_empty() {
            let slopes = scaled.slopes(channels, &omega, &x, changes);
            for (mut slope, change) in slopes.into_iter().zip(changes) {
                // the torque's amplitude grows by half as much as its power
                for (k, w) in omega.iter().enumerate() {
                    let grow = change.intensity + 0.5 * change.rate * self.remnant_density(*w).1;
                    for c in 0..channels.len() {
                        slope.re[(k, c)] += grow * y.re[(k, c)];
                        slope.im[(k, c)] += grow * y.im[(k, c)];
                    }
                }
                let (mut re, mut im) = densities(&y, Some(&slope));
                real.append(&mut re);
                imaginary.append(&mut im);
            }
        }
        let power = omega.iter().map(|w| self.remnant_density(*w).0);
        let power = DVector::from_iterator(omega.len(), power);
        let weighted = |columns: Vec<f64>| {
            let count = columns.len() / power.len();
            let mut columns = DMatrix::from_vec(power.len(), count, columns);
            for mut column in columns.column_iter_mut() {
                column.component_mul_assign(&power);
            }
            columns
        };
        let real = kernel.expect_real(&weighted(real));
        let imaginary = kernel.expect_imaginary(&weighted(imaginary));

        let n = channels.len();
        let (pairs, crossed) = (n * (n + 1) / 2, n * (n - 1) / 2);
        let bins = |part: usize| -> Vec<Bin> {
            let bin = |k: usize| {
                let mut bin = DMatrix::zeros(n, n);
                let (mut column, mut cross) = (part * pairs, part * crossed);
                for i in 0..n {
                    for j in 0..=i {
                        let mut value = Complex::from(real[(k, column)]);
                        column += 1;
                        if i > j {
                            value.im = imaginary[(k, cross)];
                            cross += 1;
                        }
                        bin[(i, j)] = value;
                        bin[(j, i)] = value.conj();
                    }
                }
                bin
            };
            (0..real.nrows()).map(bin).collect()
        };
        let mut expected = bins(0);
        for (bin, white) in expected.iter_mut().zip(&kernel.white) {
            for (i, deviation) in noise.iter().enumerate() {
                bin[(i, i)] += deviation * deviation * step * white;
            }
        }
        Expansion {
            expected,
            slopes: (1..=changes.len()).map(bins).collect(),
        }
    }
}
