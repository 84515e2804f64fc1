//! What is in an FMU, in words.

use crate::output::Output;
use anyhow::Result;
use fmi_import::model_description::DefaultExperiment;
use fmi_import::{Archive, Inspection, Severity, VariableRow};
use std::fmt::Write as _;
use std::path::Path;

/// Tells what is in the FMU and what is odd about it.
pub fn inspect(path: &Path, output: &Output) -> Result<()> {
    let found = Archive::open(path)?.inspect();
    output.json_or(&found, || describe(path, &found))
}

fn describe(path: &Path, found: &Inspection) -> String {
    let mut text = format!("{}: {}", path.display(), found.model_name);
    if let Some(version) = &found.version {
        let _ = write!(text, " {version}");
    }
    text.push('\n');
    let mut line = |what: &str, words: String| {
        if !words.is_empty() {
            let _ = writeln!(text, "  {what:13} {words}");
        }
    };
    let given = |words: &Option<String>| words.clone().unwrap_or_default();
    line("description", given(&found.description));
    line("author", given(&found.author));
    line("licence", given(&found.license));
    let made = [&found.generation_tool, &found.generation_date_and_time];
    let made: Vec<&str> = made.into_iter().flatten().map(String::as_str).collect();
    line("made by", made.join(", "));
    let kinds = [
        (found.co_simulation, "co-simulation"),
        (found.model_exchange, "model exchange"),
    ];
    let kinds: Vec<&str> = kinds.iter().filter(|k| k.0).map(|k| k.1).collect();
    line(
        "FMI",
        format!("{}, {}", found.fmi_version, kinds.join(" and ")),
    );
    line("guid", found.guid.clone());
    line("platforms", found.platforms.join(", "));
    if let Some(experiment) = found.default_experiment {
        line("experiment", describe_experiment(experiment));
    }
    let capabilities = found.capabilities.iter().filter(|c| c.value > 0);
    let capabilities: Vec<String> = capabilities
        .map(|c| match c.name {
            "maxOutputDerivativeOrder" => format!("{} {}", c.name, c.value),
            name => name.to_owned(),
        })
        .collect();
    line("capabilities", capabilities.join(", "));
    let units: Vec<String> = found
        .units
        .iter()
        .map(|unit| match unit.display_units.as_slice() {
            [] => unit.name.clone(),
            others => format!("{} ({})", unit.name, others.join(", ")),
        })
        .collect();
    line("units", units.join(", "));
    text.push_str(&table(&found.variables));
    for oddity in &found.oddities {
        let severity = match oddity.severity {
            Severity::Fault => "fault",
            Severity::Remark => "remark",
        };
        let _ = writeln!(text, "{severity}: {oddity}");
    }
    text
}

fn describe_experiment(experiment: DefaultExperiment) -> String {
    let DefaultExperiment {
        start_time,
        stop_time,
        tolerance,
        step_size,
    } = experiment;
    let parts = [
        start_time.map(|time| format!("from {time} s")),
        stop_time.map(|time| format!("to {time} s")),
        step_size.map(|step| format!("in steps of {step} s")),
        tolerance.map(|tolerance| format!("tolerance {tolerance}")),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

fn table(variables: &[VariableRow]) -> String {
    let range = |v: &VariableRow| match (v.min, v.max) {
        (None, None) => String::new(),
        (min, max) => {
            let end = |end: Option<f64>| end.map_or_else(String::new, |end| end.to_string());
            format!("{}…{}", end(min), end(max))
        }
    };
    let heads = [
        "name",
        "type",
        "kind",
        "unit",
        "start",
        "range",
        "description",
    ];
    let mut rows = vec![heads.map(str::to_owned)];
    rows.extend(variables.iter().map(|v| {
        [
            v.name.clone(),
            v.type_name.to_owned(),
            format!("{} {}", v.variability, v.causality),
            v.unit.clone().unwrap_or_default(),
            v.start_text().unwrap_or_default(),
            range(v),
            v.description.clone().unwrap_or_default(),
        ]
    }));
    let width = |column: usize| {
        let widths = rows
            .iter()
            .map(|row: &[String; 7]| row[column].chars().count());
        widths.max().unwrap_or(0)
    };
    let widths: [usize; 7] = std::array::from_fn(width);
    let mut text = String::new();
    for row in &rows {
        let mut line = String::new();
        for (cell, width) in row.iter().zip(widths) {
            let _ = write!(line, "  {cell:width$}");
        }
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}
