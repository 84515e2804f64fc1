//! `RearLoadBicycle.fmu`: library, description, documentation in one archive.

use crate::description::{MODEL_IDENTIFIER, description};
use crate::row::Row;
use bicycle::{Formulation, Quantity};
use fmi_export::Package;
use model_description::Platform;
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::path::{Path, PathBuf};

/// An FMU that cannot be packed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The shared library was not built, or not installed with the program.
    #[error(
        "expected the shared library {name} beside {program}, found none; \
         `cargo build --release -p fmu` makes it, `--library FILE` names one elsewhere"
    )]
    NoLibrary {
        /// File name of the library.
        name: String,
        /// The running program.
        program: PathBuf,
    },
    /// The running program cannot be located.
    #[error("expected to find the path of the running program: {0}")]
    NoProgram(#[source] std::io::Error),
    /// FMI 2.0 has no name for this platform.
    #[error("expected a platform that FMI 2.0 names (Linux, Windows, macOS), found {os}", os = std::env::consts::OS)]
    NoPlatform,
    /// The archive could not be written.
    #[error(transparent)]
    Pack(#[from] fmi_export::Error),
}

/// Packs the shared library of this platform into the FMU `out`.
pub fn pack(library: &Path, out: &Path) -> Result<(), Error> {
    let platform = Platform::current().ok_or(Error::NoPlatform)?;
    let package = Package {
        description: description(),
        libraries: vec![(platform, library.to_owned())],
        files: vec![
            (
                "documentation/index.html".to_owned(),
                documentation().into_bytes(),
            ),
            (
                "documentation/licenses/license.txt".to_owned(),
                include_bytes!("../documentation/licenses/license.txt").to_vec(),
            ),
        ],
    };
    Ok(package.write(out)?)
}

/// The shared library that cargo put beside the running program, or an installer did.
pub fn built_library() -> Result<PathBuf, Error> {
    let program = std::env::current_exe().map_err(Error::NoProgram)?;
    let name = format!("{DLL_PREFIX}fmu{DLL_SUFFIX}");
    let folder = program.parent().unwrap_or(Path::new("."));
    // Cargo builds into `deps` and links from there to beside the program; tests run in `deps`.
    [folder.join("deps"), folder.to_owned(), folder.join("..")]
        .into_iter()
        .take(if folder.ends_with("deps") { 3 } else { 2 })
        .map(|folder| folder.join(&name))
        .find(|path| path.is_file())
        .ok_or(Error::NoLibrary { name, program })
}

/// documentation/index.html: the page with the tables filled in.
fn documentation() -> String {
    let rows = |wanted: fn(&Row) -> bool| -> String {
        let rows: Vec<String> = Row::all()
            .filter(wanted)
            .filter_map(Row::quantity)
            .map(table_row)
            .collect();
        rows.join("\n")
    };
    let formulations: Vec<String> = Formulation::ALL
        .iter()
        .map(|formulation| {
            let cells = [formulation.name(), formulation.what()].map(cell);
            format!("<tr>{}</tr>", cells.concat())
        })
        .collect();
    include_str!("../documentation/index.html")
        .replace("<!-- model -->", MODEL_IDENTIFIER)
        .replace("<!-- version -->", env!("CARGO_PKG_VERSION"))
        .replace(
            "<!-- parameters -->",
            &rows(|row| matches!(row, Row::Parameter(_))),
        )
        .replace("<!-- inputs -->", &rows(|row| matches!(row, Row::Input(_))))
        .replace(
            "<!-- outputs -->",
            &rows(|row| matches!(row, Row::Output(_))),
        )
        .replace(
            "<!-- locals -->",
            &rows(|row| matches!(row, Row::Derived(_))),
        )
        .replace("<!-- formulations -->", &formulations.join("\n"))
}

/// Name, symbol, unit, nominal value, range, meaning, source.
fn table_row(quantity: &Quantity) -> String {
    let bound = |value: f64| {
        if value.is_finite() {
            value.to_string()
        } else {
            String::new()
        }
    };
    let cells = [
        quantity.name,
        quantity.symbol,
        quantity.unit.symbol,
        &quantity.nominal.to_string(),
        &bound(quantity.min),
        &bound(quantity.max),
        quantity.what,
        quantity.source,
    ]
    .map(cell);
    format!("<tr>{}</tr>", cells.concat())
}

fn cell(text: &str) -> String {
    let text = text
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;");
    format!("<td>{text}</td>")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_documentation_has_every_row_and_no_gap() {
        let page = documentation();
        for quantity in Row::all().filter_map(Row::quantity) {
            assert!(page.contains(&cell(quantity.name)), "{}", quantity.name);
        }
        assert!(!page.contains("<!--"), "a placeholder is left");
    }
}
