//! What an inspection finds.

use crate::build::Variant;
use fmi_import::{Archive, Inspection, Severity, Value};

fn inspect(variant: &Variant) -> Inspection {
    let (_folder, path) = variant.pack();
    Archive::open(&path).expect("an FMU").inspect()
}

/// The rules by which an FMU with `edits` is odd.
fn rules(edits: &[(&str, &str)]) -> Vec<&'static str> {
    let variant = Variant {
        edits,
        ..Variant::default()
    };
    let oddities = inspect(&variant).oddities;
    oddities.iter().map(|oddity| oddity.rule).collect()
}

#[test]
fn what_is_in_it_is_told_and_nothing_is_odd() {
    let found = inspect(&Variant::default());
    assert_eq!(found.model_name, "Mass on a spring");
    assert_eq!(found.generation_tool.as_deref(), Some("by hand"));
    assert!(found.co_simulation && !found.model_exchange);
    let capability = |name| {
        let all = &found.capabilities;
        all.iter().find(|c| c.name == name).map(|c| c.value)
    };
    assert_eq!(capability("canGetAndSetFMUstate"), Some(1));
    assert_eq!(capability("needsExecutionTool"), Some(0));
    assert_eq!(found.platforms.len(), 1);
    assert_eq!(found.units[0].si.as_deref(), Some("m"));
    assert_eq!(found.units[0].display_units, ["mm"]);
    assert_eq!(found.units[2].si.as_deref(), Some("m.s-2"));
    let mass = &found.variables[0];
    assert_eq!(mass.start, Some(Value::Real(2.0)));
    // from its declared type
    assert_eq!(
        (mass.unit.as_deref(), mass.min, mass.max),
        (Some("kg"), Some(0.1), Some(100.0))
    );
    assert_eq!((mass.causality, mass.variability), ("parameter", "fixed"));
    let refuse = &found.variables[8];
    assert_eq!(refuse.start_text().as_deref(), Some("nothing"));
    assert_eq!(refuse.choices.len(), 6);
    assert_eq!(found.oddities, []);
}

/// What is written in place of what, and the rule that this breaks.
const ODD: &[(&str, &str, &str)] = &[
    ("fmiVersion=\"2.0\"", "fmiVersion=\"2.0.3\"", "fmi-version"),
    ("guid=\"{f0e1}\"", "guid=\"\"", "no-guid"),
    ("generationTool=\"by hand\"", "", "no-generation-tool"),
    (
        "<DefaultExperiment startTime=\"1\" stopTime=\"2\" stepSize=\"0.1\"/>",
        "",
        "no-default-experiment",
    ),
    ("stepSize=\"0.1\"", "", "no-step-size"),
    ("stopTime=\"2\"", "stopTime=\"1\"", "stop-time"),
    (
        "modelIdentifier=\"foreign\"",
        "modelIdentifier=\"else\"",
        "no-binary",
    ),
    (
        "canRunAsynchronuously=\"true\"",
        "needsExecutionTool=\"true\"",
        "needs-execution-tool",
    ),
    (
        "canRunAsynchronuously=\"true\"",
        "canBeInstantiatedOnlyOncePerProcess=\"true\"",
        "only-once",
    ),
    (
        "canHandleVariableCommunicationStepSize=\"true\"",
        "",
        "fixed-step",
    ),
    ("name=\"velocity\"", "name=\"position\"", "duplicate-name"),
    ("description=\"Velocity\"", "", "no-description"),
    (
        "causality=\"output\" variability=\"discrete\" description=\"Number",
        "causality=\"output\" description=\"Number",
        "continuous-not-real",
    ),
    (
        "variability=\"tunable\"",
        "variability=\"continuous\"",
        "variability",
    ),
    ("unit=\"N\" start=\"0\"", "unit=\"N\"", "no-start"),
    (
        "<Real unit=\"m\"/>",
        "<Real unit=\"m\" start=\"1\"/>",
        "needless-start",
    ),
    ("start=\"2\"/>", "start=\"0.01\"/>", "start-out-of-range"),
    ("max=\"100\"", "max=\"0.01\"", "empty-range"),
    (
        "start=\"0\"/>\n    </ScalarVariable>\n    <ScalarVariable name=\"held\"",
        "start=\"9\"/>\n    </ScalarVariable>\n    <ScalarVariable name=\"held\"",
        "start-no-item",
    ),
    (
        "declaredType=\"Mass\"",
        "declaredType=\"Muss\"",
        "declared-type",
    ),
    (
        "declaredType=\"Refuse\"",
        "declaredType=\"Mass\"",
        "declared-type",
    ),
    (
        "declaredType=\"Refuse\"",
        "declaredType=\"Mass\"",
        "no-items",
    ),
    ("<Real unit=\"m/s\"/>", "<Real/>", "no-unit"),
    (
        "<Real unit=\"m/s\"/>",
        "<Real unit=\"mph\"/>",
        "undefined-unit",
    ),
    ("<BaseUnit m=\"1\" s=\"-2\"/>", "", "unit-without-meaning"),
    (
        "<Unknown index=\"5\" dependencies=\"\"/>",
        "",
        "output-not-in-structure",
    ),
    (
        "<Unknown index=\"5\" dependencies=\"\"/>",
        "<Unknown index=\"5\"/>",
        "no-dependencies",
    ),
    (
        "<Unknown index=\"5\" dependencies=\"\"/>",
        "<Unknown index=\"1\" dependencies=\"\"/>",
        "no-output",
    ),
    (
        "<Unknown index=\"5\" dependencies=\"\"/>",
        "<Unknown index=\"5\" dependencies=\"99\"/>",
        "index",
    ),
    (
        "dependenciesKind=\"fixed\"",
        "dependenciesKind=\"fixed fixed\"",
        "dependencies-kind",
    ),
];

#[test]
fn what_is_odd_is_found() {
    for &(from, to, rule) in ODD {
        let found = rules(&[(from, to)]);
        assert!(found.contains(&rule), "{rule}: {found:?}");
    }
}

#[test]
fn model_exchange_only_cannot_be_run() {
    let found = rules(&[
        ("<CoSimulation", "<ModelExchange"),
        ("</CoSimulation", "</ModelExchange"),
    ]);
    assert_eq!(found, ["model-exchange-only"]);
}

#[test]
fn faults_come_first_and_name_whom_they_concern() {
    let variant = Variant {
        edits: &[
            ("description=\"Velocity\"", ""),
            ("<Real unit=\"m/s\"/>", "<Real unit=\"mph\"/>"),
        ],
        files: &[
            ("notes.txt", ""),
            ("tmp/x", ""),
            ("extra/x", ""),
            ("binaries/x86_64-linux/foreign.so", ""),
        ],
        ..Variant::default()
    };
    let oddities = inspect(&variant).oddities;
    let told: Vec<String> = oddities.iter().map(ToString::to_string).collect();
    assert_eq!(
        told,
        [
            "units missing from UnitDefinitions: mph",
            "files the standard gives no meaning to: notes.txt, tmp/x",
            "binaries for platforms FMI 2.0 does not name: x86_64-linux",
            "variables without description: velocity",
        ]
    );
    assert_eq!(oddities[0].severity, Severity::Fault);
    assert_eq!(oddities[1].severity, Severity::Remark);
}
