//! A killed run goes on where it was: the same numbers, nothing lost.

use crate::wobble::{program, wobble};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const FIT: &str = "fit ride.csv --starts 10 --bootstrap 10 --seed 5";

/// Finished jobs in the journal at `path`.
fn finished(path: &Path) -> usize {
    std::fs::read_to_string(path).map_or(0, |text| text.lines().count().saturating_sub(1))
}

/// Starts the fit in `folder` and kills it once its journal `kind` has two finished jobs.
fn kill_in(folder: &Path, kind: &str) {
    let journal = folder.join(format!("half.{kind}"));
    let mut child = Command::new(program())
        .args(FIT.split(' '))
        .args(["--resume", "half", "-o", "half.json"])
        .current_dir(folder)
        .stderr(Stdio::null())
        .spawn()
        .expect("the program");
    let patience = Instant::now() + Duration::from_mins(5);
    while finished(&journal) < 2 {
        assert!(Instant::now() < patience, "no {kind} finished");
        assert!(
            child.try_wait().expect("a child").is_none(),
            "it ended before it was killed"
        );
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().expect("killed");
    child.wait().expect("a child");
    assert!(!folder.join("half.json").exists(), "half a fit was written");
}

#[test]
fn a_fit_killed_among_its_starts_and_in_its_bootstrap_ends_with_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let ride = "simulate --ride --set remnant_intensity=2 --duration 12s -o ride.csv";
    assert_eq!(wobble(folder, ride).code, 0);
    let whole = wobble(folder, &format!("{FIT} -o whole.json"));
    assert_eq!(whole.code, 0, "{}", whole.err);

    kill_in(folder, "starts");
    let started = finished(&folder.join("half.starts"));
    kill_in(folder, "bootstrap");
    assert_eq!(
        finished(&folder.join("half.starts")),
        10,
        "of which {started} were there"
    );
    let resumed = wobble(folder, &format!("{FIT} --resume half -o half.json"));
    assert_eq!(resumed.code, 0, "{}", resumed.err);
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect("written");
    assert_eq!(read("half.json"), read("whole.json"));

    // a larger budget goes on; another run's journal is refused
    let more = FIT.replace("--bootstrap 10", "--bootstrap 12");
    assert_eq!(
        wobble(folder, &format!("{more} --resume half -o more.json")).code,
        0
    );
    assert_eq!(finished(&folder.join("half.bootstrap")), 12);
    let other = FIT.replace("--seed 5", "--seed 6");
    let refused = wobble(folder, &format!("{other} --resume half -o other.json"));
    assert_eq!(refused.code, 1);
    assert!(refused.err.contains("half.starts"), "{}", refused.err);
}
