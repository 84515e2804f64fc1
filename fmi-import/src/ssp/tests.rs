use super::*;
use crate::archive::unpack::tests::archive;
use crate::archive::unpack::{Limits, unpack};
use crate::master::Terminal;
use std::fmt;
use std::fs::File;
use std::io::Write;
use zip::write::{SimpleFileOptions, ZipWriter};

/// The description of an FMU with the output `y` [unit], the input `u` [deg] and a start value of
/// each type.
fn fmu(identifier: &str, unit: &str) -> String {
    format!(
        "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"Empty\" guid=\"{{0}}\">\
         <CoSimulation modelIdentifier=\"{identifier}\"/>\
         <UnitDefinitions><Unit name=\"rad\"><BaseUnit rad=\"1\"/></Unit>\
         <Unit name=\"deg\"><BaseUnit rad=\"1\" factor=\"0.0174\"/></Unit>\
         <Unit name=\"m\"><BaseUnit m=\"1\"/></Unit><Unit name=\"odd\"/></UnitDefinitions>\
         <TypeDefinitions><SimpleType name=\"Gait\"><Enumeration><Item name=\"trot\" value=\"1\"/>\
         <Item name=\"walk\" value=\"2\"/></Enumeration></SimpleType>\
         <SimpleType name=\"Angle\"><Real unit=\"deg\"/></SimpleType></TypeDefinitions>\
         <ModelVariables>\
         <ScalarVariable name=\"y\" valueReference=\"0\" causality=\"output\">\
         <Real unit=\"{unit}\"/></ScalarVariable>\
         <ScalarVariable name=\"u\" valueReference=\"1\" causality=\"input\">\
         <Real declaredType=\"Angle\" start=\"0\"/></ScalarVariable>\
         <ScalarVariable name=\"n\" valueReference=\"2\" causality=\"output\" \
         variability=\"discrete\"><Integer/></ScalarVariable>\
         <ScalarVariable name=\"a.b\" valueReference=\"3\" causality=\"parameter\" \
         variability=\"fixed\"><Real unit=\"odd\" start=\"1\"/></ScalarVariable>\
         <ScalarVariable name=\"on\" valueReference=\"4\" causality=\"parameter\" \
         variability=\"fixed\"><Boolean start=\"true\"/></ScalarVariable>\
         <ScalarVariable name=\"label\" valueReference=\"5\" causality=\"parameter\" \
         variability=\"fixed\"><String start=\"\"/></ScalarVariable>\
         <ScalarVariable name=\"gait\" valueReference=\"6\" causality=\"parameter\" \
         variability=\"fixed\"><Enumeration declaredType=\"Gait\" start=\"1\"/></ScalarVariable>\
         <ScalarVariable name=\"count\" valueReference=\"7\" causality=\"parameter\" \
         variability=\"fixed\"><Integer start=\"0\"/></ScalarVariable>\
         </ModelVariables></fmiModelDescription>"
    )
}

fn packed(identifier: &str, unit: &str) -> (TempDir, PathBuf) {
    archive(&[
        ("modelDescription.xml", &fmu(identifier, unit)),
        ("binaries/linux64/Empty.so", identifier),
    ])
}

fn port(text: &str) -> Terminal {
    text.parse().expect("a terminal")
}

fn connection(source: &str, target: &str) -> Connection {
    Connection {
        source: port(source),
        target: port(target),
    }
}

fn component(name: &str, fmu: &Path) -> Component {
    Component {
        name: name.to_owned(),
        fmu: fmu.to_owned(),
        start_values: Vec::new(),
    }
}

/// Three components, two of which share an FMU; the third's is another of the same name.
struct Fixture {
    system: System,
    folders: [TempDir; 2],
}

impl Fixture {
    fn new() -> Self {
        let (one, shared) = packed("Empty", "rad");
        let (two, other) = packed("Empty", "odd");
        let mut plant = component("plant", &shared);
        plant.start_values = vec![
            ("u".to_owned(), Value::Real(0.1)),
            ("a.b".to_owned(), Value::Real(-1e-310)),
            ("on".to_owned(), Value::Boolean(false)),
            ("label".to_owned(), Value::String("<a & b>".to_owned())),
            ("gait".to_owned(), Value::Integer(2)),
            ("count".to_owned(), Value::Integer(-3)),
        ];
        let system = System {
            name: "three in a ring".to_owned(),
            components: vec![
                plant,
                component("controller", &shared),
                component("rider", &other),
            ],
            connections: vec![
                connection("plant.y", "controller.u"),
                connection("controller.y", "rider.u"),
                connection("rider.y", "plant.u"),
            ],
            start_time: None,
            stop_time: Some(20.0),
        };
        Self {
            system,
            folders: [one, two],
        }
    }

    fn out(&self) -> PathBuf {
        self.folders[0].path().join("system.ssp")
    }

    fn written(&self) -> PathBuf {
        write(&self.system, &self.out()).expect("written");
        self.out()
    }

    /// The archive with texts in its descriptions replaced.
    fn changed(&self, replacements: &[(&str, &str)]) -> (TempDir, PathBuf) {
        let unpacked = unpack(&self.written(), &Limits::default()).expect("an archive");
        let (folder, path) = archive(&[]);
        let mut zip = ZipWriter::new(File::create(&path).expect("writable"));
        let mut replaced = 0;
        for name in &unpacked.files {
            let file = unpacked.folder.path().join(name);
            let mut bytes = std::fs::read(file).expect("readable");
            if [DESCRIPTION, PARAMETERS].contains(&name.as_str()) {
                let mut text = String::from_utf8(bytes).expect("a text");
                for (from, to) in replacements {
                    replaced += text.matches(from).count();
                    text = text.replace(from, to);
                }
                bytes = text.into_bytes();
            }
            zip.start_file(name.as_str(), SimpleFileOptions::default())
                .expect("started");
            zip.write_all(&bytes).expect("written");
        }
        assert!(replaced >= replacements.len(), "{replacements:?}");
        zip.finish().expect("finished");
        (folder, path)
    }

    fn read_changed(&self, replacements: &[(&str, &str)]) -> Result<Package, Error> {
        let (_folder, path) = self.changed(replacements);
        read(&path)
    }
}

/// `system` with the files of `like`.
fn with_files(system: &System, like: &System) -> System {
    let mut system = system.clone();
    for (component, like) in system.components.iter_mut().zip(&like.components) {
        component.fmu.clone_from(&like.fmu);
    }
    system
}

#[test]
fn reading_what_was_written_gives_the_same_system() {
    let fixture = Fixture::new();
    let package = read(&fixture.written()).expect("readable");
    let found = package.system().clone();
    assert_eq!(with_files(&fixture.system, &found), found);
    assert!(package.ignored().is_empty());
    let files: Vec<&Path> = found.components.iter().map(|c| c.fmu.as_path()).collect();
    assert_eq!(files[0], files[1]);
    for (component, file) in fixture.system.components.iter().zip(&files) {
        let bytes = std::fs::read(file).expect("unpacked");
        assert_eq!(bytes, std::fs::read(&component.fmu).expect("readable"));
    }
    drop(package);
    assert!(!found.components[0].fmu.exists());
}

#[test]
fn the_same_system_gives_the_same_bytes_and_replaces_what_was_there() {
    let fixture = Fixture::new();
    let first = std::fs::read(fixture.written()).expect("readable");
    std::fs::write(fixture.out(), "old").expect("writable");
    let second = std::fs::read(fixture.written()).expect("readable");
    assert!(first == second);
    let files = std::fs::read_dir(fixture.folders[0].path()).expect("readable");
    assert_eq!(files.count(), 2, "the FMU and the SSP");
}

#[test]
fn only_what_is_connected_is_a_connector_and_units_are_said_where_they_are_known() {
    let fixture = Fixture::new();
    let package = unpack(&fixture.written(), &Limits::default());
    let folder = package.expect("an archive").folder;
    let ssd = std::fs::read_to_string(folder.path().join(DESCRIPTION)).expect("a text");
    assert_eq!(ssd.matches("<ssd:Connector ").count(), 6, "{ssd}");
    assert_eq!(ssd.matches("<ssc:Real unit=\"rad\"/>").count(), 2, "{ssd}");
    // by the declared type
    assert_eq!(ssd.matches("<ssc:Real unit=\"deg\"/>").count(), 3, "{ssd}");
    // not in SI units
    assert_eq!(ssd.matches("<ssc:Real/>").count(), 1, "{ssd}");
    let ssv = std::fs::read_to_string(folder.path().join(PARAMETERS)).expect("a text");
    assert!(ssv.contains("<ssv:Parameter name=\"plant.a.b\">"), "{ssv}");
    assert!(ssv.contains("<ssv:Enumeration value=\"walk\"/>"), "{ssv}");
}

#[track_caller]
fn refused<T: fmt::Debug>(result: Result<T, Error>, expected: &str) {
    let error = result.expect_err("refused").to_string();
    assert!(error.contains(expected), "{error}");
}

#[test]
fn systems_that_cannot_be_are_not_written() {
    #[track_caller]
    fn check(change: impl FnOnce(&mut System), expected: &str) {
        let mut fixture = Fixture::new();
        change(&mut fixture.system);
        refused(write(&fixture.system, &fixture.out()), expected);
        assert!(!fixture.out().exists());
    }
    check(|s| s.name.clear(), "system: expected a name");
    check(
        |s| s.components[1].name = "plant".to_owned(),
        "expected a name no other component has, found \"plant\"",
    );
    check(
        |s| s.components[1].name = "a.b".to_owned(),
        "without dots, found \"a.b\"",
    );
    check(
        |s| s.connections[0].target = port("nobody.u"),
        "connection of nobody.u: expected a component of the system, found \"nobody\"",
    );
    check(
        |s| s.connections[0].target = port("rider.v"),
        "expected a variable of rider, found \"v\"",
    );
    check(
        |s| s.connections[0].target = port("rider.y"),
        "connection of plant.y with rider.y: expected an output and an input, found output and \
         output",
    );
    check(
        |s| s.connections[0].source = port("plant.n"),
        "expected variables of one type, found Integer and Real",
    );
    check(
        |s| s.connections.push(connection("plant.y", "rider.u")),
        "input rider.u: expected one source, found controller.y and plant.y",
    );
    for (component, name, value, expected) in [
        (
            0,
            "u",
            Value::Real(0.0),
            "start value of plant.u: expected one, found two",
        ),
        (
            1,
            "v",
            Value::Real(0.0),
            "expected a variable of controller, found \"v\"",
        ),
        (
            1,
            "u",
            Value::Real(f64::NAN),
            "expected a finite number, found NaN",
        ),
        (
            1,
            "on",
            Value::Integer(1),
            "variable on: expected Boolean, found Integer",
        ),
        (
            1,
            "gait",
            Value::Integer(3),
            "expected one of its choices, found 3",
        ),
    ] {
        let start = (name.to_owned(), value);
        check(
            |s| s.components[component].start_values.push(start),
            expected,
        );
    }
    check(|s| s.components[0].fmu.push("none.fmu"), "none.fmu");
}

#[test]
fn units_of_parameters_are_converted() {
    let fixture = Fixture::new();
    let read = |from: &str, to: &str| {
        let package = fixture.read_changed(&[(from, to)])?;
        Ok::<_, Error>(package.system().components[0].start_values[0].1.clone())
    };
    let given = "value=\"0.1\" unit=\"deg\"";
    let without = read(given, "value=\"0.1\"").expect("readable");
    assert_eq!(without, Value::Real(0.1));
    // 1 deg of the file is 0.001 rad, 1 deg of the FMU 0.0174 rad
    let base = "<ssc:BaseUnit rad=\"1\" factor=\"0.0174\"/>";
    let other = "<ssc:BaseUnit rad=\"1\" factor=\"0.001\"/>";
    let converted = read(base, other).expect("readable");
    assert_eq!(converted, Value::Real(0.001 * 0.1 / 0.0174));
    let expected = "value of u: expected a unit that converts to \"deg\", found";
    refused(read(base, "<ssc:BaseUnit m=\"1\"/>"), expected);
    refused(read(given, "value=\"0.1\" unit=\"furlong\""), expected);
}

#[test]
fn parameters_are_bound_as_the_standard_has_it() {
    let fixture = Fixture::new();
    let binding = |prefix: &str, name: &str, value: &str| {
        format!(
            "<ssd:ParameterBinding prefix=\"{prefix}\"><ssd:ParameterValues>\
             <ssv:ParameterSet version=\"1.0\" name=\"x\"><ssv:Parameters>\
             <ssv:Parameter name=\"{name}\"><ssv:Real value=\"{value}\"/></ssv:Parameter>\
             </ssv:Parameters></ssv:ParameterSet></ssd:ParameterValues></ssd:ParameterBinding>"
        )
    };
    // of the system, and of the controller
    let values = |system: &str, component: &str| {
        let file = format!("<ssd:ParameterBinding source=\"{PARAMETERS}\"/>");
        let end = "</ssd:Component>\n      <ssd:Component name=\"rider\"";
        let component = format!("<ssd:ParameterBindings>{component}</ssd:ParameterBindings>{end}");
        let package = fixture
            .read_changed(&[(&file, &format!("{file}{system}")), (end, &component)])
            .expect("readable");
        let values = package.system().components[1].start_values.clone();
        (values, package.ignored().to_vec())
    };
    let u = |value| vec![("u".to_owned(), Value::Real(value))];
    // a component's names are the FMU's, a system's begin with the component
    assert_eq!(values("", &binding("", "u", "1")), (u(1.0), vec![]));
    assert_eq!(
        values(&binding("controller.", "u", "2"), ""),
        (u(2.0), vec![])
    );
    // the system's hold over the component's, the later over the earlier
    let twice = binding("", "controller.u", "4") + &binding("", "controller.u", "3");
    assert_eq!(values(&twice, &binding("", "u", "1")), (u(3.0), vec![]));
    // what no variable has is ignored
    let ignored = vec!["controller.v".to_owned(), "nobody.u".to_owned()];
    let found = values(&binding("", "nobody.u", "1"), &binding("", "v", "1"));
    assert_eq!(found, (vec![], ignored));
}

#[test]
fn parameters_that_do_not_fit_are_refused() {
    let fixture = Fixture::new();
    refused(
        fixture.read_changed(&[("value=\"walk\"", "value=\"fly\"")]),
        "value of gait: expected one of its choices, found \"fly\"",
    );
    refused(
        fixture.read_changed(&[("<ssv:Integer ", "<ssv:Real ")]),
        "variable count: expected Integer, found Real",
    );
    refused(
        fixture.read_changed(&[
            ("ssv:ParameterSet ", "ssv:Set "),
            ("ssv:ParameterSet>", "ssv:Set>"),
        ]),
        "resources/parameters.ssv: expected a parameter set of SSP 1, found the element",
    );
}

#[test]
fn connections_go_from_output_to_input_whatever_their_order() {
    let fixture = Fixture::new();
    let forth = "startElement=\"plant\" startConnector=\"y\" endElement=\"controller\" \
                 endConnector=\"u\"";
    let back = "startElement=\"controller\" startConnector=\"u\" endElement=\"plant\" \
                endConnector=\"y\"";
    let package = fixture.read_changed(&[(forth, back)]).expect("readable");
    assert_eq!(package.system().connections, fixture.system.connections);

    // the system's own connectors
    let connector = |kind: &str| {
        format!(
            "<ssd:Connectors><ssd:Connector name=\"own\" kind=\"{kind}\"/></ssd:Connectors>\
             <ssd:ParameterBindings>\n      <ssd:ParameterBinding s"
        )
    };
    let own = "<ssd:Connection startElement=\"plant\" startConnector=\"y\" \
               endConnector=\"own\"/></ssd:Connections>";
    let with = |kind: &str| {
        let bindings = "<ssd:ParameterBindings>\n      <ssd:ParameterBinding s";
        fixture.read_changed(&[(bindings, &connector(kind)), ("</ssd:Connections>", own)])
    };
    let package = with("output").expect("readable");
    assert_eq!(package.system().connections, fixture.system.connections);
    refused(
        with("input"),
        "connection of the system's \"own\": expected a connection between components",
    );
    refused(
        fixture.read_changed(&[(forth, &format!("{forth} suppressUnitConversion=\"true\""))]),
        "connection of plant.y with controller.u: expected unit conversion",
    );
}

#[test]
fn archives_that_are_none_or_reach_outside_are_refused() {
    let fixture = Fixture::new();
    let source = "source=\"resources/Empty_2.fmu\"";
    for outside in [
        "../Empty_2.fmu",
        "resources/%2E%2E/%2e%2e/x.fmu",
        "/etc/passwd",
        "file:///etc/passwd",
        "https://example.org/x.fmu",
        "#other",
        "resources",
        "%ff",
    ] {
        refused(
            fixture.read_changed(&[(source, &format!("source=\"{outside}\""))]),
            "source: expected the URI of a file in the archive, found",
        );
    }
    let encoded = "source=\"resources/%45mpty_2.fmu\"";
    assert!(fixture.read_changed(&[(source, encoded)]).is_ok());
    refused(
        fixture.read_changed(&[("\"CoSimulation\"", "\"ModelExchange\"")]),
        "component plant: expected an FMU for co-simulation, found ModelExchange",
    );
    refused(
        fixture.read_changed(&[(source, "source=\"resources/parameters.ssv\"")]),
        "expected an FMU, a zip archive",
    );

    let (_folder, path) = archive(&[("other.ssd", "")]);
    refused(
        read(&path),
        "archive: expected SystemStructure.ssd, found none",
    );
    let (_folder, path) = archive(&[("../SystemStructure.ssd", "")]);
    refused(read(&path), "points outside");
    let (_folder, path) = archive(&[(DESCRIPTION, "<html/>")]);
    refused(
        read(&path),
        "SystemStructure.ssd: expected a system structure description of SSP 1, found the element",
    );
    std::fs::write(&path, "no archive").expect("writable");
    refused(read(&path), "file: expected an SSP, a zip archive");
}
