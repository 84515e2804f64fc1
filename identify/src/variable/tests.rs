use super::*;
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
