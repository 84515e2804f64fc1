//! A zip archive unpacked, nothing of it outside its folder.

use crate::Error;
use std::collections::HashSet;
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use zip::ZipArchive;
use zip::read::ZipFile;

/// How big an archive may be.
pub(crate) struct Limits {
    entries: usize,
    bytes: u64,
}

impl Default for Limits {
    /// More entries and bytes, unpacked, than any FMU has: 100 000 and 4 GiB.
    fn default() -> Self {
        Self {
            entries: 100_000,
            bytes: 1 << 32,
        }
    }
}

/// What came out of an archive.
#[derive(Debug)]
pub(crate) struct Unpacked {
    /// Where; removed when dropped.
    pub(crate) folder: TempDir,
    /// Names of the files, folders separated by `/`.
    pub(crate) files: Vec<String>,
    /// Names of the symbolic links, which are left out.
    pub(crate) links: Vec<String>,
}

/// Unpacks the archive at `path` into a folder of its own.
pub(crate) fn unpack(path: &Path, limits: &Limits) -> Result<Unpacked, Error> {
    let no_file = |path: &Path, source| Error::File {
        path: path.to_owned(),
        source,
    };
    let no_zip = |source| Error::Zip {
        path: path.to_owned(),
        source,
    };
    let too_big = |what, limit| Error::TooBig {
        path: path.to_owned(),
        what,
        limit,
    };
    let file = File::open(path).map_err(|source| no_file(path, source))?;
    let mut archive = ZipArchive::new(BufReader::new(file)).map_err(no_zip)?;
    if archive.len() > limits.entries {
        return Err(too_big("entries", limits.entries as u64));
    }
    if let Some(entry) = first_twin(path, archive.central_directory_start())
        .map_err(|source| no_file(path, source))?
    {
        return Err(Error::Duplicate {
            path: path.to_owned(),
            entry,
        });
    }
    let folder = tempfile::Builder::new()
        .prefix("fmu")
        .tempdir()
        .map_err(|source| no_file(&std::env::temp_dir(), source))?;
    let mut unpacked = Unpacked {
        folder,
        files: Vec::new(),
        links: Vec::new(),
    };
    let mut bytes_left = limits.bytes;
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index).map_err(no_zip)?;
        let name = entry.name().to_owned();
        let relative = inside(&name).ok_or_else(|| Error::Escape {
            path: path.to_owned(),
            entry: name.clone(),
        })?;
        if entry.is_symlink() {
            unpacked.links.push(name);
            continue;
        }
        let target = unpacked.folder.path().join(&relative);
        let written = write(&mut entry, &target, bytes_left).map_err(|source| {
            if source.kind() == ErrorKind::AlreadyExists {
                Error::Duplicate {
                    path: path.to_owned(),
                    entry: name.clone(),
                }
            } else {
                no_file(&target, source)
            }
        })?;
        bytes_left = bytes_left
            .checked_sub(written)
            .ok_or_else(|| too_big("bytes when unpacked", limits.bytes))?;
        if !entry.is_dir() {
            unpacked.files.push(name.replace('\\', "/"));
        }
    }
    Ok(unpacked)
}

/// The first name that the central directory, which begins at `start`, has twice: the zip crate
/// keeps the last entry of a name without a word, other tools the first.
fn first_twin(path: &Path, start: u64) -> std::io::Result<Option<String>> {
    let mut file = BufReader::new(File::open(path)?);
    file.seek(SeekFrom::Start(start))?;
    let mut seen = HashSet::new();
    let mut header = [0; 46];
    while file.read_exact(&mut header).is_ok() && header.starts_with(b"PK\x01\x02") {
        let length = |at: usize| u16::from_le_bytes([header[at], header[at + 1]]);
        let (extra, comment) = (length(30), length(32));
        let mut name = vec![0; usize::from(length(28))];
        file.read_exact(&mut name)?;
        file.seek_relative(i64::from(extra) + i64::from(comment))?;
        if let Some(name) = seen.replace(name) {
            return Ok(Some(String::from_utf8_lossy(&name).into_owned()));
        }
    }
    Ok(None)
}

/// The name of an entry as a path below a folder; none for one that might lead out of it, on any
/// operating system. Some tools write `\` for `/`.
pub(crate) fn inside(name: &str) -> Option<PathBuf> {
    if name.starts_with(['/', '\\']) || name.contains('\0') {
        return None;
    }
    let mut path = PathBuf::new();
    for part in name.split(['/', '\\']) {
        match part {
            "" | "." => {}
            ".." => return None,
            // `C:` is a drive
            drive if drive.as_bytes().get(1) == Some(&b':') => return None,
            part => path.push(part),
        }
    }
    Some(path)
}

/// Writes one entry; how many bytes that were, at most one more than `most`.
fn write(
    entry: &mut ZipFile<'_, BufReader<File>>,
    target: &Path,
    most: u64,
) -> std::io::Result<u64> {
    if entry.is_dir() {
        std::fs::create_dir_all(target)?;
        return Ok(0);
    }
    if let Some(parent) = target.parent() {
        std::fs::create_dir_all(parent)?;
    }
    let is_program = entry.unix_mode().is_some_and(|mode| mode & 0o100 != 0);
    // never over what is there
    let mut file = File::create_new(target)?;
    let written = std::io::copy(&mut entry.take(most.saturating_add(1)), &mut file)?;
    if is_program {
        allow_execution(&file)?;
    }
    Ok(written)
}

/// Some FMUs start programs from their resources.
#[cfg(unix)]
fn allow_execution(file: &File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o700))
}

#[cfg(not(unix))]
#[expect(clippy::unnecessary_wraps, reason = "fails elsewhere")]
fn allow_execution(_file: &File) -> std::io::Result<()> {
    Ok(())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::io::Write;
    use zip::write::{SimpleFileOptions, ZipWriter};

    /// An archive of these entries; a name `x -> y` makes a symbolic link.
    pub(crate) fn archive(entries: &[(&str, &str)]) -> (TempDir, PathBuf) {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("a b.fmu");
        let mut zip = ZipWriter::new(File::create(&path).expect("writable"));
        let options = SimpleFileOptions::default();
        for (name, text) in entries {
            if let Some((link, to)) = name.split_once(" -> ") {
                zip.add_symlink(link, to, options).expect("linked");
            } else {
                zip.start_file(*name, options).expect("started");
                zip.write_all(text.as_bytes()).expect("written");
            }
        }
        zip.finish().expect("finished");
        (folder, path)
    }

    const FEW: Limits = Limits {
        entries: 3,
        bytes: 1000,
    };

    #[track_caller]
    fn check(entries: &[(&str, &str)], expected: &str) {
        let (_folder, path) = archive(entries);
        let error = unpack(&path, &FEW).expect_err("refused");
        assert!(error.to_string().contains(expected), "{error}");
    }

    #[test]
    fn no_entry_escapes() {
        check(&[("../evil", "")], "entry \"../evil\" points outside");
        for name in [
            "a/../../evil",
            "/evil",
            "\\evil",
            "..\\evil",
            "C:\\evil",
            "a/C:evil",
        ] {
            check(&[(name, "")], "points outside");
        }
    }

    #[test]
    fn a_link_is_neither_made_nor_followed() {
        let (outside, _) = archive(&[]);
        let link = format!("resources -> {}", outside.path().display());
        let (_folder, path) = archive(&[(&link, ""), ("resources/evil", "x")]);
        let unpacked = unpack(&path, &FEW).expect("unpacked");
        assert_eq!(unpacked.links, ["resources"]);
        assert!(!outside.path().join("evil").exists());
        assert!(unpacked.folder.path().join("resources/evil").is_file());
    }

    #[test]
    fn backslashes_separate_folders() {
        let (_folder, path) = archive(&[("binaries\\win64\\x.dll", "x")]);
        let unpacked = unpack(&path, &FEW).expect("unpacked");
        assert_eq!(unpacked.files, ["binaries/win64/x.dll"]);
        assert!(
            unpacked
                .folder
                .path()
                .join("binaries/win64/x.dll")
                .is_file()
        );
    }

    #[test]
    fn no_entry_comes_twice() {
        check(
            &[("a/b", "1"), ("a\\b", "2")],
            "expected one entry \"a\\\\b\", found two",
        );
        check(&[("a", ""), ("a/b", "")], "entry \"a/b\"");
        // The writer refuses a name twice; patched in, headers and directory alike.
        let (_folder, path) = archive(&[("twin-1", "1"), ("twin-2", "2")]);
        let mut bytes = std::fs::read(&path).expect("readable");
        for at in 0..bytes.len() - 6 {
            if bytes[at..].starts_with(b"twin-2") {
                bytes[at + 5] = b'1';
            }
        }
        std::fs::write(&path, bytes).expect("writable");
        let error = unpack(&path, &FEW).expect_err("refused");
        assert!(error.to_string().contains("twin-1"), "{error}");
    }

    #[test]
    fn size_is_limited() {
        check(
            &[("a", ""), ("b", ""), ("c", ""), ("d", "")],
            "at most 3 entries",
        );
        check(
            &[("a", &"0".repeat(600)), ("b", &"0".repeat(600))],
            "at most 1000 bytes",
        );
    }

    #[test]
    fn what_is_unpacked_goes_with_it() {
        let (_folder, path) = archive(&[("a/b", "1")]);
        let unpacked = unpack(&path, &FEW).expect("unpacked");
        let folder = unpacked.folder.path().to_owned();
        assert!(folder.join("a/b").is_file());
        drop(unpacked);
        assert!(!folder.exists());
    }
}
