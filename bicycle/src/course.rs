//! Courses to ride: geometry on the ground, and where a point lies with respect to it.
//!
//! A course starts at the origin along x and is followed by the rear contact point, as every place
//! in this crate is the rear contact's. It is kept as stations along its arc length, so that a
//! circle is a course as well as a path y(x) is one.

mod layout;

pub use layout::{Circle, LaneChange, Layout, Slalom, Straight};

use crate::quantity::{self, Quantity, Variability};
use crate::real::Real;
use crate::simulate::rk4;
use crate::state::Path;
use num_dual::Dual2SVec64;

/// Arc length between stations [m]: with curvatures up to 2 1/m the cubic between two of them is
/// off by less than a micrometre.
const SPACING: f64 = 0.01;

/// What a ride along a course shows besides the outputs of the bicycle.
pub const LATERAL_OFFSET: Quantity = Quantity {
    name: "lateral_offset",
    symbol: "e",
    unit: quantity::M,
    nominal: 0.0,
    min: f64::NEG_INFINITY,
    max: f64::INFINITY,
    measured: None,
    variability: Variability::Continuous,
    what: "Distance of the rear contact from the course, left positive",
    source: "course",
};

/// A point of a course.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Forward of the start [m].
    pub x: f64,
    /// Left of the start [m].
    pub y: f64,
    /// Direction of the course, left positive [rad]; it goes on counting beyond a turn.
    pub heading: f64,
    /// dψ/ds, left positive [1/m].
    pub curvature: f64,
}

/// A cone at (`x`, `y`) [m] and the side on which it is to be passed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Forward of the start [m].
    pub x: f64,
    /// Left of the start [m].
    pub y: f64,
    /// +1: the bicycle passes left of the cone; −1: right of it.
    pub side: f64,
}

/// Where a point lies with respect to a course.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Arc length of the nearest point of the course [m].
    pub arc_length: f64,
    /// Distance from it, positive left of the course [m].
    pub offset: f64,
    /// Direction of the course there [rad].
    pub heading: f64,
}

/// A line to follow, with its cones.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// Every [`SPACING`] of arc length from the start on; at least two.
    stations: Vec<Station>,
    cones: Vec<Cone>,
    length: f64,
}

impl Course {
    /// The course y(x) over x from 0 to `length` [m]; `profile` gives y [m] and is differentiated
    /// by dual numbers.
    fn of_profile(
        length: f64,
        cones: Vec<Cone>,
        profile: impl Fn(Dual2SVec64<1>) -> Dual2SVec64<1>,
    ) -> Self {
        let at = |x: f64| {
            let one = nalgebra::Const::<1>;
            let mut dual = Dual2SVec64::<1>::from(x);
            dual.v1 = num_dual::Derivative::derivative_generic(one, one, 0);
            let y = profile(dual);
            let slope = y.v1.unwrap_generic(one, one)[0];
            let bend = y.v2.unwrap_generic(one, one)[0];
            let stretch = (1.0 + slope * slope).sqrt();
            let station = Station {
                x,
                y: y.re,
                heading: Real::atan(slope),
                curvature: bend / (stretch * stretch * stretch),
            };
            (station, 1.0 / stretch)
        };
        let mut stations = vec![at(0.0).0];
        let mut path = Path::ZERO;
        while path.x < length || stations.len() < 2 {
            path = rk4(path, SPACING, |_, path| Path {
                x: at(path.x).1,
                ..Path::ZERO
            });
            stations.push(at(path.x).0);
        }
        // the last station lies beyond the end by a part of a spacing
        let last = stations[stations.len() - 1];
        let beyond = (last.x - length) / at(last.x).1;
        Self {
            length: (stations.len() - 1) as f64 * SPACING - beyond,
            stations,
            cones,
        }
    }

    /// The course of given `curvature` [1/m] over an arc length from 0 to `length` [m].
    fn of_curvature(length: f64, curvature: impl Fn(f64) -> f64) -> Self {
        let station = |s: f64, path: &Path| Station {
            x: path.x,
            y: path.y,
            heading: path.heading,
            curvature: curvature(s),
        };
        let mut path = Path::ZERO;
        let mut stations = vec![station(0.0, &path)];
        let spaces = ((length / SPACING).ceil() as usize).max(1);
        for n in 0..spaces {
            let s = n as f64 * SPACING;
            path = rk4(path, SPACING, |fraction, path| {
                let (sin, cos) = Real::sin_cos(path.heading);
                Path {
                    heading: curvature(s + fraction * SPACING),
                    x: cos,
                    y: sin,
                }
            });
            stations.push(station(s + SPACING, &path));
        }
        Self {
            stations,
            cones: Vec::new(),
            length,
        }
    }

    /// Arc length from the start to the end [m].
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The cones, in the order in which they are passed.
    pub fn cones(&self) -> &[Cone] {
        &self.cones
    }

    /// The point at arc length `s` [m]. Before the start and beyond the end the course goes on with
    /// the curvature it has there.
    pub fn at(&self, s: f64) -> Station {
        let last = self.stations.len() - 1;
        let position = s / SPACING;
        if position < 0.0 {
            return self.stations[0].onward(s);
        }
        if position >= last as f64 {
            return self.stations[last].onward(s - last as f64 * SPACING);
        }
        let n = position as usize;
        between(
            &self.stations[n],
            &self.stations[n + 1],
            position - n as f64,
        )
    }

    /// Curvature at arc length `s` [1/m], as [`Self::at`] has it.
    pub fn curvature(&self, s: f64) -> f64 {
        let last = self.stations.len() - 1;
        let position = (s / SPACING).clamp(0.0, last as f64);
        let n = (position as usize).min(last - 1);
        let t = position - n as f64;
        let [a, b] = [n, n + 1].map(|i| self.stations[i].curvature);
        a + t * (b - a)
    }

    /// Where (`x`, `y`) [m] lies with respect to the course, looked for around arc length `near`
    /// [m]: on a circle ridden round several times the nearest point is not the only one.
    pub fn locate(&self, x: f64, y: f64, near: f64) -> Place {
        let mut s = near;
        let mut station = self.at(s);
        for _ in 0..ROUNDS {
            let (along, offset) = station.seen(x, y);
            // Newton on "the point lies abeam"; inside of half the radius of curvature, where the
            // course ahead and behind comes as near, the step is held to the distance itself
            let step = along / (1.0 - station.curvature * offset).max(0.5);
            s += step;
            station = self.at(s);
            if step.abs() < 1e-12 * (1.0 + s.abs()) {
                break;
            }
        }
        Place {
            arc_length: s,
            offset: station.seen(x, y).1,
            heading: station.heading,
        }
    }

    /// The course seen in a mirror: left for right.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let station = |s: &Station| Station {
            x: s.x,
            y: -s.y,
            heading: -s.heading,
            curvature: -s.curvature,
        };
        let cone = |c: &Cone| Cone {
            x: c.x,
            y: -c.y,
            side: -c.side,
        };
        Self {
            stations: self.stations.iter().map(station).collect(),
            cones: self.cones.iter().map(cone).collect(),
            length: self.length,
        }
    }
}

/// Most rounds of Newton's method in [`Course::locate`]; from one sample to the next it takes three.
const ROUNDS: usize = 20;

impl Station {
    /// The point `s` [m] further on at the same curvature.
    fn onward(&self, s: f64) -> Self {
        let half = 0.5 * self.curvature * s;
        let chord = if half == 0.0 {
            s
        } else {
            s * Real::sin(half) / half
        };
        let (sin, cos) = Real::sin_cos(self.heading + half);
        Self {
            x: self.x + chord * cos,
            y: self.y + chord * sin,
            heading: self.heading + 2.0 * half,
            curvature: self.curvature,
        }
    }

    /// How far (`x`, `y`) lies ahead of and left of the station [m].
    fn seen(&self, x: f64, y: f64) -> (f64, f64) {
        let (sin, cos) = Real::sin_cos(self.heading);
        let (dx, dy) = (x - self.x, y - self.y);
        (dx * cos + dy * sin, dy * cos - dx * sin)
    }
}

/// The point a part `t` of the way from station `a` to the next one, `b`: cubics through both with
/// their directions, straight lines in the curvature.
fn between(a: &Station, b: &Station, t: f64) -> Station {
    let cubic = |p: [f64; 2], slope: [f64; 2]| {
        let change = p[1] - p[0];
        let [m, n] = slope.map(|s| s * SPACING - change);
        p[0] + t * (change + (1.0 - t) * ((1.0 - t) * m - t * n))
    };
    let (sin_a, cos_a) = Real::sin_cos(a.heading);
    let (sin_b, cos_b) = Real::sin_cos(b.heading);
    Station {
        x: cubic([a.x, b.x], [cos_a, cos_b]),
        y: cubic([a.y, b.y], [sin_a, sin_b]),
        heading: cubic([a.heading, b.heading], [a.curvature, b.curvature]),
        curvature: a.curvature + t * (b.curvature - a.curvature),
    }
}
