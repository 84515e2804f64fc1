//! `EQUATIONS.md` says what the code does: its symbols are the tables', its tests exist.

use crate::marked::assert_block;
use bicycle::{Derived, Excitation, Input, Instruments, Output, Parameters, Path, Quantity, State};
use std::fmt::Write;

const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/EQUATIONS.md");

fn symbols() -> String {
    let mut text = String::from("| symbol | name | unit | what |\n|---|---|---|---|\n");
    let tables: [(&str, &[Quantity]); 8] = [
        ("states", State::TABLE),
        ("inputs", Input::TABLE),
        ("path", Path::TABLE),
        ("outputs", Output::TABLE),
        ("parameters", Parameters::TABLE),
        ("derived from the parameters", Derived::TABLE),
        ("excitation and effective friction", Excitation::TABLE),
        ("instruments", Instruments::TABLE),
    ];
    for (title, table) in tables {
        writeln!(text, "| **{title}** | | | |").expect("a string");
        for row in table {
            let (symbol, name, unit, what) = (row.symbol, row.name, row.unit.symbol, row.what);
            // a cell of a Markdown table ends at a bar
            let what = what.replace('|', "\\|");
            writeln!(text, "| {symbol} | `{name}` | {unit} | {what} |").expect("a string");
        }
    }
    text
}

#[test]
fn symbols_are_those_of_the_tables() {
    assert_block(PATH, "symbols", &symbols());
}

/// Every row of the table of deviations names a test, and every test it names is there.
#[test]
fn deviations_name_tests_that_exist() {
    let sources = [
        include_str!("grid.rs"),
        include_str!("jumps.rs"),
        include_str!("laws.rs"),
        include_str!("linear.rs"),
        include_str!("mass.rs"),
        include_str!("section3.rs"),
        include_str!("stepper.rs"),
        include_str!("stops.rs"),
        include_str!("tables.rs"),
        include_str!("tyre.rs"),
        include_str!("whipple.rs"),
    ]
    .concat();
    let text = std::fs::read_to_string(PATH).expect("EQUATIONS.md");
    let (_, rest) = text.split_once("\n## Deviations").expect("the deviations");
    let (deviations, _) = rest.split_once("\n## ").expect("a section after them");
    let rows: Vec<&str> = deviations
        .lines()
        .filter(|l| l.starts_with("| "))
        .skip(1)
        .collect();
    for id in [
        "7a", "7b", "6/7c", "9a", "9b", "9c", "9d", "T4", "T5", "tan", "L", "inputs", "load",
        "signs", "limit", "state",
    ] {
        assert!(
            rows.iter().any(|row| row.starts_with(&format!("| {id} |"))),
            "no row {id}"
        );
    }
    let (_, rest) = text
        .split_once("\n| what | test |")
        .expect("the four-body bicycle");
    let (four_body, _) = rest.split_once("\n## ").expect("a section after it");
    let four_body = four_body.lines().filter(|l| l.starts_with("| "));
    for row in rows.into_iter().chain(four_body) {
        let cell = row.trim_end_matches(" |").rsplit(" | ").next();
        let tests: Vec<&str> = cell
            .expect("a cell")
            .split('`')
            .skip(1)
            .step_by(2)
            .collect();
        assert!(!tests.is_empty(), "no test: {row}");
        for test in tests {
            assert!(
                sources.contains(&format!("fn {test}(")),
                "no test called {test}"
            );
        }
    }
}
