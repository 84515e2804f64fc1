//! The program packs FMUs, looks at them and simulates them.

use crate::wobble::{json, wobble};
use bicycle::{Input, Parameters};
use fmi_import::Archive;
use fmi_import::model_description::{Platform, VariableType};
use fmu::Library;
use identify::run::Run;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

fn folder() -> TempDir {
    tempfile::tempdir().expect("temporary folder")
}

#[track_caller]
fn packed(folder: &Path, arguments: &str) -> Archive {
    let called = wobble(folder, &format!("fmu {arguments} -o packed.fmu"));
    assert_eq!(called.code, 0, "{}", called.err);
    Archive::open(&folder.join("packed.fmu")).expect("an FMU")
}

/// The start value of a `Real` in the description.
fn start(archive: &Archive, name: &str) -> f64 {
    match &archive
        .description()
        .variable(name)
        .expect(name)
        .variable_type
    {
        VariableType::Real(real) => real.start.expect("a start value"),
        other => panic!("{name}: {other:?}"),
    }
}

/// The values that start.json holds, and the guid.
fn starts(folder: &Path) -> serde_json::Value {
    let file = std::fs::File::open(folder.join("packed.fmu")).expect("an FMU");
    let mut archive = zip::ZipArchive::new(file).expect("an archive");
    let entry = archive.by_name("resources/start.json").expect("packed");
    serde_json::from_reader(entry).expect("JSON")
}

#[test]
fn start_values_are_the_same_in_description_file_and_instance() {
    let folder = folder();
    let archive = packed(
        folder.path(),
        "--bicycle section3 --set roll_start=3deg --load 12.3kg",
    );
    let starts = starts(folder.path());
    assert_eq!(starts["guid"], archive.description().guid);
    assert_eq!(
        start(&archive, "roll_start").to_bits(),
        3_f64.to_radians().to_bits()
    );
    let guid = archive.description().guid.clone();
    let fmu = fmi_import::Fmu::load(archive).expect("loaded");
    let mut instance = fmu.instantiate("bicycle").expect("an instance");
    for _ in 0..2 {
        instance.setup_experiment(None, 0.0, None).expect("legal");
        instance.enter_initialization_mode().expect("legal");
        for row in Parameters::TABLE.iter().chain(Input::TABLE) {
            let variable = fmu.description().variable(row.name).expect("a variable");
            let described = start(fmu.archive(), row.name).to_bits();
            let in_file = starts["start"][row.name].as_f64().expect("a number");
            assert_eq!(in_file.to_bits(), described, "{}", row.name);
            let mut found = [f64::NAN];
            instance
                .get_real(&[variable.value_reference], &mut found)
                .expect("read");
            assert_eq!(found[0].to_bits(), described, "{}", row.name);
            // a value that reset must bring back
            let other = [0.5 * (found[0] + 0.5 * (row.min + row.max))];
            if row.name != "internal_step" && other[0].is_finite() {
                instance
                    .set_real(&[variable.value_reference], &other)
                    .expect("within the range");
            }
        }
        instance.reset().expect("legal");
    }
    // the guid does not know the start values
    let nominal = packed(folder.path(), "");
    assert_eq!(nominal.description().guid, guid);
}

#[test]
fn a_fit_is_packed_with_what_it_found() {
    let folder = folder();
    let ride = "simulate --ride --torque --set remnant_intensity=2 -o ride.csv";
    assert_eq!(wobble(folder.path(), ride).code, 0);
    assert_eq!(wobble(folder.path(), "fit ride.csv -o fit.json").code, 0);
    let archive = packed(folder.path(), "--parameters fit.json");
    let run = Run::read(&folder.path().join("fit.json")).expect("a fit");
    for name in ["cornering_stiffness", "camber_stiffness"] {
        let value = run.fit.estimate(name).expect("fitted").value;
        assert_eq!(start(&archive, name).to_bits(), value.to_bits(), "{name}");
    }
}

#[test]
fn a_windows_library_is_merged_where_it_can_be_built() {
    let target = "x86_64-pc-windows-gnu";
    let libraries = Command::new("rustc")
        .args(["--print", "target-libdir", "--target", target])
        .output()
        .expect("rustc starts");
    let libraries = String::from_utf8(libraries.stdout).expect("UTF-8");
    let linker = Command::new("x86_64-w64-mingw32-gcc")
        .arg("--version")
        .output();
    if !Path::new(libraries.trim()).is_dir() || linker.is_err() {
        eprintln!("skipped: the Rust target {target} or its linker is not installed");
        return;
    }
    let folder = folder();
    let built = Command::new("cargo")
        .args([
            "build",
            "--release",
            "--locked",
            "-p",
            "fmu",
            "--target",
            target,
        ])
        .arg("--target-dir")
        .arg(folder.path())
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .status();
    assert!(built.expect("cargo starts").success());
    let library = folder.path().join(target).join("release/fmu.dll");
    let archive = packed(
        folder.path(),
        &format!("--library win64={}", library.display()),
    );
    assert_eq!(archive.platforms(), [Platform::Linux64, Platform::Win64]);
}

#[test]
fn the_library_exports_the_standard_alone_and_needs_little() {
    let folder = folder();
    let mut package = fmu::package(&fmu::Starts::default()).expect("in range");
    let platform = Platform::current().expect("a platform of the standard");
    let library = fmu::built_library().expect("cargo builds it as a dependency");
    package.libraries.push((platform, library));
    let found: Vec<Library> = package
        .write(&folder.path().join("packed.fmu"))
        .expect("written");
    assert_eq!(found[0].warnings(), []);
    assert_eq!(found[0].missing(), [] as [&str; 0]);
    // the 34 functions of a co-simulation FMU
    assert_eq!(found[0].exports.len(), 34, "{:?}", found[0].exports);
}

#[test]
fn an_fmu_is_simulated_to_the_same_bytes_as_the_bicycle() {
    let folder = folder();
    packed(folder.path(), "--bicycle section3");
    let native = wobble(
        folder.path(),
        "simulate --bicycle section3 --set roll_start=2deg --set speed=9km/h --duration 5s",
    );
    let foreign = wobble(
        folder.path(),
        "simulate --fmu packed.fmu --set roll_start=2deg --set speed=9km/h --duration 5s",
    );
    assert_eq!((native.code, foreign.code), (0, 0), "{}", foreign.err);
    assert!(native.out == foreign.out, "the tables differ");
}

#[test]
fn our_own_fmu_has_nothing_odd() {
    let folder = folder();
    packed(folder.path(), "");
    let found = json(folder.path(), "inspect packed.fmu --json");
    assert_eq!(found["model_name"], "RearLoadBicycle");
    assert_eq!(
        found["oddities"],
        serde_json::json!([]),
        "{}",
        found["oddities"]
    );
}

#[test]
fn what_cannot_be_packed_or_simulated_leaves_nothing_behind() {
    let folder = folder();
    let path = folder.path();
    std::fs::write(path.join("text.so"), "no library").expect("written");
    std::fs::write(path.join("broken.xml"), "<fmiModelDescription").expect("written");
    packed(path, "");
    let before = std::fs::read_dir(path).expect("a folder").count();
    for (call, code, expected) in [
        (
            "fmu --library text.so -o out.fmu",
            1,
            "text.so: expected a shared library",
        ),
        ("fmu --library atari=text.so -o out.fmu", 2, "win64"),
        (
            "fmu --library win64=nowhere.dll -o out.fmu",
            1,
            "x86_64-pc-windows-gnu",
        ),
        ("fmu --set trail=9 -o out.fmu", 2, "trail"),
        (
            "fmu --description broken.xml --library text.so -o out.fmu",
            1,
            "broken.xml",
        ),
        ("fmu -o nowhere/out.fmu", 1, "nowhere"),
        ("fmu --parameters packed.fmu -o out.fmu", 1, "packed.fmu"),
        ("simulate --fmu packed.fmu --set trial=1", 2, "trail"),
        (
            "simulate --fmu packed.fmu --set formulation=painted",
            2,
            "printed",
        ),
        ("simulate --fmu packed.fmu --set speed=nan", 2, "speed"),
        ("simulate --fmu packed.fmu --record steeer", 2, "steer"),
        ("simulate --fmu packed.fmu --duration 0s", 2, "--duration"),
        ("simulate --fmu packed.fmu --load 3kg", 2, "--load"),
        ("simulate --fmu broken.xml", 1, "expected an FMU"),
        ("simulate --fmu none.fmu", 1, "none.fmu"),
        ("inspect none.fmu", 1, "none.fmu"),
    ] {
        let called = wobble(path, call);
        assert_eq!(called.code, code, "{call}: {}", called.err);
        assert!(called.err.contains(expected), "{call}: {}", called.err);
        assert!(called.out.is_empty(), "{call}: {}", called.out);
    }
    assert_eq!(std::fs::read_dir(path).expect("a folder").count(), before);
}
