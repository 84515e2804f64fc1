//! (iω − A)⁻¹ b at many frequencies.

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
        let transpose = matrix.transpose();
        Self {
            re: &self.re * &transpose,
            im: &self.im * &transpose,
        }
    }
}

/// `(iω − A)⁻¹ b` for the angular frequencies `omega`.
///
/// In the orthonormal basis V that Arnoldi's process makes of b, A b, A² b, … the matrix is a
/// Hessenberg matrix H and b a multiple of the first vector. The rows of `(iω − H) x = e_1` below
/// the first then give x from its last entry upwards, and the first row its size (Hyman's method:
/// Wilkinson 1965, *The Algebraic Eigenvalue Problem*, ch. 7 §11). Each row is solved to round-off,
/// whatever the eigenvectors; what b does not reach does not move and is left out.
pub(super) fn response(a: &DMatrix<f64>, b: &DVector<f64>, omega: &DVector<f64>) -> Motion {
    let (h, basis) = arnoldi(a, b);
    let (m, count) = (h.nrows(), omega.len());
    if m == 0 {
        let still = DMatrix::zeros(count, a.nrows());
        return Motion {
            re: still.clone(),
            im: still,
        };
    }
    let mut x = Motion {
        re: DMatrix::zeros(count, m),
        im: DMatrix::zeros(count, m),
    };
    x.re.column_mut(m - 1).fill(1.0);
    for i in (0..m).rev() {
        // row i of (iω − H) x, but for x_{i−1}
        let row = h.row(i).columns(i, m - i).transpose();
        let mut re = -x.im.column(i).component_mul(omega);
        re.gemv(-1.0, &x.re.columns(i, m - i), &row, 1.0);
        let mut im = x.re.column(i).component_mul(omega);
        im.gemv(-1.0, &x.im.columns(i, m - i), &row, 1.0);
        if i > 0 {
            x.re.set_column(i - 1, &(re / h[(i, i - 1)]));
            x.im.set_column(i - 1, &(im / h[(i, i - 1)]));
            continue;
        }
        let size = b.norm();
        for (re, im) in re.iter_mut().zip(im.iter_mut()) {
            let square = *re * *re + *im * *im;
            (*re, *im) = (size * *re / square, -size * *im / square);
        }
        for (mut u, mut v) in x.re.column_iter_mut().zip(x.im.column_iter_mut()) {
            for (((u, v), re), im) in u.iter_mut().zip(v.iter_mut()).zip(&re).zip(&im) {
                (*u, *v) = (*u * re - *v * im, *u * im + *v * re);
            }
        }
    }
    x.through(&basis)
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
