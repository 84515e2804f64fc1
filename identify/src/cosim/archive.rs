//! What is coupled, as an SSP archive, for other tools: without the native rider, whom none has.

use super::RIDER;
use super::coupling::Coupling;
use crate::error::{Error, Result};
use fmi_import::Value;
use fmi_import::master::Connection;
use fmi_import::ssp::{self, Component, System};
use std::path::Path;

/// Writes the FMUs with their start values and connections to `out`. A rider who follows a course
/// or has a remnant cannot travel; one who only holds speed and torque travels as start values.
pub fn write_ssp(coupling: &Coupling, out: &Path) -> Result<()> {
    let rides = match &coupling.bicycle {
        _ if coupling.has_course() => Some("one who follows a course"),
        Some(bicycle) if bicycle.excitation.remnant_intensity > 0.0 => Some("one with a remnant"),
        _ => None,
    };
    if let Some(found) = rides {
        let expected = "a rider who is the law in the plant: no other travels in an SSP";
        return Err(Error::Form {
            expected,
            found: found.into(),
        }
        .typed("--ssp"));
    }
    let variation = coupling.as_typed();
    let master = coupling.master(&variation)?;
    let (of_rider, connections): (Vec<&Connection>, Vec<&Connection>) = master
        .connections()
        .iter()
        .partition(|connection| connection.source.participant == RIDER);
    let components = coupling.present(&variation).map(|opened| {
        let mut start_values = coupling.starts_of(opened, &variation);
        // what the rider holds
        for connection in of_rider
            .iter()
            .filter(|c| c.target.participant == opened.name)
        {
            let held = coupling.held(&connection.source.variable);
            start_values.retain(|(name, _)| *name != connection.target.variable);
            start_values.push((connection.target.variable.clone(), Value::Real(held)));
        }
        Component {
            name: opened.name.clone(),
            fmu: opened.file.clone(),
            start_values,
        }
    });
    let system = System {
        name: "wobble".to_owned(),
        components: components.collect(),
        connections: connections.into_iter().cloned().collect(),
        start_time: Some(0.0),
        stop_time: Some(coupling.stop()),
    };
    Ok(ssp::write(&system, out)?)
}
