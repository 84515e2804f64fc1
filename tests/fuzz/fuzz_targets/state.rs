//! Serialised states under a right header and checksum, of the bicycle and of a model of all types.
#![no_main]

use std::cell::RefCell;
use tests::fuzz::{Gauge, Reader};

thread_local! {
    static BICYCLE: RefCell<Reader<fmu::RearLoadBicycle>> = RefCell::default();
    static GAUGE: RefCell<Reader<Gauge>> = RefCell::default();
}

libfuzzer_sys::fuzz_target!(|body: &[u8]| {
    BICYCLE.with_borrow_mut(|bicycle| bicycle.read_body(body));
    GAUGE.with_borrow_mut(|gauge| gauge.read_body(body));
});
