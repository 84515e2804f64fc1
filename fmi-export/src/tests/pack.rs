use super::cart::Cart;
use crate::{Error, Model, Package};
use model_description::{ModelDescription, Platform};
use std::io::Read;

fn package(library: &std::path::Path) -> Package {
    Package {
        description: Cart::description(),
        libraries: vec![(Platform::Linux64, library.to_owned())],
        files: vec![("documentation/index.html".to_owned(), b"<html/>".to_vec())],
    }
}

#[test]
fn an_fmu_holds_what_was_packed_and_the_same_bytes_every_time() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let library = folder.path().join("libcart.so");
    std::fs::write(&library, b"library").expect("writable");
    let [first, second] = ["a.fmu", "b.fmu"].map(|name| {
        let out = folder.path().join(name);
        package(&library).write(&out).expect("packed");
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
            "documentation/index.html"
        ]
    );
    let mut xml = String::new();
    archive
        .by_index(0)
        .expect("first entry")
        .read_to_string(&mut xml)
        .expect("text");
    let description = ModelDescription::from_xml(&xml).expect("a description");
    assert_eq!(description.guid, Cart::description().fingerprint());
}

#[test]
fn a_missing_library_leaves_nothing_behind() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let missing = folder.path().join("libcart.so");
    let out = folder.path().join("Cart.fmu");
    let error = package(&missing).write(&out).expect_err("no library");
    assert!(matches!(&error, Error::File { path, .. } if *path == missing));
    assert_eq!(std::fs::read_dir(folder.path()).expect("folder").count(), 0);
}
