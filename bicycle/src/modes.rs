//! The modes of a bicycle that rides upright, by name, at any speed.
//!
//! Names are given once, at a speed where they are not in doubt, and carried from there to every
//! other speed by eigenvector and continuity of the eigenvalue: not by sorting, and not from one
//! point of a sweep to the next. So neither the step of a sweep nor its direction nor its ends
//! change a name.
//!
//! 1. **The four-body bicycle without slip and without rider law** has, at the first of some
//!    speeds (8 m/s, then others from 1 to 15 m/s) with exactly one complex pair, the pair `weave`
//!    and two real modes, of which the faster decaying is `castering`, the other `capsize`
//!    (Meijaard et al. 2007, section 5). Where no speed has that, the two of largest real part at
//!    3 m/s are `weave`, the next `capsize`, the last `castering`. The names are carried to 3 m/s,
//!    where tyres are stiff.
//! 2. **Slipping tyres and the paper's formulations**: the four modes most like those of 1 at
//!    3 m/s, by eigenvalue and by eigenvector over roll, steer and their rates, have their
//!    names. Of the rest, what tyres add (the yaw rate of the paper's formulations among it),
//!    the complex pair with the largest steer angle against its roll angle is `wobble`, all
//!    others `tyre`.
//! 3. **A rider law** is switched on gradually at 3 m/s, and the names are carried along.
//!
//! 4. **Over a row of the parameter table** names are carried from the bicycle's own value of that
//!    row, at each speed.
//!
//! A pair that meets the real axis and splits keeps its name for both. Two real modes of
//! different names that join become a pair with the name of the one that grew more, and part with
//! their own names; where `castering` joins a mode of the tyres the pair is the field's `wobble`, and
//! where `capsize` joins one of a split weave it is `weave`.
//!
//! The limits: names are those of a hands-free bicycle at moderate speed. Far from that, with
//! large gains or friction, or with equations unlike the four-body bicycle's (`printed`,
//! `minimal`), they tell which mode this one comes from, not what it looks like. Around a double
//! root names depend on the way: a mode that speed leads to may have another name than one that a
//! parameter leads to.

mod track;

use crate::dynamics::{Bicycle, Formulation};
use crate::linear::{Spectral, Upright};
use nalgebra::{Complex, SMatrix};
use track::{Branches, follow};

/// A mode by the name bicycle dynamics has for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Mode {
    /// Sways of roll and steer, the steer lagging: the unstable pair of slow bicycles.
    Weave,
    /// Slow falling to a side with little steering.
    Capsize,
    /// The steering that swings back behind its axis.
    Castering,
    /// Fast swings of the steering on a tyre that yields.
    Wobble,
    /// What else tyres add: slip and relaxation of their forces.
    Tyre,
}

impl Mode {
    /// The name in files and figures.
    pub fn name(self) -> &'static str {
        match self {
            Self::Weave => "weave",
            Self::Capsize => "capsize",
            Self::Castering => "castering",
            Self::Wobble => "wobble",
            Self::Tyre => "tyre",
        }
    }

    /// Every mode, in the order of [`over_speeds`].
    pub const ALL: [Self; 5] = [
        Self::Weave,
        Self::Capsize,
        Self::Castering,
        Self::Wobble,
        Self::Tyre,
    ];
}

/// An eigenvalue and its name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Root {
    /// Eigenvalue [1/s]: growth and angular frequency.
    pub value: Complex<f64>,
    /// Which mode it belongs to.
    pub mode: Mode,
}

/// Speeds [m/s] at which names are looked for, in this order. Riding speed comes first: there
/// weave swings and capsize creeps whatever the trail, where slow bicycles fall in other ways.
const CLEAR: [f64; 11] = [8.0, 10.0, 6.0, 5.0, 4.0, 12.0, 15.0, 3.0, 2.0, 1.5, 1.0];
/// Speed [m/s] at which formulations are compared: slow enough that tyres are stiff, fast enough
/// that weave mostly swings.
const COMPARED: f64 = 3.0;
/// Names are carried in steps no longer than this [m/s].
const STRIDE: f64 = 0.2;

/// The eigenvalues of `b` upright at each of `speeds` [m/s], with their names: by mode, then by
/// growth, a pair's upper member first. Jumps (Coulomb friction, sign θ) are left out; the rider
/// law is in the loop as far as its gains are not zero. NaN where there is no linear system.
pub fn over_speeds(b: &Bicycle, speeds: &[f64]) -> Vec<Vec<Root>> {
    match b.order() {
        4 => Named::<4>::new(b).over(speeds),
        5 => Named::<5>::new(b).over(speeds),
        6 => Named::<6>::new(b).over(speeds),
        _ => Named::<8>::new(b).over(speeds),
    }
}

/// The same of each of `values` of something that changes the bicycle, `b` being the bicycle at a
/// value: names are carried from `own`, the value that the bicycle has itself. Where the number of
/// states changes on the way they are given anew.
pub fn over_values(
    b: &impl Fn(f64) -> Bicycle,
    own: f64,
    values: &[f64],
    speeds: &[f64],
) -> Vec<Vec<Vec<Root>>> {
    match b(own).order() {
        4 => Named::<4>::over_values(b, own, values, speeds),
        5 => Named::<5>::over_values(b, own, values, speeds),
        6 => Named::<6>::over_values(b, own, values, speeds),
        _ => Named::<8>::over_values(b, own, values, speeds),
    }
}

/// The speeds between `slowest` and `fastest` [m/s] at which every mode of `b` decays: from, to,
/// to round-off, but for stretches shorter than .2 m/s.
pub fn stable_speeds(b: &Bicycle, slowest: f64, fastest: f64) -> Vec<[f64; 2]> {
    match b.order() {
        4 => stable(&Upright::<4>::new(b), slowest, fastest),
        5 => stable(&Upright::<5>::new(b), slowest, fastest),
        6 => stable(&Upright::<6>::new(b), slowest, fastest),
        _ => stable(&Upright::<8>::new(b), slowest, fastest),
    }
}

fn stable<const N: usize>(system: &Upright<N>, slowest: f64, fastest: f64) -> Vec<[f64; 2]>
where
    SMatrix<f64, N, N>: Spectral<N>,
{
    let decays = |speed: f64| {
        let spectrum = system.at(speed).spectrum();
        spectrum.is_some_and(|values| values.iter().all(|value| value.re < 0.0))
    };
    let mut found: Vec<[f64; 2]> = Vec::new();
    let grid = grid(slowest, fastest);
    let mut decayed = false;
    for (i, &speed) in grid.iter().enumerate() {
        let here = decays(speed);
        if here != decayed {
            let edge = if i == 0 {
                speed
            } else {
                bisect(grid[i - 1], speed, |v| decays(v) == decayed)
            };
            if here {
                found.push([edge, fastest]);
            } else if let Some(last) = found.last_mut() {
                last[1] = edge;
            }
        }
        decayed = here;
    }
    found
}

/// Speeds from `slowest` to `fastest`, both among them, a stride or less apart.
fn grid(slowest: f64, fastest: f64) -> Vec<f64> {
    let count = ((fastest - slowest) / STRIDE).ceil().max(1.0);
    let inner = (1..count as usize).map(|i| slowest + (fastest - slowest) * i as f64 / count);
    [slowest]
        .into_iter()
        .chain(inner)
        .chain([fastest])
        .collect()
}

/// Where `holds` ends between `low`, where it does, and `high`, where it does not.
fn bisect(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
}

/// Speeds [m/s] at which a mode changes between growth and decay.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Crossings {
    /// Lowest speed from which weave, unstable below, decays.
    pub weave: Option<f64>,
    /// Lowest speed from which capsize, stable below, grows.
    pub capsize: Option<f64>,
}

/// The weave and the capsize speed of `b` between `slowest` and `fastest` [m/s], to round-off.
/// Where there are several the lowest; none where the mode does not change in that direction.
pub fn crossings(b: &Bicycle, slowest: f64, fastest: f64) -> Crossings {
    match b.order() {
        4 => Named::<4>::new(b).crossings(slowest, fastest),
        5 => Named::<5>::new(b).crossings(slowest, fastest),
        6 => Named::<6>::new(b).crossings(slowest, fastest),
        _ => Named::<8>::new(b).crossings(slowest, fastest),
    }
}

/// A bicycle whose modes have names, at [`COMPARED`].
struct Named<const N: usize> {
    system: Upright<N>,
    branches: Branches<N>,
}

impl<const N: usize> Named<N>
where
    SMatrix<f64, N, N>: Spectral<N>,
{
    fn new(b: &Bicycle) -> Self {
        let idle = b.p.riderless();
        let reference = reference(&Bicycle::new(&idle, Formulation::Whipple));
        let system = Upright::new(b);
        let free = Upright::<N>::new(&Bicycle::new(&idle, b.formulation)).at(COMPARED);
        // the rider's torque is linear in its gains
        let law = system.at(COMPARED) - free;
        let mut branches = Branches::of(&free);
        branches.name_after(&reference);
        if law != SMatrix::<f64, N, N>::zeros() {
            branches = follow(|gain| free + law * gain, &branches, (0.0, 1.0), 0.05);
        }
        Self { system, branches }
    }

    fn onward(&self, from: (f64, &Branches<N>), to: f64) -> Branches<N> {
        follow(|speed| self.system.at(speed), from.1, (from.0, to), STRIDE)
    }

    /// The modes at each of `speeds`, in their order.
    fn at(&self, speeds: &[f64]) -> Vec<Branches<N>> {
        let mut order: Vec<usize> = (0..speeds.len()).collect();
        order.sort_by(|i, j| speeds[*i].total_cmp(&speeds[*j]));
        let (below, above) = order.split_at(order.partition_point(|i| speeds[*i] < COMPARED));
        let mut found = vec![self.branches; speeds.len()];
        let mut walk = |way: &mut dyn Iterator<Item = &usize>| {
            let mut at = (COMPARED, self.branches);
            for i in way {
                at = (speeds[*i], self.onward((at.0, &at.1), speeds[*i]));
                found[*i] = at.1;
            }
        };
        walk(&mut below.iter().rev());
        walk(&mut above.iter());
        found
    }

    fn over(&self, speeds: &[f64]) -> Vec<Vec<Root>> {
        self.at(speeds).iter().map(Branches::roots).collect()
    }

    fn over_values(
        b: &impl Fn(f64) -> Bicycle,
        own: f64,
        values: &[f64],
        speeds: &[f64],
    ) -> Vec<Vec<Vec<Root>>> {
        let (low, high) = values
            .iter()
            .fold((own, own), |(low, high), v| (low.min(*v), high.max(*v)));
        let stride = (high - low) / 16.0;
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|i, j| values[*i].total_cmp(&values[*j]));
        let (below, above) = order.split_at(order.partition_point(|i| values[*i] < own));
        let start = Self::new(&b(own)).at(speeds);
        let mut found = vec![Vec::new(); values.len()];
        let mut walk = |way: &mut dyn Iterator<Item = &usize>| {
            let (mut at, mut branches) = (own, start.clone());
            for &i in way {
                let bicycle = b(values[i]);
                if bicycle.order() != N {
                    found[i] = over_speeds(&bicycle, speeds);
                    continue;
                }
                for (branch, &speed) in branches.iter_mut().zip(speeds) {
                    let system = |value| Upright::<N>::new(&b(value)).at(speed);
                    *branch = follow(system, branch, (at, values[i]), stride);
                }
                at = values[i];
                found[i] = branches.iter().map(Branches::roots).collect();
            }
        };
        walk(&mut below.iter().rev());
        walk(&mut above.iter());
        found
    }

    fn crossings(&self, slowest: f64, fastest: f64) -> Crossings {
        let speeds = grid(slowest, fastest);
        let found = self.at(&speeds);
        let first = |mode: Mode, sign: f64| {
            let growths: Vec<f64> = found.iter().map(|b| sign * b.growth(mode)).collect();
            let i = growths.windows(2).position(|g| g[0] > 0.0 && g[1] <= 0.0)?;
            Some(self.root(mode, (speeds[i], &found[i]), speeds[i + 1]))
        };
        Crossings {
            weave: first(Mode::Weave, 1.0),
            capsize: first(Mode::Capsize, -1.0),
        }
    }

    /// Where the growth of `mode` changes sign between two speeds. Bisection: some fifty small
    /// eigenvalue problems, and nothing to go wrong at the kink where a pair splits.
    fn root(&self, mode: Mode, from: (f64, &Branches<N>), to: f64) -> f64 {
        let grows = from.1.growth(mode) > 0.0;
        bisect(from.0, to, |speed| {
            (self.onward(from, speed).growth(mode) > 0.0) == grows
        })
    }
}

/// The modes of the bicycle without slip and rider at [`COMPARED`].
fn reference(whipple: &Bicycle) -> Branches<4> {
    let system = Upright::<4>::new(whipple);
    let at = |speed: f64| (speed, Branches::of(&system.at(speed)));
    let (speed, mut branches) = CLEAR
        .into_iter()
        .map(at)
        .find(|(_, branches)| branches.pairs() == 1)
        .unwrap_or_else(|| at(COMPARED));
    branches.name_without_slip();
    follow(|v| system.at(v), &branches, (speed, COMPARED), STRIDE)
}
