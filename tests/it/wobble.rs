//! Calls of the program, as a user types them.

use std::path::{Path, PathBuf};
use std::process::Command;

/// What a call gave.
pub struct Called {
    pub code: i32,
    pub out: String,
    pub err: String,
}

/// The program that cargo built beside these tests.
pub fn program() -> PathBuf {
    let tests = std::env::current_exe().expect("a running test");
    let folder = tests.ancestors().nth(2).expect("target/PROFILE/deps/it");
    let program = folder.join(format!("wobble{}", std::env::consts::EXE_SUFFIX));
    assert!(
        program.is_file(),
        "no program at {}: `cargo build` first",
        program.display()
    );
    program
}

/// Calls `wobble` with `arguments`, split at spaces, in `folder`.
pub fn wobble(folder: &Path, arguments: &str) -> Called {
    let output = Command::new(program())
        .args(arguments.split_whitespace())
        .current_dir(folder)
        .output()
        .expect("the program starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    Called {
        code: output.status.code().expect("no signal"),
        out: text(output.stdout),
        err: text(output.stderr),
    }
}

/// Packs an example of fmi-export, such as `roll_assist`, as `out` in `folder`.
pub fn pack_example(folder: &Path, name: &str, out: &str) {
    let program = program();
    let profile = program.parent().expect("target/PROFILE");
    let (prefix, suffix) = (std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let library = profile.join(format!("examples/{prefix}{name}{suffix}"));
    assert!(
        library.is_file(),
        "no library at {}: `cargo build -p fmi-export --examples` first",
        library.display()
    );
    let description = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../fmi-export/examples")
        .join(format!("{name}.xml"));
    let call = format!(
        "fmu --description {} --library {} -o {out}",
        description.display(),
        library.display()
    );
    let packed = wobble(folder, &call);
    assert_eq!(packed.code, 0, "{}", packed.err);
}

/// Calls and expects success; gives stdout as JSON.
pub fn json(folder: &Path, arguments: &str) -> serde_json::Value {
    let called = wobble(folder, arguments);
    assert_eq!(called.code, 0, "wobble {arguments}: {}", called.err);
    serde_json::from_str(&called.out).unwrap_or_else(|e| panic!("wobble {arguments}: {e}"))
}

/// The data set named by WOBBLE_DATA, or none, said aloud.
pub fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("WOBBLE_DATA").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("skipped: WOBBLE_DATA does not name a folder with sbw-delft/");
    }
    folder
}
