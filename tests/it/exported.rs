//! A bicycle, or what a fit found, handed on: as parameter set of SSP and as bicycle file.

use crate::wobble::{json, wobble};
use bicycle::{Input, Parameters};
use fmi_import::Archive;
use fmi_import::model_description::VariableType;
use fmi_import::model_description::ssp::{ParameterSet, ParameterValue};
use identify::run::Run;
use std::path::Path;
use tempfile::TempDir;

fn folder() -> TempDir {
    tempfile::tempdir().expect("temporary folder")
}

#[track_caller]
fn run(folder: &Path, call: &str) {
    let called = wobble(folder, call);
    assert_eq!(called.code, 0, "wobble {call}: {}", called.err);
}

/// Each row but the excitation's by name and value, and the formulation; JSON gives every number
/// back to the last bit.
fn listed(folder: &Path, arguments: &str) -> Vec<(String, serde_json::Value)> {
    let rows = json(folder, &format!("parameters {arguments} --json"));
    let rows = rows.as_array().expect("rows").iter();
    rows.filter(|row| row["kind"] != "excitation")
        .map(|row| (row["name"].to_string(), row["value"].clone()))
        .collect()
}

fn parameter_set(folder: &Path) -> ParameterSet {
    let text = std::fs::read_to_string(folder.join("x.ssv")).expect("written");
    ParameterSet::from_xml(&text).expect("a parameter set")
}

/// The set has each row with its unit, and the formulation, and the FMU in packed.fmu starts from
/// just these.
#[track_caller]
fn same_as_packed(folder: &Path, set: &ParameterSet) {
    let archive = Archive::open(&folder.join("packed.fmu")).expect("an FMU");
    let description = archive.description();
    assert_eq!(
        set.parameters.len(),
        Parameters::LEN + Input::TABLE.len() + 1
    );
    for row in Parameters::TABLE.iter().chain(Input::TABLE) {
        let found = set.parameters.iter().find(|found| found.name == row.name);
        let ParameterValue::Real { value, unit } = &found.expect(row.name).value else {
            panic!("{}: {found:?}", row.name);
        };
        assert_eq!(unit.as_deref(), Some(row.unit.symbol), "{}", row.name);
        let defined = set.units.iter().find(|unit| unit.name == row.unit.symbol);
        let base = defined.expect(row.unit.symbol).base;
        let exponents = [base.kg, base.m, base.s, base.rad].map(i64::from);
        let expected = [row.unit.kg, row.unit.m, row.unit.s, row.unit.rad].map(i64::from);
        assert_eq!((exponents, base.factor), (expected, 1.0), "{}", row.name);
        let variable = description.variable(row.name).expect(row.name);
        let VariableType::Real(real) = &variable.variable_type else {
            panic!("{}: {variable:?}", row.name);
        };
        let start = real.start.expect(row.name);
        assert_eq!(value.to_bits(), start.to_bits(), "{}", row.name);
    }
}

#[test]
fn a_changed_bicycle_comes_back_from_its_file_and_starts_the_fmu() {
    let folder = folder();
    for arguments in [
        "--load 20kg --set trail=-35mm --set speed=8km/h",
        "--bicycle sbw-delft --set assist_torque=0.3",
    ] {
        run(
            folder.path(),
            &format!("parameters {arguments} --ssv x.ssv --toml x.toml"),
        );
        assert_eq!(
            listed(folder.path(), "--bicycle x.toml"),
            listed(folder.path(), arguments)
        );
        run(folder.path(), &format!("fmu {arguments} -o packed.fmu"));
        same_as_packed(folder.path(), &parameter_set(folder.path()));
    }
    let formulation = parameter_set(folder.path())
        .parameters
        .into_iter()
        .find(|parameter| parameter.name == "formulation")
        .expect("the formulation");
    let expected = ParameterValue::Enumeration {
        value: "whipple".to_owned(),
        name: Some("Formulation".to_owned()),
    };
    assert_eq!(formulation.value, expected);
}

#[test]
fn what_a_fit_found_is_handed_on() {
    let folder = folder();
    let ride = "simulate --ride --torque --set remnant_intensity=2 -o ride.csv";
    run(folder.path(), ride);
    run(folder.path(), "fit ride.csv -o fit.json");
    run(
        folder.path(),
        "parameters --fit fit.json --load 10kg --ssv x.ssv --toml x.toml",
    );
    run(
        folder.path(),
        "fmu --parameters fit.json --load 10kg -o packed.fmu",
    );
    let set = parameter_set(folder.path());
    same_as_packed(folder.path(), &set);
    let fit = Run::read(&folder.path().join("fit.json")).expect("a fit");
    let found = fit.fit.estimate("cornering_stiffness").expect("fitted");
    let mut parameters = set.parameters.iter();
    let written = parameters.find(|parameter| parameter.name == "cornering_stiffness");
    assert!(matches!(
        written.expect("a row").value,
        ParameterValue::Real { value, .. } if value == found.value
    ));
    assert_eq!(
        listed(folder.path(), "--bicycle x.toml"),
        listed(folder.path(), "--fit fit.json --load 10kg")
    );
    // and packs as the fit does
    run(folder.path(), "fmu --bicycle x.toml -o packed.fmu");
    same_as_packed(folder.path(), &set);
}

#[test]
fn exports_that_cannot_be() {
    let folder = folder();
    for (call, code, message) in [
        ("parameters --ssv x.ssv --json", 2, "cannot be used with"),
        ("parameters --fit none.json --ssv x.ssv", 1, "none.json"),
        (
            "parameters --fit fit.json --bicycle section3",
            2,
            "cannot be used with",
        ),
        ("parameters --toml none/x.toml", 1, "none/x.toml"),
    ] {
        let called = wobble(folder.path(), call);
        assert_eq!(called.code, code, "wobble {call}: {}", called.err);
        assert!(called.err.contains(message), "{}", called.err);
    }
    assert!(!folder.path().join("x.ssv").exists());
}
