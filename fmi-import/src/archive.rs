//! The archive: unpacked to a temporary folder, its description read.

use crate::Error;
use model_description::{ModelDescription, Platform};
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use zip::ZipArchive;

/// More entries than any FMU has.
const MOST_ENTRIES: u64 = 100_000;
/// More bytes, unpacked, than any FMU has: 4 GiB.
const MOST_BYTES: u64 = 1 << 32;

/// An unpacked FMU; its folder is removed when this is dropped.
#[derive(Debug)]
pub struct Archive {
    path: PathBuf,
    folder: TempDir,
    description: ModelDescription,
}

impl Archive {
    /// Unpacks the FMU at `path` and reads its description.
    pub fn open(path: &Path) -> Result<Self, Error> {
        Self::open_within(path, MOST_ENTRIES, MOST_BYTES)
    }

    fn open_within(path: &Path, most_entries: u64, most_bytes: u64) -> Result<Self, Error> {
        let file = File::open(path).map_err(|source| Error::File {
            path: path.to_owned(),
            source,
        })?;
        let mut archive = ZipArchive::new(BufReader::new(file)).map_err(|source| Error::Zip {
            path: path.to_owned(),
            source,
        })?;
        if archive.len() as u64 > most_entries {
            return Err(Error::TooBig {
                path: path.to_owned(),
                what: "entries",
                limit: most_entries,
            });
        }
        let folder = tempfile::Builder::new()
            .prefix("fmu")
            .tempdir()
            .map_err(|source| Error::File {
                path: std::env::temp_dir(),
                source,
            })?;
        let mut bytes_left = most_bytes;
        for index in 0..archive.len() {
            let written = extract(path, &mut archive, index, folder.path(), bytes_left)?;
            bytes_left = bytes_left.checked_sub(written).ok_or(Error::TooBig {
                path: path.to_owned(),
                what: "bytes when unpacked",
                limit: most_bytes,
            })?;
        }
        let xml = folder.path().join("modelDescription.xml");
        if !xml.is_file() {
            return Err(Error::NoDescription {
                path: path.to_owned(),
            });
        }
        let xml =
            std::fs::read_to_string(&xml).map_err(|source| Error::File { path: xml, source })?;
        let description =
            ModelDescription::from_xml(&xml).map_err(|source| Error::Description {
                path: path.to_owned(),
                source,
            })?;
        Ok(Self {
            path: path.to_owned(),
            folder,
            description,
        })
    }

    /// The file it came from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What modelDescription.xml says.
    pub fn description(&self) -> &ModelDescription {
        &self.description
    }

    /// Platforms for which it has a co-simulation binary.
    pub fn platforms(&self) -> Vec<Platform> {
        Platform::ALL
            .into_iter()
            .filter(|&platform| self.library(platform).is_some_and(|path| path.is_file()))
            .collect()
    }

    /// Where the binary for a platform would be.
    fn library(&self, platform: Platform) -> Option<PathBuf> {
        let co_simulation = self.description.co_simulation.as_ref()?;
        let path = platform.library(&co_simulation.model_identifier);
        Some(self.folder.path().join(path))
    }

    /// The binary for this machine.
    pub(crate) fn own_library(&self) -> Result<PathBuf, Error> {
        if self.description.co_simulation.is_none() {
            return Err(Error::NotCoSimulation {
                path: self.path.clone(),
            });
        }
        Platform::current()
            .and_then(|platform| self.library(platform))
            .filter(|path| path.is_file())
            .ok_or_else(|| Error::NoBinary {
                path: self.path.clone(),
                expected: Platform::current(),
                found: self.platforms(),
            })
    }

    /// The `resources` folder as a file URI (RFC 3986), whether it exists or not.
    pub(crate) fn resource_location(&self) -> String {
        let path = self.folder.path().join("resources");
        let mut uri = "file://".to_owned();
        let path = path.to_string_lossy().replace('\\', "/");
        if !path.starts_with('/') {
            uri.push('/');
        }
        for byte in path.bytes() {
            if byte.is_ascii_alphanumeric() || b"/-._~:".contains(&byte) {
                uri.push(char::from(byte));
            } else {
                uri.push('%');
                uri.extend(
                    [byte >> 4, byte & 15]
                        .map(|digit| char::from(b"0123456789ABCDEF"[usize::from(digit)])),
                );
            }
        }
        uri
    }
}

/// Writes one entry below `folder`; how many bytes that were, at most one more than `most`.
fn extract(
    path: &Path,
    archive: &mut ZipArchive<BufReader<File>>,
    index: usize,
    folder: &Path,
    most: u64,
) -> Result<u64, Error> {
    let entry = archive.by_index(index).map_err(|source| Error::Zip {
        path: path.to_owned(),
        source,
    })?;
    let target = entry.enclosed_name().ok_or_else(|| Error::Escape {
        path: path.to_owned(),
        entry: entry.name().to_owned(),
    })?;
    let target = folder.join(target);
    let write = || {
        if entry.is_dir() {
            std::fs::create_dir_all(&target)?;
            return Ok(0);
        }
        if let Some(parent) = target.parent() {
            std::fs::create_dir_all(parent)?;
        }
        let mut file = File::create(&target)?;
        std::io::copy(&mut entry.take(most.saturating_add(1)), &mut file)
    };
    write().map_err(|source| Error::File {
        path: target.clone(),
        source,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;
    use zip::write::SimpleFileOptions;

    const DESCRIPTION: &str = "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"Empty\" \
                               guid=\"{0}\"><CoSimulation modelIdentifier=\"Empty\"/>\
                               </fmiModelDescription>";

    fn archive(entries: &[(&str, &str)]) -> (TempDir, PathBuf) {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("a b.fmu");
        let mut zip = zip::ZipWriter::new(File::create(&path).expect("writable"));
        for (name, text) in entries {
            zip.start_file(*name, SimpleFileOptions::default())
                .expect("started");
            zip.write_all(text.as_bytes()).expect("written");
        }
        zip.finish().expect("finished");
        (folder, path)
    }

    #[track_caller]
    fn check(entries: &[(&str, &str)], expected: &str) {
        let (_folder, path) = archive(entries);
        let error = Archive::open_within(&path, 3, 1000).expect_err("refused");
        assert!(error.to_string().contains(expected), "{error}");
    }

    #[test]
    fn what_is_no_fmu_is_refused() {
        check(&[], "expected modelDescription.xml");
        check(
            &[("modelDescription.xml", "<html>")],
            "modelDescription.xml: expected an FMI 2.0",
        );
        let (folder, path) = archive(&[]);
        std::fs::write(&path, "no archive").expect("writable");
        let error = Archive::open(&path).expect_err("refused");
        assert!(
            error.to_string().contains("expected an FMU, a zip archive"),
            "{error}"
        );
        let error = Archive::open(&folder.path().join("none.fmu")).expect_err("refused");
        assert!(matches!(error, Error::File { .. }));
    }

    #[test]
    fn no_entry_escapes() {
        check(&[("../evil", "")], "entry \"../evil\" points outside");
        check(&[("a/../../evil", "")], "points outside");
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
    fn platforms_are_listed_and_a_missing_one_is_named() {
        let (_folder, path) = archive(&[
            ("modelDescription.xml", DESCRIPTION),
            ("binaries/darwin32/Empty.dylib", ""),
        ]);
        let archive = Archive::open(&path).expect("an FMU");
        assert_eq!(archive.platforms(), [Platform::Darwin32]);
        let error = archive.own_library().expect_err("another platform");
        assert!(error.to_string().ends_with("found darwin32"), "{error}");
        assert!(archive.resource_location().ends_with("/resources"));
    }
}
