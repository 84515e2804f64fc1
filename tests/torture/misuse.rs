//! Wrong arguments: NULL, other numbers, other types.

use crate::expect;
use fmi2::{fmi2CallbackFunctions, fmi2Discard, fmi2Error, fmi2OK, fmi2String, fmi2Type};
use std::ffi::CString;
use std::ptr::{null, null_mut};
use tests::symbols::*;
use tests::{Slave, State, bicycle};

/// States in which every function of a kind can be called.
const SETTABLE: [State; 3] = [
    State::Instantiated,
    State::Initialization,
    State::StepComplete,
];
const READABLE: [State; 4] = [
    State::Initialization,
    State::StepComplete,
    State::StepFailed,
    State::Terminated,
];

#[test]
fn instantiation_refuses_with_one_line() {
    let guid = CString::new(&*bicycle().guid).expect("no inner null");
    let (name, guid, nowhere) = (c"slave".as_ptr(), guid.as_ptr(), null());
    let check = |name, kind: fmi2Type, guid, resources: fmi2String, word: &str| {
        for logging in [0, 1] {
            let callbacks = Slave::callbacks();
            // SAFETY: texts are null-terminated or NULL.
            let c = unsafe {
                fmi2Instantiate(
                    name,
                    kind,
                    guid,
                    resources,
                    &raw const *callbacks,
                    0,
                    logging,
                )
            };
            Slave::hear_panics();
            assert!(c.is_null(), "{word}");
            let lines = Slave::lines();
            let [line] = &lines[..] else {
                panic!("{word}: expected one line, found {lines:?}");
            };
            assert_eq!(
                (line.environment, line.status),
                (Slave::ENVIRONMENT, fmi2Error)
            );
            assert_eq!(line.category.as_deref(), Some("logStatusError"));
            assert!(line.instance.is_some());
            assert!(
                line.message
                    .as_ref()
                    .is_some_and(|message| message.contains(word)),
                "{line:?}"
            );
        }
    };
    check(null(), 1, guid, nowhere, "instanceName");
    check(c"".as_ptr(), 1, guid, nowhere, "instanceName");
    check(c"\xff".as_ptr(), 1, guid, nowhere, "instanceName");
    check(name, 0, guid, nowhere, "fmuType");
    check(name, -7, guid, nowhere, "fmuType");
    check(name, 1, null(), nowhere, "fmuGUID");
    check(name, 1, c"".as_ptr(), nowhere, "fmuGUID");
    check(
        name,
        1,
        c"{8c4e810f-3df3-4a00-8276-176fa3c9f000}".as_ptr(),
        nowhere,
        "fmuGUID",
    );
    check(
        name,
        1,
        guid,
        c"http://host/resources".as_ptr(),
        "fmuResourceLocation",
    );
    check(
        name,
        1,
        guid,
        c"file:///%00".as_ptr(),
        "fmuResourceLocation",
    );
}

#[test]
fn without_callbacks_or_a_logger_nothing_falls_over() {
    let guid = CString::new(&*bicycle().guid).expect("no inner null");
    let instantiate = |guid, callbacks: *const fmi2CallbackFunctions| {
        // SAFETY: texts are null-terminated.
        unsafe { fmi2Instantiate(c"slave".as_ptr(), 1, guid, null(), callbacks, 0, 1) }
    };
    assert!(instantiate(guid.as_ptr(), null()).is_null());
    let mute = fmi2CallbackFunctions {
        logger: None,
        ..*Slave::callbacks()
    };
    assert!(instantiate(c"{0}".as_ptr(), &raw const mute).is_null());
    let c = instantiate(guid.as_ptr(), &raw const mute);
    Slave::hear_panics();
    assert!(!c.is_null());
    // SAFETY: a live instance.
    unsafe {
        assert_eq!(fmi2DoStep(c, 0.0, 1.0, 1), fmi2Error);
        fmi2FreeInstance(c);
    }
    assert_eq!(Slave::lines(), []);
}

#[test]
fn the_importers_callbacks_may_be_gone_after_instantiation() {
    let mut callbacks = Slave::callbacks();
    let guid = CString::new(&*bicycle().guid).expect("no inner null");
    // SAFETY: texts are null-terminated; a live instance.
    unsafe {
        let c = fmi2Instantiate(
            c"slave".as_ptr(),
            1,
            guid.as_ptr(),
            null(),
            &raw const *callbacks,
            0,
            1,
        );
        // FMI 2.0 §2.1.5 lets the importer neither change nor free it; some do.
        callbacks.logger = None;
        drop(callbacks);
        drop(guid);
        assert_eq!(fmi2DoStep(c, 0.0, 1.0, 1), fmi2Error);
        fmi2FreeInstance(c);
    }
    Slave::hear_panics();
    let lines = Slave::lines();
    assert_eq!(lines.len(), 1);
    assert_eq!(lines[0].instance.as_deref(), Some("slave"));
}

#[test]
fn null_arrays_are_refused_unless_they_are_empty() {
    let (vr, one, unit) = (Slave::reference("steer_torque"), 1, 1.0);
    let (vr, order, value) = (&raw const vr, &raw const one, &raw const unit);
    let (integers, texts) = (null::<i32>(), null::<fmi2String>());
    for state in SETTABLE {
        let slave = &mut Slave::reach(state);
        for (n, expected) in [(0, fmi2OK), (1, fmi2Error), (usize::MAX, fmi2Error)] {
            let mut check = |what: &str, call: &dyn Fn(fmi2::fmi2Component) -> i32| {
                expect(slave, &format!("{what}, {n} in {state:?}"), expected, |s| {
                    call(s.c)
                });
            };
            // SAFETY: NULL is what is tested.
            unsafe {
                check("set reals", &|c| fmi2SetReal(c, null(), n, null()));
                check("set integers", &|c| fmi2SetInteger(c, null(), n, integers));
                check("set booleans", &|c| fmi2SetBoolean(c, null(), n, integers));
                check("set texts", &|c| fmi2SetString(c, null(), n, texts));
                check("ramps", &|c| {
                    fmi2SetRealInputDerivatives(c, null(), n, integers, null())
                });
                check("logging", &|c| fmi2SetDebugLogging(c, 1, n, null()));
                if n < 2 {
                    check("references only", &|c| fmi2SetReal(c, vr, n, null()));
                    check("values only", &|c| fmi2SetReal(c, null(), n, value));
                    check("no orders", &|c| {
                        fmi2SetRealInputDerivatives(c, vr, n, null(), value)
                    });
                    check("no slopes", &|c| {
                        fmi2SetRealInputDerivatives(c, vr, n, order, null())
                    });
                }
            }
        }
    }
    for state in READABLE {
        let slave = &mut Slave::reach(state);
        for (n, expected) in [(0, fmi2OK), (1, fmi2Error), (usize::MAX, fmi2Error)] {
            let mut check = |what: &str, call: &dyn Fn(fmi2::fmi2Component) -> i32| {
                expect(slave, &format!("{what}, {n} in {state:?}"), expected, |s| {
                    call(s.c)
                });
            };
            // SAFETY: NULL is what is tested.
            unsafe {
                check("get reals", &|c| fmi2GetReal(c, null(), n, null_mut()));
                check("get integers", &|c| {
                    fmi2GetInteger(c, null(), n, null_mut())
                });
                check("get booleans", &|c| {
                    fmi2GetBoolean(c, null(), n, null_mut())
                });
                check("get texts", &|c| fmi2GetString(c, null(), n, null_mut()));
                check("derivatives", &|c| {
                    fmi2GetDirectionalDerivative(c, null(), n, null(), n, null(), null_mut())
                });
                if n < 2 {
                    check("nowhere to put them", &|c| {
                        fmi2GetReal(c, vr, n, null_mut())
                    });
                    check("no seeds", &|c| {
                        fmi2GetDirectionalDerivative(c, null(), 0, vr, n, null(), null_mut())
                    });
                }
                if state != State::Initialization {
                    check("rates", &|c| {
                        fmi2GetRealOutputDerivatives(c, null(), n, null(), null_mut())
                    });
                }
            }
        }
    }
}

#[test]
fn status_without_a_place_and_of_an_unknown_kind() {
    for state in [State::StepComplete, State::StepFailed, State::Terminated] {
        let slave = &mut Slave::reach(state);
        let (mut real, mut flag) = (0.0, 0);
        let (real, flag) = (&raw mut real, &raw mut flag);
        // SAFETY: a live instance, and places or NULL.
        unsafe {
            expect(slave, "nowhere", fmi2Error, |s| {
                fmi2GetRealStatus(s.c, 2, null_mut())
            });
            expect(slave, "nowhere", fmi2Error, |s| {
                fmi2GetBooleanStatus(s.c, 3, null_mut())
            });
            for kind in [-1, 0, 1, 4, i32::MAX] {
                expect(slave, "kind", fmi2Discard, |s| {
                    fmi2GetRealStatus(s.c, kind, real)
                });
                expect(slave, "kind", fmi2Discard, |s| {
                    fmi2GetBooleanStatus(s.c, kind, flag)
                });
            }
        }
    }
}

#[test]
fn unknown_log_categories_are_refused_and_change_nothing() {
    for state in State::ALL {
        let slave = &mut Slave::reach(state);
        let set = |s: &Slave, on, names: &[fmi2String]| {
            // SAFETY: as many texts as said, null-terminated or NULL.
            unsafe { fmi2SetDebugLogging(s.c, on, names.len(), names.as_ptr()) }
        };
        let error = c"logStatusError".as_ptr();
        for wrong in [
            c"logGossip".as_ptr(),
            c"".as_ptr(),
            c"\xff".as_ptr(),
            null(),
        ] {
            expect(slave, "wrong", fmi2Error, |s| set(s, 1, &[error, wrong]));
            expect(slave, "wrong", fmi2Error, |s| set(s, 0, &[wrong]));
        }
        for known in &bicycle().log_categories {
            let name = CString::new(&*known.name).expect("no inner null");
            expect(slave, &known.name, fmi2OK, |s| set(s, 1, &[name.as_ptr()]));
        }
        assert_eq!(set(slave, 1, &[error]), fmi2OK);
        expect(slave, "heard", fmi2Error, |s| s.set("time", 1.0));
        for (on, names) in [(0, &[][..]), (1, &[c"logStatusDiscard".as_ptr()])] {
            assert_eq!(set(slave, on, names), fmi2OK);
            assert_eq!(slave.set("time", 1.0), fmi2Error);
            assert_eq!(Slave::lines(), [], "{on}");
        }
    }
}
