//! Names near a misspelt one, and what counts as typed.

use super::*;

#[test]
fn a_misspelt_name_finds_its_neighbours() {
    assert_eq!(nearest("trial", ["steer", "trail", "roll"]), ["trail"]);
    assert_eq!(
        nearest("Steer", ["roll", "steer_rate", "steer"]),
        ["steer", "steer_rate"]
    );
    assert_eq!(
        nearest("stiffness", ["trail", "camber_stiffness"]),
        ["camber_stiffness"]
    );
    assert_eq!(nearest("", ["trail", "speed"]), ["trail"]);
}

#[test]
fn typed_errors_are_told_from_others() {
    let unknown = || Error::unknown("parameter", "trial", ["trail"]);
    assert!(
        !unknown().in_file("lab.toml").is_typed(),
        "what stands in a file was not typed"
    );
    let typed = unknown().typed("--set trial=3");
    assert!(typed.is_typed());
    assert_eq!(
        typed.to_string(),
        "--set trial=3: unknown parameter `trial`; nearest: trail"
    );
}
