//! File URIs (RFC 3986, RFC 8089).

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, percent_encode};
use std::path::Path;

/// What stands for itself: unreserved characters and the separator of a path.
const ENCODED: &AsciiSet = &NON_ALPHANUMERIC
    .remove(b'-')
    .remove(b'.')
    .remove(b'_')
    .remove(b'~')
    .remove(b'/');

/// The URI of an absolute path.
#[cfg(unix)]
pub(super) fn file(path: &Path) -> String {
    use std::os::unix::ffi::OsStrExt;
    format!(
        "file://{}",
        percent_encode(path.as_os_str().as_bytes(), ENCODED)
    )
}

/// The URI of an absolute path.
#[cfg(windows)]
pub(super) fn file(path: &Path) -> String {
    windows(&path.to_string_lossy())
}

/// `C:\a b` → `file:///C:/a%20b`, `\\host\share` → `file://host/share`; the prefix `\\?\` goes.
#[cfg(any(windows, test))]
fn windows(path: &str) -> String {
    let encoded =
        |path: &str| percent_encode(path.replace('\\', "/").as_bytes(), ENCODED).to_string();
    let path = match path.strip_prefix(r"\\?\") {
        Some(verbatim) => verbatim
            .strip_prefix(r"UNC\")
            .map_or_else(|| verbatim.to_owned(), |share| format!(r"\\{share}")),
        None => path.to_owned(),
    };
    if let Some(share) = path.strip_prefix(r"\\") {
        format!("file://{}", encoded(share))
    } else if let Some((drive, rest)) = path.split_once(':') {
        format!("file:///{drive}:{}", encoded(rest))
    } else {
        format!("file:///{}", encoded(path.trim_start_matches('\\')))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn a_path_is_encoded_byte_by_byte() {
        assert_eq!(file(Path::new("/x/.a-b_c~1")), "file:///x/.a-b_c~1");
        assert_eq!(
            file(Path::new("/a b/ü#?%:\\")),
            "file:///a%20b/%C3%BC%23%3F%25%3A%5C"
        );
    }

    #[test]
    fn a_windows_path_keeps_its_drive_or_host() {
        for (path, uri) in [
            (
                r"C:\Users\J. Müller\x",
                "file:///C:/Users/J.%20M%C3%BCller/x",
            ),
            (r"\\?\D:\x", "file:///D:/x"),
            (r"\\host\share\a b", "file://host/share/a%20b"),
            (r"\\?\UNC\host\share", "file://host/share"),
            (r"\x", "file:///x"),
        ] {
            assert_eq!(windows(path), uri, "{path}");
        }
    }
}
