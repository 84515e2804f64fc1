//! The two laws that find misprints without a human, and the misprints they find.
//!
//! Dimension law: written in other units of mass, length and time, every derivative is the same
//! quantity. Mirror law: left and right are alike. The units change by powers of two and a mirror
//! flips signs, so neither rounds: both laws hold to the last bit or not at all.

use crate::draw;
use bicycle::dynamics::{derivative, output};
use bicycle::{Bicycle, Formulation, Input, Output, Parameters, Path, Quantity, State, Unit};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use std::collections::BTreeSet;

/// Exponents of two by which kilogram, metre and second are rescaled.
type Exponents = [i32; 3];

fn factor(unit: Unit, [kg, m, s]: Exponents) -> f64 {
    let exponent = kg * i32::from(unit.kg) + m * i32::from(unit.m) + s * i32::from(unit.s);
    2f64.powi(exponent)
}

fn rescaled<const N: usize>(table: &[Quantity], values: [f64; N], by: Exponents) -> [f64; N] {
    std::array::from_fn(|i| values[i] * factor(table[i].unit, by))
}

/// A bicycle in motion.
#[derive(Debug, Clone, Copy)]
struct Motion {
    p: Parameters,
    x: State,
    u: Input,
}

impl Motion {
    /// The same in other units.
    fn rescaled(&self, by: Exponents) -> Self {
        Self {
            p: Parameters::from_array(rescaled(Parameters::TABLE, self.p.to_array(), by)),
            x: State::from_array(rescaled(State::TABLE, self.x.to_array(), by)),
            u: Input::from_array(rescaled(Input::TABLE, self.u.to_array(), by)),
        }
    }

    /// The same seen in a mirror: only the speed stays.
    fn mirrored(&self) -> Self {
        Self {
            p: self.p,
            x: self.x.map(|v: f64| -v),
            u: Input {
                speed: self.u.speed,
                ..self.u.map(|v: f64| -v)
            },
        }
    }

    fn derivative(&self, formulation: Formulation) -> [f64; State::LEN] {
        derivative(&Bicycle::new(&self.p, formulation), &self.x, &self.u).to_array()
    }

    fn output(&self, formulation: Formulation) -> [f64; Output::LEN] {
        let b = Bicycle::new(&self.p, formulation);
        output(&b, &self.x, &Path::default(), &self.u).to_array()
    }

    /// What the parameters or inputs called `switches` contribute to the derivative, every other
    /// one of [`SWITCHES`] being off.
    fn share(&self, switches: &[&str], formulation: Formulation) -> [f64; State::LEN] {
        let others: Vec<&str> = SWITCHES
            .into_iter()
            .filter(|s| !switches.contains(s))
            .collect();
        let (with, without) = (
            self.without(&others).derivative(formulation),
            self.without(&SWITCHES).derivative(formulation),
        );
        std::array::from_fn(|i| with[i] - without[i])
    }

    fn without(&self, switches: &[&str]) -> Self {
        let mut off = *self;
        for name in switches {
            match Parameters::index(name) {
                Some(row) => off.p.set(row, 0.0),
                None => off.u.set(Input::index(name).expect("a row"), 0.0),
            }
        }
        off
    }
}

fn motion() -> impl Strategy<Value = Motion> {
    (draw::parameters(), draw::state(), draw::input()).prop_map(|(p, x, u)| Motion { p, x, u })
}

fn exponents() -> impl Strategy<Value = Exponents> {
    prop::array::uniform3(-4..=4)
}

/// Derivatives of `term` that do not rescale with their own unit (that of the state, per second).
fn off_dimension(
    term: impl Fn(&Motion) -> [f64; State::LEN],
    motion: &Motion,
    by: Exponents,
) -> Vec<&'static str> {
    let (ours, theirs) = (term(motion), term(&motion.rescaled(by)));
    let per_second = 2f64.powi(-by[2]);
    let keeps = |i: &usize| theirs[*i] == ours[*i] * factor(State::TABLE[*i].unit, by) * per_second;
    (0..State::LEN)
        .filter(|i| !keeps(i))
        .map(|i| State::TABLE[i].name)
        .collect()
}

/// Derivatives of `term` that do not change sign in a mirror.
fn off_mirror(term: impl Fn(&Motion) -> [f64; State::LEN], motion: &Motion) -> Vec<&'static str> {
    let (ours, theirs) = (term(motion), term(&motion.mirrored()));
    (0..State::LEN)
        .filter(|i| theirs[*i] != -ours[*i])
        .map(|i| State::TABLE[i].name)
        .collect()
}

const NONE: [&str; 0] = [];

/// The formulations that keep both laws.
fn lawful() -> impl Strategy<Value = Formulation> {
    prop::sample::select(&Formulation::ALL[2..])
}

proptest! {
    #[test]
    fn all_but_the_misprinted_keep_the_dimension_law(
        motion in motion(),
        by in exponents(),
        formulation in lawful(),
    ) {
        let term = |m: &Motion| m.derivative(formulation);
        prop_assert_eq!(off_dimension(term, &motion, by), NONE);
        let expected = rescaled(Output::TABLE, motion.output(formulation), by);
        prop_assert_eq!(motion.rescaled(by).output(formulation), expected);
    }

    #[test]
    fn all_but_the_misprinted_keep_the_mirror_law(motion in motion(), formulation in lawful()) {
        let term = |m: &Motion| m.derivative(formulation);
        prop_assert_eq!(off_mirror(term, &motion), NONE);
        let even = ["x", "effective_trail", "front_load", "x_rate"];
        let (ours, theirs) = (motion.output(formulation), motion.mirrored().output(formulation));
        for (i, row) in Output::TABLE.iter().enumerate() {
            let expected = if even.contains(&row.name) { ours[i] } else { -ours[i] };
            prop_assert_eq!(theirs[i], expected, "{}", row.name);
        }
    }
}

/// Rows and inputs each of which switches on one term of an equation, or one in each.
const SWITCHES: [&str; 18] = [
    "cross_inertia",
    "rear_wheel_inertia",
    "front_wheel_inertia",
    "cornering_stiffness",
    "camber_stiffness",
    "viscous_friction",
    "coulomb_friction",
    "rider_roll_gain",
    "rider_roll_rate_gain",
    "rider_steer_gain",
    "rider_steer_rate_gain",
    "rider_roll_gain_slope",
    "rider_roll_rate_gain_slope",
    "rider_steer_gain_slope",
    "rider_steer_rate_gain_slope",
    "steer_torque",
    "assist_torque",
    "roll_moment",
];
/// What is left with all of them off: weight, and the frame that follows the front wheel.
const REST: &str = "rest";

/// One term that breaks one law: formulation, switch, derivative, law.
type Misprint = (&'static str, &'static str, &'static str, &'static str);

/// Runs every term of every formulation through both laws, on a few motions (a law that is broken
/// is broken almost everywhere, and one that holds holds for all).
fn misprints() -> BTreeSet<Misprint> {
    let mut found = BTreeSet::new();
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    for _ in 0..20 {
        let motion = motion().new_tree(&mut runner).expect("a motion").current();
        for formulation in Formulation::ALL {
            let mut note = |switch, derivatives: Vec<&'static str>, law| {
                for derivative in derivatives {
                    found.insert((formulation.name(), switch, derivative, law));
                }
            };
            let by = [1, 2, 3];
            for switch in SWITCHES {
                let term = |m: &Motion| m.share(&[switch], formulation);
                note(switch, off_dimension(term, &motion, by), "dimension");
                note(switch, off_mirror(term, &motion), "mirror");
            }
            let rest = |m: &Motion| m.without(&SWITCHES).derivative(formulation);
            note(REST, off_dimension(rest, &motion, by), "dimension");
            note(REST, off_mirror(rest, &motion), "mirror");
        }
    }
    found
}

#[test]
fn printed_terms_that_break_a_law() {
    let row_7a = [("printed", "cornering_stiffness", "yaw_rate", "dimension")];
    let shared = |formulation| {
        [
            (formulation, "camber_stiffness", "yaw_rate", "dimension"), // 7b
            (
                formulation,
                "front_wheel_inertia",
                "steer_rate",
                "dimension",
            ), // 9b
            (formulation, "cornering_stiffness", "steer_rate", "mirror"), // 9c
            (formulation, "camber_stiffness", "steer_rate", "dimension"), // 9d
        ]
    };
    let expected: BTreeSet<Misprint> = row_7a
        .into_iter()
        .chain(shared("printed"))
        .chain(shared("minimal"))
        .collect();
    assert_eq!(misprints(), expected);
}

/// The wheel's axle by rotation: steer θ about the axis (−sin λ, 0, cos λ), then roll φ about x.
/// Its elevation is the sine of the wheel's lean to the right.
fn lean_of_the_wheel(caster: f64, roll: f64, steer: f64) -> f64 {
    (steer.cos() * roll.sin() - caster.sin() * steer.sin() * roll.cos()).asin()
}

fn nominal(formulation: Formulation) -> Bicycle {
    Bicycle::new(&Parameters::default(), formulation)
}

/// Row 6/7c passes both laws; geometry decides it.
#[test]
fn camber_angle_of_the_steered_wheel() {
    let x = State {
        roll: 0.02,
        steer: 0.05,
        ..State::default()
    };
    let lean = lean_of_the_wheel(Parameters::<f64>::default().caster_angle, x.roll, x.steer);
    // what the equations leave out is of third order in angles below .07 rad
    let order = 0.07f64.powi(3);
    let angle = |formulation| bicycle::tyre::camber_angle(&nominal(formulation), &x);
    assert!((angle(Formulation::Repaired) - lean).abs() < order);
    assert!((angle(Formulation::Printed) - lean).abs() > 10.0 * order);
    assert!((angle(Formulation::Minimal) - lean).abs() > 10.0 * order);
}

/// As printed, the camber term of (7) vanishes at another lean than that of (9).
#[test]
fn camber_of_yaw_and_of_steer_agree_when_repaired() {
    let caster: f64 = Parameters::<f64>::default().caster_angle;
    let steer = 0.05;
    let thrusts = |formulation, roll| {
        let motion = Motion {
            p: Parameters::default(),
            x: State {
                roll,
                steer,
                ..State::default()
            },
            u: Input::default(),
        };
        let [_, in_steer, _, _, in_yaw, ..] = motion.share(&["camber_stiffness"], formulation);
        (in_yaw, in_steer)
    };
    // the wheel stands upright when φ = θ sin λ: no thrust
    let upright = steer * bicycle::Real::sin(caster);
    assert_eq!(thrusts(Formulation::Repaired, upright), (0.0, 0.0));
    for formulation in [Formulation::Printed, Formulation::Minimal] {
        let (in_yaw, in_steer) = thrusts(formulation, upright);
        assert_eq!(in_steer, 0.0);
        assert!(in_yaw.abs() > 1e-3, "{in_yaw}"); // [rad/s²], of 2 θ sin λ C_φ/I_zz = 1.6e-3
    }
}

/// Row 9a passes both laws. What decides it: the fork turns in its bearings, however heavy the
/// body that it is mounted on, so the answer to a steer torque does not know `I_xx`.
#[test]
fn steering_inertia_without_the_body() {
    let answer = |formulation, roll_inertia| {
        let motion = Motion {
            p: Parameters {
                roll_inertia,
                ..Parameters::default()
            },
            x: State::default(),
            u: Input {
                steer_torque: 1.0,
                ..Input::default()
            },
        };
        motion.derivative(formulation)[1]
    };
    for formulation in [Formulation::Minimal, Formulation::Repaired] {
        assert_eq!(answer(formulation, 100.0), answer(formulation, 200.0));
    }
    // doubling the body's roll inertia halves the printed answer, but for I_h = .14 of 100 kg m²
    let ratio = answer(Formulation::Printed, 100.0) / answer(Formulation::Printed, 200.0);
    assert!((ratio - 2.0).abs() < 2e-3, "{ratio}");
}

proptest! {
    /// −θ̇ (c θ̇ + d s(θ̇)) ≤ 0, and friction acts on the steering alone.
    #[test]
    fn friction_only_dissipates(motion in motion(), f in prop::sample::select(&Formulation::ALL[..3])) {
        let friction = ["viscous_friction", "coulomb_friction"];
        let [roll, _, _, _, yaw, ..] = motion.share(&friction, f);
        prop_assert_eq!((roll, yaw), (0.0, 0.0));
        // without weight nothing else acts on the fork, and the difference does not round
        let p = Parameters { gravity: 0.0, ..motion.p };
        let torque = Motion { p, ..motion }.share(&friction, f)[1] * Bicycle::new(&p, f).steering_inertia;
        let rate = motion.x.steer_rate;
        prop_assert!(torque * rate <= 0.0);
        let sign = bicycle::real::sign(rate, p.steer_rate_smoothing);
        let expected = -(p.viscous_friction * rate + p.coulomb_friction * sign);
        // a handful of roundings of terms of one sign
        prop_assert!((torque - expected).abs() <= 8.0 * f64::EPSILON * expected.abs());
    }
}
