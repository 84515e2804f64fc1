//! Random bicycles, states and inputs, each row within its range.

use bicycle::mass::{self, Body};
use bicycle::{Input, Parameters, Quantity, State};
use proptest::prelude::*;

/// Values for the rows of `table`, uniform over their ranges; `bound` where a range is open.
fn rows<const N: usize>(table: &'static [Quantity], bound: f64) -> impl Strategy<Value = [f64; N]> {
    prop::collection::vec(0.0..=1.0f64, N).prop_map(move |shares| {
        std::array::from_fn(|i| {
            let (min, max) = (table[i].min.max(-bound), table[i].max.min(bound));
            min + shares[i] * (max - min)
        })
    })
}

/// Any bicycle the doors let in, each row by itself.
pub fn parameters() -> impl Strategy<Value = Parameters> {
    rows(Parameters::TABLE, f64::MAX).prop_map(Parameters::from_array)
}

/// Any bicycle that matter makes: its own inertias drawn, on the wheels it has.
pub fn possible() -> impl Strategy<Value = Parameters> {
    parameters().prop_map(|mut p| {
        let (roll_inertia, yaw_inertia) = (0.1 * p.roll_inertia, 0.1 * p.yaw_inertia);
        p.set_lumps(mass::compose(&[Body {
            mass: p.total_mass.max(20.0),
            x: p.cog_to_rear.min(0.8 * p.wheelbase),
            h: p.cog_height,
            roll_inertia,
            yaw_inertia,
            cross_inertia: p.cross_inertia / 1000.0 * (roll_inertia * yaw_inertia).sqrt(),
        }]));
        p.set_front_assembly(Parameters::default().front_assembly());
        p
    })
}

/// Angles and rates up to ±1.4 rad, rad/s: on both sides of everything but the barrier at 90°.
pub fn state() -> impl Strategy<Value = State> {
    rows(State::TABLE, 1.4).prop_map(State::from_array)
}

/// Inputs up to ±20 m/s, N m.
pub fn input() -> impl Strategy<Value = Input> {
    rows(Input::TABLE, 20.0).prop_map(Input::from_array)
}
