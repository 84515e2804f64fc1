//! The bytes of modelDescription.xml as text, whatever their encoding.

/// The text without its XML declaration, whose encoding no longer holds, and what was wrong with
/// the encoding. The standard wants UTF-8 (FMI 2.0 §2.2).
pub(crate) fn decode(bytes: &[u8]) -> (String, Option<String>) {
    let (text, oddity) = match bytes {
        [0xEF, 0xBB, 0xBF, rest @ ..] => utf_8(rest),
        [0xFF, 0xFE, rest @ ..] => utf_16(rest, u16::from_le_bytes),
        [0xFE, 0xFF, rest @ ..] => utf_16(rest, u16::from_be_bytes),
        [b'<', 0, ..] => utf_16(bytes, u16::from_le_bytes),
        [0, b'<', ..] => utf_16(bytes, u16::from_be_bytes),
        _ => utf_8(bytes),
    };
    let body = text
        .trim_start()
        .strip_prefix("<?xml")
        .and_then(|rest| Some(rest.split_once("?>")?.1));
    (body.unwrap_or(&text).to_owned(), oddity)
}

/// UTF-8, else ISO 8859-1, in which every byte is a character.
fn utf_8(bytes: &[u8]) -> (String, Option<String>) {
    let declared = declared_encoding(bytes);
    let is_latin = declared.as_deref().is_some_and(|name| {
        ["iso-8859-1", "iso-8859-15", "latin1", "windows-1252"].contains(&name)
    });
    match (str::from_utf8(bytes), declared) {
        (Ok(text), declared) if !is_latin || text.is_ascii() => {
            let foreign =
                declared.filter(|name| !["utf-8", "utf8", "us-ascii"].contains(&name.as_str()));
            (text.to_owned(), foreign.map(|name| odd(&name)))
        }
        (_, declared) => {
            let text = bytes.iter().copied().map(char::from).collect();
            let oddity = if is_latin {
                declared.as_deref().map(odd)
            } else {
                Some("expected UTF-8, found other bytes, read as ISO 8859-1".to_owned())
            };
            (text, oddity)
        }
    }
}

fn utf_16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> (String, Option<String>) {
    let (pairs, _) = bytes.as_chunks::<2>();
    let units = pairs.iter().copied().map(unit);
    let text = char::decode_utf16(units)
        .map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER))
        .collect();
    (text, Some(odd("utf-16")))
}

fn odd(encoding: &str) -> String {
    format!("expected UTF-8, found {encoding}")
}

/// What the XML declaration says, in lower case.
fn declared_encoding(bytes: &[u8]) -> Option<String> {
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(256)]);
    let declaration = head
        .trim_start()
        .strip_prefix("<?xml")?
        .split("?>")
        .next()?;
    attribute(declaration, "encoding").map(str::to_ascii_lowercase)
}

/// The version of FMI that the description states.
pub(super) fn fmi_version(xml: &str) -> Option<&str> {
    let (_, root) = xml.split_once("<fmiModelDescription")?;
    attribute(root, "fmiVersion")
}

/// The value of the first attribute called `name` in `text`.
fn attribute<'a>(text: &'a str, name: &str) -> Option<&'a str> {
    let (_, rest) = text.split_once(name)?;
    let rest = rest.trim_start().strip_prefix('=')?.trim_start();
    let quote = rest.chars().next().filter(|c| "\"'".contains(*c))?;
    rest[1..].split(quote).next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(bytes: &[u8], text: &str, oddity: Option<&str>) {
        assert_eq!(decode(bytes), (text.to_owned(), oddity.map(str::to_owned)));
    }

    #[test]
    fn encodings_are_found_out() {
        check("<a>é</a>".as_bytes(), "<a>é</a>", None);
        check("\u{feff}<a/>".as_bytes(), "<a/>", None);
        check(
            "\n<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<a>é</a>".as_bytes(),
            "\n<a>é</a>",
            None,
        );
        check(
            b"<?xml version='1.0' encoding='UTF-8'?><a>\xE9</a>",
            "<a>é</a>",
            Some("expected UTF-8, found other bytes, read as ISO 8859-1"),
        );
        check(
            b"<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?><a>\xE9</a>",
            "<a>é</a>",
            Some("expected UTF-8, found iso-8859-1"),
        );
        let little: Vec<u8> = "<a>é</a>"
            .encode_utf16()
            .flat_map(u16::to_le_bytes)
            .collect();
        check(&little, "<a>é</a>", Some("expected UTF-8, found utf-16"));
        let big: Vec<u8> = "\u{feff}<a>é</a>"
            .encode_utf16()
            .flat_map(u16::to_be_bytes)
            .collect();
        check(&big, "<a>é</a>", Some("expected UTF-8, found utf-16"));
        check(b"", "", None);
    }

    #[test]
    fn the_version_is_read_without_the_rest() {
        let xml = "<!-- x --><fmiModelDescription\n  modelName='fmi' fmiVersion = '3.0-beta.1'>";
        assert_eq!(fmi_version(xml), Some("3.0-beta.1"));
        assert_eq!(fmi_version("<html>"), None);
        assert_eq!(fmi_version("<fmiModelDescription fmiVersion"), None);
    }
}
