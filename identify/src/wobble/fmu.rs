//! The command fmu: packs the bicycle, or any model, with its libraries.

mod library;

use crate::arguments::BicycleArguments;
use crate::fitted;
use crate::output::Output;
use anyhow::{Context, Result, bail};
use clap::Args;
use fmi_import::model_description::Platform;
use fmi_import::{Error as Refusal, Fmu as Loaded, LogLine};
use fmu::{Library, Package, Starts};
use serde_json::json;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct Fmu {
    #[command(flatten)]
    bicycle: BicycleArguments,
    /// Fitted values: the fit.json of a fit, on top of the bicycle it was made with
    #[arg(long, value_name = "FILE", conflicts_with_all = ["bicycle", "rider"])]
    parameters: Option<PathBuf>,
    /// Pack another model than the bicycle: its modelDescription.xml
    #[arg(
        long,
        value_name = "FILE",
        requires = "library",
        conflicts_with_all = ["bicycle", "set", "load", "rider", "formulation", "parameters"]
    )]
    description: Option<PathBuf>,
    /// Shared library for a platform such as win64, else for this machine's [default: the
    /// bicycle's beside this program]
    #[arg(long, value_name = "[PLATFORM=]FILE")]
    library: Vec<String>,
    /// Folder whose files go under documentation/
    #[arg(long, value_name = "FOLDER")]
    documentation: Option<PathBuf>,
    /// The FMU to write [default: the model's name, .fmu]
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Fmu {
    pub fn run(&self) -> Result<()> {
        let mut libraries = library::typed(&self.library)?;
        let mut package = if let Some(path) = &self.description {
            Package::from_xml(path)?
        } else {
            let here = Platform::current();
            if let Some(here) = here.filter(|here| libraries.iter().all(|(p, _)| p != here)) {
                libraries.insert(0, (here, fmu::built_library()?));
            }
            fmu::package(&self.starts()?)?
        };
        let ours = self.description.is_none();
        for (platform, path) in &libraries {
            if !path.is_file() {
                bail!(library::missing(*platform, path, ours));
            }
        }
        package.libraries = libraries;
        if let Some(folder) = &self.documentation {
            collect(folder, "documentation", &mut package.files)?;
        }
        let out = match &self.out {
            Some(out) => out.clone(),
            None => format!("{}.fmu", package.description.model_name).into(),
        };
        let found = put_in_place(&package, &out)?;
        self.tell(&package, &found, &out)
    }

    /// What the bicycle starts from.
    fn starts(&self) -> Result<Starts> {
        let bicycle = fitted::open(self.parameters.as_deref(), &self.bicycle)?;
        fitted::tell_excitation(&bicycle, "the FMU excites nothing itself");
        Ok(fitted::starts(&bicycle))
    }

    fn tell(&self, package: &Package, found: &[Library], out: &Path) -> Result<()> {
        let description = &package.description;
        eprintln!("wrote {}: {}", out.display(), description.model_name);
        let mut rows = Vec::new();
        for ((_, path), library) in package.libraries.iter().zip(found) {
            let (platform, file) = (library.platform, path.display());
            let glibc = library.glibc.map(|glibc| glibc.to_string());
            let needs = match library.needs.as_slice() {
                [] => "no library".to_owned(),
                needs => needs.join(", "),
            };
            let exports = library.exports.len();
            eprintln!("{platform}: {file}, exports {exports} functions, needs {needs}");
            if let Some(glibc) = &glibc {
                eprintln!("{platform}: runs with glibc {glibc} or newer");
            }
            let warnings: Vec<_> = library.warnings().iter().map(ToString::to_string).collect();
            for warning in &warnings {
                eprintln!("warning: {platform}: {warning}");
            }
            rows.push(json!({
                "platform": platform.folder(), "file": file.to_string(), "exports": exports,
                "needs": library.needs, "glibc": glibc, "warnings": warnings,
            }));
        }
        let output = Output {
            json: self.json,
            out: None,
        };
        let json = json!({
            "fmu": out.display().to_string(), "model": description.model_name,
            "guid": description.fingerprint(), "libraries": rows,
        });
        output.json_or(&json, String::new)
    }
}

/// The files below `folder`, as paths below `name`.
fn collect(folder: &Path, name: &str, files: &mut Vec<(String, Vec<u8>)>) -> Result<()> {
    let unreadable = || format!("{}: expected a folder of files", folder.display());
    for entry in std::fs::read_dir(folder).with_context(unreadable)? {
        let path = entry.with_context(unreadable)?.path();
        let last = path.file_name().unwrap_or_default();
        let Some(last) = last.to_str() else {
            bail!("{}: expected a name in UTF-8", path.display());
        };
        let name = format!("{name}/{last}");
        let kind = path.symlink_metadata().with_context(unreadable)?;
        if kind.is_dir() {
            collect(&path, &name, files)?;
        } else if kind.is_file() {
            files.push((name, identify::file::read(&path)?));
        } else {
            bail!(
                "{}: expected a file or a folder, found neither",
                path.display()
            );
        }
    }
    Ok(())
}

/// Writes the FMU beside `out`, tries it where this machine can, and only then gives it its name.
fn put_in_place(package: &Package, out: &Path) -> Result<Vec<Library>> {
    let folder = match out.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let trial = tempfile::Builder::new()
        .prefix(".fmu")
        .tempdir_in(folder)
        .with_context(|| format!("{}: expected a folder to write to", folder.display()))?;
    let written = trial.path().join("trial.fmu");
    let found = package.write(&written)?;
    let here = |(platform, _): &&(Platform, PathBuf)| Platform::current() == Some(*platform);
    if let Some((platform, library)) = package.libraries.iter().find(here) {
        try_out(&written).with_context(|| format!("{platform}: {}", library.display()))?;
    }
    std::fs::rename(&written, out)
        .with_context(|| format!("{}: cannot be written", out.display()))?;
    Ok(found)
}

/// Loads the FMU and instantiates it once. Whether it initialises is no condition: the start
/// values may be meant to be changed.
fn try_out(path: &Path) -> Result<()> {
    let loaded = Loaded::open(path)?;
    let mut instance = loaded
        .instantiate("trial")
        .map_err(|refusal| match &refusal {
            Refusal::NotInstantiated { log } if is_about_the_guid(log) => anyhow::Error::new(
                refusal,
            )
            .context("library and description do not belong together: build the library anew"),
            _ => refusal.into(),
        })?;
    let initialized = instance
        .setup_experiment(None, 0.0, None)
        .and_then(|()| instance.enter_initialization_mode())
        .and_then(|()| instance.exit_initialization_mode());
    if let Err(refusal) = initialized {
        eprintln!("note: with its start values the model does not initialise: {refusal}");
    }
    Ok(())
}

fn is_about_the_guid(log: &[LogLine]) -> bool {
    log.iter()
        .any(|line| line.message.to_lowercase().contains("guid"))
}
