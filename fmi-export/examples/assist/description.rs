//! What the descriptions of both assists have in common.

use fmi_export::Row;
use fmi_export::model_description::{BaseUnit, DefaultExperiment, ModelDescription};

/// The description of an assist called `name`, its units in those of the SI.
pub fn describe(name: &str, what: &str, rows: &[Row]) -> ModelDescription {
    let mut description = ModelDescription {
        author: Some("the wobble authors".to_owned()),
        version: Some(env!("CARGO_PKG_VERSION").to_owned()),
        copyright: Some("the wobble authors".to_owned()),
        license: Some(env!("CARGO_PKG_LICENSE").to_owned()),
        default_experiment: Some(DefaultExperiment {
            start_time: Some(0.0),
            stop_time: Some(20.0),
            tolerance: None,
            step_size: Some(0.005),
        }),
        ..fmi_export::describe(name, what, rows)
    };
    for unit in &mut description.units {
        unit.base = Some(base(&unit.name));
    }
    description
}

/// Exponents of kg, m, s and rad.
fn base(unit: &str) -> BaseUnit {
    let [kg, m, s, rad] = match unit {
        "s" => [0, 0, 1, 0],
        "Hz" => [0, 0, -1, 0],
        "rad" => [0, 0, 0, 1],
        "rad/s" => [0, 0, -1, 1],
        "m/s" => [0, 1, -1, 0],
        "kg.m2" => [1, 2, 0, 0],
        "N.m" => [1, 2, -2, 0],
        "N.m/s" => [1, 2, -3, 0],
        "N.m/rad" => [1, 2, -2, -1],
        "N.m.s/rad" => [1, 2, -1, -1],
        _ => panic!("{unit} has no meaning yet"),
    };
    BaseUnit {
        kg,
        m,
        s,
        rad,
        ..BaseUnit::default()
    }
}
