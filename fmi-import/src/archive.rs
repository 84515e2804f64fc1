//! The archive: unpacked to a temporary folder, its description read.

pub(crate) mod text;
pub(crate) mod unpack;
mod uri;

use crate::Error;
use model_description::{ModelDescription, Platform};
use std::path::{Path, PathBuf};
use unpack::{Limits, Unpacked};

/// An unpacked FMU; its folder is removed when this is dropped.
#[derive(Debug)]
pub struct Archive {
    path: PathBuf,
    unpacked: Unpacked,
    description: ModelDescription,
    /// What was wrong with the description's encoding.
    encoding: Option<String>,
}

impl Archive {
    /// Unpacks the FMU at `path` and reads its description.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let unpacked = unpack::unpack(path, &Limits::default())?;
        let xml = unpacked.folder.path().join("modelDescription.xml");
        if !xml.is_file() {
            return Err(Error::NoDescription {
                path: path.to_owned(),
            });
        }
        let bytes = std::fs::read(&xml).map_err(|source| Error::File { path: xml, source })?;
        let (xml, encoding) = text::decode(&bytes);
        if let Some(found) = text::fmi_version(&xml).filter(|found| !found.starts_with("2.")) {
            return Err(Error::FmiVersion {
                path: path.to_owned(),
                found: found.to_owned(),
            });
        }
        let description =
            ModelDescription::from_xml(&xml).map_err(|source| Error::Description {
                path: path.to_owned(),
                source,
            })?;
        Ok(Self {
            path: path.to_owned(),
            unpacked,
            description,
            encoding,
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

    /// Names of the files in it, folders separated by `/`.
    pub fn files(&self) -> &[String] {
        &self.unpacked.files
    }

    /// Names of the symbolic links in it; they are left out.
    pub fn links(&self) -> &[String] {
        &self.unpacked.links
    }

    /// What was wrong with the encoding of modelDescription.xml.
    pub(crate) fn encoding(&self) -> Option<&str> {
        self.encoding.as_deref()
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
        let path = unpack::inside(&platform.library(&co_simulation.model_identifier))?;
        Some(self.unpacked.folder.path().join(path))
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
        uri::file(&self.unpacked.folder.path().join("resources"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use unpack::tests::archive;

    const DESCRIPTION: &str = "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"Empty\" \
                               guid=\"{0}\"><CoSimulation modelIdentifier=\"Empty\"/>\
                               </fmiModelDescription>";

    #[track_caller]
    fn check(entries: &[(&str, &str)], expected: &str) {
        let (_folder, path) = archive(entries);
        let error = Archive::open(&path).expect_err("refused");
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
    fn other_versions_are_named() {
        let one = "<?xml version=\"1.0\"?><fmiModelDescription fmiVersion=\"1.0\" \
                   modelName=\"M\" modelIdentifier=\"M\" guid=\"\" numberOfEventIndicators=\"0\"/>";
        check(
            &[("modelDescription.xml", one)],
            "expected FMI 2.0, found FMI 1.0",
        );
        let three = "<fmiModelDescription\n  fmiVersion = '3.0' modelName=\"M\" \
                     instantiationToken=\"\"><ModelVariables><Float64 name=\"x\" \
                     valueReference=\"1\"/></ModelVariables></fmiModelDescription>";
        check(
            &[("modelDescription.xml", three)],
            "expected FMI 2.0, found FMI 3.0",
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

    #[test]
    fn a_library_is_not_looked_for_outside() {
        let description =
            DESCRIPTION.replace("modelIdentifier=\"Empty\"", "modelIdentifier=\"../../x\"");
        let (_folder, path) = archive(&[("modelDescription.xml", &description)]);
        let archive = Archive::open(&path).expect("an FMU");
        assert!(archive.own_library().is_err());
    }
}
