//! (iω − A)⁻¹ b at many frequencies.

use bicycle::State;
use nalgebra::{DMatrix, DVector};

/// Complex rows over frequencies: one row a frequency, real and imaginary parts apart.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    pub re: DMatrix<f64>,
    pub im: DMatrix<f64>,
}

impl Motion {
    /// Each row mapped by `matrix`: x ↦ `matrix` x.
    pub fn through(&self, matrix: &DMatrix<f64>) -> Self {
        let mut mapped = Self {
            re: DMatrix::zeros(self.re.nrows(), matrix.nrows()),
            im: DMatrix::zeros(self.im.nrows(), matrix.nrows()),
        };
        // changes of a loop are mostly zeros
        for j in 0..matrix.ncols() {
            for (i, &factor) in matrix.column(j).iter().enumerate() {
                if factor != 0.0 {
                    let (mut re, mut im) = (mapped.re.column_mut(i), mapped.im.column_mut(i));
                    re.axpy(factor, &self.re.column(j), 1.0);
                    im.axpy(factor, &self.im.column(j), 1.0);
                }
            }
        }
        mapped
    }
}

/// Frequencies taken together, so that they fill vector registers.
const TOGETHER: usize = 8;
type Together = [f64; TOGETHER];

/// `rows · (iω − A)⁻¹ b` for the angular frequencies `omega`; at most [`State::LEN`] states.
///
/// In the orthonormal basis V that Arnoldi's process makes of b, A b, A² b, … the matrix is a
/// Hessenberg matrix H and b a multiple of the first vector. The rows of `(iω − H) x = e_1` below
/// the first then give x from its last entry upwards, and the first row its size (Hyman's method:
/// Wilkinson 1965, *The Algebraic Eigenvalue Problem*, ch. 7 §11). Each row is solved to round-off,
/// whatever the eigenvectors; what b does not reach does not move and is left out.
pub(super) fn response(
    rows: &DMatrix<f64>,
    a: &DMatrix<f64>,
    b: &DVector<f64>,
    omega: &[f64],
) -> Motion {
    let (h, basis) = arnoldi(a, b);
    let rows = rows * basis * b.norm();
    let mut seen = Motion {
        re: DMatrix::zeros(omega.len(), rows.nrows()),
        im: DMatrix::zeros(omega.len(), rows.nrows()),
    };
    if h.nrows() == 0 {
        return seen;
    }
    for (chunk, frequencies) in omega.chunks(TOGETHER).enumerate() {
        let mut w = [0.0; TOGETHER];
        w[..frequencies.len()].copy_from_slice(frequencies);
        let (re, im) = hyman(&h, &w);
        let place = chunk * TOGETHER..chunk * TOGETHER + frequencies.len();
        for (i, row) in rows.row_iter().enumerate() {
            let (mut sum_re, mut sum_im) = ([0.0; TOGETHER], [0.0; TOGETHER]);
            for (j, factor) in row.iter().enumerate() {
                add(&mut sum_re, *factor, &re[j]);
                add(&mut sum_im, *factor, &im[j]);
            }
            let count = frequencies.len();
            let (mut re, mut im) = (seen.re.column_mut(i), seen.im.column_mut(i));
            re.as_mut_slice()[place.clone()].copy_from_slice(&sum_re[..count]);
            im.as_mut_slice()[place.clone()].copy_from_slice(&sum_im[..count]);
        }
    }
    seen
}

/// `sum + factor · x`.
fn add(sum: &mut Together, factor: f64, x: &Together) {
    for (sum, x) in sum.iter_mut().zip(x) {
        *sum += factor * x;
    }
}

/// x of `(iω − H) x = e_1`, real and imaginary parts.
fn hyman(h: &DMatrix<f64>, omega: &Together) -> ([Together; State::LEN], [Together; State::LEN]) {
    let mut re = [[0.0; TOGETHER]; State::LEN];
    let mut im = re;
    let m = h.nrows();
    re[m - 1] = [1.0; TOGETHER];
    for i in (0..m).rev() {
        // row i of (iω − H) x, but for x_{i−1}
        let (mut row_re, mut row_im) = ([0.0; TOGETHER], [0.0; TOGETHER]);
        for k in 0..TOGETHER {
            row_re[k] = -omega[k] * im[i][k];
            row_im[k] = omega[k] * re[i][k];
        }
        for j in i..m {
            add(&mut row_re, -h[(i, j)], &re[j]);
            add(&mut row_im, -h[(i, j)], &im[j]);
        }
        if i > 0 {
            let inverse = 1.0 / h[(i, i - 1)];
            add(&mut re[i - 1], inverse, &row_re);
            add(&mut im[i - 1], inverse, &row_im);
            continue;
        }
        for k in 0..TOGETHER {
            let square = row_re[k] * row_re[k] + row_im[k] * row_im[k];
            (row_re[k], row_im[k]) = (row_re[k] / square, -row_im[k] / square);
        }
        for j in 0..m {
            for k in 0..TOGETHER {
                let (u, v) = (re[j][k], im[j][k]);
                re[j][k] = u * row_re[k] - v * row_im[k];
                im[j][k] = u * row_im[k] + v * row_re[k];
            }
        }
    }
    (re, im)
}

/// H = Vᵀ A V and V, its first column along `b`; as many columns as `b` reaches.
fn arnoldi(a: &DMatrix<f64>, b: &DVector<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = a.nrows();
    let (mut h, mut basis) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    let unreached = n as f64 * f64::EPSILON * a.norm();
    let mut next = b.clone();
    let mut rest = b.norm();
    let mut reached = 0;
    while reached < n && rest > if reached == 0 { 0.0 } else { unreached } {
        if reached > 0 {
            h[(reached, reached - 1)] = rest;
        }
        basis.set_column(reached, &(next / rest));
        next = a * basis.column(reached);
        let known = basis.columns(0, reached + 1);
        // twice is enough (Kahan, Parlett)
        for _ in 0..2 {
            let along = known.tr_mul(&next);
            next -= known * &along;
            let mut column = h.view_mut((0, reached), (reached + 1, 1));
            column += along;
        }
        rest = next.norm();
        reached += 1;
    }
    (
        h.view((0, 0), (reached, reached)).into_owned(),
        basis.columns(0, reached).into_owned(),
    )
}
