use clap::Parser;
use clap::error::ErrorKind;

#[test]
fn what_belongs_to_the_bicycle_is_refused_for_an_fmu() {
    let parse = |arguments: &[&str]| {
        let start = ["wobble", "simulate"].iter().chain(arguments);
        crate::Program::try_parse_from(start).map(|_| ())
    };
    for alone in [
        &["--bicycle", "nominal"][..],
        &["--load", "5"],
        &["--rider", "75kg,1.8m"],
        &["--formulation", "printed"],
        &["--at", "5s:speed=3"],
        &["--ride"],
    ] {
        assert!(parse(alone).is_ok(), "{alone:?}");
        let both: Vec<&str> = ["--fmu", "x.fmu"].iter().chain(alone).copied().collect();
        let error = parse(&both).expect_err("refused");
        assert_eq!(error.kind(), ErrorKind::ArgumentConflict, "{alone:?}");
    }
    for alone in [&["--start", "1s"][..], &["--record", "x"]] {
        let error = parse(alone).expect_err("refused");
        assert_eq!(error.kind(), ErrorKind::MissingRequiredArgument);
    }
    let all = [
        "--fmu",
        "x.fmu",
        "--set",
        "a=1",
        "--duration",
        "1s",
        "--step",
        "5ms",
    ];
    assert!(parse(&all).is_ok());
}
