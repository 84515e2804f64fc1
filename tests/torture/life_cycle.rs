//! Each function in each state.

use crate::calls::{CALLS, expected, make};
use crate::expect;
use fmi2::{fmi2Error, fmi2OK};
use std::collections::BTreeSet;
use std::ffi::CStr;
use std::ptr::null_mut;
use tests::symbols::{fmi2FreeInstance, fmi2GetTypesPlatform, fmi2GetVersion};
use tests::{Slave, State};

#[test]
fn each_function_in_each_state() {
    for state in State::ALL {
        for (call, legal) in CALLS {
            let mut slave = Slave::reach(state);
            slave.saved = slave.save();
            let what = format!("{call} in {state:?}");
            expect(&mut slave, &what, expected(legal, state), |slave| {
                make(slave, call)
            });
        }
    }
}

#[test]
fn the_table_has_every_function_that_takes_an_instance() {
    let functions: BTreeSet<&str> = CALLS
        .iter()
        .filter_map(|(call, _)| call.split(' ').next())
        .collect();
    // 34 functions of co-simulation, less fmi2GetTypesPlatform, fmi2GetVersion, fmi2Instantiate
    // and fmi2FreeInstance
    assert_eq!(functions.len(), 30);
}

#[test]
fn reading_changes_nothing() {
    // In initialization mode reading computes what was not yet asked for.
    for state in [State::StepComplete, State::StepFailed, State::Terminated] {
        let mut slave = Slave::reach(state);
        slave.saved = slave.save();
        let before = slave.bytes();
        let reading = |call: &str| call.starts_with("fmi2Get") || call.starts_with("fmi2Serialize");
        for (call, _) in CALLS.iter().filter(|(call, _)| reading(call)) {
            make(&mut slave, call);
            assert!(slave.bytes() == before, "{call} in {state:?}");
        }
    }
}

#[test]
fn any_order_of_refused_calls_leaves_the_simulation_as_it_is() {
    let mut tormented = Slave::reach(State::Instantiated);
    for state in State::ALL {
        // by the calls that are legal there, as one who is not tormented goes
        match state {
            State::Instantiated => {}
            State::Initialization => {
                assert_eq!(make(&mut tormented, "fmi2EnterInitializationMode"), fmi2OK);
            }
            State::StepComplete => {
                assert_eq!(make(&mut tormented, "fmi2ExitInitializationMode"), fmi2OK);
                assert_eq!(tormented.step(1.0 / 60.0), fmi2OK);
            }
            State::StepFailed => continue,
            State::Terminated => assert_eq!(make(&mut tormented, "fmi2Terminate"), fmi2OK),
        }
        for (call, legal) in CALLS {
            if expected(legal, state) == fmi2Error {
                assert_eq!(make(&mut tormented, call), fmi2Error, "{call} in {state:?}");
            }
        }
        let untouched = Slave::reach(state);
        assert!(tormented.bytes() == untouched.bytes(), "{state:?}");
    }
    Slave::lines();
}

#[test]
fn reset_brings_back_the_start_from_every_state() {
    let fresh = Slave::new().bytes();
    for state in State::ALL {
        let mut slave = Slave::reach(state);
        assert_eq!(slave.reset(), fmi2OK, "{state:?}");
        assert!(slave.bytes() == fresh, "{state:?}");
        for goal in State::ALL {
            slave.lead(goal);
            assert!(
                slave.bytes() == Slave::reach(goal).bytes(),
                "{state:?} to {goal:?}"
            );
            assert_eq!(slave.reset(), fmi2OK, "{state:?} to {goal:?}");
        }
    }
}

#[test]
fn a_null_instance_is_an_error_everywhere() {
    let mut slave = Slave::reach(State::StepComplete);
    slave.saved = slave.save();
    let live = std::mem::replace(&mut slave.c, null_mut());
    for (call, _) in CALLS {
        assert_eq!(make(&mut slave, call), fmi2Error, "{call}");
    }
    // SAFETY: NULL is nothing to free.
    unsafe { fmi2FreeInstance(null_mut()) };
    assert_eq!(Slave::lines(), []);
    slave.c = live;
}

#[test]
fn an_instance_can_be_freed_in_every_state() {
    for state in State::ALL {
        let mut slave = Slave::reach(state);
        // a state left behind is no leak
        slave.save();
        // SAFETY: freed once, here; what is dropped then is NULL.
        unsafe { fmi2FreeInstance(std::mem::replace(&mut slave.c, null_mut())) };
    }
}

#[test]
fn version_and_types_are_those_of_the_standard() {
    // SAFETY: static texts.
    let [version, types] =
        unsafe { [fmi2GetVersion(), fmi2GetTypesPlatform()].map(|text| CStr::from_ptr(text)) };
    assert_eq!((version, types), (c"2.0", c"default"));
}
