//! `wobble cases` from outside, and the measured bicycles by name.

use crate::wobble::{json, wobble};

#[test]
fn every_formulation_rides_the_cases() {
    let folder = tempfile::tempdir().expect("a folder");
    for formulation in bicycle::Formulation::ALL {
        let name = formulation.name();
        let call = format!("cases --bicycle section3 --formulation {name} -o {name}.svg --json");
        let said = json(folder.path(), &call);
        assert_eq!(said["formulation"], name);
        let cases = said["cases"].as_array().expect("cases");
        assert_eq!(cases.len(), 9);
        for case in cases {
            let ended = case["stop"] != "end";
            assert_eq!(case["amplitude_deg"].is_null(), ended, "{name}: {case}");
            assert!(case["early_reversals"].is_u64(), "{name}: {case}");
        }
        let figure = std::fs::read_to_string(folder.path().join(format!("{name}.svg")));
        assert!(figure.expect("drawn").contains("trail −0.035 m"));
    }
}

#[test]
fn loads_stand_in_for_centres_of_mass() {
    let folder = tempfile::tempdir().expect("a folder");
    let said = json(
        folder.path(),
        "cases --bicycle browser-jason --loads 0,10kg,20 --json",
    );
    assert_eq!(said["formulation"], "whipple", "what its file says");
    let cases = said["cases"].as_array().expect("cases");
    let loads: Vec<_> = cases
        .iter()
        .map(|case| case["rear_load"].as_f64())
        .collect();
    let thrice = [Some(0.0), Some(10.0), Some(20.0)].repeat(3);
    assert_eq!(loads, thrice);
    // without a load on the trail of the set it is the set itself: its rider holds it
    let damping = |case: &serde_json::Value| case["least_damped"]["damping_ratio"].as_f64();
    assert!(cases.iter().all(|case| damping(case) > Some(0.0)));
    let alone = json(
        folder.path(),
        "cases --bicycle browser-jason --loads 20 --json",
    );
    assert_eq!(
        alone["cases"][0]["amplitude_deg"],
        cases[2]["amplitude_deg"]
    );
}

#[test]
fn loads_that_are_none_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    for (call, code, words) in [
        (
            "--loads=-5",
            2,
            "--loads -5: rear_load: expected 0 to 100 kg",
        ),
        (
            "--loads 0,200",
            2,
            "--loads 200: rear_load: expected 0 to 100 kg",
        ),
        ("--loads 3m", 2, "expected a unit of the dimension of kg"),
        ("--loads 0,,10", 2, "expected a number"),
        ("--loads 10 --load 5", 2, "cannot be used with"),
        (
            "--loads 0,60 --set rear_load_x=-0.9",
            1,
            "case 2: expected a front wheel on the ground",
        ),
        ("--bicycle browser-jasn", 2, "nearest: browser-jason"),
    ] {
        let called = wobble(folder.path(), &format!("cases {call}"));
        assert_eq!(called.code, code, "{call}: {}", called.err);
        assert!(called.err.contains(words), "{call}: {}", called.err);
        assert_eq!(called.out, "", "{call}");
    }
}

#[test]
fn a_light_front_wheel_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let set = "--set rear_load_x=-0.9";
    for call in [
        format!("parameters --load 31kg {set}"),
        format!("simulate --duration 1s --load 31kg {set}"),
        format!("cases --loads 31 {set}"),
    ] {
        let called = wobble(folder.path(), &call);
        assert_eq!(called.code, 0, "{call}: {}", called.err);
        let words = "the front wheel carries 2.8 % of the weight";
        assert!(called.err.contains(words), "{call}: {}", called.err);
    }
}
