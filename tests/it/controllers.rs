//! The steering assists among the examples of `fmi-export`: when they sample, what they do without
//! live sensors, and what they are worth in front of the bicycle.

#[path = "../../fmi-export/examples/assist/mod.rs"]
mod assist;
#[path = "../../fmi-export/examples/disturbance_observer/model.rs"]
mod disturbance_observer;
#[path = "../../fmi-export/examples/roll_assist/model.rs"]
mod roll_assist;
mod worth;

use bicycle::State;
use disturbance_observer::DisturbanceObserver;
use fmi_export::{Experiment, Flow, Model};
use roll_assist::RollAssist;

/// What the tests do with either assist.
trait Assist: Model {
    /// Its sensors see the bicycle in state `x` at `speed` [m/s].
    fn see(&mut self, x: &State, speed: f64);
    /// Its torque [N m].
    fn torque(&self) -> f64;
    fn fault(&self) -> bool;
}

impl Assist for DisturbanceObserver {
    fn see(&mut self, x: &State, _speed: f64) {
        self.variables.steer = x.steer;
    }
    fn torque(&self) -> f64 {
        self.variables.assist_torque
    }
    fn fault(&self) -> bool {
        self.variables.fault
    }
}

impl Assist for RollAssist {
    fn see(&mut self, x: &State, speed: f64) {
        let v = &mut self.variables;
        (v.roll, v.roll_rate, v.speed) = (x.roll, x.roll_rate, speed);
    }
    fn torque(&self) -> f64 {
        self.variables.assist_torque
    }
    fn fault(&self) -> bool {
        self.variables.fault
    }
}

/// An assist at time 0.
fn started<A: Assist>() -> A {
    let mut assist = A::new();
    let experiment = Experiment {
        start_time: 0.0,
        stop_time: None,
        tolerance: None,
    };
    assist
        .initialize(&experiment)
        .expect("its own start values");
    assist
}

const SPEED: f64 = 8.0 / 3.6;

/// A weaving bicycle at time `t` [s]: fork and frame swing at 1 Hz by some degrees.
fn weaving(t: f64) -> State {
    let (sin, cos) = (std::f64::consts::TAU * t).sin_cos();
    State {
        steer: 0.3 * sin,
        roll: 0.05 * sin,
        roll_rate: 0.3 * cos,
        ..State::ZERO
    }
}

fn step<A: Assist>(assist: &mut A, t: f64, h: f64) {
    assert_eq!(assist.step(t, h), Flow::Continue);
}

/// Rides along the weaving bicycle from step `from` to `to` of `h` [s]; the torque after each.
fn along<A: Assist>(assist: &mut A, h: f64, from: usize, to: usize) -> Vec<f64> {
    (from..to)
        .map(|i| {
            let t = i as f64 * h;
            assist.see(&weaving(t), SPEED);
            step(assist, t, h);
            assist.torque()
        })
        .collect()
}

/// Runs a generic check with both assists.
macro_rules! both {
    ($($name:ident: $check:ident;)*) => {$(
        #[test]
        fn $name() {
            $check::<DisturbanceObserver>();
            $check::<RollAssist>();
        }
    )*};
}

both! {
    what_is_seen_between_ticks_does_not_matter: between_ticks;
    left_is_the_mirror_image_of_right: mirrored;
    a_dead_time_that_is_no_number_of_samples_is_refused: odd_dead_time;
    a_saved_assist_goes_on_to_the_last_bit: saved;
    inputs_that_are_no_numbers_let_the_torque_go: no_numbers;
    inputs_that_stand_still_let_the_torque_go: stale;
    a_bicycle_at_rest_is_no_fault: at_rest;
}

/// Steps of a fifth of the sampling period: four of five inputs are not sampled, and a step of the
/// whole period gives the same torque but for rounding of the motor's lag.
fn between_ticks<A: Assist>() {
    let (mut whole, mut fifths) = (started::<A>(), started::<A>());
    for i in 0..400 {
        let t = f64::from(i) * 0.005;
        whole.see(&weaving(t), SPEED);
        step(&mut whole, t, 0.005);
        for part in 0..5 {
            let junk = f64::from(part) * 0.2;
            fifths.see(&weaving(t + junk), SPEED);
            step(&mut fifths, t + f64::from(part) * 0.001, 0.001);
        }
        let apart = (whole.torque() - fifths.torque()).abs();
        // rounding, which neither motor nor filter amplifies
        assert!(apart < 1e-12, "{apart} N m apart after {t} s");
    }
    assert!(whole.torque().abs() > 0.01, "it does something");
}

fn mirrored<A: Assist>() {
    let (mut left, mut right) = (started::<A>(), started::<A>());
    for i in 0..400 {
        let t = f64::from(i) * 0.005;
        let x = weaving(t);
        left.see(&x, SPEED);
        right.see(&x.map(|value| -value), SPEED);
        step(&mut left, t, 0.005);
        step(&mut right, t, 0.005);
        assert_eq!(left.torque(), -right.torque());
    }
}

fn odd_dead_time<A: Assist>() {
    for (dead_time, expected) in [(0.0, true), (0.08, true), (0.012, false), (0.085, false)] {
        let mut assist = A::new();
        let reference = A::description()
            .variables
            .iter()
            .find(|variable| variable.name == "dead_time")
            .expect("a row")
            .value_reference;
        assist.set(reference, fmi_export::Value::Real(dead_time));
        let experiment = Experiment {
            start_time: 0.0,
            stop_time: None,
            tolerance: None,
        };
        let found = assist.initialize(&experiment);
        assert_eq!(found.is_ok(), expected, "{dead_time} s: {found:?}");
    }
}

fn saved<A: Assist>() {
    let mut assist = started::<A>();
    // ends between two ticks
    along(&mut assist, 0.002, 0, 333);
    let text = serde_json::to_string(&assist).expect("written");
    let mut restored: A = serde_json::from_str(&text).expect("read");
    let mut copied = assist.clone();
    let expected = along(&mut assist, 0.002, 333, 666);
    assert_eq!(along(&mut restored, 0.002, 333, 666), expected);
    assert_eq!(along(&mut copied, 0.002, 333, 666), expected);
}

/// How far a torque may be from 0 [N m] once the command, which changes by 200 N m/s, is 0 and has
/// passed the dead time, 5 ms: it dies out with the motor's time constant, 10 ms.
fn afterwards(torque: f64, since: f64) -> f64 {
    let ramp = torque.abs() / 200.0 + 0.005 + 0.010;
    torque.abs() * (-(since - ramp).max(0.0) / 0.010).exp()
}

fn no_numbers<A: Assist>() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut assist = started::<A>();
        let ridden = along(&mut assist, 0.005, 0, 245);
        // the command may be on its way up
        let torque = ridden
            .iter()
            .fold(0.0, |most: f64, torque| most.max(torque.abs()));
        assert!(torque > 0.1 && !assist.fault());
        let nothing = State::ZERO.map(|_| bad);
        for i in 0..40 {
            let t = f64::from(245 + i) * 0.005;
            assist.see(&nothing, SPEED);
            step(&mut assist, t, 0.005);
            assert!(assist.fault());
            let most = afterwards(torque, f64::from(i + 1) * 0.005);
            assert!(
                assist.torque().abs() <= most,
                "{} N m at {t} s",
                assist.torque()
            );
        }
        // and comes back without a kick
        let again = along(&mut assist, 0.005, 285, 485);
        assert!(!assist.fault());
        let most = again
            .iter()
            .fold(0.0, |most: f64, torque| most.max(torque.abs()));
        assert!(most < 1.2 * torque, "{most} N m after {torque} N m before");
    }
}

/// An importer that goes on after a refused input leaves the last one in place.
fn stale<A: Assist>() {
    let mut assist = started::<A>();
    along(&mut assist, 0.005, 0, 211);
    let mut faults = Vec::new();
    for i in 211..311 {
        step(&mut assist, f64::from(i) * 0.005, 0.005);
        faults.push(assist.fault());
    }
    let first = faults.iter().position(|fault| *fault);
    // stale_time is 20 samples
    assert_eq!(first, Some(20));
    assert!(assist.torque().abs() < 0.01, "{} N m", assist.torque());
    along(&mut assist, 0.005, 311, 312);
    assert!(!assist.fault(), "live again");
}

fn at_rest<A: Assist>() {
    let mut assist = started::<A>();
    assist.see(&State::ZERO, SPEED);
    for i in 0..1000 {
        step(&mut assist, f64::from(i) * 0.005, 0.005);
        assert!(!assist.fault());
        assert_eq!(assist.torque(), 0.0);
    }
}

/// Under a constant torque a free fork turns as T t²/2 J; the estimate is then the step response of
/// Q, with ζ = 1: T (1 − (1 + ω t) exp(−ω t)).
#[test]
fn the_observer_finds_a_torque_as_fast_as_its_filter() {
    const TORQUE: f64 = 0.7;
    let mut assist = started::<DisturbanceObserver>();
    assist.variables.assist_gain = 0.0;
    assist.variables.observer_damping = 1.0;
    assist.variables.steer_resolution = 0.0;
    let omega = std::f64::consts::TAU * assist.variables.observer_bandwidth;
    for i in 0..200 {
        let t = f64::from(i) * 0.005;
        assist.variables.steer = TORQUE * t * t / (2.0 * assist.variables.nominal_inertia);
        step(&mut assist, t, 0.005);
        let exact = TORQUE * (1.0 - (1.0 + omega * t) * (-omega * t).exp());
        let apart = (assist.variables.estimated_torque - exact).abs();
        // the trapezoidal rule at ω T = 0.09 errs by up to (ω T)²/12 of the torque, and the fork's
        // first half sample, in which it does not yet turn for the encoder, costs ω T/2 of its rate
        assert!(apart < 0.05 * TORQUE, "{apart} N m at {t} s");
    }
    let last = assist.variables.estimated_torque;
    // the filter forgets its start as exp(−ω t), 1e-7 after a second
    assert!((last - TORQUE).abs() < 1e-5 * TORQUE, "{last} N m");
}

/// The motor's own torque is known: what turns the fork beyond it is the estimate.
#[test]
fn the_observer_does_not_take_its_own_motor_for_the_rider() {
    let mut assist = started::<DisturbanceObserver>();
    let v = &mut assist.variables;
    (v.steer_resolution, v.nominal_inertia) = (0.0, 0.2);
    // the same fork, driven by a hand and by this motor, in fine steps
    let (mut rate, mut angle) = (0.0, 0.0);
    let hand = |t: f64| 0.3 * (std::f64::consts::TAU * 0.2 * t).sin();
    for i in 0..20_000 {
        let t = f64::from(i) * 0.0005;
        assist.variables.steer = angle;
        step(&mut assist, t, 0.0005);
        rate += 0.0005 * (hand(t) + assist.torque()) / 0.2;
        angle += 0.0005 * rate;
        if t > 2.0 {
            // Q lags 2 ζ/ω = .15 s behind, which the hand changes by 6 % of in its 5 s; dead time and
            // motor add little
            let apart = (assist.variables.estimated_torque - hand(t - 0.15)).abs();
            assert!(apart < 0.02, "{apart} N m at {t} s");
        }
    }
}

#[test]
fn the_roll_assist_fades_with_speed() {
    let torque = |speed: f64| {
        let mut assist = started::<RollAssist>();
        for i in 0..50 {
            let x = State {
                // moves by more than the resolution, so that it is alive
                roll: 0.02 + 2e-4 * f64::from(i % 2),
                ..State::ZERO
            };
            assist.see(&x, speed);
            step(&mut assist, f64::from(i) * 0.005, 0.005);
        }
        assist.torque()
    };
    assert_eq!(torque(0.0), 0.0);
    assert_eq!(torque(6.5), 0.0);
    assert_eq!(torque(20.0), 0.0);
    // 60 N m/rad · .02 rad · (1 − 2.22/6.5), to the right into the lean; the roll flickers by 1 %
    let expected = -60.0 * 0.02 * (1.0 - SPEED / 6.5);
    assert!((torque(SPEED) - expected).abs() < 0.01 * expected.abs());
    assert!((torque(0.5) + 0.5 * 60.0 * 0.02 * (1.0 - 0.5 / 6.5)).abs() < 0.01);
}
