//! The archive: description, libraries, documentation.

use crate::Error;
use crate::date::{iso, source_date};
use model_description::{ModelDescription, Platform};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use zip::write::SimpleFileOptions;
use zip::{DateTime, ZipWriter};

/// What goes into an FMU.
///
/// Same contents, same bytes: entries are in a fixed order and dated by `SOURCE_DATE_EPOCH`,
/// else 1980.
#[derive(Clone, Debug)]
pub struct Package {
    /// modelDescription.xml, complete but for the guid and the date.
    pub description: ModelDescription,
    /// The shared library of each platform.
    pub libraries: Vec<(Platform, PathBuf)>,
    /// Further files: path in the archive, e.g. `documentation/index.html`, and contents.
    pub files: Vec<(String, Vec<u8>)>,
}

impl Package {
    /// Writes the FMU to `out`: first under a temporary name beside it, then renamed.
    pub fn write(&self, out: &Path) -> Result<(), Error> {
        let fail = |source| Error::File {
            path: out.to_owned(),
            source,
        };
        let date = source_date()?;
        let mut description = self.description.clone();
        description.guid = description.fingerprint();
        description.generation_date_and_time = date.map(iso);
        let identifier = description
            .co_simulation
            .as_ref()
            .map(|co_simulation| co_simulation.model_identifier.clone())
            .ok_or_else(|| Error::Description("expected CoSimulation, found none".to_owned()))?;

        let mut entries = vec![(
            "modelDescription.xml".to_owned(),
            description.to_xml()?.into_bytes(),
        )];
        for (platform, library) in &self.libraries {
            let bytes = std::fs::read(library).map_err(|source| Error::File {
                path: library.clone(),
                source,
            })?;
            entries.push((platform.library(&identifier), bytes));
        }
        entries.extend(self.files.iter().cloned());
        // The description comes first, for those who read the archive as a stream.
        entries[1..].sort();

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
        Ok(())
    }
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
