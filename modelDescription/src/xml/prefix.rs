//! Names with the prefixes our types use, whatever prefixes a file uses.

use super::{Error, Format};
use xml::name::Name;
use xml::reader::XmlEvent as Read;
use xml::writer::XmlEvent as Write;
use xml::{EmitterConfig, EventReader};

/// The namespaces of SSP 1.0 with the prefixes its documents use.
pub(super) const NAMESPACES: [(&str, &str); 3] = [
    ("ssc", "http://ssp-standard.org/SSP1/SystemStructureCommon"),
    (
        "ssd",
        "http://ssp-standard.org/SSP1/SystemStructureDescription",
    ),
    (
        "ssv",
        "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    ),
];

/// The elements and attributes of `xml`, which must have the root of `format`, with the prefixes
/// of [`NAMESPACES`]. Elements of other namespaces lose theirs, and with it all meaning; texts are
/// left out, for SSP has none.
pub(super) fn canonical(xml: &str, format: &Format) -> Result<String, Error> {
    let mut writer = EmitterConfig::new().create_writer(Vec::new());
    let mut is_root = true;
    for event in EventReader::new(xml.as_bytes()) {
        let event = event.map_err(|error| format.unreadable(error))?;
        let written = match &event {
            Read::StartElement {
                name, attributes, ..
            } => {
                let uri = name.namespace.as_deref();
                let prefix = NAMESPACES
                    .iter()
                    .find(|(_, known)| uri == Some(known))
                    .map(|(prefix, _)| *prefix);
                if std::mem::take(&mut is_root)
                    && (prefix, name.local_name.as_str()) != (Some(format.prefix), format.root)
                {
                    return Err(Error::Root {
                        expected: format.what,
                        found: name.to_string(),
                    });
                }
                let mut element = Write::start_element(Name {
                    local_name: &name.local_name,
                    namespace: None,
                    prefix,
                });
                for (prefix, uri) in NAMESPACES {
                    element = element.ns(prefix, uri);
                }
                for attribute in attributes.iter().filter(|a| a.name.prefix.is_none()) {
                    element = element.attr(attribute.name.local_name.as_str(), &attribute.value);
                }
                writer.write(element)
            }
            Read::EndElement { .. } => writer.write(Write::end_element()),
            _ => Ok(()),
        };
        written.map_err(|error| format.unreadable(error))?;
    }
    let written = String::from_utf8(writer.into_inner()).expect("written from texts");
    Ok(super::with_tabs(&written))
}
