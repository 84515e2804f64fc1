//! Descriptions as they come from other tools.

use fmi_import::{Archive, Error};
use std::fmt::Write as _;
use std::fs::File;
use std::io::Write;
use zip::write::{SimpleFileOptions, ZipWriter};

/// An archive with nothing but a description of these bytes.
fn open(xml: &[u8]) -> Result<Archive, Error> {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("x.fmu");
    let mut zip = ZipWriter::new(File::create(&path).expect("writable"));
    zip.start_file("modelDescription.xml", SimpleFileOptions::default())
        .expect("started");
    zip.write_all(xml).expect("written");
    zip.finish().expect("finished");
    Archive::open(&path)
}

/// A description with `inner` and one variable; `head` stands in front.
fn description(head: &str, inner: &str) -> String {
    format!(
        "{head}<fmiModelDescription xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" \
         xsi:noNamespaceSchemaLocation=\"x.xsd\" fmiVersion=\"2.0\" modelName=\"M\" guid=\"\">\
         {inner}<ModelVariables><!-- 1 --><ScalarVariable name=\"x\" valueReference=\"1\">\
         <Annotations><Tool name=\"t\"><Real start=\"?\"/></Tool></Annotations><Real/>\
         </ScalarVariable></ModelVariables></fmiModelDescription>"
    )
}

#[test]
fn what_is_not_known_is_passed_over() {
    for (head, inner) in [
        (
            "<?xml version=\"1.0\"?>\n<!-- made by --><?tool x?>",
            "<![CDATA[z]]>",
        ),
        ("\u{feff}<?xml version=\"1.1\" standalone='yes' ?>", ""),
        (
            "<!DOCTYPE fmiModelDescription SYSTEM \"file:///etc/hosts\">",
            "",
        ),
        (
            "",
            "<VendorAnnotations><Tool name=\"t\"><v:a xmlns:v=\"urn:v\" v:b=\"1\"/>\
             <ModelVariables><ScalarVariable/></ModelVariables></Tool></VendorAnnotations>",
        ),
        (
            "",
            "<ModelExchange modelIdentifier=\"M\"><SourceFiles/></ModelExchange>\
             <CoSimulation modelIdentifier=\"M\" canInterpolateInputs=\"1\"><SourceFiles>\
             <File name=\"a.c\"/></SourceFiles></CoSimulation>",
        ),
    ] {
        let archive = open(description(head, inner).as_bytes()).expect("read");
        assert_eq!(archive.description().variables.len(), 1, "{head}{inner}");
    }
}

#[test]
fn other_encodings_are_read_and_told() {
    let xml = "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"Fahrrad für Öl\" guid=\"\"/>";
    let latin = |text: &str| -> Vec<u8> {
        let byte = |c| u8::try_from(u32::from(c)).expect("Latin");
        text.chars().map(byte).collect()
    };
    let declared = format!("<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>{xml}");
    let wrongly = format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>{xml}");
    let wide = format!("\u{feff}<?xml version=\"1.0\" encoding=\"UTF-16\"?>{xml}");
    let wide: Vec<u8> = wide.encode_utf16().flat_map(u16::to_le_bytes).collect();
    for bytes in [latin(&declared), latin(&wrongly), wide] {
        let found = open(&bytes).expect("read").inspect();
        assert_eq!(found.model_name, "Fahrrad für Öl");
        assert!(
            found
                .oddities
                .iter()
                .any(|oddity| oddity.rule == "encoding")
        );
    }
    let found = open(wrongly.as_bytes()).expect("read").inspect();
    assert!(
        found
            .oddities
            .iter()
            .all(|oddity| oddity.rule != "encoding")
    );
}

#[test]
fn entities_do_not_blow_up_and_read_no_files() {
    let mut laughs = String::from("<!DOCTYPE x [<!ENTITY l0 \"laughlaugh\">");
    for n in 1..12 {
        let ten = format!("&l{};", n - 1).repeat(10);
        let _ = write!(laughs, "<!ENTITY l{n} \"{ten}\">");
    }
    laughs.push_str("]>");
    let error =
        open(description(&laughs, "<VendorAnnotations>&l11;</VendorAnnotations>").as_bytes());
    assert!(matches!(error, Err(Error::Description { .. })));

    let outside = "<!DOCTYPE x [<!ENTITY e SYSTEM \"file:///etc/passwd\">]>";
    let xml = description(outside, "").replace("modelName=\"M\"", "modelName=\"&e;\"");
    let archive = open(xml.as_bytes()).expect("read");
    assert_eq!(archive.description().model_name, "");
}

#[test]
fn a_description_of_ten_thousand_variables_is_read() {
    let mut variables = String::from("<ModelVariables>");
    for n in 0..10_000 {
        let _ = write!(
            variables,
            "<ScalarVariable name=\"v[{n}]\" valueReference=\"{n}\"><Real/></ScalarVariable>"
        );
    }
    let xml = format!(
        "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"M\" guid=\"\">{variables}\
         </ModelVariables></fmiModelDescription>"
    );
    let archive = open(xml.as_bytes()).expect("read");
    assert_eq!(archive.description().variables.len(), 10_000);
}

#[test]
fn what_is_no_description_is_refused() {
    for (xml, expected) in [
        ("", "expected an FMI 2.0 model description"),
        (
            "<fmiModelDescription",
            "expected an FMI 2.0 model description",
        ),
        (
            "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"M\"/>",
            "missing field `@guid`",
        ),
    ] {
        let error = open(xml.as_bytes()).expect_err("refused").to_string();
        assert!(error.contains(expected), "{error}");
    }
}
