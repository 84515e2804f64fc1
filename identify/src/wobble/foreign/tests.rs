use super::*;
use clap::Parser;
use clap::error::ErrorKind;
use fmi_import::model_description::DisplayUnit;

fn kelvin() -> Unit {
    Unit {
        name: "K".into(),
        display_units: vec![DisplayUnit {
            name: "degC".into(),
            factor: 1.0,
            offset: -273.15,
        }],
        ..Unit::default()
    }
}

#[test]
fn a_number_is_in_the_variables_unit_or_carries_its_own() {
    let units = [kelvin()];
    for (unit, text, expected) in [
        (Some("m/s"), "8", 8.0),
        (Some("m/s"), "8km/h", 8.0 * 1000.0 / 3600.0),
        (Some("km/h"), "8 km/h", 8.0),
        (Some("mm"), "2m", 2000.0),
        (Some("m"), "5mm", 0.005),
        (Some("bar"), "2bar", 2.0),
        (Some("K"), "20 degC", 293.15),
        (Some("K"), "-1e2K", -100.0),
        (None, "0.5", 0.5),
    ] {
        let found = real(&units, unit, "x", text).expect("a number");
        assert_eq!(found, expected, "{text}");
    }
    for (unit, text, expected) in [
        (
            Some("m/s"),
            "8kg",
            "x [m/s]: expected a unit of the dimension of m/s, found `kg`",
        ),
        (
            Some("bar"),
            "8kg",
            "x [bar]: expected a number or a number with a unit, found `8kg`",
        ),
        (
            None,
            "8kg",
            "x: expected a number or a number with a unit, found `8kg`",
        ),
        (
            Some("m"),
            "inf",
            "x [m]: expected a number or a number with a unit, found `inf`",
        ),
    ] {
        let error = real(&units, unit, "x", text).expect_err("refused");
        assert_eq!(error.to_string(), expected);
    }
}

fn variable(type_name: &'static str) -> VariableRow {
    VariableRow {
        name: "a[1,2]".into(),
        value_reference: 0,
        type_name,
        causality: "parameter",
        variability: "fixed",
        unit: None,
        start: None,
        min: None,
        max: None,
        choices: vec![("trot".into(), 3)],
        description: None,
    }
}

#[test]
fn texts_become_values_of_the_variables_type() {
    for (type_name, text, expected) in [
        ("Integer", "-7", Value::Integer(-7)),
        ("Boolean", "true", Value::Boolean(true)),
        ("String", "a=b", Value::String("a=b".into())),
        ("Enumeration", "trot", Value::Integer(3)),
        ("Enumeration", "5", Value::Integer(5)),
    ] {
        let found = parse(&[], &variable(type_name), text).expect("a value");
        assert_eq!(found, expected);
    }
    for (type_name, text, expected) in [
        ("Integer", "1.5", "expected an integer, found `1.5`"),
        ("Boolean", "yes", "expected true or false, found `yes`"),
        (
            "Enumeration",
            "tort",
            "unknown choice `tort`; nearest: trot",
        ),
    ] {
        let error = parse(&[], &variable(type_name), text).expect_err("refused");
        assert_eq!(error.to_string(), expected);
    }
}

#[test]
fn a_name_with_a_comma_is_one_cell() {
    let trajectory = Trajectory {
        names: vec!["time".into(), "a[1,2]".into()],
        columns: vec![vec![0.0, 0.5], vec![1.0, 1e-7]],
        ended: None,
    };
    assert_eq!(
        to_csv(&trajectory, &[variable("Real")]),
        "time[s],\"a[1,2]\"\n0,1\n0.5,0.0000001\n"
    );
}

#[test]
fn what_belongs_to_the_bicycle_is_refused_for_an_fmu() {
    let parse = |arguments: &[&str]| {
        let start = ["wobble", "simulate"].iter().chain(arguments);
        crate::Program::try_parse_from(start).map(|_| ())
    };
    for alone in [
        &["--bicycle", "nominal"][..],
        &["--load", "5"],
        &["--rider", "75kg,1.8m"],
        &["--formulation", "printed"],
        &["--at", "5s:speed=3"],
        &["--ride"],
    ] {
        assert!(parse(alone).is_ok(), "{alone:?}");
        let both: Vec<&str> = ["--fmu", "x.fmu"].iter().chain(alone).copied().collect();
        let error = parse(&both).expect_err("refused");
        assert_eq!(error.kind(), ErrorKind::ArgumentConflict, "{alone:?}");
    }
    for alone in [&["--start", "1s"][..], &["--record", "x"]] {
        let error = parse(alone).expect_err("refused");
        assert_eq!(error.kind(), ErrorKind::MissingRequiredArgument);
    }
    let all = [
        "--fmu",
        "x.fmu",
        "--set",
        "a=1",
        "--duration",
        "1s",
        "--step",
        "5ms",
    ];
    assert!(parse(&all).is_ok());
}
