//! Files: whole in, whole out. A result is written to a temporary name and renamed, so that what
//! stands under its name is never half of it.

use crate::error::{Error, Result};
use sha2::{Digest, Sha256};
use std::borrow::Cow;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

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

/// Whether [`write`] can write to `path`, as far as can be told before: a file can be made beside it.
pub fn check_writable(path: &Path) -> Result<()> {
    let check = || match std::fs::metadata(path) {
        Ok(found) if found.is_dir() => Err(ErrorKind::IsADirectory.into()),
        Ok(found) if !found.is_file() => Ok(()),
        _ => beside(path).map(drop),
    };
    check().map_err(|cause| Error::Write {
        file: path.display().to_string(),
        cause,
    })
}

/// The file that `path` names, whatever way it is written; none where there is no such folder.
pub fn place(path: &Path) -> Option<PathBuf> {
    let canonical = path.canonicalize().ok();
    canonical.or_else(|| Some(folder(path).canonicalize().ok()?.join(path.file_name()?)))
}

/// Refuses to write to any of `written` where it is one of the files `read`, or is named twice.
pub fn check_apart<'a>(
    written: impl IntoIterator<Item = &'a Path>,
    read: impl IntoIterator<Item = &'a Path>,
) -> Result<()> {
    let read: Vec<PathBuf> = read.into_iter().filter_map(place).collect();
    let mut seen = Vec::new();
    for path in written {
        let file = || path.display().to_string();
        let Some(place) = place(path) else { continue };
        // a pipe or a terminal is not overwritten
        if std::fs::metadata(&place).is_ok_and(|found| !found.is_file()) {
            continue;
        }
        if read.contains(&place) {
            return Err(Error::Taken { file: file() });
        }
        if seen.contains(&place) {
            return Err(Error::NamedTwice { file: file() });
        }
        seen.push(place);
    }
    Ok(())
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// A temporary file in the folder of `path`.
fn beside(path: &Path) -> std::io::Result<NamedTempFile> {
    let folder = folder(path);
    // the folder's own error: the one below would name the temporary file
    if !std::fs::metadata(folder)?.is_dir() {
        return Err(ErrorKind::NotADirectory.into());
    }
    let mut builder = tempfile::Builder::new();
    // a temporary file is private by default; a result has the permissions of any new file
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let made = builder.tempfile_in(folder);
    made.map_err(|cause| cause.kind().into())
}

fn replace(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    if std::fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        return std::fs::write(path, bytes);
    }
    let mut file = beside(path)?;
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
        for refused in [write(&nowhere, "text"), check_writable(&nowhere)] {
            let message = refused.unwrap_err().to_string();
            let cause = "cannot be written: No such file or directory (os error 2)";
            assert_eq!(message, format!("{}: {cause}", nowhere.display()));
        }
        assert!(check_writable(&path).is_err(), "a folder");
        check_writable(&folder.path().join("new")).unwrap();
        check_writable(Path::new("/dev/null")).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn what_is_read_is_not_written_however_it_is_called() {
        let folder = tempfile::tempdir().unwrap();
        let ride = folder.path().join("ride.csv");
        std::fs::write(&ride, "time").unwrap();
        std::fs::create_dir(folder.path().join("in")).unwrap();
        let again = folder.path().join("in").join("..").join("ride.csv");
        let new = folder.path().join("new");
        let apart = |written: &[&Path]| check_apart(written.iter().copied(), [&*ride]);
        assert!(matches!(apart(&[&again]), Err(Error::Taken { .. })));
        assert!(matches!(
            apart(&[&new, &new]),
            Err(Error::NamedTwice { .. })
        ));
        apart(&[&new, Path::new("nowhere/at/all")]).unwrap();
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
