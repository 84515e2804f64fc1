//! The README's commands do what they say.

use crate::wobble::{pack_example, wobble};
use std::path::Path;

#[test]
fn every_wobble_line_of_the_readme_runs() {
    let readme = Path::new(env!("CARGO_MANIFEST_DIR")).join("../README.md");
    let text = std::fs::read_to_string(readme).expect("README.md");
    let folder = tempfile::tempdir().expect("a folder");
    let mut calls = 0;
    // the first command of the README, by another spelling
    assert_eq!(wobble(folder.path(), "demo").code, 0);
    // and one that cargo has a part in
    pack_example(folder.path(), "roll_assist", "RollAssist.fmu");
    for line in text
        .lines()
        .filter_map(|line| line.trim().strip_prefix("wobble "))
    {
        let arguments = line.split('#').next().unwrap_or_default();
        let called = wobble(folder.path(), arguments);
        assert_eq!(called.code, 0, "wobble {line}: {}", called.err);
        calls += 1;
    }
    assert!(calls >= 10, "{calls} calls found");
    assert!(text.lines().count() <= 150, "the README grew");
}

#[test]
fn the_figure_of_the_readme_is_what_the_program_draws() {
    let folder = tempfile::tempdir().expect("a folder");
    let called = wobble(folder.path(), "cases --bicycle section3 -o cases.svg");
    assert_eq!(called.code, 0, "{}", called.err);
    let drawn = std::fs::read_to_string(folder.path().join("cases.svg")).expect("drawn");
    let shown = Path::new(env!("CARGO_MANIFEST_DIR")).join("../identify/figures/cases.svg");
    let shown = std::fs::read_to_string(shown).expect("the README's figure");
    assert!(
        drawn == shown,
        "`wobble cases --bicycle section3 -o identify/figures/cases.svg` redraws it"
    );
}
