//! What the fuzzer found worth keeping, through the same functions.

use std::path::Path;
use tests::fuzz::{Gauge, Reader, archive, description};

/// Replays the corpus of `target`, of which a part can be read and a part cannot: else it would
/// not be worth keeping.
#[track_caller]
fn replay(target: &str, mut read: impl FnMut(&[u8]) -> bool) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fuzz/corpus")
        .join(target);
    let (mut accepted, mut refused) = (0, 0);
    for file in std::fs::read_dir(folder).expect("a corpus") {
        let bytes = std::fs::read(file.expect("a file").path()).expect("readable");
        if read(&bytes) {
            accepted += 1;
        } else {
            refused += 1;
        }
    }
    assert!(
        accepted > 0 && refused > 0,
        "{target}: {accepted} accepted, {refused} refused"
    );
}

#[test]
fn descriptions() {
    replay("description", description);
}

#[test]
fn archives() {
    replay("archive", archive);
}

#[test]
fn states() {
    let mut bicycle = Reader::<fmu::RearLoadBicycle>::new();
    let mut gauge = Reader::<Gauge>::new();
    replay("state", |body| {
        bicycle.read_body(body) | gauge.read_body(body)
    });
}
