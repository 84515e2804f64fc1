//! In which order things are freed, and libraries that do not fit.

use crate::build::Variant;
use crate::calls::{set, started};
use fmi_import::{Error, Fmu, Value};
use std::path::PathBuf;

#[test]
fn states_go_before_their_instance_and_it_before_its_library() {
    let (folder, path) = Variant::default().pack();
    let trace = folder.path().join("trace");
    let fmu = Fmu::open(&path).expect("loaded");
    let mut instance = started(&fmu);
    let trace_text = trace.to_str().expect("UTF-8").to_owned();
    set(&mut instance, "trace", &Value::String(trace_text));
    let resources = fmu.description().variable("resources").expect("a variable");
    let Value::String(resources) = instance.get(resources).expect("read") else {
        panic!("expected a text");
    };
    let resources = resources.strip_prefix("file://").map(PathBuf::from);
    let resources = resources.expect("a file URI");
    assert!(resources.join("here.txt").is_file());

    let saved = instance.get_fmu_state().expect("saved");
    instance.terminate().expect("terminated");
    // the wrong way round
    drop(instance);
    drop(saved);
    drop(fmu);
    assert_eq!(
        std::fs::read_to_string(&trace).expect("written"),
        "terminate\nfree state\nfree instance\nunload with resources\n"
    );
    assert!(!resources.exists());
    assert!(!resources.parent().expect("the archive's").exists());
}

#[test]
fn a_library_that_does_not_fit_is_refused() {
    #[track_caller]
    fn check(define: &'static str, expected: &str) {
        let (_folder, path) = Variant {
            defines: &[define],
            ..Variant::default()
        }
        .pack();
        let error = Fmu::open(&path).expect_err("refused");
        assert!(error.to_string().ends_with(expected), "{error}");
    }
    check("VERSION=\"1.0\"", "to return \"2.0\", found \"1.0\"");
    check("VERSION=0", "to return \"2.0\", found \"\"");
    check(
        "TYPES=\"standard32\"",
        "to return \"default\", found \"standard32\"",
    );

    let (_folder, path) = Variant {
        without_binary: true,
        files: &[("binaries/linux64/foreign.so", "no library")],
        ..Variant::default()
    }
    .pack();
    let error = Fmu::open(&path).expect_err("refused");
    assert!(
        matches!(error, Error::NoLibrary { .. } | Error::NoBinary { .. }),
        "{error}"
    );
}

#[test]
fn instances_in_threads_do_not_meet() {
    let fmu = Variant::default().load();
    std::thread::scope(|scope| {
        for n in 0..8 {
            let fmu = &fmu;
            scope.spawn(move || {
                let mut instance = started(fmu);
                let force = f64::from(n);
                set(&mut instance, "force", &Value::Real(force));
                instance.do_step(0.0, 0.5).expect("a step");
                let position = crate::calls::real(&mut instance, "position");
                // about F/k: the rounding of a sum of numbers of about 1
                let expected = force / 8.0 + (1.0 - force / 8.0) * 1.0_f64.cos();
                assert!((position - expected).abs() < 1e-15);
            });
        }
    });
}
