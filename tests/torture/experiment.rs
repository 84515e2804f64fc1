//! Wrong times, and right ones that look wrong.

use crate::expect;
use fmi2::{fmi2Discard, fmi2Error, fmi2OK, fmi2Status};
use std::f64::consts::FRAC_PI_2;
use tests::symbols::{
    fmi2EnterInitializationMode, fmi2ExitInitializationMode, fmi2GetBooleanStatus,
    fmi2GetRealStatus, fmi2SetupExperiment,
};
use tests::{Slave, State};

/// A bicycle about to take its first step.
fn begun(start: f64, stop: Option<f64>) -> Slave {
    let mut slave = Slave::new();
    assert_eq!(slave.setup(start, stop), fmi2OK);
    // SAFETY: a live instance.
    unsafe {
        assert_eq!(fmi2EnterInitializationMode(slave.c), fmi2OK);
        assert_eq!(fmi2ExitInitializationMode(slave.c), fmi2OK);
    }
    slave.time = start;
    slave
}

#[test]
fn experiments_that_make_no_sense_are_refused() {
    let slave = &mut Slave::new();
    let setup = |s: &Slave, tolerance: Option<f64>, start, stop: Option<f64>| -> fmi2Status {
        let flags = [tolerance, stop].map(|value| i32::from(value.is_some()));
        let [tolerance, stop] = [tolerance, stop].map(Option::unwrap_or_default);
        // SAFETY: a live instance.
        unsafe { fmi2SetupExperiment(s.c, flags[0], tolerance, start, flags[1], stop) }
    };
    for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        expect(slave, "start", fmi2Error, |s| setup(s, None, wrong, None));
        expect(slave, "stop", fmi2Error, |s| {
            setup(s, None, 0.0, Some(wrong))
        });
        expect(slave, "tolerance", fmi2Error, |s| {
            setup(s, Some(wrong), 0.0, None)
        });
    }
    expect(slave, "stop", fmi2Error, |s| setup(s, None, 1.0, Some(0.5)));
    expect(slave, "tolerance", fmi2Error, |s| {
        setup(s, Some(-1e-6), 0.0, None)
    });
    expect(slave, "without", fmi2Error, |s| {
        // SAFETY: a live instance.
        unsafe { fmi2EnterInitializationMode(s.c) }
    });
    // what is not defined is not looked at
    // SAFETY: a live instance.
    expect(slave, "undefined", fmi2OK, |s| unsafe {
        fmi2SetupExperiment(s.c, 0, f64::NAN, -3.0, 0, f64::NAN)
    });
    expect(slave, "again", fmi2OK, |s| {
        setup(s, Some(1e-4), -3.0, Some(5.0))
    });
}

#[test]
fn wrong_steps_are_refused_and_the_right_one_still_goes() {
    let slave = &mut Slave::reach(State::StepComplete);
    let now = slave.time;
    for h in [
        0.0,
        -0.0,
        -0.01,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        1e15,
        f64::MAX,
    ] {
        expect(slave, &format!("h = {h}"), fmi2Error, |s| {
            s.step_from(now, h)
        });
    }
    for point in [
        0.0,
        now + 0.01,
        now - 1e-9,
        -now,
        1e15,
        f64::NAN,
        f64::INFINITY,
    ] {
        expect(slave, &format!("t = {point}"), fmi2Error, |s| {
            s.step_from(point, 0.01)
        });
    }
    let mut untouched = Slave::reach(State::StepComplete);
    for slave in [&mut *slave, &mut untouched] {
        expect(slave, "right", fmi2OK, |s| s.step_from(now, 0.01));
    }
    assert!(slave.bytes() == untouched.bytes());
}

#[test]
fn a_stop_time_is_kept_and_round_off_beyond_it_is_none() {
    for (h, steps) in [(0.1, 3_u32), (1.0 / 60.0, 600), (0.001, 5000)] {
        let stop = f64::from(steps) * h;
        let slave = &mut begun(0.0, Some(stop));
        // summed up, which is not n·h
        for _ in 0..steps {
            expect(slave, &format!("{h} s"), fmi2OK, |s| s.step(h));
        }
        let now = slave.time;
        expect(slave, "beyond", fmi2Error, |s| s.step_from(now, h));
        expect(slave, "a little beyond", fmi2Error, |s| {
            s.step_from(now, 0.01 * h)
        });
    }
    let slave = &mut begun(0.0, Some(1.0));
    expect(slave, "too long", fmi2Error, |s| s.step_from(0.0, 1.5));
    expect(slave, "to the end", fmi2OK, |s| s.step(1.0));
    // without a stop time there is no end
    let slave = &mut begun(0.0, None);
    expect(slave, "on", fmi2OK, |s| s.step(50.0));
}

#[test]
fn any_length_of_step_arrives_where_it_was_to() {
    for start in [0.0, -2.5, 1e6] {
        for h in [1.0 / 60.0, 1e-3, 0.005, 0.0123, 1.0] {
            let slave = &mut begun(start, None);
            let mut time = start;
            for _ in 0..50 {
                expect(slave, &format!("{h} s from {time} s"), fmi2OK, |s| {
                    s.step_from(time, h)
                });
                time += h;
                assert_eq!(slave.get("time").to_bits(), time.to_bits());
            }
        }
    }
    let slave = &mut begun(0.0, None);
    for n in 0..20 {
        expect(slave, "1 ns", fmi2OK, |s| {
            s.step_from(f64::from(n) * 1e-9, 1e-9)
        });
    }
}

#[test]
fn an_early_end_tells_when_and_that_it_is_the_end() {
    let slave = &mut Slave::reach(State::StepFailed);
    let (mut time, mut terminated) = (f64::NAN, -1);
    // SAFETY: a live instance and places.
    unsafe {
        assert_eq!(fmi2GetRealStatus(slave.c, 2, &raw mut time), fmi2OK);
        assert_eq!(
            fmi2GetBooleanStatus(slave.c, 3, &raw mut terminated),
            fmi2OK
        );
    }
    assert!(time > 0.0 && time < 10.0, "{time}");
    assert_eq!(terminated, 1);
    assert_eq!(slave.get("time").to_bits(), time.to_bits());
    assert!(slave.get("steer").abs() > 1.4 || slave.get("roll").abs() > FRAC_PI_2 - 0.1);
    // before, it was not
    let slave = &mut Slave::reach(State::StepComplete);
    // SAFETY: as above.
    unsafe {
        assert_eq!(fmi2GetRealStatus(slave.c, 2, &raw mut time), fmi2OK);
        assert_eq!(
            fmi2GetBooleanStatus(slave.c, 3, &raw mut terminated),
            fmi2OK
        );
    }
    assert_eq!(
        (time.to_bits(), terminated),
        ((1.0_f64 / 60.0).to_bits(), 0)
    );
}

#[test]
fn a_discarded_step_can_be_taken_back_and_shortened() {
    let mut slave = Slave::reach(State::StepComplete);
    assert_eq!(slave.set("rider_roll_gain", -2000.0), fmi2OK);
    let (state, now) = (slave.save(), slave.time);
    expect(&mut slave, "too far", fmi2Discard, |s| {
        s.step_from(now, 10.0)
    });
    assert_eq!(slave.restore(state), fmi2OK);
    expect(&mut slave, "not as far", fmi2OK, |s| s.step_from(now, 0.01));
    slave.forget(state);
}

#[test]
fn a_ramp_out_of_its_range_is_refused_until_it_is_set_anew() {
    let slave = &mut Slave::reach(State::StepComplete);
    // to 1001 N·m within a second, 1000 N·m are allowed
    expect(slave, "value", fmi2OK, |s| s.set("roll_moment", 0.0));
    expect(slave, "slope", fmi2OK, |s| s.ramp("steer_torque", 1001.0));
    let now = slave.time;
    expect(slave, "too far", fmi2Error, |s| s.step_from(now, 1.0));
    expect(slave, "less far", fmi2OK, |s| s.step_from(now, 0.001));
    expect(slave, "level", fmi2OK, |s| s.ramp("steer_torque", 0.0));
    expect(slave, "on", fmi2OK, |s| s.step_from(now + 0.001, 1.0));
    // value + slope·h, with the rounding of time
    assert!((slave.get("steer_torque") - 1.001).abs() < 1e-12);
}
