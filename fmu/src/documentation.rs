//! What an FMU's reader finds in the archive: the page, its scripts, the picture, the licences.

use crate::description::{MODEL_IDENTIFIER, formulation_value};
use crate::row::Row;
use bicycle::{Formulation, Quantity};

/// Paths in the archive and contents.
pub(crate) fn files() -> Vec<(String, Vec<u8>)> {
    let page = page();
    let files: [(&str, &[u8]); 8] = [
        ("documentation/index.html", page.as_bytes()),
        ("documentation/assist.py", ASSIST.as_bytes()),
        (
            "documentation/couple.py",
            include_bytes!("../documentation/couple.py"),
        ),
        (
            "documentation/licenses/license.txt",
            include_bytes!("../documentation/licenses/license.txt"),
        ),
        (
            "documentation/licenses/apache-2.0.txt",
            include_bytes!("../../LICENSE-APACHE"),
        ),
        (
            "documentation/licenses/crates.txt",
            include_bytes!("../documentation/licenses/crates.txt"),
        ),
        (
            "documentation/licenses/third-party.txt",
            include_bytes!("../documentation/licenses/third-party.txt"),
        ),
        ("model.png", include_bytes!("../documentation/model.png")),
    ];
    files
        .map(|(path, bytes)| (path.to_owned(), bytes.to_owned()))
        .into()
}

const ASSIST: &str = include_str!("../documentation/assist.py");

/// The page with figure, script and tables filled in.
fn page() -> String {
    let rows = |wanted: fn(&Row) -> bool, cells: fn(&Quantity) -> Vec<String>| -> String {
        let rows = Row::all().filter(wanted).filter_map(Row::quantity);
        rows.map(|quantity| table_row(&cells(quantity))).collect()
    };
    let formulations: String = Formulation::ALL
        .into_iter()
        .map(|formulation| {
            table_row(&[
                formulation.name().to_owned(),
                formulation_value(formulation).to_string(),
                formulation.what().to_owned(),
            ])
        })
        .collect();
    [
        ("model", MODEL_IDENTIFIER.to_owned()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("signs", figure(include_str!("../../bicycle/signs.svg"))),
        ("assist.py", escaped(ASSIST)),
        ("formulations", formulations),
        (
            "parameters",
            rows(|row| matches!(row, Row::Parameter(_)), settable),
        ),
        ("inputs", rows(|row| matches!(row, Row::Input(_)), settable)),
        (
            "outputs",
            rows(|row| matches!(row, Row::Output(_)), computed),
        ),
        (
            "locals",
            rows(|row| matches!(row, Row::Derived(_)), computed),
        ),
    ]
    .into_iter()
    .fold(
        include_str!("../documentation/index.html").to_owned(),
        |page, (gap, contents)| page.replace(&format!("<!-- {gap} -->"), &contents),
    )
}

/// The drawing without its comments: in the page a comment is a gap.
fn figure(svg: &str) -> String {
    let mut parts = svg.split("<!--");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |figure, part| {
        figure + part.split_once("-->").map_or("", |(_, rest)| rest)
    })
}

/// Name, symbol, unit, nominal value, range, meaning, source.
fn settable(quantity: &Quantity) -> Vec<String> {
    let numbers = [quantity.nominal, quantity.min, quantity.max].map(number);
    let [name, symbol, unit, what, source] = words(quantity);
    [vec![name, symbol, unit], numbers.into(), vec![what, source]].concat()
}

/// Name, symbol, unit, meaning, source.
fn computed(quantity: &Quantity) -> Vec<String> {
    words(quantity).into()
}

fn words(quantity: &Quantity) -> [String; 5] {
    let Quantity {
        name,
        symbol,
        unit,
        what,
        source,
        ..
    } = quantity;
    [name, symbol, unit.symbol, what, source].map(str::to_owned)
}

/// Four digits are enough to read; the exact value is in modelDescription.xml.
fn number(value: f64) -> String {
    let digits = 3 - value.abs().log10().floor().clamp(-6.0, 3.0) as i32;
    let factor = 10_f64.powi(digits);
    ((value * factor).round() / factor).to_string()
}

fn table_row(cells: &[String]) -> String {
    let cells: String = cells.iter().map(|text| cell(text)).collect();
    format!("<tr>{cells}</tr>\n")
}

fn cell(text: &str) -> String {
    format!("<td>{}</td>", escaped(text))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect_file;
    use std::process::Command;

    #[test]
    fn the_page_has_every_row_and_no_gap() {
        let page = page();
        for quantity in Row::all().filter_map(Row::quantity) {
            assert!(page.contains(&cell(quantity.name)), "{}", quantity.name);
        }
        assert!(!page.contains("<!--"), "a placeholder is left");
        for outside in ["src=", "href=\"http", "url(http", "@import"] {
            assert!(!page.contains(outside), "needs {outside}");
        }
    }

    #[test]
    fn numbers_are_short() {
        let check = |value: f64, expected: &str| assert_eq!(number(value), expected);
        check(0.0, "0");
        check(1e-5, "0.00001");
        check(20_f64.to_radians(), "0.3491");
        check(8.0 / 3.6, "2.222");
        check(-0.1, "-0.1");
        check(10000.0, "10000");
        check(100.513, "100.5");
    }

    /// What cargo would link into the library, apart from what only runs while compiling.
    #[test]
    fn the_list_of_crates_is_up_to_date() {
        let tree = "tree --package fmu --edges normal,no-proc-macro --prefix none --no-dedupe \
                    --target x86_64-unknown-linux-gnu --locked --offline --format";
        let output = Command::new(env!("CARGO"))
            .args(tree.split_whitespace())
            .arg("{p}|{l}")
            .output()
            .expect("cargo runs");
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{error}");
        let text = String::from_utf8(output.stdout).expect("UTF-8");
        let mut lines: Vec<String> = text
            .lines()
            .filter_map(|line| {
                let (package, license) = line.split_once('|')?;
                let mut words = package.split(' ');
                let (name, version) = (words.next()?, words.next()?);
                // Ours stand in folders; theirs are known by name and version alone.
                let ours = words.next().is_some();
                (!ours).then(|| format!("{name} {version}: {license}\n"))
            })
            .collect();
        lines.sort();
        lines.dedup();
        expect_file!["../documentation/licenses/crates.txt"].assert_eq(&lines.concat());
    }
}
