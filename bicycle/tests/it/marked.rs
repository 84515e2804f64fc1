//! Generated blocks of `EQUATIONS.md`, each between `<!-- begin NAME -->` and `<!-- end NAME -->`.

use std::env;
use std::fs;

/// Asserts that the block called `name` of the file at `path` is `block`; with `UPDATE_EXPECT=1`
/// in the environment it is written instead.
pub fn assert_block(path: &str, name: &str, block: &str) {
    let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let (begin, end) = (
        format!("<!-- begin {name} -->\n"),
        format!("<!-- end {name} -->"),
    );
    let from = text
        .find(&begin)
        .unwrap_or_else(|| panic!("{path}: no {begin}"))
        + begin.len();
    let to = from
        + text[from..]
            .find(&end)
            .unwrap_or_else(|| panic!("{path}: no {end}"));
    if &text[from..to] == block {
        return;
    }
    assert!(
        env::var_os("UPDATE_EXPECT").is_some_and(|v| v == "1"),
        "{path}: the block '{name}' is stale; UPDATE_EXPECT=1 rewrites it as\n{block}"
    );
    let fresh = format!("{}{block}{}", &text[..from], &text[to..]);
    fs::write(path, fresh).unwrap_or_else(|e| panic!("{path}: {e}"));
}
