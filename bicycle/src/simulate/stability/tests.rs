//! The shape of the stability limit over speed, and what that saves.

use super::*;
use crate::dynamics::Formulation;
use crate::parameters::Parameters;
use crate::simulate::Simulation;
use proptest::prelude::*;
use std::cell::Cell;

thread_local! {
    /// How often this thread has computed the stability limit.
    pub static COMPUTED: Cell<u64> = const { Cell::new(0) };
}

fn computed(work: impl FnOnce()) -> u64 {
    let before = COMPUTED.get();
    work();
    COMPUTED.get() - before
}

/// Any bicycle the doors let in; in one of three the rider's gains do not follow the speed.
fn bicycles() -> impl Strategy<Value = Bicycle> {
    let rows = Parameters::TABLE;
    let shares = prop::collection::vec(0.0..=1.0f64, rows.len());
    let formulation = prop::sample::select(&Formulation::ALL[..]);
    (shares, formulation, 0..3)
        .prop_map(move |(shares, formulation, kind)| {
            let values = std::array::from_fn(|i| match rows[i].name {
                name if name.ends_with("_gain_slope") && kind == 0 => 0.0,
                _ => rows[i].min + shares[i] * (rows[i].max - rows[i].min),
            });
            Bicycle::new(&Parameters::from_array(values), formulation)
        })
        .prop_filter("the front wheel is lifted", |b| b.front_load > 0.0)
}

/// 0.1 to 20 m/s, as many slow as fast ones.
fn speeds() -> impl Strategy<Value = f64> {
    (0.0..=1.0f64).prop_map(|share| 0.1 * 200f64.powf(share))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn the_limit_is_shortest_at_an_end(b in bicycles(), slow in speeds()) {
        let limit = |share: f64| stability_limit(&b, slow * WIDENING.powf(share));
        let ends = limit(0.0).min(limit(1.0));
        for k in 1..8 {
            let between = limit(f64::from(k) / 8.0);
            prop_assert!(between >= (1.0 - DIP) * ends, "{between} between {ends}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    /// Courses of speeds, near each other and far: the answer is that of the limit there.
    #[test]
    fn a_refusal_does_not_depend_on_what_was_asked_before(
        mut b in bicycles(),
        start in speeds(),
        // the step as a share of the limit at the start: on both sides of it
        share in 0.5..1.2f64,
        ratios in prop::collection::vec(0.6..1.6f64, 20),
    ) {
        b.p.internal_step = share * stability_limit(&b, start);
        let mut stable = StableSpeeds::NONE;
        let mut speed = start;
        for ratio in ratios {
            speed *= ratio;
            let fresh = b.p.internal_step <= stability_limit(&b, speed);
            prop_assert_eq!(stable.admit(&b, speed).is_ok(), fresh, "{} m/s", speed);
        }
    }
}

fn ride(speed: f64) -> Simulation {
    let input = Input {
        speed,
        ..Input::default()
    };
    Simulation::new(&Parameters::default(), Formulation::Repaired, input, 0.0).expect("nominal")
}

#[test]
fn a_ramp_of_speed_costs_a_few_limits() {
    let mut ride = ride(2.0);
    let by_steps = computed(|| {
        for k in 1..=1000 {
            let speed = 2.0 + 0.004 * f64::from(k);
            ride.set_input(Input {
                speed,
                ..Input::default()
            })
            .expect("stable from 2 to 6 m/s");
        }
    });
    // at 2.004 m/s itself and a factor 1.25 on either side; then, each time the known speeds
    // end, at 2.5 · 1.25ⁿ m/s: there and 1.25 beyond
    assert_eq!(by_steps, 3 + 2 * 4);
}

#[test]
fn a_course_ahead_is_checked_where_it_leads() {
    let faster = Input {
        speed: 2.0,
        ..Input::ZERO
    };
    let mut moving = ride(2.0);
    let start = *moving.parameters();
    let present = moving.input();
    moving.set(&start, present, faster).expect("2 m/s");
    let work = computed(|| {
        for k in 1..=400 {
            let to = 5e-3 * f64::from(k);
            moving.check_until(to).expect("stable up to 6 m/s");
            moving.advance(to).expect("no fall");
        }
    });
    // as above, and once more each time: the check keeps nothing, arriving there does
    assert_eq!(work, 2 * (3 + 2 * 4));
    // a step that does not come to an end of the known speeds costs nothing
    assert_eq!(computed(|| moving.check_until(2.01).expect("6 m/s")), 0);
    // a long way: at one speed in each factor, and around it
    let far = computed(|| moving.check_until(5.0).expect("12 m/s"));
    assert!((3..=8).contains(&far), "{far}");
}

#[test]
fn a_course_out_of_the_stable_speeds_is_refused() {
    // the yaw pole −L² F_z C_θ/(V I_zz): 5 ms are too long below .9 m/s or so
    let p = Parameters {
        cornering_stiffness: 40.0,
        internal_step: 5e-3,
        ..Parameters::default()
    };
    let start = Input::default();
    let slower = Input {
        speed: -1.0,
        ..Input::ZERO
    };
    let mut ride = Simulation::new(&p, Formulation::Repaired, start, 0.0).expect("fast enough");
    ride.set(&p, start, slower).expect("fast enough now");
    assert_eq!(ride.check_until(0.5), Ok(()));
    let too_long = |to: f64| match ride.check_until(to) {
        Err(Refusal::StepTooLong { step, limit }) => step == 5e-3 && limit < step,
        _ => false,
    };
    // slow, standing, backwards, never
    for to in [1.2, start.speed, 3.0, f64::INFINITY, f64::NAN] {
        assert!(too_long(to), "{to}");
    }
    ride.set_input(start).expect("no ramp any more");
    assert_eq!(ride.check_until(3.0), Ok(()));
}
