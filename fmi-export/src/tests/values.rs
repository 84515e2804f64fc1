use super::cart::{
    ACCELERATION, BRAKED, COUNT, Cart, DRAG, FORCE, GAIT, MASS, OWNER, POSITION, TIME, WHEELS,
};
use super::host::{Host, check, run, text};
use crate::variables::Variables;
use crate::{Model, ffi};
use fmi2::{fmi2Error, fmi2OK};
use std::ffi::CStr;
use std::ptr::{null, null_mut};

#[test]
fn every_type_travels_both_ways() {
    let host = check("setup enter");
    assert_eq!(host.set(MASS, 4.0), fmi2OK);
    assert_eq!(host.get(MASS), 4.0);
    assert_eq!(host.set_integer(WHEELS, 6), fmi2OK);
    assert_eq!(host.set_integer(GAIT, 2), fmi2OK);
    let mut integers = [0; 2];
    let mut flag = 7;
    let (owner, mut found) = (text("Ä %s"), null());
    let owner = owner.as_ptr();
    // SAFETY: arrays as long as said.
    unsafe {
        let references = [GAIT, WHEELS];
        let status = ffi::get::<Cart, i32>(host.c, references.as_ptr(), 2, integers.as_mut_ptr());
        assert_eq!((status, integers), (fmi2OK, [2, 6]));
        ffi::set_boolean::<Cart>(host.c, &BRAKED, 1, &raw const flag);
        ffi::get_boolean::<Cart>(host.c, &BRAKED, 1, &raw mut flag);
        assert_eq!(flag, 1);
        ffi::set_string::<Cart>(host.c, &OWNER, 1, &raw const owner);
        ffi::get_string::<Cart>(host.c, &OWNER, 1, &raw mut found);
        assert_eq!(CStr::from_ptr(found).to_str(), Ok("Ä %s"));
    }
}

#[test]
fn outputs_follow_what_is_set_at_once() {
    let mut host = check("setup enter");
    assert_eq!(host.get(ACCELERATION), 0.5);
    host.set(FORCE, 3.0);
    assert_eq!(host.get(ACCELERATION), 1.5);
    run(&mut host, "exit");
    host.set(FORCE, 4.0);
    assert_eq!(host.get(ACCELERATION), 2.0);
}

#[test]
fn values_out_of_place_are_refused_and_change_nothing() {
    let host = check("setup enter");
    let check = |reference, value, expected: &str| {
        assert_eq!(host.set(reference, value), fmi2Error, "{expected}");
        let log = host.log();
        assert!(log.len() == 1 && log[0].ends_with(expected), "{log:?}");
    };
    check(
        FORCE,
        f64::NAN,
        "variable force: expected a finite value, found NaN",
    );
    check(
        FORCE,
        f64::INFINITY,
        "variable force: expected a finite value, found inf",
    );
    check(
        MASS,
        0.0,
        "variable mass: expected a value in [0.1, inf], found 0",
    );
    check(
        DRAG,
        9.1,
        "variable drag: expected a value in [-inf, 9], found 9.1",
    );
    check(
        WHEELS,
        1.0,
        "variable wheels: expected a call for Integer, found one for Real",
    );
    check(COUNT, 1.0, "expected a value reference below 11, found 11");
    check(
        TIME,
        1.0,
        "(Independent, Continuous) cannot be set in state initialization mode",
    );
    assert_eq!(host.set_integer(WHEELS, 1), fmi2Error);
    assert_eq!(host.set_integer(GAIT, 3), fmi2Error);
    assert_eq!(host.set_integer(GAIT, 0), fmi2Error);
    assert_eq!(host.set_integer(MASS, 1), fmi2Error);
    // the first of two is valid, and yet not taken
    let (references, values) = ([FORCE, MASS], [9.0, -1.0]);
    // SAFETY: two elements each.
    let status = unsafe { ffi::set::<Cart, f64>(host.c, references.as_ptr(), 2, values.as_ptr()) };
    assert_eq!(status, fmi2Error);
    assert_eq!((host.get(FORCE), host.get(MASS)), (1.0, 2.0));
}

#[test]
fn null_arrays_are_fine_only_when_empty() {
    let host = check("setup enter");
    let (reference, value) = (MASS, 1.0);
    // SAFETY: NULL arrays, some with a length: what is tested.
    unsafe {
        let c = host.c;
        assert_eq!(ffi::get::<Cart, f64>(c, null(), 0, null_mut()), fmi2OK);
        assert_eq!(ffi::get_boolean::<Cart>(c, null(), 0, null_mut()), fmi2OK);
        assert_eq!(ffi::get_string::<Cart>(c, null(), 0, null_mut()), fmi2OK);
        assert_eq!(ffi::set::<Cart, i32>(c, null(), 0, null()), fmi2OK);
        assert_eq!(ffi::set_boolean::<Cart>(c, null(), 0, null()), fmi2OK);
        assert_eq!(ffi::set_string::<Cart>(c, null(), 0, null()), fmi2OK);
        assert!(host.log().is_empty());
        assert_eq!(ffi::get::<Cart, f64>(c, null(), 1, null_mut()), fmi2Error);
        assert_eq!(
            ffi::get::<Cart, f64>(c, &raw const reference, 1, null_mut()),
            fmi2Error
        );
        assert_eq!(
            ffi::set::<Cart, f64>(c, null(), 1, &raw const value),
            fmi2Error
        );
        assert_eq!(
            ffi::set::<Cart, f64>(c, &raw const reference, 1, null()),
            fmi2Error
        );
        let nothing = null();
        assert_eq!(
            ffi::set_string::<Cart>(c, &OWNER, 1, &raw const nothing),
            fmi2Error
        );
        assert_eq!(host.log().len(), 5);
    }
}

#[test]
fn texts_that_are_not_utf8_are_refused() {
    let host = Host::new(true);
    let latin = c"\xc4rger".as_ptr();
    // SAFETY: one element each.
    let status = unsafe { ffi::set_string::<Cart>(host.c, &OWNER, 1, &raw const latin) };
    assert_eq!(status, fmi2Error);
    assert_eq!(
        host.log(),
        ["cart 3 logStatusError argument value: expected UTF-8, found other bytes"]
    );
}

#[test]
fn a_description_whose_value_references_are_no_row_numbers_is_refused() {
    let mut description = Cart::description();
    description.variables[POSITION as usize].value_reference = 99;
    let error = Variables::new(&description).expect_err("refused");
    assert_eq!(
        error.to_string(),
        "model description: variable position: expected value reference 7, its row number, found 99"
    );
}
