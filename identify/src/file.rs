//! Files: whole in, whole out. A result is written to a temporary name and renamed, so that what
//! stands under its name is never half of it.

use crate::error::{Error, Result};
use sha2::{Digest, Sha256};
use std::borrow::Cow;
use std::io::Write as _;
use std::path::Path;

/// The bytes of the file at `path`.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|cause| Error::Read {
        file: path.display().to_string(),
        cause,
    })
}

/// The text of the file at `path`, which must be UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).map_err(|cause| Error::Read {
        file: path.display().to_string(),
        cause,
    })
}

/// The text called `name`: one of those `shipped` (name, text) with the program, or else a file.
/// Returns where it comes from besides.
pub(crate) fn named(
    kind: &'static str,
    shipped: &[(&str, &'static str)],
    name: &str,
) -> Result<(String, Cow<'static, str>)> {
    if let Some((_, text)) = shipped.iter().find(|(known, _)| *known == name) {
        return Ok((format!("{kind} {name}"), Cow::Borrowed(text)));
    }
    let path = Path::new(name);
    if path.components().count() == 1 && path.extension().is_none() && !path.exists() {
        return Err(Error::unknown(
            kind,
            name,
            shipped.iter().map(|(known, _)| *known),
        ));
    }
    Ok((name.into(), Cow::Owned(read_text(path)?)))
}

/// Writes `bytes` to `path`, all or nothing. What is no regular file (a pipe, a terminal) is
/// written to directly: it cannot be replaced.
pub fn write(path: &Path, bytes: impl AsRef<[u8]>) -> Result<()> {
    replace(path, bytes.as_ref()).map_err(|cause| Error::Write {
        file: path.display().to_string(),
        cause,
    })
}

fn replace(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    if std::fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        return std::fs::write(path, bytes);
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    // a temporary file is private by default; a result has the permissions of any new file
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    file.persist(path)?;
    Ok(())
}

/// The SHA-256 of `bytes`, in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    format!("{:x}", Sha256::digest(bytes))
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed write is a failed test")]
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_leaves_nothing_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("fit.json");
        write(&path, "first, and longer").unwrap();
        write(&path, "second").unwrap();
        assert_eq!(read_text(&path).unwrap(), "second");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_failed_write_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("taken");
        std::fs::create_dir(&path).unwrap();
        let message = write(&path, "text").unwrap_err().to_string();
        assert!(message.starts_with(&format!("{}: cannot be written: ", path.display())));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        let nowhere = folder.path().join("none").join("fit.json");
        assert!(matches!(write(&nowhere, "text"), Err(Error::Write { .. })));
    }

    #[test]
    fn a_missing_file_is_named() {
        let message = read(Path::new("nowhere/ride.csv")).unwrap_err().to_string();
        assert_eq!(
            message,
            "nowhere/ride.csv: cannot be read: No such file or directory (os error 2)"
        );
    }

    #[test]
    fn the_hash_is_the_standards() {
        // FIPS 180-2, appendix B.1
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256(b"abc"), abc);
    }
}
