//! The foreign FMU, compiled and packed.

use fmi_import::Fmu;
use model_description::Platform;
use std::collections::HashMap;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, LazyLock, Mutex};
use tempfile::TempDir;
use zip::write::{SimpleFileOptions, ZipWriter};

const DESCRIPTION: &str = include_str!("modelDescription.xml");

/// What is different about an FMU.
#[derive(Clone, Copy, Default)]
pub struct Variant<'a> {
    /// Macros for the C compiler.
    pub defines: &'a [&'static str],
    /// What to write instead of what in the description.
    pub edits: &'a [(&'a str, &'a str)],
    /// Files to add, each with its text.
    pub files: &'a [(&'a str, &'a str)],
    /// To leave out the binary.
    pub without_binary: bool,
}

impl Variant<'_> {
    /// The FMU as a file, which lies in the folder.
    pub fn pack(&self) -> (TempDir, PathBuf) {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("foreign.fmu");
        let mut description = DESCRIPTION.to_owned();
        for (from, to) in self.edits {
            assert!(description.contains(from), "{from}");
            description = description.replace(from, to);
        }
        let mut zip = ZipWriter::new(File::create(&path).expect("writable"));
        let mut add = |name: &str, bytes: &[u8]| {
            zip.start_file(name, SimpleFileOptions::default())
                .expect("started");
            zip.write_all(bytes).expect("written");
        };
        add("modelDescription.xml", description.as_bytes());
        add("resources/here.txt", b"");
        for (name, text) in self.files {
            add(name, text.as_bytes());
        }
        if !self.without_binary {
            let platform = Platform::current().expect("a platform of the standard");
            add(&platform.library("foreign"), &library(self.defines));
        }
        zip.finish().expect("finished");
        (folder, path)
    }

    /// The FMU loaded.
    pub fn load(&self) -> Fmu {
        let (_folder, path) = self.pack();
        Fmu::open(&path).expect("loaded")
    }
}

/// The value reference of a variable.
pub fn reference(fmu: &Fmu, name: &str) -> u32 {
    let variable = fmu.description().variable(name);
    variable.expect("a variable").value_reference
}

type Compiled = HashMap<Vec<&'static str>, Arc<[u8]>>;

/// The library, compiled once for each set of macros.
fn library(defines: &[&'static str]) -> Arc<[u8]> {
    static COMPILED: LazyLock<Mutex<Compiled>> = LazyLock::new(Mutex::default);
    let mut compiled = COMPILED.lock().expect("nobody panics here");
    let bytes = compiled
        .entry(defines.to_vec())
        .or_insert_with(|| compile(defines));
    Arc::clone(bytes)
}

fn compile(defines: &[&str]) -> Arc<[u8]> {
    let folder = tempfile::tempdir().expect("temporary folder");
    let library = folder.path().join("foreign.so");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/foreign/foreign.c");
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    let status = Command::new(compiler)
        .args(["-shared", "-fPIC", "-O1", "-Wall", "-Wextra", "-o"])
        .arg(&library)
        .args(defines.iter().map(|name| format!("-D{name}")))
        .arg(source)
        .arg("-lm")
        .status()
        .expect("a C compiler");
    assert!(status.success());
    std::fs::read(library).expect("compiled").into()
}
