//! The courses there are, and what each can be told.

use super::{Cone, Course};
use crate::quantity::{Quantity, rows};
use crate::real::Real;
use num_dual::Dual2SVec64;
use std::f64::consts::{PI, TAU};

rows! {
    /// Straight ahead.
    Straight;
    Fixed {
        length: "s" M = 24.0, in [1.0, 1000.0], "Length of the course", "paper, section 4.1: 24.0 m of asphalt";
    }
}

rows! {
    /// Cones in a row, passed alternately left and right, the first on its left.
    ///
    /// The paper gives the distance between the cones and the asphalt, 24 m by 8 m; not how many
    /// cones there were, nor the path. Here the rear contact swings as a cosine. The front contact
    /// swings √(1 + (πL/d)²) times as far, and later on its way: with cones a wheelbase apart, a
    /// rear contact furthest out at the cone would have the front wheel pass it on the wrong side.
    /// So the rear contact is furthest out a [`Slalom::lead`] before the cone.
    Slalom;
    Fixed {
        cone_spacing: "d" M = 1.0, in [0.5, 50.0], "Distance between cones", "paper, section 4.1: 1 meter";
        amplitude: "A" M = 0.04, in [0.0, 5.0], "Largest offset of the rear contact from the line of cones", "assumed: at cones 1 m apart some 20° of steer; more of it turns the front wheel past the wrong side of a cone";
        wheelbase: "L" M = 1.015, in [0.5, 2.0], "Wheelbase of the bicycle whose two wheels are to clear the cones", "paper, Table 4";
        length: "s" M = 24.0, in [1.0, 1000.0], "Length of the asphalt", "paper, section 4.1: 24.0 m";
        run_in: "s_1" M = 4.0, in [0.0, 100.0], "From either end of the asphalt to the cone next to it", "assumed: two seconds at the paper's 8 km/h";
    }
}

rows! {
    /// A single smooth change to the left: the first three sections of the double lane change of
    /// ISO 3888-1 (15, 30 and 25 m long, 3.5 m aside), at a quarter of its size.
    LaneChange;
    Fixed {
        run_in: "s_1" M = 3.75, in [0.0, 100.0], "Straight before the change", "ISO 3888-1: 15 m; a quarter assumed, for a bicycle";
        transition: "s_2" M = 7.5, in [0.5, 100.0], "Length of the change", "ISO 3888-1: 30 m; a quarter assumed, for a bicycle";
        lane_offset: "y_2" M = 0.875, in [-10.0, 10.0], "Change to the left", "ISO 3888-1: 3.5 m; a quarter assumed, for a bicycle";
        run_out: "s_3" M = 6.25, in [0.0, 100.0], "Straight after the change", "ISO 3888-1: 25 m; a quarter assumed, for a bicycle";
    }
}

rows! {
    /// A circle to the left, entered from a straight by a clothoid.
    Circle;
    Fixed {
        run_in: "s_1" M = 2.0, in [0.0, 100.0], "Straight before the clothoid", "assumed";
        transition: "s_2" M = 4.0, in [0.1, 100.0], "Length of the clothoid", "assumed: 1.8 s at the paper's 8 km/h, time to lean over";
        radius: "R" M = 3.5, in [0.5, 1000.0], "Radius", "assumed: a circle that fits into the 8.0 m width of the paper's asphalt";
        rounds: "n" ONE = 1.0, in [0.0, 100.0], "How many times round", "assumed";
    }
}

/// A course by name and what it was told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Layout {
    /// Straight ahead.
    Straight(Straight),
    /// Around cones in a row.
    Slalom(Slalom),
    /// To the left by a lane.
    LaneChange(LaneChange),
    /// Round and round to the left.
    Circle(Circle),
}

/// One expression for whichever layout it is.
macro_rules! each {
    ($layout:expr, $rows:ident => $value:expr) => {
        match $layout {
            Layout::Straight($rows) => $value,
            Layout::Slalom($rows) => $value,
            Layout::LaneChange($rows) => $value,
            Layout::Circle($rows) => $value,
        }
    };
}

impl Layout {
    /// Every layout at its nominal values.
    pub fn all() -> [Self; 4] {
        [
            Self::Straight(Straight::default()),
            Self::Slalom(Slalom::default()),
            Self::LaneChange(LaneChange::default()),
            Self::Circle(Circle::default()),
        ]
    }

    /// The name on the command line.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Straight(_) => "straight",
            Self::Slalom(_) => "slalom",
            Self::LaneChange(_) => "lane-change",
            Self::Circle(_) => "circle",
        }
    }

    /// What it can be told.
    pub fn table(&self) -> &'static [Quantity] {
        match self {
            Self::Straight(_) => Straight::TABLE,
            Self::Slalom(_) => Slalom::TABLE,
            Self::LaneChange(_) => LaneChange::TABLE,
            Self::Circle(_) => Circle::TABLE,
        }
    }

    /// Tells row `index` of the table.
    pub fn set(&mut self, index: usize, value: f64) {
        each!(self, rows => rows.set(index, value));
    }

    /// The course; of meaning where each row admits its value.
    pub fn course(&self) -> Course {
        each!(self, rows => rows.course())
    }
}

impl Straight {
    /// The course.
    pub fn course(&self) -> Course {
        Course::of_curvature(self.length, |_| 0.0)
    }
}

impl Slalom {
    /// How far before a cone the rear contact is furthest out [m], so that both wheels clear the
    /// cone by the same distance; 0 where the front wheel clears it by more without.
    ///
    /// For small slopes and k = π/d the rear contact at y = A cos k(x + lead − x_n) has the front
    /// contact at y + L y' = A √(1 + k²L²) cos(k(x + lead − x_n) − (kL − atan kL)), x being the
    /// front contact's own place. So ζ = k·lead follows from
    /// cos ζ = √(1 + k²L²) cos(kL − atan kL − ζ).
    pub fn lead(&self) -> f64 {
        let k = PI / self.cone_spacing;
        let kl = k * self.wheelbase;
        let (swing, lag) = ((1.0 + kl * kl).sqrt(), kl - Real::atan(kl));
        let (sin, cos) = Real::sin_cos(lag);
        if swing * cos >= 1.0 {
            return 0.0;
        }
        Real::atan((1.0 - swing * cos) / (swing * sin)) / k
    }

    /// The course. The swing fades in over one spacing before the first cone and out over one
    /// after the last, or over the room there is.
    pub fn course(&self) -> Course {
        let Self {
            cone_spacing,
            amplitude,
            length,
            run_in,
            ..
        } = *self;
        let row = length - 2.0 * run_in;
        // whole spaces, whatever the rounding; none where the run-ins leave no room for a cone
        let spaces = (row / cone_spacing + 1e-9).floor();
        let cone = |n| Cone {
            x: run_in + n as f64 * cone_spacing,
            y: 0.0,
            side: if n % 2 == 0 { 1.0 } else { -1.0 },
        };
        let cones: Vec<_> = (0..=spaces as i64).map(cone).collect();
        let swing = if cones.is_empty() { 0.0 } else { amplitude };
        let first = run_in - self.lead();
        let last = first + spaces * cone_spacing;
        let room = |length: f64| cone_spacing.min(length).max(f64::MIN_POSITIVE);
        let (before, after) = (room(first), room(length - last));
        Course::of_profile(length, cones, |x| {
            let fade_in = smooth((x - (first - before)) / before);
            let fade_out = smooth((-x + (last + after)) / after);
            let phase = (x - first) * (PI / cone_spacing);
            fade_in * fade_out * phase.cos() * swing
        })
    }
}

impl LaneChange {
    /// The course.
    pub fn course(&self) -> Course {
        let length = self.run_in + self.transition + self.run_out;
        Course::of_profile(length, Vec::new(), |x| {
            smooth((x - self.run_in) / self.transition) * self.lane_offset
        })
    }
}

impl Circle {
    /// The course.
    pub fn course(&self) -> Course {
        let round = TAU * self.radius * self.rounds;
        Course::of_curvature(self.run_in + self.transition + round, |s| {
            ((s - self.run_in) / self.transition).clamp(0.0, 1.0) / self.radius
        })
    }
}

/// From 0 to 1 over t from 0 to 1, without a jump in slope or curvature: 10 t³ − 15 t⁴ + 6 t⁵.
fn smooth(t: Dual2SVec64<1>) -> Dual2SVec64<1> {
    if t.re <= 0.0 {
        Dual2SVec64::from(0.0)
    } else if t.re >= 1.0 {
        Dual2SVec64::from(1.0)
    } else {
        t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
    }
}
