//! Libraries as typed, and what makes one that is missing.

use anyhow::Result;
use fmi_import::model_description::Platform;
use identify::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;

/// `[PLATFORM=]FILE`, each; a bare file is for this machine.
pub fn typed(texts: &[String]) -> Result<Vec<(Platform, PathBuf)>> {
    let mut libraries: Vec<(Platform, PathBuf)> = Vec::new();
    for text in texts {
        let argument = format!("--library {text}");
        let (platform, path) = split(text).map_err(|cause| cause.typed(&argument))?;
        if libraries.iter().any(|(other, _)| *other == platform) {
            let twice = Error::Form {
                expected: "one library for each platform",
                found: format!("a second one for {platform}"),
            };
            return Err(twice.typed(argument).into());
        }
        libraries.push((platform, path));
    }
    Ok(libraries)
}

fn split(text: &str) -> Result<(Platform, PathBuf), Error> {
    let known = || Platform::ALL.map(Platform::folder);
    match text.split_once('=') {
        // A file's name may contain the sign.
        Some((name, path)) if !Path::new(text).exists() => {
            let platform = Platform::ALL.into_iter().find(|p| p.folder() == name);
            let platform = platform.ok_or_else(|| Error::Unknown {
                kind: "platform",
                name: name.into(),
                nearest: known().map(str::to_owned).into(),
            })?;
            if path.is_empty() {
                return Err(Error::Form {
                    expected: "PLATFORM=FILE",
                    found: text.into(),
                });
            }
            Ok((platform, path.into()))
        }
        _ => match Platform::current() {
            Some(here) => Ok((here, text.into())),
            None => Err(Error::Form {
                expected: "PLATFORM=FILE: FMI 2.0 has no name for this machine",
                found: text.into(),
            }),
        },
    }
}

/// Says that the library for `platform` is missing, what makes it, and what that lacks here.
pub fn missing(platform: Platform, path: &Path, ours: bool) -> String {
    let found = format!(
        "{}: expected the library for {platform}, found no file",
        path.display()
    );
    let package = if ours { " -p fmu" } else { "" };
    if Platform::current() == Some(platform) {
        return format!("{found}; `cargo build --release{package}` makes one");
    }
    let Some((target, linker)) = toolchain(platform) else {
        return found;
    };
    let mut parts = vec![
        found,
        format!("`cargo build --release{package} --target {target}` makes one"),
    ];
    if has_target(target) == Some(false) {
        parts.push(format!(
            "the Rust target {target} is not installed here: `rustup target add {target}`"
        ));
    }
    match linker {
        Some(linker) if !is_on_the_path(linker) => {
            parts.push(format!("its linker {linker} is not installed here"));
        }
        None if !cfg!(target_os = "macos") => parts.push("its linker is Apple's".to_owned()),
        _ => {}
    }
    parts.join("; ")
}

/// Rust's target for a platform, and the linker rustc calls where the machine is another; none
/// where only the platform itself has one.
fn toolchain(platform: Platform) -> Option<(&'static str, Option<&'static str>)> {
    Some(match platform {
        Platform::Linux32 => ("i686-unknown-linux-gnu", Some("cc")),
        Platform::Linux64 => ("x86_64-unknown-linux-gnu", Some("cc")),
        Platform::Win32 => ("i686-pc-windows-gnu", Some("i686-w64-mingw32-gcc")),
        Platform::Win64 => ("x86_64-pc-windows-gnu", Some("x86_64-w64-mingw32-gcc")),
        Platform::Darwin64 => ("x86_64-apple-darwin", None),
        // Rust has no such target any more.
        Platform::Darwin32 => return None,
    })
}

/// Whether the standard library for `target` is installed; `None` where rustc is not.
fn has_target(target: &str) -> Option<bool> {
    let output = Command::new("rustc")
        .args(["--print", "target-libdir", "--target", target])
        .output()
        .ok()?;
    let folder = String::from_utf8(output.stdout).ok()?;
    Some(output.status.success() && Path::new(folder.trim()).is_dir())
}

fn is_on_the_path(program: &str) -> bool {
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let name = format!("{program}{}", std::env::consts::EXE_SUFFIX);
    std::env::split_paths(&folders).any(|folder| folder.join(&name).is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_library_is_for_the_platform_typed() {
        let texts = ["win64=a=b.dll".to_owned(), "darwin64=c".to_owned()];
        let libraries = typed(&texts).expect("typed well");
        assert_eq!(
            libraries,
            [
                (Platform::Win64, "a=b.dll".into()),
                (Platform::Darwin64, "c".into())
            ]
        );
    }

    #[test]
    fn wrong_platforms_and_two_of_one_are_typed_errors() {
        let check = |texts: &[&str], expected: &str| {
            let texts: Vec<String> = texts.iter().map(|&text| text.to_owned()).collect();
            let error = typed(&texts).expect_err("refused");
            let typed = error.downcast_ref::<Error>().is_some_and(Error::is_typed);
            assert!(typed && error.to_string().contains(expected), "{error}");
        };
        check(
            &["win65=a.dll"],
            "linux32, linux64, win32, win64, darwin32, darwin64",
        );
        check(
            &["win64=a.dll", "win64=b.dll"],
            "one library for each platform",
        );
    }

    #[test]
    fn a_missing_library_comes_with_the_command_that_makes_it() {
        let words = missing(Platform::Win64, Path::new("fmu.dll"), true);
        let command = "`cargo build --release -p fmu --target x86_64-pc-windows-gnu`";
        assert!(cfg!(windows) || words.contains(command), "{words}");
        assert!(
            words.starts_with("fmu.dll: expected the library for win64"),
            "{words}"
        );
        assert!(!missing(Platform::Darwin32, Path::new("a"), true).contains("cargo"));
    }
}
