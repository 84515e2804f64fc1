//! From the resource location to a folder (FMI 2.0 §2.1.5: a URI by RFC 3986).

use crate::Error;
use percent_encoding::percent_decode_str;
use std::path::PathBuf;

/// The folder that `location` names; `None` where it names none.
///
/// Importers write `file:///folder`, `file:/folder` or `file://localhost/folder`; a plain path,
/// as some do, is taken as it is.
pub(crate) fn folder(location: &str) -> Result<Option<PathBuf>, Error> {
    let refuse = |expected| {
        Err(Error::ResourceLocation {
            expected,
            found: location.to_owned(),
        })
    };
    if location.is_empty() {
        return Ok(None);
    }
    let Some((scheme, rest)) = scheme(location) else {
        return Ok(Some(location.into()));
    };
    if !scheme.eq_ignore_ascii_case("file") {
        return refuse("a URI with the scheme file");
    }
    // What follows ? and # is no part of the path.
    let rest = rest.split(['?', '#']).next().unwrap_or_default();
    let (host, path) = match rest.strip_prefix("//") {
        Some(rest) => rest.split_at(rest.find('/').unwrap_or(rest.len())),
        None => ("", rest),
    };
    if !path.starts_with('/') {
        return refuse("an absolute path");
    }
    let escapes = path.split('%').skip(1);
    let digits = |text: &str| {
        let mut digits = text.bytes().take(2).map(|byte| byte.is_ascii_hexdigit());
        digits.next() == Some(true) && digits.next() == Some(true)
    };
    if !escapes.into_iter().all(digits) {
        return refuse("two hexadecimal digits after each %");
    }
    let bytes: Vec<u8> = percent_decode_str(path).collect();
    if bytes.contains(&0) {
        return refuse("a path without null characters");
    }
    match local(host, bytes) {
        Some(path) => Ok(Some(path)),
        None => refuse("a folder of this machine"),
    }
}

/// Scheme and rest. One letter before the colon is a drive.
fn scheme(location: &str) -> Option<(&str, &str)> {
    let (scheme, rest) = location.split_once(':')?;
    let mut letters = scheme.bytes();
    let first = letters.next()?;
    let is_scheme = first.is_ascii_alphabetic()
        && scheme.len() > 1
        && letters.all(|byte| byte.is_ascii_alphanumeric() || b"+-.".contains(&byte));
    is_scheme.then_some((scheme, rest))
}

/// The path in this system's form, if the host is this one.
#[cfg(unix)]
fn local(host: &str, path: Vec<u8>) -> Option<PathBuf> {
    use std::os::unix::ffi::OsStringExt;
    let here = host.is_empty() || host.eq_ignore_ascii_case("localhost");
    here.then(|| std::ffi::OsString::from_vec(path).into())
}

/// The path in this system's form: `/C:/x` is `C:/x`, another host a network share.
#[cfg(not(unix))]
fn local(host: &str, path: Vec<u8>) -> Option<PathBuf> {
    let path = String::from_utf8(path).ok()?;
    if !host.is_empty() && !host.eq_ignore_ascii_case("localhost") {
        return Some(format!("//{host}{path}").into());
    }
    let drive = path
        .as_bytes()
        .get(2)
        .is_some_and(|byte| b":|".contains(byte));
    Some(if drive {
        path[1..].replacen('|', ":", 1).into()
    } else {
        path.into()
    })
}

#[cfg(all(test, unix))]
mod tests {
    use super::folder;
    use std::os::unix::ffi::OsStrExt;

    #[test]
    fn every_way_to_write_a_folder() {
        let check = |location: &str, expected: &[u8]| {
            let found = folder(location).expect("a folder").expect("one");
            assert_eq!(found.as_os_str().as_bytes(), expected, "{location}");
        };
        check("file:///a/resources", b"/a/resources");
        check("file:/a/resources", b"/a/resources");
        check("FILE://localhost/a/resources", b"/a/resources");
        check("file:///a%20b/%C3%A4%25%23", "/a b/ä%#".as_bytes());
        check("file:///%ff", b"/\xff");
        check("file:///a/resources?x#y", b"/a/resources");
        check("file:///a+b", b"/a+b");
        check("/a/resources", b"/a/resources");
        check("C:\\a", b"C:\\a");
        assert_eq!(folder("").expect("no error"), None);
    }

    #[test]
    fn what_is_no_folder_of_this_machine_is_refused() {
        let check = |location: &str, expected: &str| {
            let error = folder(location).expect_err("refused").to_string();
            assert!(error.contains(expected), "{error}");
        };
        check("https://host/a", "scheme file");
        check("file://elsewhere/a", "this machine");
        check("file://", "absolute path");
        check("file:a/b", "absolute path");
        check("file:///a%2", "two hexadecimal digits");
        check("file:///a%zz", "two hexadecimal digits");
        check("file:///a%é", "two hexadecimal digits");
        check("file:///a%00b", "null");
    }
}
