//! Under which conditions explicit steps make sense, and how to know it without much work.

use crate::dynamics::{Bicycle, Formulation};
use crate::linear;
use crate::mass::Body;
use crate::state::{Input, State};
use std::fmt;

/// Why a simulation was not started, or a change not taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Refusal {
    /// The internal step is too long for explicit steps of these parameters.
    StepTooLong {
        /// The row `internal_step` [s].
        step: f64,
        /// The longest stable step [s].
        limit: f64,
    },
    /// A wheel is lifted: the centre of mass lies outside the wheelbase.
    Lifted {
        /// Front or rear.
        wheel: &'static str,
        /// Its normal load [N].
        load: f64,
    },
    /// The formulation does not know this speed: none runs backwards, and only one without slip
    /// stands.
    Speed {
        /// The speed [m/s].
        speed: f64,
        /// The formulation.
        formulation: Formulation,
    },
    /// A body has a mass or inertia that no matter has.
    Body {
        /// Which.
        name: &'static str,
        /// What it would be.
        body: Body,
    },
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::StepTooLong { step, limit } => write!(
                f,
                "internal_step: expected less than {limit:.3e} s, the stability limit of these \
                 parameters at this speed, found {step:.3e} s"
            ),
            Self::Lifted { wheel, load } => write!(
                f,
                "expected a {wheel} wheel on the ground, found a {wheel} load of {load:.1} N"
            ),
            Self::Speed { speed, formulation } => {
                let expected = match formulation {
                    Formulation::Whipple => "0 m/s or more",
                    _ => "above 0 m/s",
                };
                let name = formulation.name();
                write!(
                    f,
                    "speed: expected {expected} with {name}, found {speed} m/s"
                )
            }
            Self::Body { name, body } => write!(
                f,
                "expected bodies of positive mass and positive definite inertia, found {name} with \
                 {:.4} kg and {:.4} (xx), {:.4} (zz), {:.4} (xz) kg.m2 about its centre of mass",
                body.mass, body.roll_inertia, body.yaw_inertia, body.cross_inertia
            ),
        }
    }
}

impl std::error::Error for Refusal {}

/// Refuses what no equation of motion says anything about: a speed that the formulation does not
/// know [m/s], a lifted wheel, a body that no matter makes.
pub fn check(b: &Bicycle, speed: f64) -> Result<(), Refusal> {
    check_speed(b, speed)?;
    for (wheel, load) in [("front", b.front_load), ("rear", b.rear_wheel_load)] {
        if load <= 0.0 {
            return Err(Refusal::Lifted { wheel, load });
        }
    }
    let front = b.p.front_assembly();
    let bodies = [
        ("bicycle, rider and load", b.lumps.body()),
        ("the front assembly", front),
        (
            "the rear frame with rider and load",
            b.lumps.without(&front),
        ),
    ];
    // only the four-body bicycle has a front assembly
    let known = if b.four_bodies.is_some() { 3 } else { 1 };
    let impossible = bodies[..known].iter().find(|(_, body)| !body.is_possible());
    match impossible {
        Some(&(name, body)) => Err(Refusal::Body { name, body }),
        None => Ok(()),
    }
}

fn check_speed(b: &Bicycle, speed: f64) -> Result<(), Refusal> {
    let stands = speed == 0.0 && b.formulation == Formulation::Whipple;
    if speed > 0.0 || stands {
        return Ok(());
    }
    let formulation = b.formulation;
    Err(Refusal::Speed { speed, formulation })
}

/// Every z = h λ with Re z ≤ 0 and |z| up to this lies in the stability region of [`super::rk4`];
/// its border comes nearest to the origin, 2.616, at 123° (2.785 on the real, 2.828 on the
/// imaginary axis).
const STABLE_RADIUS: f64 = 2.6;

/// Longest step [s] of [`super::rk4`] at `speed` [m/s] with which every decaying mode of the
/// bicycle upright decays, smoothed Coulomb friction (a jump, width 0, has no slope) and rider law
/// included. A bound a few per cent short of the limit, 0 where there is none.
pub fn stability_limit(b: &Bicycle, speed: f64) -> f64 {
    #[cfg(test)]
    tests::COMPUTED.with(|count| count.set(count.get() + 1));
    let input = Input {
        speed,
        ..Input::default()
    };
    let (a, _) = linear::state_equations(b, &State::ZERO, &input);
    STABLE_RADIUS / linear::spectral_bound(&a)
}

/// Ratio by which the known speeds are widened, and up to which [`DIP`] was measured.
const WIDENING: f64 = 1.25;

/// Below this speed [m/s] nothing of a bicycle that can stand depends on how slowly it goes.
const CRAWL: f64 = 0.1;

/// Between two speeds a factor [`WIDENING`] apart the stability limit is no shorter than the
/// shorter one of theirs, but for this share of it.
///
/// The fastest pole is, at low speed, that of the yaw rate, which slows down as 1/V, and at high
/// speed one that quickens with V: the limit rises, then falls, and over an interval is shortest at
/// an end. Two things bend this. Where poles come near one another they push each other away or
/// make a pair, and the fastest may pass a maximum there: dips of up to 1.3 % in 40 000 draws over
/// the tables' ranges, no dip at all in 99.6 % of them. And the limit is computed from a bound that
/// lies up to 8 % above the fastest pole: with it, dips of up to 1.5 % in 60 000 draws.
const DIP: f64 = 0.1;

/// Speeds [m/s] at which a bicycle's internal step is known to be stable: an interval whose ends
/// were computed, as was a speed every factor [`WIDENING`] or less in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StableSpeeds {
    slowest: f64,
    fastest: f64,
}

impl StableSpeeds {
    /// Nothing known yet.
    pub const NONE: Self = Self {
        slowest: f64::INFINITY,
        fastest: f64::NEG_INFINITY,
    };

    /// What is known of a bicycle at its first speed: the conditions under which explicit steps
    /// make sense.
    pub fn around(b: &Bicycle, speed: f64) -> Result<Self, Refusal> {
        check(b, speed)?;
        let mut stable = Self::NONE;
        stable.admit(b, speed)?;
        Ok(stable)
    }

    /// Refuses a speed at which the internal step of `b` is too long. The answer is that of the
    /// limit at that speed, whatever was asked before: an end is kept only where the limit leaves
    /// [`DIP`] in hand.
    pub fn admit(&mut self, b: &Bicycle, speed: f64) -> Result<(), Refusal> {
        if self.holds(speed) {
            return Ok(());
        }
        check_speed(b, speed)?;
        let (step, limit) = (b.p.internal_step, stability_limit(b, speed));
        if step > limit {
            return Err(Refusal::StepTooLong { step, limit });
        }
        if is_ample(step, limit) {
            self.extend(b, speed);
        }
        Ok(())
    }

    /// Refuses a course from one speed to another where the internal step of `b` is too long at
    /// an end, or at a speed between them every factor [`WIDENING`] or less apart.
    pub fn admit_between(&mut self, b: &Bicycle, from: f64, to: f64) -> Result<(), Refusal> {
        let rises = from < to;
        let mut speed = from;
        loop {
            self.admit(b, speed)?;
            if speed == to || self.holds(speed) && self.holds(to) {
                return Ok(());
            }
            let next = if rises {
                (speed * WIDENING).max(CRAWL)
            } else {
                speed / WIDENING
            };
            let is_short_of = if rises {
                next < to
            } else {
                next > to.max(CRAWL)
            };
            speed = if is_short_of { next } else { to };
        }
    }

    fn holds(&self, speed: f64) -> bool {
        (self.slowest..=self.fastest).contains(&speed)
    }

    /// Takes in `speed`. A speed near the known ones hints at more to come: then what lies around
    /// it is taken in as well.
    fn extend(&mut self, b: &Bicycle, speed: f64) {
        if !(self.slowest / WIDENING..=self.fastest * WIDENING).contains(&speed) {
            (self.slowest, self.fastest) = (speed, speed);
            return;
        }
        self.take(speed);
        for beyond in [speed / WIDENING, speed * WIDENING] {
            if !self.holds(beyond) && is_ample(b.p.internal_step, stability_limit(b, beyond)) {
                self.take(beyond);
            }
        }
    }

    fn take(&mut self, speed: f64) {
        self.slowest = self.slowest.min(speed);
        self.fastest = self.fastest.max(speed);
    }
}

fn is_ample(step: f64, limit: f64) -> bool {
    step <= limit * (1.0 - DIP)
}

#[cfg(test)]
mod tests;
