//! A yardstick in C++: compiled as its first lines say, run, and read.

use crate::file;
use crate::kernel::Isa;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// What the yardstick does on this machine.
#[derive(Debug, Clone, Serialize)]
pub struct Yardstick {
    /// Rides a second, one at a time.
    pub scalar_per_s: f64,
    /// Rides a second in vectors, on one core.
    pub vector_per_s: f64,
    /// Its step [s].
    pub step_s: f64,
    /// The compiler, as it names itself.
    pub compiler: String,
}

impl Yardstick {
    /// The faster of each.
    #[must_use]
    pub fn better(self, other: Option<Self>) -> Self {
        let Some(other) = other else { return self };
        Self {
            scalar_per_s: self.scalar_per_s.max(other.scalar_per_s),
            vector_per_s: self.vector_per_s.max(other.vector_per_s),
            ..self
        }
    }
}

/// A yardstick ready to run.
pub struct Built {
    program: PathBuf,
    compiler: String,
    _folder: TempDir,
}

/// The call of the compiler in `source`: what stands between `Build:` and the next wide space, the
/// source and the program named as they are here.
fn call(source: &str, file: &str, program: &str) -> Option<Vec<String>> {
    let line = source.lines().find_map(|line| line.split_once("Build:"))?.1;
    let line = line.trim_start();
    let end = line.find("   ").unwrap_or(line.len());
    let mut words: Vec<String> = line[..end].split_whitespace().map(Into::into).collect();
    let output = words.iter().position(|word| word == "-o")? + 1;
    *words.get_mut(output)? = program.into();
    let is_source = |word: &&mut String| Path::new(word).extension().is_some_and(|e| e == "cpp");
    *words.iter_mut().find(is_source)? = file.into();
    if Isa::best() == Isa::Avx2 {
        words.extend(["-DW=4".into(), "-DNG=4".into()]);
    }
    Some(words)
}

/// Compiles `path`; what hinders is said in words.
pub fn build(path: &Path) -> Result<Built, String> {
    let source = file::read(path).map_err(|e| e.to_string())?;
    let source = String::from_utf8_lossy(&source);
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    let program = folder.path().join("yardstick");
    let (file, output) = (path.display().to_string(), program.display().to_string());
    let words = call(&source, &file, &output).ok_or_else(|| {
        format!("{file}: expected a line 'Build: COMPILER … FILE.cpp -o PROGRAM …'")
    })?;
    let run = |arguments: &[String]| {
        let output = Command::new(&words[0]).args(arguments).output();
        let output = output.map_err(|e| format!("{}: {e}", words[0]))?;
        if output.status.success() {
            return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
        }
        Err(String::from_utf8_lossy(&output.stderr).into_owned())
    };
    run(&words[1..])?;
    let version = run(&["--version".into()])?;
    Ok(Built {
        program,
        compiler: version.lines().next().unwrap_or_default().into(),
        _folder: folder,
    })
}

impl Built {
    /// Runs it once: steps of 1 ms, the best of five.
    pub fn run(&self) -> Result<Yardstick, String> {
        let output = Command::new(&self.program).args(["5", "5"]).output();
        let output = output.map_err(|e| e.to_string())?;
        let text = String::from_utf8_lossy(&output.stdout);
        let rate = |kind: &str| {
            figure(&text, kind).ok_or_else(|| format!("expected '{kind} … sim/s', found: {text}"))
        };
        Ok(Yardstick {
            scalar_per_s: rate("scalar")?,
            vector_per_s: rate("vector")?,
            step_s: 1e-3,
            compiler: self.compiler.clone(),
        })
    }
}

/// The number before `sim/s` in the line on `kind` of the ride of 4800 samples.
fn figure(text: &str, kind: &str) -> Option<f64> {
    let of_kind = |line: &&str| line.starts_with("n=4800 ") && line.contains(kind);
    let words: Vec<&str> = text.lines().find(of_kind)?.split_whitespace().collect();
    let unit = words.iter().position(|word| word.starts_with("sim/s"))?;
    words.get(unit.checked_sub(1)?)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn compiler_is_called_as_the_file_says() {
        let source = "// Build: g++ -O3 rk4.cpp -o rk4 -lm   (more)   Run: ./rk4\nint main(){}";
        let words = call(source, "/a/b.cpp", "/t/y").expect("a call");
        assert_eq!(words[..6], ["g++", "-O3", "/a/b.cpp", "-o", "/t/y", "-lm"]);
        assert_eq!(call("int main(){}", "a.cpp", "y"), None);
    }

    #[test]
    fn figures_are_read() {
        let text = "n=24000 sub=5 scalar: 9 ms/sim  50.0 sim/s/core\n\
                    n=4800 sub=5 scalar: 3.6 ms/sim  277.5 sim/s/core  37.5 ns/deriv\n\
                    n=4800 sub=5 vector 2x8: 12.7 ms per batch  1255.0 sim/s/core  8.30 ns\n";
        assert_eq!(figure(text, "scalar"), Some(277.5));
        assert_eq!(figure(text, "vector"), Some(1255.0));
        assert_eq!(figure("nothing", "vector"), None);
    }
}
