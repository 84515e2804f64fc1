//! The C functions of the bicycle, each called in each state, and in every wrong way.
//!
//! What is expected stands here as FMI 2.0 says it, not as the exporter's own table does.

mod calls;
mod experiment;
mod life_cycle;
mod misuse;
mod states;
mod values;

use fmi2::{fmi2Discard, fmi2Error, fmi2OK, fmi2Status};
use tests::Slave;

/// Runs a call, and checks what goes with its status: an obeyed call says nothing; a refused one
/// says so in one line, and leaves the state as it was, to the last bit.
#[track_caller]
fn expect(
    slave: &mut Slave,
    what: &str,
    expected: fmi2Status,
    call: impl Fn(&mut Slave) -> fmi2Status,
) {
    Slave::lines();
    let before = slave.bytes();
    let status = call(slave);
    let lines = Slave::lines();
    assert_eq!(status, expected, "{what}: {lines:?}");
    if expected == fmi2OK {
        assert_eq!(lines, [], "{what}");
        return;
    }
    let [line] = &lines[..] else {
        panic!("{what}: expected one line, found {lines:?}");
    };
    let category = if expected == fmi2Discard {
        "logStatusDiscard"
    } else {
        "logStatusError"
    };
    assert_eq!(line.environment, Slave::ENVIRONMENT, "{what}");
    assert_eq!(line.instance.as_deref(), Some("slave"), "{what}");
    assert_eq!(line.status, expected, "{what}");
    assert_eq!(line.category.as_deref(), Some(category), "{what}");
    let message = line.message.as_deref().expect("a message");
    assert!(
        !message.is_empty() && !message.contains('\n'),
        "{what}: {message}"
    );
    if expected == fmi2Error {
        assert!(slave.bytes() == before, "{what}: the state changed");
    }
}
