#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]

use super::*;
use fmi_import::model_description::BaseUnit;

fn row(name: &str, causality: &'static str, unit: Option<&str>, start: f64) -> VariableRow {
    VariableRow {
        name: name.into(),
        value_reference: 7,
        type_name: "Real",
        causality,
        variability: "continuous",
        unit: unit.map(str::to_owned),
        start: Some(Value::Real(start)),
        min: None,
        max: None,
        choices: Vec::new(),
        description: None,
    }
}

/// A unit an FMU defines as `factor` of rad.
fn angle(name: &str, factor: f64, exponent: i32) -> model_description::Unit {
    model_description::Unit {
        name: name.into(),
        base: Some(BaseUnit {
            kg: 0,
            m: 0,
            s: 0,
            ampere: 0,
            kelvin: 0,
            mol: 0,
            cd: 0,
            rad: exponent,
            factor,
            offset: 0.0,
        }),
        display_units: Vec::new(),
    }
}

fn quantity(name: &str) -> &'static Quantity {
    &Output::TABLE[Output::index(name).unwrap()]
}

#[test]
fn values_come_in_our_units_and_signs() {
    // by the FMU's definition, by a symbol of ours, and as they are; an angle may be a number
    let units = [angle("grad", 0.5, 1), angle("number", 1.0, 0)];
    let rows = vec![
        row("delta", "output", Some("grad"), 3.0),
        row("theta", "output", Some("deg"), 180.0),
        row("phi", "output", None, 0.25),
        row("psi", "output", Some("number"), 0.25),
    ];
    let variables = Variables {
        rows,
        units: &units,
    };
    let meant = |name: &str| {
        let own = variables
            .counterpart(name, quantity("steer"), &["output"])
            .unwrap();
        let start = own.start().unwrap();
        // there and back
        assert!((own.si(own.own(start)) - start).abs() < 1e-15, "{name}");
        start
    };
    assert_eq!(meant("delta"), 1.5);
    assert_eq!(meant("-delta"), -1.5);
    assert!((meant("theta") - std::f64::consts::PI).abs() < 1e-15);
    assert_eq!(meant("phi"), 0.25);
    assert_eq!(meant("psi"), 0.25);
}

#[test]
fn what_cannot_stand_for_a_row_is_refused() {
    let units = [angle("grad", 0.5, 1)];
    let variables = Variables {
        rows: vec![
            row("delta", "output", Some("grad"), 0.0),
            row("mass", "parameter", Some("kg"), 0.0),
        ],
        units: &units,
    };
    let refused = |name: &str, of: &str, causality| {
        let error = variables.counterpart(name, quantity(of), &[causality]);
        error.unwrap_err().to_string()
    };
    assert_eq!(
        refused("delta", "steer_rate", "output"),
        "delta: expected a unit of the dimension of rad/s, found `grad`"
    );
    assert_eq!(
        refused("mass", "steer", "parameter"),
        "mass: expected a unit of the dimension of rad, found `kg`"
    );
    assert_eq!(
        refused("mass", "steer", "output"),
        "steer: expected a Real output of the FMU, found mass, parameter Real"
    );
    assert!(refused("deltb", "steer", "output").contains("delta"));
}

#[test]
fn names_that_are_ours_need_no_line() {
    let variables = Variables {
        rows: vec![
            row("steer", "output", Some("rad"), 0.0),
            row("rate", "output", Some("rad/s"), 0.0),
            row("roll", "input", Some("rad"), 0.0),
            row("roll_start", "parameter", Some("rad"), 0.0),
        ],
        units: &[],
    };
    let written = BTreeMap::from([("roll_rate".to_owned(), "rate".to_owned())]);
    let found = variables
        .table("output", &written, Output::TABLE, "", &["output"])
        .unwrap();
    let names: Vec<&str> = found.iter().map(|(i, _)| Output::TABLE[*i].name).collect();
    assert_eq!(names, ["steer", "roll_rate"]);
    let none = BTreeMap::new();
    let starts = variables
        .table("state", &none, State::TABLE, "_start", &["parameter"])
        .unwrap();
    assert_eq!(starts.len(), 1);
    let misspelt = BTreeMap::from([("stear".to_owned(), "steer".to_owned())]);
    let error = variables
        .table("output", &misspelt, Output::TABLE, "", &["output"])
        .unwrap_err();
    assert!(error.to_string().contains("steer"), "{error}");
}
