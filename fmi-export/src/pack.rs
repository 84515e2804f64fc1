//! The archive: description, libraries, start values, documentation.

use crate::date::{iso, source_date};
use crate::{Error, Library, start};
use model_description::{ModelDescription, Platform};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use zip::write::SimpleFileOptions;
use zip::{DateTime, ZipWriter};

/// Path in the archive, and contents.
type Entry = (String, Vec<u8>);

/// What goes into an FMU.
///
/// Same contents, same bytes: entries are in a fixed order and dated by `SOURCE_DATE_EPOCH`,
/// else 1980.
#[derive(Clone, Debug)]
pub struct Package {
    /// modelDescription.xml, complete but for the date. The guid is the fingerprint; it may be
    /// left empty, but may not be another.
    pub description: ModelDescription,
    /// The shared library of each platform.
    pub libraries: Vec<(Platform, PathBuf)>,
    /// Further files: path in the archive, e.g. `documentation/index.html`, and contents.
    pub files: Vec<(String, Vec<u8>)>,
}

impl Package {
    /// The description in the file `path`, without libraries and files yet.
    pub fn from_xml(path: &Path) -> Result<Self, Error> {
        let text = String::from_utf8(read(path)?).map_err(|_| {
            Error::Description(format!(
                "{}: expected UTF-8, found other bytes",
                path.display()
            ))
        })?;
        let description = ModelDescription::from_xml(&text)
            .map_err(|error| Error::Description(format!("{}: {error}", path.display())))?;
        Ok(Self {
            description,
            libraries: Vec::new(),
            files: Vec::new(),
        })
    }

    /// Writes the FMU to `out`: first under a temporary name beside it, then renamed. Libraries
    /// are examined before, not loaded; returns what was found, one for each.
    pub fn write(&self, out: &Path) -> Result<Vec<Library>, Error> {
        let fail = |source| Error::File {
            path: out.to_owned(),
            source,
        };
        let date = source_date()?;
        let (entries, libraries) = self.entries(date)?;
        let folder = match out.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        let temporary = tempfile::Builder::new()
            .prefix(".fmu")
            .tempfile_in(folder)
            .map_err(fail)?;
        write_archive(temporary.as_file(), &entries, date.unwrap_or_default()).map_err(
            |source| Error::Zip {
                path: out.to_owned(),
                source,
            },
        )?;
        make_readable(temporary.as_file()).map_err(fail)?;
        temporary.persist(out).map_err(|error| fail(error.error))?;
        Ok(libraries)
    }

    /// Paths and contents in the order of the archive.
    fn entries(&self, date: Option<DateTime>) -> Result<(Vec<Entry>, Vec<Library>), Error> {
        let mut description = self.description.clone();
        description.guid = description.fingerprint();
        if ![&description.guid, ""].contains(&self.description.guid.as_str()) {
            return Err(Error::Fingerprint {
                expected: description.guid,
                found: self.description.guid.clone(),
            });
        }
        if let Some(date) = date {
            description.generation_date_and_time = Some(iso(date));
        }
        let identifier = description
            .co_simulation
            .as_ref()
            .map(|co_simulation| co_simulation.model_identifier.clone())
            .ok_or_else(|| Error::Description("expected CoSimulation, found none".to_owned()))?;

        let letters = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
        if !identifier.bytes().all(letters) || identifier.starts_with(|c: char| c.is_ascii_digit())
        {
            return Err(Error::Description(format!(
                "modelIdentifier: expected an identifier of C, found {identifier:?}"
            )));
        }
        let mut entries = vec![
            (
                "modelDescription.xml".to_owned(),
                description.to_xml()?.into_bytes(),
            ),
            (
                format!("resources/{}", start::FILE_NAME),
                start::to_json(&description).into_bytes(),
            ),
        ];
        let mut libraries = Vec::new();
        for (platform, path) in &self.libraries {
            let bytes = read(path)?;
            libraries.push(examine(&bytes, *platform, path)?);
            entries.push((platform.library(&identifier), bytes));
        }
        for (path, bytes) in &self.files {
            check_path(path)?;
            entries.push((path.clone(), bytes.clone()));
        }
        // The description comes first, for those who read the archive as a stream.
        entries[1..].sort();
        let twice = entries[1..].windows(2).find(|pair| pair[0].0 == pair[1].0);
        match twice {
            Some(pair) => Err(Error::SameEntry {
                path: pair[0].0.clone(),
            }),
            None => Ok((entries, libraries)),
        }
    }
}

/// The facts of a library, if it can serve on `platform`.
fn examine(bytes: &[u8], platform: Platform, path: &Path) -> Result<Library, Error> {
    let path = path.to_owned();
    let library = match Library::read(bytes) {
        Ok(library) => library,
        Err(found) => return Err(Error::NoLibrary { path, found }),
    };
    if library.platform != platform {
        return Err(Error::OtherPlatform {
            path,
            expected: platform,
            found: library.platform,
        });
    }
    let missing = library.missing();
    if !missing.is_empty() {
        return Err(Error::MissingFunctions { path, missing });
    }
    Ok(library)
}

/// Entries are named relative to the archive.
fn check_path(path: &str) -> Result<(), Error> {
    let is_name = |name: &str| !["", ".", ".."].contains(&name);
    if path.split('/').all(is_name) && !path.contains(['\\', ':']) && path != "modelDescription.xml"
    {
        return Ok(());
    }
    Err(Error::Entry {
        path: path.to_owned(),
    })
}

fn read(path: &Path) -> Result<Vec<u8>, Error> {
    std::fs::read(path).map_err(|source| Error::File {
        path: path.to_owned(),
        source,
    })
}

fn write_archive(
    file: &File,
    entries: &[(String, Vec<u8>)],
    date: DateTime,
) -> zip::result::ZipResult<()> {
    let options = SimpleFileOptions::default()
        .compression_method(zip::CompressionMethod::Deflated)
        .last_modified_time(date);
    let mut archive = ZipWriter::new(BufWriter::new(file));
    for (path, bytes) in entries {
        let mode = if path.starts_with("binaries/") {
            0o755
        } else {
            0o644
        };
        archive.start_file(path, options.unix_permissions(mode))?;
        archive.write_all(bytes)?;
    }
    archive.finish()?.flush()?;
    Ok(())
}

/// Temporary files are made for their owner only; an FMU is for others.
#[cfg(unix)]
fn make_readable(file: &File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn make_readable(_: &File) -> std::io::Result<()> {
    Ok(())
}
