use super::cart::{Cart, FORCE, MASS};
use super::host::{Host, SHARED, callbacks, text};
use crate::{Model, ffi, start};
use fmi2::{fmi2CoSimulation, fmi2OK};
use std::path::Path;
use tempfile::TempDir;

/// A folder with `start.json`, if there is a text for it.
fn resources(json: Option<&str>) -> TempDir {
    let folder = tempfile::Builder::new()
        .prefix("a b")
        .tempdir()
        .expect("a temporary folder");
    if let Some(json) = json {
        std::fs::write(folder.path().join(start::FILE_NAME), json).expect("written");
    }
    folder
}

/// An instance whose resources are `folder`, or what it says.
fn instantiate(folder: &Path) -> Result<Host, Vec<String>> {
    let location = format!("file://{}", folder.display()).replace(' ', "%20");
    let (guid, location) = (text(&Cart::description().fingerprint()), text(&location));
    let log = Box::<super::host::Log>::default();
    let given = callbacks(&log);
    // SAFETY: all texts are null-terminated, the callbacks valid.
    let c = unsafe {
        ffi::instantiate(
            &SHARED,
            c"cart".as_ptr(),
            fmi2CoSimulation,
            guid.as_ptr(),
            location.as_ptr(),
            &raw const given,
            0,
            1,
        )
    };
    if c.is_null() {
        return Err(std::mem::take(&mut *log.lock().expect("one thread")));
    }
    Ok(Host::of(c, log))
}

#[test]
fn start_values_come_from_the_file_and_reset_goes_back_to_them() {
    let mut description = Cart::description();
    for variable in &mut description.variables {
        if let model_description::VariableType::Real(real) = &mut variable.variable_type
            && variable.name == "mass"
        {
            real.start = Some(0.1 + 0.2);
        }
    }
    let folder = resources(Some(&start::to_json(&description)));
    let mut host = instantiate(folder.path()).expect("an instance");
    for _ in 0..2 {
        super::host::run(&mut host, "setup enter");
        assert_eq!(host.get(MASS).to_bits(), (0.1_f64 + 0.2).to_bits());
        assert_eq!(host.get(FORCE), 1.0);
        assert_eq!(host.set(MASS, 5.0), fmi2OK);
        super::host::run(&mut host, "exit step reset");
    }
}

#[test]
fn without_the_file_the_compiled_values_hold() {
    let folder = resources(None);
    let mut host = instantiate(folder.path()).expect("an instance");
    super::host::run(&mut host, "setup enter");
    assert_eq!(host.get(MASS), 2.0);
    assert!(instantiate(&folder.path().join("none")).is_ok());
}

#[test]
fn a_file_that_does_not_fit_makes_no_instance_and_one_line() {
    let guid = Cart::description().fingerprint();
    let check = |json: &str, expected: &str| {
        let folder = resources(Some(json));
        let lines = instantiate(folder.path()).err().expect("refused");
        assert!(lines.len() == 1 && lines[0].contains(expected), "{lines:?}");
        assert!(lines[0].contains("start.json"), "{lines:?}");
    };
    let start = |values: &str| format!("{{\"guid\": \"{guid}\", \"start\": {{{values}}}}}");
    check("no json", "expected");
    check("{}", "missing field");
    check("{\"guid\": \"{0}\", \"start\": {}}", "guid: expected {");
    check(
        &start("\"mast\": 1.0"),
        "expected a variable of the model, found mast",
    );
    check(&start("\"mass\": true"), "mass: expected a call for Real");
    check(
        &start("\"mass\": 0.01"),
        "mass: expected a value in [0.1, inf]",
    );
    check(&start("\"gait\": 7"), "gait: expected a value in [1, 2]");
    check(
        &start("\"position\": 1.0"),
        "position (Output, Continuous) cannot be set",
    );
    let folder = resources(Some(&start("\"mass\": 3, \"gait\": 2")));
    let host = instantiate(folder.path()).expect("a whole number is a Real too");
    assert_eq!(host.set(FORCE, 1.0), fmi2OK);
}
