//! States saved, set, and read from bytes.

use crate::expect;
use fmi2::{fmi2Byte, fmi2Error, fmi2FMUstate, fmi2OK};
use std::ptr::{null, null_mut, without_provenance_mut};
use tests::symbols::{
    fmi2DeSerializeFMUstate, fmi2FreeFMUstate, fmi2GetFMUstate, fmi2SerializeFMUstate,
    fmi2SerializedFMUstateSize, fmi2SetFMUstate,
};
use tests::{Slave, State};

/// Length of the SHA-256 at the end of the bytes.
const CHECKSUM: usize = 32;

#[test]
fn a_saved_state_brings_an_instance_back_from_every_state() {
    for from in State::ALL {
        let origin = Slave::reach(from);
        let (state, bytes) = (origin.save(), origin.bytes());
        for to in State::ALL {
            let mut slave = Slave::reach(to);
            // by the handle, and by the bytes
            assert_eq!(slave.restore(state), fmi2OK);
            assert!(slave.bytes() == bytes, "{from:?} to {to:?}");
            let mut slave_again = Slave::reach(to);
            let mut read = null_mut();
            assert_eq!(slave_again.read(&bytes, &mut read), fmi2OK);
            slave_again.saved = read;
            assert_eq!(slave_again.restore(read), fmi2OK);
            assert!(slave_again.bytes() == bytes, "{from:?} to {to:?}");
            if from == State::StepComplete {
                let mut going_on = Slave::reach(from);
                for slave in [&mut slave, &mut slave_again, &mut going_on] {
                    slave.time = 1.0 / 60.0;
                    assert_eq!(slave.step(0.1), fmi2OK);
                }
                assert!(slave.bytes() == going_on.bytes());
                assert!(slave_again.bytes() == going_on.bytes());
            }
        }
        origin.forget(state);
    }
}

#[test]
fn rollback_is_bitwise_on_and_off_the_grid_and_with_a_ramp() {
    for slope in [0.0, 0.7] {
        for h in [0.005, 1.0 / 60.0, 1e-9, 0.3] {
            let mut slave = Slave::reach(State::StepComplete);
            slave.set("steer_torque", 0.1);
            if slope != 0.0 {
                assert_eq!(slave.ramp("steer_torque", slope), fmi2OK);
            }
            assert_eq!(slave.step(h), fmi2OK);
            let (state, time) = (slave.save(), slave.time);
            let go_on = |slave: &mut Slave| {
                slave.time = time;
                for _ in 0..5 {
                    assert_eq!(slave.step(h), fmi2OK);
                }
                slave.set("rear_load", 2.0);
                assert_eq!(slave.step(h), fmi2OK);
                slave.bytes()
            };
            let first = go_on(&mut slave);
            // another way in between
            slave.set("speed", 4.0);
            slave.step(0.1);
            assert_eq!(slave.restore(state), fmi2OK);
            assert!(go_on(&mut slave) == first, "steps of {h} s, slope {slope}");
            slave.forget(state);
        }
    }
}

#[test]
fn what_is_no_state_is_refused_and_not_followed() {
    for state in State::ALL {
        let mut slave = Slave::reach(state);
        let freed = slave.save();
        slave.forget(freed);
        let mut size = 0;
        let mut bytes: Vec<fmi2Byte> = vec![0; 1 << 16];
        let room = bytes.as_mut_ptr();
        let place = &raw mut size;
        for number in [freed.addr(), 1 << 40, 8, usize::MAX] {
            let wrong: fmi2FMUstate = without_provenance_mut(number);
            let what = |function: &str| format!("{function} of {number:#x} in {state:?}");
            // SAFETY: a live instance and places; the state may be anything.
            unsafe {
                expect(&mut slave, &what("set"), fmi2Error, |s| {
                    fmi2SetFMUstate(s.c, wrong)
                });
                expect(&mut slave, &what("free"), fmi2Error, |s| {
                    fmi2FreeFMUstate(s.c, &mut wrong.clone())
                });
                expect(&mut slave, &what("save in place"), fmi2Error, |s| {
                    fmi2GetFMUstate(s.c, &mut wrong.clone())
                });
                expect(&mut slave, &what("size"), fmi2Error, |s| {
                    fmi2SerializedFMUstateSize(s.c, wrong, place)
                });
                expect(&mut slave, &what("serialise"), fmi2Error, |s| {
                    fmi2SerializeFMUstate(s.c, wrong, room, 1 << 16)
                });
            }
        }
        // SAFETY: NULL where a state or a place is expected: what is tested.
        unsafe {
            expect(&mut slave, "set NULL", fmi2Error, |s| {
                fmi2SetFMUstate(s.c, null_mut())
            });
            expect(&mut slave, "free NULL", fmi2OK, |s| {
                fmi2FreeFMUstate(s.c, &mut null_mut())
            });
            expect(&mut slave, "free nothing", fmi2OK, |s| {
                fmi2FreeFMUstate(s.c, null_mut())
            });
            expect(&mut slave, "save nowhere", fmi2Error, |s| {
                fmi2GetFMUstate(s.c, null_mut())
            });
            expect(&mut slave, "size of NULL", fmi2Error, |s| {
                fmi2SerializedFMUstateSize(s.c, null_mut(), place)
            });
            let state = slave.save();
            expect(&mut slave, "size nowhere", fmi2Error, |s| {
                fmi2SerializedFMUstateSize(s.c, state, null_mut())
            });
            expect(&mut slave, "serialise nowhere", fmi2Error, |s| {
                fmi2SerializeFMUstate(s.c, state, null_mut(), 1 << 16)
            });
            expect(&mut slave, "no room", fmi2Error, |s| {
                fmi2SerializeFMUstate(s.c, state, room, 10)
            });
            expect(&mut slave, "bytes from nowhere", fmi2Error, |s| {
                fmi2DeSerializeFMUstate(s.c, null(), 10, &mut null_mut())
            });
            expect(&mut slave, "bytes to nowhere", fmi2Error, |s| {
                fmi2DeSerializeFMUstate(s.c, room, 10, null_mut())
            });
            slave.forget(state);
        }
    }
}

#[test]
fn garbage_bytes_are_refused() {
    let mut slave = Slave::reach(State::StepComplete);
    let bytes = slave.bytes();
    let mut refused = |what: &str, bytes: &[u8]| {
        expect(&mut slave, what, fmi2Error, |s| {
            let mut state = null_mut();
            let status = s.read(bytes, &mut state);
            assert!(state.is_null());
            status
        });
    };
    refused("nothing", &[]);
    refused("zeros", &[0; 500]);
    refused("half", &bytes[..bytes.len() / 2]);
    refused("more", &[&bytes[..], &[0]].concat());
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x40;
        refused("damaged", &damaged);
    }
}

/// What keeps out bytes that someone made: whatever is accepted must behave like an instance.
#[test]
fn made_up_bytes_are_refused_or_harmless() {
    let origin = Slave::reach(State::StepComplete);
    let bytes = origin.bytes();
    let body = bytes.len() - CHECKSUM;
    let mut reader = tests::fuzz::Reader::<fmu::RearLoadBicycle>::new();
    let mut accepted = 0;
    for at in 0..body {
        for flip in [0x01, 0xff] {
            let mut made_up = bytes.clone();
            made_up[at] ^= flip;
            let made_up = tests::fuzz::with_checksum(&made_up);
            accepted += u32::from(reader.read(&made_up));
        }
    }
    // low bits of parameters, inputs and states make another bicycle, as good as this one
    assert!(accepted > 0);
}
