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

/// Starts `fit` in `folder` and ends it by `signal` once its journal `kind` has `jobs` more jobs.
fn end_in(folder: &Path, fit: &str, (kind, jobs): (&str, usize), signal: &str) {
    let journal = folder.join(format!("half.{kind}"));
    let before = finished(&journal);
    let mut child = Command::new(program())
        .args(fit.split(' '))
        .args(["--resume", "half", "-o", "half.json"])
        .current_dir(folder)
        .stderr(Stdio::null())
        .spawn()
        .expect("the program");
    let patience = Instant::now() + Duration::from_mins(5);
    while finished(&journal) < before + jobs {
        assert!(Instant::now() < patience, "no {kind} finished");
        assert!(
            child.try_wait().expect("a child").is_none(),
            "it ended before it was killed"
        );
        std::thread::sleep(Duration::from_millis(2));
    }
    let kill = Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status();
    assert!(kill.expect("kill").success());
    child.wait().expect("a child");
}

#[test]
fn a_fit_killed_among_its_starts_and_in_its_bootstrap_ends_with_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let ride = "simulate --ride --set remnant_intensity=2 --duration 12s -o ride.csv";
    assert_eq!(wobble(folder, ride).code, 0);
    let whole = wobble(folder, &format!("{FIT} -o whole.json"));
    assert_eq!(whole.code, 0, "{}", whole.err);

    let kill = |kind| {
        end_in(folder, FIT, (kind, 2), "-KILL");
        let half = folder.join("half.json");
        assert!(!half.exists(), "half a fit was written");
    };
    kill("starts");
    let started = finished(&folder.join("half.starts"));
    kill("bootstrap");
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

#[test]
fn a_population_interrupted_in_the_middle_of_a_generation_loses_it_and_nothing_else() {
    const FIT: &str = "fit ride.csv --free viscous_friction,coulomb_friction --population 200";
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let ride = "simulate --ride --torque --set remnant_intensity=2 --duration 6s -o ride.csv";
    assert_eq!(wobble(folder, ride).code, 0);
    let whole = wobble(folder, &format!("{FIT} --resume whole -o whole.json"));
    assert_eq!(whole.code, 0, "{}", whole.err);
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect("written");
    for _ in 0..3 {
        end_in(folder, FIT, ("population", 3), "-INT");
        // what was interrupted is written, as far as it came
        assert!(read("half.json").contains("stopped"));
        let journal = read("half.population");
        assert!(read("whole.population").starts_with(&journal), "{journal}");
    }
    let resumed = wobble(folder, &format!("{FIT} --resume half -o half.json"));
    assert_eq!(resumed.code, 0, "{}", resumed.err);
    assert_eq!(read("half.population"), read("whole.population"));
    assert_eq!(read("half.json"), read("whole.json"));
}
