use super::*;
use expect_test::expect;
use proptest::prelude::*;

fn real(name: &str, value_reference: u32, causality: Causality) -> ScalarVariable {
    ScalarVariable {
        name: name.to_owned(),
        value_reference,
        description: None,
        causality,
        variability: Variability::Continuous,
        initial: None,
        variable_type: VariableType::Real(RealVariable {
            unit: Some("m/s".to_owned()),
            ..RealVariable::default()
        }),
    }
}

/// Parameters of the four types that are not `Real`.
fn parameters() -> Vec<ScalarVariable> {
    let parameter = |name: &str, value_reference, variable_type| ScalarVariable {
        causality: Causality::Parameter,
        variability: Variability::Fixed,
        variable_type,
        ..real(name, value_reference, Causality::Parameter)
    };
    vec![
        parameter(
            "horses",
            2,
            VariableType::Integer(IntegerVariable {
                start: Some(2),
                ..IntegerVariable::default()
            }),
        ),
        parameter(
            "loaded",
            3,
            VariableType::Boolean(BooleanVariable {
                start: Some(true),
                ..BooleanVariable::default()
            }),
        ),
        parameter(
            "owner",
            4,
            VariableType::String(StringVariable {
                start: Some(String::new()),
                ..StringVariable::default()
            }),
        ),
        parameter(
            "gait",
            5,
            VariableType::Enumeration(EnumerationVariable {
                declared_type: "Gait".to_owned(),
                start: Some(1),
                ..EnumerationVariable::default()
            }),
        ),
    ]
}

/// One of everything.
pub(crate) fn cart() -> ModelDescription {
    let mut speed = real("speed", 0, Causality::Input);
    speed.variable_type = VariableType::Real(RealVariable {
        unit: Some("m/s".to_owned()),
        display_unit: Some("km/h".to_owned()),
        min: Some(0.0),
        start: Some(8.0 / 3.6),
        ..RealVariable::default()
    });
    ModelDescription {
        model_name: "Cart".to_owned(),
        guid: "{1}".to_owned(),
        description: Some("\"carts\" & <horses>".to_owned()),
        co_simulation: Some(CoSimulation {
            model_identifier: "Cart".to_owned(),
            can_handle_variable_communication_step_size: true,
            ..CoSimulation::default()
        }),
        units: vec![Unit {
            name: "m/s".to_owned(),
            base: Some(BaseUnit {
                m: 1,
                s: -1,
                ..BaseUnit::default()
            }),
            display_units: vec![DisplayUnit {
                name: "km/h".to_owned(),
                factor: 3.6,
                offset: 0.0,
            }],
        }],
        types: vec![
            SimpleType {
                name: "Gait".to_owned(),
                description: None,
                definition: TypeDefinition::Enumeration(EnumerationType {
                    quantity: None,
                    items: vec![Item {
                        name: "trot".to_owned(),
                        value: 1,
                        description: None,
                    }],
                }),
            },
            SimpleType {
                name: "Flag".to_owned(),
                description: None,
                definition: TypeDefinition::Boolean,
            },
        ],
        log_categories: vec![Category {
            name: "logStatusError".to_owned(),
            description: None,
        }],
        default_experiment: Some(DefaultExperiment {
            start_time: Some(0.0),
            stop_time: Some(24.0),
            tolerance: Some(1e-4),
            step_size: Some(0.005),
        }),
        variables: [speed, real("position", 1, Causality::Output)]
            .into_iter()
            .chain(parameters())
            .collect(),
        structure: ModelStructure {
            outputs: vec![Unknown {
                index: 2,
                dependencies: Some(vec![]),
                dependencies_kind: None,
            }],
            derivatives: vec![],
            initial_unknowns: vec![Unknown {
                index: 2,
                dependencies: Some(vec![1, 3]),
                dependencies_kind: Some(vec![DependencyKind::Constant, DependencyKind::Dependent]),
            }],
        },
        ..ModelDescription::default()
    }
}

#[test]
fn the_text_is_what_the_schema_wants() {
    expect![[r#"
        <?xml version="1.0" encoding="UTF-8"?>
        <fmiModelDescription fmiVersion="2.0" modelName="Cart" guid="{1}" description="&quot;carts&quot; &amp; &lt;horses&gt;" variableNamingConvention="flat">
          <CoSimulation modelIdentifier="Cart" needsExecutionTool="false" canHandleVariableCommunicationStepSize="true" canInterpolateInputs="false" maxOutputDerivativeOrder="0" canRunAsynchronuously="false" canBeInstantiatedOnlyOncePerProcess="false" canNotUseMemoryManagementFunctions="false" canGetAndSetFMUstate="false" canSerializeFMUstate="false" providesDirectionalDerivative="false"/>
          <UnitDefinitions>
            <Unit name="m/s">
              <BaseUnit m="1" s="-1"/>
              <DisplayUnit name="km/h" factor="3.6"/>
            </Unit>
          </UnitDefinitions>
          <TypeDefinitions>
            <SimpleType name="Gait">
              <Enumeration>
                <Item name="trot" value="1"/>
              </Enumeration>
            </SimpleType>
            <SimpleType name="Flag">
              <Boolean/>
            </SimpleType>
          </TypeDefinitions>
          <LogCategories>
            <Category name="logStatusError"/>
          </LogCategories>
          <DefaultExperiment startTime="0" stopTime="24" tolerance="0.0001" stepSize="0.005"/>
          <ModelVariables>
            <ScalarVariable name="speed" valueReference="0" causality="input" variability="continuous">
              <Real unit="m/s" displayUnit="km/h" min="0" start="2.2222222222222223"/>
            </ScalarVariable>
            <ScalarVariable name="position" valueReference="1" causality="output" variability="continuous">
              <Real unit="m/s"/>
            </ScalarVariable>
            <ScalarVariable name="horses" valueReference="2" causality="parameter" variability="fixed">
              <Integer start="2"/>
            </ScalarVariable>
            <ScalarVariable name="loaded" valueReference="3" causality="parameter" variability="fixed">
              <Boolean start="true"/>
            </ScalarVariable>
            <ScalarVariable name="owner" valueReference="4" causality="parameter" variability="fixed">
              <String start=""/>
            </ScalarVariable>
            <ScalarVariable name="gait" valueReference="5" causality="parameter" variability="fixed">
              <Enumeration declaredType="Gait" start="1"/>
            </ScalarVariable>
          </ModelVariables>
          <ModelStructure>
            <Outputs>
              <Unknown index="2" dependencies=""/>
            </Outputs>
            <InitialUnknowns>
              <Unknown index="2" dependencies="1 3" dependenciesKind="constant dependent"/>
            </InitialUnknowns>
          </ModelStructure>
        </fmiModelDescription>
    "#]].assert_eq(&cart().to_xml().expect("writable"));
}

#[test]
fn reading_what_was_written_gives_the_same_value() {
    for description in [cart(), ModelDescription::default()] {
        let xml = description.to_xml().expect("writable");
        assert_eq!(
            ModelDescription::from_xml(&xml).expect("readable"),
            description
        );
    }
}

#[test]
fn unknown_elements_attributes_comments_and_a_byte_order_mark_are_ignored() {
    let xml = cart().to_xml().expect("writable");
    let (head, tail) = xml.split_once("<ModelVariables>").expect("element");
    let (first, rest) = tail.split_once("</ScalarVariable>").expect("element");
    let foreign = format!(
        "\u{feff}{}<VendorAnnotations><Tool name=\"x\"><deep/>text</Tool></VendorAnnotations>\
         <ModelVariables><!-- remark -->{}<Annotations><Tool name=\"y\"/></Annotations>\
         </ScalarVariable><Strange odd=\"1\"/>{}",
        head.replace(
            "modelName=",
            "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" \
             xsi:noNamespaceSchemaLocation=\"fmi2.xsd\" novel=\"1\" modelName="
        ),
        first,
        rest
    );
    assert_eq!(
        ModelDescription::from_xml(&foreign).expect("tolerated"),
        cart()
    );
}

#[test]
fn what_is_no_description_is_refused_with_a_reason() {
    let check = |xml: &str, reason: &str| {
        let error = ModelDescription::from_xml(xml).expect_err("refused");
        assert!(error.to_string().contains(reason), "{error}");
    };
    check("", "expected an FMI 2.0 model description");
    check("<html/>", "fmiVersion");
    check(
        "<fmiModelDescription fmiVersion=\"3.0\" modelName=\"a\" guid=\"b\"/>",
        "expected fmiVersion \"2.0\", found \"3.0\"",
    );
    check(
        "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"a\" guid=\"b\"><ModelVariables>\
         <ScalarVariable name=\"x\" valueReference=\"0\"/></ModelVariables></fmiModelDescription>",
        "ScalarVariable \"x\": expected one of Real",
    );
}

#[test]
fn the_fingerprint_knows_what_binaries_must_agree_with() {
    let guid = cart().fingerprint();
    let groups: Vec<usize> = guid[1..guid.len() - 1].split('-').map(str::len).collect();
    assert_eq!(groups, [8, 4, 4, 4, 12]);

    let mut same = cart();
    same.guid = guid.clone();
    same.generation_tool = Some("wobble 9".to_owned());
    same.generation_date_and_time = Some("2026-01-01T00:00:00Z".to_owned());
    for variable in &mut same.variables {
        if let VariableType::Real(real) = &mut variable.variable_type {
            real.start = Some(1.0);
        }
    }
    assert_eq!(same.fingerprint(), guid);

    let mut other = cart();
    other.variables[1].value_reference = 7;
    assert_ne!(other.fingerprint(), guid);
    let mut other = cart();
    other.structure.outputs[0].dependencies = None;
    assert_ne!(other.fingerprint(), guid);
}

#[test]
fn initial_defaults_follow_the_standard() {
    let check = |causality, variability, initial| {
        let variable = ScalarVariable {
            variability,
            ..real("x", 0, causality)
        };
        assert_eq!(variable.initial(), initial, "{causality:?} {variability:?}");
    };
    check(
        Causality::Parameter,
        Variability::Tunable,
        Some(Initial::Exact),
    );
    check(
        Causality::CalculatedParameter,
        Variability::Fixed,
        Some(Initial::Calculated),
    );
    check(
        Causality::Output,
        Variability::Continuous,
        Some(Initial::Calculated),
    );
    check(
        Causality::Local,
        Variability::Constant,
        Some(Initial::Exact),
    );
    check(Causality::Input, Variability::Continuous, None);
    check(Causality::Independent, Variability::Continuous, None);
}

proptest! {
    /// Any finite number and any text survive, bit for bit.
    #[test]
    fn numbers_and_texts_survive(
        start in proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL,
        text in "[ -~äθ²]{0,40}",
    ) {
        let mut description = cart();
        description.description = Some(text);
        description.variables[0].variable_type = VariableType::Real(RealVariable {
            start: Some(start),
            ..RealVariable::default()
        });
        let xml = description.to_xml().expect("writable");
        let back = ModelDescription::from_xml(&xml).expect("readable");
        prop_assert_eq!(back, description);
    }
}
