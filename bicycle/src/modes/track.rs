//! Eigenvalues and eigenvectors along a path of matrices, from one to the next.

use super::{Mode, Root};
use crate::linear::Spectral;
use nalgebra::{Complex, SMatrix, SVector};

/// Eigenvectors are compared over roll rate, steer rate, roll and steer: the first rows of the
/// state in every formulation, and in like units.
const SEEN: usize = 4;
const ROLL: usize = 2;
const STEER: usize = 3;
/// Two modes are told apart where the likelier continuation costs at most half the other.
const CLEARLY: f64 = 0.5;
/// A continuation that costs more is no continuation: a third of the way to another mode of
/// another shape.
const FAR: f64 = 0.3;
/// A step is halved at most this often. By then two modes that cannot be told apart are next to
/// a double root, where they have become one.
const HALVINGS: i32 = 10;

/// A real eigenvalue, or a complex pair by its upper member.
#[derive(Debug, Clone, Copy)]
struct Branch {
    value: Complex<f64>,
    /// The eigenvector over what is seen, of length 1.
    shape: SVector<Complex<f64>, SEEN>,
    /// Names of the upper and the lower member of a pair; of a real mode twice its one.
    names: [Mode; 2],
}

impl Branch {
    fn is_real(&self) -> bool {
        self.value.im == 0.0
    }

    /// How unlike the other it is: distance of the eigenvalues against their size, and angle
    /// between the eigenvectors (1 − MAC, the modal assurance criterion; Allemang 2003).
    fn cost(&self, other: &Self) -> f64 {
        let distance = (self.value - other.value).norm();
        // 1/s, a slow mode: below that the size of an eigenvalue is no scale
        let size = self.value.norm() + other.value.norm() + 1.0;
        distance / size + 1.0 - self.shape.dotc(&other.shape).norm_sqr()
    }

    /// The name as it is told: of two that joined that of the one that grew more, but what swings
    /// with weave in it is weave.
    fn told(&self) -> Mode {
        match self.names {
            [Mode::Castering, Mode::Tyre] | [Mode::Tyre, Mode::Castering] => Mode::Wobble,
            [Mode::Weave, Mode::Capsize] | [Mode::Capsize, Mode::Weave] => Mode::Weave,
            [upper, _] => upper,
        }
    }
}

/// Real eigenvalues and pairs of an N × N matrix, as many as `count`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Branches<const N: usize> {
    all: [Branch; N],
    count: usize,
}

impl<const N: usize> Branches<N>
where
    SMatrix<f64, N, N>: Spectral<N>,
{
    /// Those of a matrix, as yet without names; NaN where it is not finite.
    pub(super) fn of(a: &SMatrix<f64, N, N>) -> Self {
        let unknown = Branch {
            value: Complex::new(f64::NAN, 0.0),
            shape: SVector::zeros(),
            names: [Mode::Tyre; 2],
        };
        let mut branches = Self {
            all: [unknown; N],
            count: N,
        };
        let Some(values) = a.spectrum() else {
            return branches;
        };
        branches.count = 0;
        for value in values.iter().filter(|v| v.im >= 0.0) {
            branches.all[branches.count] = Branch {
                value: *value,
                shape: shape(a, *value),
                ..unknown
            };
            branches.count += 1;
        }
        branches
    }

    fn iter(&self) -> impl Iterator<Item = &Branch> {
        self.all[..self.count].iter()
    }

    /// How many complex pairs there are.
    pub(super) fn pairs(&self) -> usize {
        self.iter().filter(|branch| !branch.is_real()).count()
    }

    /// Every eigenvalue with its name, in the order of [`super::over_speeds`].
    pub(super) fn roots(&self) -> Vec<Root> {
        let mut roots = Vec::with_capacity(N);
        for branch in self.iter() {
            let (value, mode) = (branch.value, branch.told());
            roots.push(Root { value, mode });
            if !branch.is_real() {
                let value = value.conj();
                roots.push(Root { value, mode });
            }
        }
        roots.sort_by(|a, b| {
            let by_value = b.value.re.total_cmp(&a.value.re);
            a.mode
                .cmp(&b.mode)
                .then(by_value)
                .then(b.value.im.total_cmp(&a.value.im))
        });
        roots
    }

    /// Largest real part [1/s] among the eigenvalues of `mode`; −∞ where there is none.
    pub(super) fn growth(&self, mode: Mode) -> f64 {
        let of_mode = self.iter().filter(|branch| branch.told() == mode);
        of_mode.fold(f64::NEG_INFINITY, |most, branch| most.max(branch.value.re))
    }

    /// Names the matrix of the next point after this one; none where it is in doubt which mode is
    /// which, unless it is `forced`.
    fn carried_to(&self, a: &SMatrix<f64, N, N>, forced: bool) -> Option<Self> {
        let mut next = Self::of(a);
        if next.iter().any(|branch| branch.value.re.is_nan()) {
            return Some(next);
        }
        if !forced && next.count.abs_diff(self.count) > 1 {
            return None;
        }
        let mut costs = [[f64::INFINITY; N]; N];
        for (row, old) in costs.iter_mut().zip(self.iter()) {
            for (cost, new) in row.iter_mut().zip(next.iter()) {
                if old.is_real() == new.is_real() {
                    *cost = old.cost(new);
                }
            }
        }
        let (mut from, mut taken) = ([None; N], [false; N]);
        while let Some((i, j)) = cheapest(&costs, &taken, &from) {
            (from[j], taken[i]) = (Some(i), true);
            let rival = |k: usize| self.all[k].names != self.all[i].names;
            let doubtful =
                (0..self.count).any(|k| k != i && rival(k) && costs[i][j] > CLEARLY * costs[k][j]);
            if !forced && (doubtful || costs[i][j] > FAR) {
                return None;
            }
            next.all[j].names = self.all[i].names;
        }
        self.junctions(&mut next, &taken, &from, forced)?;
        Some(next)
    }

    /// Names what has no counterpart of its own kind: pairs that split, real modes that join.
    fn junctions(
        &self,
        next: &mut Self,
        taken: &[bool; N],
        from: &[Option<usize>; N],
        forced: bool,
    ) -> Option<()> {
        let upper_first = |a: &Branch, b: &Branch| b.value.re.total_cmp(&a.value.re);
        let mut left: Vec<Branch> = (0..self.count)
            .filter(|i| !taken[*i])
            .map(|i| self.all[i])
            .collect();
        if left.is_empty() {
            return Some(());
        }
        left.sort_by(upper_first);
        let mut names = left.iter().flat_map(|branch| {
            let count = if branch.is_real() { 1 } else { 2 };
            branch.names.into_iter().take(count)
        });
        let mut new: Vec<usize> = (0..next.count).filter(|j| from[*j].is_none()).collect();
        new.sort_by(|i, j| upper_first(&next.all[*i], &next.all[*j]));
        let extent = |of: &[Branch]| {
            let size = of.iter().map(|b| b.value.norm()).fold(1.0, f64::max);
            let (high, low) = (of[0].value, of[of.len() - 1].value);
            (
                (high.re - low.re).abs() + high.im,
                0.5 * (high.re + low.re),
                size,
            )
        };
        let found: Vec<Branch> = new.iter().map(|j| next.all[*j]).collect();
        let ((before, middle, size), (after, moved, _)) = (extent(&left), extent(&found));
        if !forced && before + after + (middle - moved).abs() > FAR * size {
            return None;
        }
        for j in new {
            let branch = &mut next.all[j];
            let upper = names.next()?;
            let lower = if branch.is_real() {
                upper
            } else {
                names.next()?
            };
            branch.names = [upper, lower];
        }
        Some(())
    }

    /// Names the four modes of the bicycle without slip and rider: a pair weave, of the others
    /// the slower capsize. Without a single pair, by real part.
    pub(super) fn name_without_slip(&mut self) {
        let single = self.pairs() == 1;
        let mut order: Vec<usize> = (0..self.count).collect();
        order.sort_by(|i, j| {
            let later = |k: usize| single && self.all[k].is_real();
            let growth = |k: usize| self.all[k].value.re;
            let by_growth = growth(*j).total_cmp(&growth(*i));
            later(*i).cmp(&later(*j)).then(by_growth)
        });
        let mut names = [Mode::Weave, Mode::Weave, Mode::Capsize, Mode::Castering].into_iter();
        for i in order {
            let branch = &mut self.all[i];
            let upper = names.next().unwrap_or(Mode::Castering);
            let lower = if branch.is_real() { None } else { names.next() };
            branch.names = [upper, lower.unwrap_or(upper)];
        }
    }

    /// Names the modes most like those of `reference` after them, and what is left after the
    /// tyres.
    pub(super) fn name_after(&mut self, reference: &Branches<4>) {
        let members = |branch: &Branch| if branch.is_real() { 1 } else { 2 };
        // each member of a pair counts by itself: a pair here may be two real modes there
        let mut wanted: Vec<(Branch, Mode)> = Vec::with_capacity(4);
        for branch in reference.iter() {
            wanted.extend((0..members(branch)).map(|k| (*branch, branch.names[k])));
        }
        let mut given: [Vec<Mode>; N] = std::array::from_fn(|_| Vec::new());
        while !wanted.is_empty() {
            let mut best = (f64::INFINITY, 0, 0);
            for (i, (branch, _)) in wanted.iter().enumerate() {
                for (j, own) in self.iter().enumerate() {
                    let cost = branch.cost(own);
                    if given[j].len() < members(own) && cost < best.0 {
                        best = (cost, i, j);
                    }
                }
            }
            if best.0 == f64::INFINITY {
                break;
            }
            given[best.2].push(wanted.remove(best.1).1);
        }
        for (branch, names) in self.all.iter_mut().zip(&given) {
            let upper = names.first().copied().unwrap_or(Mode::Tyre);
            let lower = if branch.is_real() { upper } else { Mode::Tyre };
            branch.names = [upper, names.get(1).copied().unwrap_or(lower)];
        }
        let steering = |b: &Branch| b.shape[STEER].norm() / b.shape[ROLL].norm();
        let of_tyres = |b: &&mut Branch| !b.is_real() && b.names == [Mode::Tyre; 2];
        let wobble = self.all[..self.count]
            .iter_mut()
            .filter(of_tyres)
            .max_by(|a, b| steering(a).total_cmp(&steering(b)));
        if let Some(branch) = wobble {
            branch.names = [Mode::Wobble; 2];
        }
    }
}

/// The cheapest pair of an old mode and a new one that are both free.
fn cheapest<const N: usize>(
    costs: &[[f64; N]; N],
    taken: &[bool; N],
    from: &[Option<usize>; N],
) -> Option<(usize, usize)> {
    let mut best = (f64::INFINITY, None);
    for (i, row) in costs.iter().enumerate().filter(|(i, _)| !taken[*i]) {
        for (j, cost) in row.iter().enumerate().filter(|(j, _)| from[*j].is_none()) {
            if *cost < best.0 {
                best = (*cost, Some((i, j)));
            }
        }
    }
    best.1
}

/// The eigenvector of `a` to `value` over what is seen, of length 1: a round of inverse iteration
/// by elimination with partial pivoting.
fn shape<const N: usize>(
    a: &SMatrix<f64, N, N>,
    value: Complex<f64>,
) -> SVector<Complex<f64>, SEEN> {
    // a hair beside the eigenvalue, or there is nothing to divide by
    let shift = value + 1e-9 * (value.norm() + 1.0);
    let mut m = a.map(Complex::from);
    for i in 0..N {
        m[(i, i)] -= shift;
    }
    // no mode is orthogonal to numbers without pattern
    let mut x = SVector::<Complex<f64>, N>::from_fn(|i, _| {
        Complex::new(1.0 / (i as f64 + 1.3), 0.1 * i as f64)
    });
    for k in 0..N {
        let size = |i: &usize| m[(*i, k)].norm_sqr();
        let pivot = (k..N)
            .max_by(|i, j| size(i).total_cmp(&size(j)))
            .unwrap_or(k);
        m.swap_rows(k, pivot);
        x.swap_rows(k, pivot);
        let inverse = m[(k, k)].inv();
        for i in k + 1..N {
            let factor = m[(i, k)] * inverse;
            for j in k + 1..N {
                let above = m[(k, j)];
                m[(i, j)] -= factor * above;
            }
            let above = x[k];
            x[i] -= factor * above;
        }
    }
    for k in (0..N).rev() {
        for j in k + 1..N {
            let known = x[j];
            x[k] -= m[(k, j)] * known;
        }
        x[k] *= m[(k, k)].inv();
    }
    let seen = SVector::<Complex<f64>, SEEN>::from_fn(|i, _| x[i]);
    let size = seen.norm();
    seen.map(|v| v / size)
}

/// The modes at the end of the path `a` from `start` at `ends.0` to `ends.1`, in steps of `stride`
/// or less, halved where modes cannot be told apart.
pub(super) fn follow<const N: usize>(
    a: impl Fn(f64) -> SMatrix<f64, N, N>,
    start: &Branches<N>,
    ends: (f64, f64),
    stride: f64,
) -> Branches<N>
where
    SMatrix<f64, N, N>: Spectral<N>,
{
    let (mut at, to) = ends;
    let shortest = stride * 0.5f64.powi(HALVINGS);
    let (mut step, mut branches) = (stride, *start);
    while at != to {
        let left = (to - at).abs();
        let reaches = step >= left;
        let next = if reaches {
            to
        } else {
            at + step.copysign(to - at)
        };
        let length = step.min(left);
        if let Some(carried) = branches.carried_to(&a(next), length <= shortest) {
            (at, branches) = (next, carried);
            step = (2.0 * length).min(stride);
        } else {
            step = 0.5 * length;
        }
    }
    branches
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::Upright;
    use crate::parameters::Parameters;
    use crate::{Bicycle, Formulation};
    use std::cell::Cell;

    /// A sweep costs an eigenvalue problem a point: names are in doubt at double roots only, and
    /// not where both modes have one name.
    #[test]
    fn names_cost_nothing_where_they_are_not_in_doubt() {
        let p = Parameters::default().riderless();
        let b = Bicycle::new(&p, Formulation::Whipple);
        let system = Upright::<4>::new(&b);
        let solved = Cell::new(0);
        let a = |speed: f64| {
            solved.set(solved.get() + 1);
            system.at(speed)
        };
        let walk = |ends: (f64, f64)| {
            solved.set(0);
            let mut branches = Branches::of(&system.at(ends.0));
            branches.name_without_slip();
            let at = |i: u32| ends.0 + (ends.1 - ends.0) * f64::from(i) / 1000.0;
            for i in 0..1000 {
                branches = follow(a, &branches, (at(i), at(i + 1)), 0.2);
            }
            solved.get()
        };
        assert_eq!(walk((3.0, 13.0)), 1000);
        // weave splits at .6 m/s, where step after step is too long by half
        let across = walk((3.0, 0.0));
        assert!((1000..1030).contains(&across), "{across}");
    }
}
