//! What the windows' free initial states take up of what is left: least squares leaves (I − H) e of
//! noise e, with the hat matrix H of the slopes of a window's residuals over its start. Hoaglin &
//! Welsch 1978, *Am. Stat.* 32, 17.

use super::Time;
use crate::error::{Error, Result};
use nalgebra::{DMatrix, DVector};

/// Relative singular value below which the residuals do not see a direction of the start.
const SINGULAR: f64 = 1e-6;

impl Time {
    /// For each window at `z` an orthonormal basis Q of what its start takes up, H = Q Qᵀ: a row for
    /// each residual (channel by channel, over its noise), as many columns as the start counts for
    /// parameters.
    pub fn hat_bases(&self, z: &DVector<f64>) -> Result<Vec<DMatrix<f64>>> {
        // rad, rad/s, m/s: far below the widths of the jumps, and good to nine digits
        const H: f64 = 1e-5;
        // a start moves its own window alone: all are moved at once
        let slopes = (0..self.order)
            .map(|row| {
                let at = |h: f64| {
                    let mut moved = z.clone();
                    for start in (self.shared()..z.len()).step_by(self.order) {
                        moved[start + row] += h;
                    }
                    self.residuals(&moved)
                };
                Ok((at(H)?, at(-H)?))
            })
            .collect::<Result<Vec<_>>>()?;
        let basis = |window: usize| {
            let columns: Vec<DVector<f64>> = (slopes.iter())
                .map(|(up, down)| {
                    let pairs = up[window].iter().zip(&down[window]);
                    DVector::from_iterator(
                        up[window].len(),
                        pairs.map(|(a, b)| (a - b) / (2.0 * H)),
                    )
                })
                .filter_map(|column| column.try_normalize(0.0))
                .collect();
            orthonormal(&columns, slopes[0].0[window].len())
        };
        let bad = |(up, down): &(Vec<Vec<f64>>, Vec<Vec<f64>>)| {
            up.iter().chain(down).flatten().any(|r| !r.is_finite())
        };
        if slopes.iter().any(bad) {
            let cause = "a window's residuals are not finite beside its start";
            return Err(Error::Search(cause.into()));
        }
        Ok((0..self.windows()).map(basis).collect())
    }
}

/// An orthonormal basis of what `columns` of `rows` span.
fn orthonormal(columns: &[DVector<f64>], rows: usize) -> DMatrix<f64> {
    if columns.is_empty() {
        return DMatrix::zeros(rows, 0);
    }
    let svd = DMatrix::from_columns(columns).svd(true, false);
    let least = SINGULAR * svd.singular_values.max();
    let kept = svd.singular_values.iter().filter(|s| **s > least).count();
    // largest first
    svd.u.expect("asked for").columns(0, kept).into_owned()
}
