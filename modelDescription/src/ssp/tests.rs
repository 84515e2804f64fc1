use super::*;
use expect_test::expect;
use proptest::prelude::*;

fn metre() -> Unit {
    Unit {
        name: "m".to_owned(),
        base: BaseUnit {
            m: 1,
            ..BaseUnit::default()
        },
    }
}

fn connector(name: &str, kind: ConnectorKind, connector_type: Option<ConnectorType>) -> Connector {
    Connector {
        name: name.to_owned(),
        kind,
        connector_type,
    }
}

fn parameter(name: &str, value: ParameterValue) -> Parameter {
    Parameter {
        name: name.to_owned(),
        description: None,
        value,
    }
}

/// One of every type.
fn harness() -> ParameterSet {
    ParameterSet {
        name: "harness".to_owned(),
        parameters: vec![
            Parameter {
                description: Some("of the trace".to_owned()),
                ..parameter(
                    "horse.length",
                    ParameterValue::Real {
                        value: 2.5,
                        unit: Some("m".to_owned()),
                    },
                )
            },
            parameter("horse.hooves", ParameterValue::Integer(4)),
            parameter("cart.loaded", ParameterValue::Boolean(false)),
            parameter("cart.owner", ParameterValue::String(String::new())),
            parameter(
                "horse.gait",
                ParameterValue::Enumeration {
                    value: "trot".to_owned(),
                    name: Some("Gait".to_owned()),
                },
            ),
        ],
        enumerations: vec![Enumeration {
            name: "Gait".to_owned(),
            items: vec![Item {
                name: "trot".to_owned(),
                value: 1,
            }],
        }],
        units: vec![metre()],
        ..ParameterSet::default()
    }
}

/// One of everything.
fn team() -> SystemStructureDescription {
    use ConnectorKind::{CalculatedParameter, Inout, Input, Output, Parameter};
    let enumeration = ConnectorType::Enumeration {
        name: "Gait".to_owned(),
    };
    let real = |unit: Option<&str>| {
        let unit = unit.map(str::to_owned);
        Some(ConnectorType::Real { unit })
    };
    let binding = |prefix: &str, source| ParameterBinding {
        prefix: prefix.to_owned(),
        source,
    };
    SystemStructureDescription {
        version: VERSION.to_owned(),
        name: "team".to_owned(),
        generation_tool: Some("test".to_owned()),
        system: System {
            name: "team".to_owned(),
            description: Some("\"carts\" & <horses>".to_owned()),
            connectors: vec![connector("position", Output, None)],
            parameter_bindings: vec![
                binding("", ParameterSource::File("resources/team.ssv".to_owned())),
                binding("horse.", ParameterSource::Inline(harness())),
            ],
            components: vec![
                Component {
                    name: "horse".to_owned(),
                    source: "resources/Horse.fmu".to_owned(),
                    implementation: Implementation::CoSimulation,
                    connectors: vec![
                        connector("pull", Output, real(None)),
                        connector("hooves", Parameter, Some(ConnectorType::Integer)),
                        connector("name", CalculatedParameter, Some(ConnectorType::String)),
                        connector("gait", Output, Some(enumeration)),
                    ],
                    parameter_bindings: vec![binding(
                        "",
                        ParameterSource::File("resources/horse.ssv".to_owned()),
                    )],
                },
                Component {
                    name: "cart".to_owned(),
                    source: "resources/Cart.fmu".to_owned(),
                    connectors: vec![
                        connector("pull", Input, real(None)),
                        connector("position", Output, real(Some("m"))),
                        connector("loaded", Inout, Some(ConnectorType::Boolean)),
                    ],
                    ..Component::default()
                },
            ],
            connections: vec![
                Connection {
                    start_element: Some("horse".to_owned()),
                    start_connector: "pull".to_owned(),
                    end_element: Some("cart".to_owned()),
                    end_connector: "pull".to_owned(),
                    suppress_unit_conversion: true,
                },
                Connection {
                    start_element: Some("cart".to_owned()),
                    start_connector: "position".to_owned(),
                    end_connector: "position".to_owned(),
                    ..Connection::default()
                },
            ],
        },
        enumerations: harness().enumerations,
        units: vec![metre()],
        default_experiment: Some(DefaultExperiment {
            start_time: None,
            stop_time: Some(24.0),
        }),
    }
}

#[test]
fn start_values_are_those_of_the_description() {
    let set = ParameterSet::of_starts(&crate::tests::cart());
    let found: Vec<String> = set
        .parameters
        .iter()
        .map(|parameter| format!("{} {:?}", parameter.name, parameter.value))
        .collect();
    assert_eq!(
        found,
        [
            "speed Real { value: 2.2222222222222223, unit: Some(\"m/s\") }",
            "horses Integer(2)",
            "loaded Boolean(true)",
            "owner String(\"\")",
            "gait Enumeration { value: \"trot\", name: Some(\"Gait\") }",
        ]
    );
    assert_eq!(set.units.len(), 1);
    assert_eq!(set.enumerations, harness().enumerations);
}

fn written(description: &SystemStructureDescription) -> String {
    description.to_xml().expect("writable")
}

#[test]
fn the_text_is_what_the_schema_wants() {
    expect![[r#"
        <?xml version="1.0" encoding="UTF-8"?>
        <ssd:SystemStructureDescription xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" name="team" generationTool="test">
          <ssd:System name="team" description="&quot;carts&quot; &amp; &lt;horses&gt;">
            <ssd:Connectors>
              <ssd:Connector name="position" kind="output"/>
            </ssd:Connectors>
            <ssd:ParameterBindings>
              <ssd:ParameterBinding source="resources/team.ssv"/>
              <ssd:ParameterBinding prefix="horse.">
                <ssd:ParameterValues>
                  <ssv:ParameterSet version="1.0" name="harness">
                    <ssv:Parameters>
                      <ssv:Parameter name="horse.length" description="of the trace">
                        <ssv:Real value="2.5" unit="m"/>
                      </ssv:Parameter>
                      <ssv:Parameter name="horse.hooves">
                        <ssv:Integer value="4"/>
                      </ssv:Parameter>
                      <ssv:Parameter name="cart.loaded">
                        <ssv:Boolean value="false"/>
                      </ssv:Parameter>
                      <ssv:Parameter name="cart.owner">
                        <ssv:String value=""/>
                      </ssv:Parameter>
                      <ssv:Parameter name="horse.gait">
                        <ssv:Enumeration value="trot" name="Gait"/>
                      </ssv:Parameter>
                    </ssv:Parameters>
                    <ssv:Enumerations>
                      <ssc:Enumeration name="Gait">
                        <ssc:Item name="trot" value="1"/>
                      </ssc:Enumeration>
                    </ssv:Enumerations>
                    <ssv:Units>
                      <ssc:Unit name="m">
                        <ssc:BaseUnit m="1"/>
                      </ssc:Unit>
                    </ssv:Units>
                  </ssv:ParameterSet>
                </ssd:ParameterValues>
              </ssd:ParameterBinding>
            </ssd:ParameterBindings>
            <ssd:Elements>
              <ssd:Component name="horse" type="application/x-fmu-sharedlibrary" source="resources/Horse.fmu" implementation="CoSimulation">
                <ssd:Connectors>
                  <ssd:Connector name="pull" kind="output">
                    <ssc:Real/>
                  </ssd:Connector>
                  <ssd:Connector name="hooves" kind="parameter">
                    <ssc:Integer/>
                  </ssd:Connector>
                  <ssd:Connector name="name" kind="calculatedParameter">
                    <ssc:String/>
                  </ssd:Connector>
                  <ssd:Connector name="gait" kind="output">
                    <ssc:Enumeration name="Gait"/>
                  </ssd:Connector>
                </ssd:Connectors>
                <ssd:ParameterBindings>
                  <ssd:ParameterBinding source="resources/horse.ssv"/>
                </ssd:ParameterBindings>
              </ssd:Component>
              <ssd:Component name="cart" type="application/x-fmu-sharedlibrary" source="resources/Cart.fmu">
                <ssd:Connectors>
                  <ssd:Connector name="pull" kind="input">
                    <ssc:Real/>
                  </ssd:Connector>
                  <ssd:Connector name="position" kind="output">
                    <ssc:Real unit="m"/>
                  </ssd:Connector>
                  <ssd:Connector name="loaded" kind="inout">
                    <ssc:Boolean/>
                  </ssd:Connector>
                </ssd:Connectors>
              </ssd:Component>
            </ssd:Elements>
            <ssd:Connections>
              <ssd:Connection startElement="horse" startConnector="pull" endElement="cart" endConnector="pull" suppressUnitConversion="true"/>
              <ssd:Connection startElement="cart" startConnector="position" endConnector="position"/>
            </ssd:Connections>
          </ssd:System>
          <ssd:Enumerations>
            <ssc:Enumeration name="Gait">
              <ssc:Item name="trot" value="1"/>
            </ssc:Enumeration>
          </ssd:Enumerations>
          <ssd:Units>
            <ssc:Unit name="m">
              <ssc:BaseUnit m="1"/>
            </ssc:Unit>
          </ssd:Units>
          <ssd:DefaultExperiment stopTime="24"/>
        </ssd:SystemStructureDescription>
    "#]].assert_eq(&written(&team()));
}

#[test]
fn the_text_of_parameters_is_what_the_schema_wants() {
    expect![[r#"
        <?xml version="1.0" encoding="UTF-8"?>
        <ssv:ParameterSet xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" name="harness">
          <ssv:Parameters>
            <ssv:Parameter name="horse.length" description="of the trace">
              <ssv:Real value="2.5" unit="m"/>
            </ssv:Parameter>
            <ssv:Parameter name="horse.hooves">
              <ssv:Integer value="4"/>
            </ssv:Parameter>
            <ssv:Parameter name="cart.loaded">
              <ssv:Boolean value="false"/>
            </ssv:Parameter>
            <ssv:Parameter name="cart.owner">
              <ssv:String value=""/>
            </ssv:Parameter>
            <ssv:Parameter name="horse.gait">
              <ssv:Enumeration value="trot" name="Gait"/>
            </ssv:Parameter>
          </ssv:Parameters>
          <ssv:Enumerations>
            <ssc:Enumeration name="Gait">
              <ssc:Item name="trot" value="1"/>
            </ssc:Enumeration>
          </ssv:Enumerations>
          <ssv:Units>
            <ssc:Unit name="m">
              <ssc:BaseUnit m="1"/>
            </ssc:Unit>
          </ssv:Units>
        </ssv:ParameterSet>
    "#]].assert_eq(&harness().to_xml().expect("writable"));
}

#[test]
fn reading_what_was_written_gives_the_same_value() {
    let smallest = SystemStructureDescription {
        generation_tool: None,
        system: System::default(),
        enumerations: Vec::new(),
        units: Vec::new(),
        default_experiment: None,
        ..team()
    };
    for description in [team(), smallest] {
        let back = SystemStructureDescription::from_xml(&written(&description));
        assert_eq!(back.expect("readable"), description);
    }
    for set in [harness(), ParameterSet::default()] {
        let back = ParameterSet::from_xml(&set.to_xml().expect("writable"));
        assert_eq!(back.expect("readable"), set);
    }
}

#[test]
fn any_prefix_will_do() {
    // the description's namespace without prefix, another prefix for the common one
    let xml = written(&team())
        .replace("xmlns:ssd=", "xmlns=")
        .replace("<ssd:", "<")
        .replace("</ssd:", "</")
        .replace("ssc", "common");
    assert!(xml.contains("<common:Real"), "{xml}");
    assert_eq!(
        SystemStructureDescription::from_xml(&xml).expect("readable"),
        team()
    );
}

#[test]
fn what_is_not_held_is_dropped() {
    let xml = format!("\u{feff}{}", written(&team()))
        .replace(
            "<ssd:Elements>",
            "<!-- remark --><ssd:Elements><x:Component xmlns:x=\"urn:x\" name=\"\"/>",
        )
        .replace(
            "</ssd:Component>",
            "<ssc:Annotations><ssc:Annotation type=\"x\"><ssd:Component/> text</ssc:Annotation>\
             </ssc:Annotations></ssd:Component>",
        )
        .replace(
            "<ssd:Connector ",
            "<ssd:Connector xmlns:x=\"urn:x\" x:kind=\"y\" id=\"c\" ",
        )
        .replace(
            "</ssd:Connections>",
            "</ssd:Connections><ssd:SystemGeometry x1=\"0\" y1=\"0\" x2=\"1\" y2=\"1\"/>",
        );
    assert_eq!(
        SystemStructureDescription::from_xml(&xml).expect("tolerated"),
        team()
    );
}

#[track_caller]
fn check(xml: &str, reason: &str) {
    let error = SystemStructureDescription::from_xml(xml).expect_err("refused");
    assert!(error.to_string().contains(reason), "{error}");
}

#[test]
fn what_is_no_description_is_refused_with_a_reason() {
    check("", "expected a system structure description of SSP 1");
    check("<html/>", "found the element html");
    check(
        &harness().to_xml().expect("writable"),
        "SystemStructureParameterValues}ssv:ParameterSet",
    );
    check(
        &written(&team()).replace(
            "version=\"1.0\" name=\"team\"",
            "version=\"2.0\" name=\"t\"",
        ),
        "found version \"2.0\"",
    );
    let nothing = "<ssv:ParameterSet xmlns:ssv=\"http://ssp-standard.org/SSP1/\
                   SystemStructureParameterValues\" version=\"1.0\" name=\"n\"><ssv:Parameters>\
                   <ssv:Parameter name=\"x\"/></ssv:Parameters></ssv:ParameterSet>";
    let error = ParameterSet::from_xml(nothing).expect_err("refused");
    assert!(
        error
            .to_string()
            .contains("Parameter \"x\": expected one of Real"),
        "{error}"
    );
}

#[test]
fn what_cannot_be_held_is_refused_by_name() {
    let with = |before: &str, added: &str| {
        written(&team()).replacen(before, &format!("{added}{before}"), 1)
    };
    let elements = "</ssd:Elements>";
    check(
        &with(elements, "<ssd:System name=\"inner\"/>"),
        "expected a system of components only, found the system \"inner\"",
    );
    check(
        &with(
            elements,
            "<ssd:SignalDictionaryReference name=\"bus\" dictionary=\"d\"/>",
        ),
        "found the signal dictionary reference \"bus\"",
    );
    check(
        &with(
            elements,
            "<ssd:Component name=\"p\" type=\"application/x-ssp-package\" source=\"p.ssp\"/>",
        ),
        "component \"p\": expected the type \"application/x-fmu-sharedlibrary\", found",
    );
    check(
        &with(
            "</ssd:Connections>",
            "<ssd:Connection startConnector=\"a\" endConnector=\"b\">\
             <ssc:LinearTransformation factor=\"2\"/></ssd:Connection>",
        ),
        "connection of \"a\" with \"b\": expected no transformation",
    );
    let bindings = "</ssd:ParameterBindings>";
    for (binding, reason) in [
        (
            "<ssd:ParameterBinding source=\"a.ssv\"><ssd:ParameterMapping source=\"a.ssm\"/>\
             </ssd:ParameterBinding>",
            "expected no parameter mapping",
        ),
        (
            "<ssd:ParameterBinding type=\"x\" source=\"a\"/>",
            "found \"x\"",
        ),
        (
            "<ssd:ParameterBinding sourceBase=\"component\" source=\"a\"/>",
            "found \"component\"",
        ),
        ("<ssd:ParameterBinding/>", "found neither"),
    ] {
        check(&with(bindings, binding), reason);
    }
    check(
        &with(
            "</ssd:Connectors>",
            "<ssd:Connector name=\"b\" kind=\"input\"><ssc:Binary/></ssd:Connector>",
        ),
        "connector \"b\": expected a type of FMI 2.0, found Binary",
    );
}

proptest! {
    /// Any finite number and any text survive, bit for bit.
    #[test]
    fn numbers_and_texts_survive(
        value in proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL,
        text in "[ -~äθ²\t\n]{0,40}",
    ) {
        let set = ParameterSet {
            name: text.clone(),
            parameters: vec![
                parameter(&text, ParameterValue::Real { value, unit: None }),
                parameter("text", ParameterValue::String(text)),
            ],
            ..ParameterSet::default()
        };
        let back = ParameterSet::from_xml(&set.to_xml().expect("writable")).expect("readable");
        prop_assert_eq!(back, set);
    }
}
