use super::cart::Cart;
use crate::{Error, Function, Glibc, Library, Model, Package, Warning};
use model_description::{ModelDescription, Platform};
use std::io::Read;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// The functions of the standard.
fn functions() -> Vec<&'static str> {
    let stateless = ["fmi2GetTypesPlatform", "fmi2GetVersion", "fmi2Instantiate"];
    let others = Function::ALL.iter().map(|function| function.name);
    stateless.into_iter().chain(others).collect()
}

/// Names, each ended by a zero, and where they begin.
struct Strings(Vec<u8>);

impl Strings {
    fn add(&mut self, name: &str) -> u32 {
        let at = self.0.len() as u32;
        self.0.extend(name.bytes());
        self.0.push(0);
        at
    }
}

/// A shared library for x86-64 Linux without code: section headers and what they list. Versions
/// come with their flags (2: weak).
fn elf(exports: &[&str], needs: &[&str], versions: &[(&str, u16)]) -> Vec<u8> {
    let mut strings = Strings(vec![0]);
    let mut symbols = vec![0; 24];
    for name in exports {
        symbols.extend(strings.add(name).to_le_bytes());
        // global function in section 1, then value and size
        symbols.extend([0x12, 0, 1, 0]);
        symbols.extend([0; 16]);
    }
    let mut dynamic = Vec::new();
    for name in needs {
        dynamic.extend(1_u64.to_le_bytes());
        dynamic.extend(u64::from(strings.add(name)).to_le_bytes());
    }
    dynamic.extend([0; 16]);
    let mut required = Vec::new();
    required.extend(1_u16.to_le_bytes());
    required.extend((versions.len() as u16).to_le_bytes());
    required.extend(
        [strings.add("libc.so.6"), 16, 0]
            .map(u32::to_le_bytes)
            .concat(),
    );
    for (i, (name, flags)) in versions.iter().enumerate() {
        let next = if i + 1 < versions.len() { 16 } else { 0 };
        required.extend(0_u32.to_le_bytes());
        required.extend([flags.to_le_bytes(), 2_u16.to_le_bytes()].concat());
        required.extend([strings.add(name), next].map(u32::to_le_bytes).concat());
    }
    // type, link, info, size of an entry, contents
    let sections: [(u32, u32, u32, u64, &[u8]); 5] = [
        (0, 0, 0, 0, &[]),
        (3, 0, 0, 0, &strings.0),
        (11, 1, 1, 24, &symbols),
        (6, 1, 0, 16, &dynamic),
        (0x6fff_fffe, 1, 1, 0, &required),
    ];
    let contents: Vec<u8> = sections.iter().flat_map(|s| s.4).copied().collect();
    let mut file = b"\x7fELF\x02\x01\x01\0\0\0\0\0\0\0\0\0".to_vec();
    file.extend([3_u16, 62].map(u16::to_le_bytes).concat());
    file.extend(1_u32.to_le_bytes());
    file.extend(
        [0, 0, 64 + contents.len() as u64]
            .map(u64::to_le_bytes)
            .concat(),
    );
    file.extend(0_u32.to_le_bytes());
    file.extend([64_u16, 56, 0, 64, 5, 1].map(u16::to_le_bytes).concat());
    let mut offset = file.len() as u64;
    file.extend(contents);
    for (kind, link, info, entry, contents) in sections {
        file.extend([0, kind].map(u32::to_le_bytes).concat());
        let size = contents.len() as u64;
        file.extend([0, 0, offset, size].map(u64::to_le_bytes).concat());
        file.extend([link, info].map(u32::to_le_bytes).concat());
        file.extend([1, entry].map(u64::to_le_bytes).concat());
        offset += size;
    }
    file
}

/// A DLL for x86-64 that has nothing but headers.
fn pe() -> Vec<u8> {
    let mut file = b"MZ".to_vec();
    file.resize(60, 0);
    file.extend(64_u32.to_le_bytes());
    file.extend(b"PE\0\0\x64\x86");
    file.extend([0; 14]);
    file.extend([112_u16, 0x2022, 0x20b].map(u16::to_le_bytes).concat());
    file.extend([0; 110]);
    file
}

/// A dylib for arm64 that has nothing but its header.
fn mach_o() -> Vec<u8> {
    [0xfeed_facf_u32, 0x0100_000c, 0, 6, 0, 0, 0, 0]
        .map(u32::to_le_bytes)
        .concat()
}

fn package(library: &Path) -> Package {
    Package {
        description: Cart::description(),
        libraries: vec![(Platform::Linux64, library.to_owned())],
        files: vec![("documentation/index.html".to_owned(), b"<html/>".to_vec())],
    }
}

/// A folder with a library of these bytes.
fn library(bytes: &[u8]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("libcart.so");
    std::fs::write(&path, bytes).expect("writable");
    (folder, path)
}

fn good() -> Vec<u8> {
    elf(&functions(), &["libc.so.6"], &[("GLIBC_2.2.5", 0)])
}

#[test]
fn an_fmu_holds_what_was_packed_and_the_same_bytes_every_time() {
    let (folder, library) = library(&good());
    let [first, second] = ["a.fmu", "b.fmu"].map(|name| {
        let out = folder.path().join(name);
        let found = package(&library).write(&out).expect("packed");
        assert_eq!(found.len(), 1);
        std::fs::read(out).expect("readable")
    });
    assert!(first == second, "the archives differ");

    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(first)).expect("an archive");
    let names: Vec<String> = archive.file_names().map(str::to_owned).collect();
    assert_eq!(
        names,
        [
            "modelDescription.xml",
            "binaries/linux64/Cart.so",
            "documentation/index.html",
            "resources/start.json",
        ]
    );
    let mut text = |name: &str| {
        let mut text = String::new();
        let mut entry = archive.by_name(name).expect("an entry");
        entry.read_to_string(&mut text).expect("text");
        text
    };
    let description = ModelDescription::from_xml(&text("modelDescription.xml")).expect("XML");
    assert_eq!(description.guid, Cart::description().fingerprint());
    let starts = crate::start::to_json(&Cart::description());
    assert_eq!(text("resources/start.json"), starts);
}

#[test]
fn what_cannot_be_packed_is_refused_and_leaves_nothing_behind() {
    let check = |bytes: &[u8], change: &dyn Fn(&mut Package), expected: &str| {
        let (folder, library) = library(bytes);
        let mut package = package(&library);
        change(&mut package);
        let out = folder.path().join("Cart.fmu");
        let error = package.write(&out).expect_err("refused").to_string();
        assert!(error.contains(expected), "{error}");
        let left = std::fs::read_dir(folder.path()).expect("folder").count();
        assert_eq!(left, 1, "only the library: {expected}");
    };
    let nothing = |_: &mut Package| {};
    check(b"library", &nothing, "expected a shared library");
    check(b"!<arch>\n        ", &nothing, "found a static library");
    check(
        &pe(),
        &nothing,
        "expected a library for linux64, found one for win64",
    );
    check(&mach_o(), &nothing, "found one for darwin64");
    check(
        &elf(&functions()[1..], &[], &[]),
        &nothing,
        "not exported: fmi2GetTypesPlatform",
    );
    let arm = {
        let mut arm = good();
        arm[18] = 183;
        arm
    };
    check(&arm, &nothing, "found Elf for Aarch64");
    let twice = |p: &mut Package| p.libraries.push(p.libraries[0].clone());
    check(
        &good(),
        &twice,
        "binaries/linux64/Cart.so: expected one file",
    );
    for path in [
        "../evil",
        "/etc/passwd",
        "a//b",
        "a\\b",
        "C:/x",
        "",
        "modelDescription.xml",
    ] {
        let outside = |p: &mut Package| p.files.push((path.to_owned(), Vec::new()));
        check(&good(), &outside, "expected a path below the root");
    }
    let changed = |p: &mut Package| {
        p.description.guid = Cart::description().fingerprint();
        p.description.variables.pop();
    };
    check(&good(), &changed, "its fingerprint, found {");
}

#[test]
fn a_missing_library_or_folder_is_named() {
    let (folder, library) = library(&good());
    let missing = folder.path().join("none.so");
    let error = package(&missing).write(&folder.path().join("Cart.fmu"));
    assert!(matches!(error, Err(Error::File { path, .. }) if path == missing));
    let nowhere = folder.path().join("none").join("Cart.fmu");
    let error = package(&library).write(&nowhere);
    assert!(matches!(error, Err(Error::File { path, .. }) if path == nowhere));
}

#[test]
fn facts_of_a_library() {
    let read = |bytes: &[u8]| Library::read(bytes).expect("a library");
    let exports = [&functions()[..], &["rust_eh_personality"]].concat();
    let needs = ["libm.so.6", "libssl.so.3", "ld-linux-x86-64.so.2"];
    let versions = [
        ("GLIBC_2.9", 0),
        ("GLIBC_2.17", 0),
        ("GLIBC_2.38", 2),
        ("GCC_3.0", 0),
    ];
    let found = read(&elf(&exports, &needs, &versions));
    assert_eq!(found.platform, Platform::Linux64);
    assert_eq!(found.exports.len(), exports.len());
    assert_eq!(found.needs, needs);
    assert_eq!(
        found.glibc,
        Some(Glibc {
            major: 2,
            minor: 17
        }),
        "weak ones may be absent"
    );
    assert!(found.missing().is_empty());
    assert_eq!(
        found.warnings(),
        [
            Warning::Exports(vec!["rust_eh_personality".to_owned()]),
            Warning::Needs(vec!["libssl.so.3".to_owned()]),
        ]
    );
    assert!(read(&good()).warnings().is_empty());
    assert_eq!(read(&elf(&[], &[], &[])).glibc, None);
    assert_eq!(read(&pe()).platform, Platform::Win64);
    assert_eq!(read(&mach_o()).platform, Platform::Darwin64);
}

#[test]
fn half_a_library_is_refused_in_words() {
    let whole = good();
    for length in 0..whole.len() {
        let read = Library::read(&whole[..length]);
        assert!(read.is_err(), "{length} bytes of {}", whole.len());
    }
}
