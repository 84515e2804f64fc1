#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
use super::*;
use std::path::PathBuf;

/// Numbers that a careless file would change.
const NUMBERS: [f64; 6] = [
    0.1 + 0.2,
    -0.0,
    f64::MIN_POSITIVE / 3.0,
    f64::MAX,
    1e-7,
    0.0,
];
const IDENTITY: &str = "9f86d081884c7d65";

type Numbers = Vec<f64>;

fn result(job: u64) -> Numbers {
    NUMBERS.iter().map(|x| x / (1.0 + job as f64)).collect()
}

fn bits(numbers: &Numbers) -> Vec<u64> {
    numbers.iter().map(|x| x.to_bits()).collect()
}

fn open(path: &Path) -> Result<Journal<Numbers>> {
    Journal::open(path, "numbers", IDENTITY)
}

/// A journal of five jobs, done out of order, in `folder`.
fn written(folder: &tempfile::TempDir) -> PathBuf {
    let path = folder.path().join("run.journal");
    let journal = open(&path).unwrap();
    for job in [3, 0, 4, 1, 2] {
        journal.put(job, &result(job)).unwrap();
    }
    path
}

/// Whether `journal` has nothing that was not put in, and how much of it.
fn sound(journal: &Journal<Numbers>) -> usize {
    let jobs: Vec<_> = (0..5).filter_map(|j| Some((j, journal.get(j)?))).collect();
    for (job, found) in &jobs {
        assert_eq!(bits(found), bits(&result(*job)));
    }
    assert_eq!(journal.len(), jobs.len(), "only these jobs");
    jobs.len()
}

#[test]
fn what_was_put_is_given_back_to_the_last_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(&folder);
    let journal = open(&path).unwrap();
    assert_eq!(sound(&journal), 5);
    assert_eq!(journal.last().unwrap().0, 4);
    let memory = Journal::in_memory();
    assert!(memory.is_empty() && memory.last().is_none());
    for journal in [&journal, &memory] {
        let back = journal.put(7, &result(7)).unwrap();
        assert_eq!(bits(&back), bits(&result(7)));
        assert_eq!(bits(&journal.get(7).unwrap()), bits(&back));
    }
    // a job done anew replaces what it was
    journal.put(7, &vec![1.0]).unwrap();
    drop(journal);
    assert_eq!(open(&path).unwrap().get(7).unwrap(), [1.0]);
}

#[test]
fn a_file_cut_at_any_byte_loses_its_last_line_at_most_and_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let whole = std::fs::read(written(&folder)).unwrap();
    let path = folder.path().join("cut.journal");
    for length in 0..whole.len() {
        std::fs::write(&path, &whole[..length]).unwrap();
        let journal = open(&path).unwrap();
        let lines = whole[..length].split(|&b| b == b'\n').count();
        assert_eq!(sound(&journal), lines.saturating_sub(2), "{length} bytes");
        for job in [3, 0, 4, 1, 2] {
            if journal.get(job).is_none() {
                journal.put(job, &result(job)).unwrap();
            }
        }
        drop(journal);
        assert_eq!(std::fs::read(&path).unwrap(), whole, "{length} bytes");
    }
}

#[test]
fn a_changed_byte_is_never_a_wrong_number() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(&folder);
    let whole = std::fs::read(&path).unwrap();
    let header = whole.iter().position(|&b| b == b'\n').unwrap();
    for at in 0..whole.len() {
        for change in [1, 0x80] {
            let mut changed = whole.clone();
            changed[at] ^= change;
            std::fs::write(&path, &changed).unwrap();
            match open(&path) {
                Ok(journal) => assert!(sound(&journal) >= 3, "byte {at}"),
                Err(error) => assert!(at <= header, "byte {at}: {error}"),
            }
        }
    }
}

#[test]
fn the_journal_of_another_run_kind_or_version_is_refused_and_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(&folder);
    let whole = std::fs::read_to_string(&path).unwrap();
    let refused = |kind, identity| {
        let error = Journal::<Numbers>::open(&path, kind, identity).unwrap_err();
        error
            .to_string()
            .replace(&path.display().to_string(), "FILE")
    };
    assert_eq!(
        refused("numbers", "60303ae22b998861"),
        "FILE: expected what this very fit had finished, found that of a fit of other rides, options \
         or seed; call it as it was called, or name another file behind --resume"
    );
    assert_eq!(
        refused("bootstrap", IDENTITY),
        "FILE: expected the journal of kind bootstrap, found numbers"
    );
    assert_eq!(std::fs::read_to_string(&path).unwrap(), whole);
    let other = whole.replace(VERSION, "2, wobble 9.0.0");
    std::fs::write(&path, other).unwrap();
    assert_eq!(
        refused("numbers", IDENTITY),
        format!("FILE: expected the journal of version {VERSION}, found 2, wobble 9.0.0")
    );
    for foreign in ["time,steer[deg]\n0,1\n", "{}", "\u{0}\u{1}"] {
        std::fs::write(&path, foreign).unwrap();
        assert!(refused("numbers", IDENTITY).contains(", found no journal: `"));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), foreign);
    }
}

#[test]
fn a_journal_that_is_open_is_refused_to_another() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(&folder);
    let first = open(&path).unwrap();
    assert!(matches!(open(&path), Err(Error::JournalInUse { .. })));
    drop(first);
    assert_eq!(sound(&open(&path).unwrap()), 5);
}

#[test]
fn a_result_that_could_not_be_read_back_is_refused() {
    let journal = Journal::in_memory();
    let error = journal.put(3, &vec![1.0, f64::NAN]).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("job 3: expected a result of finite numbers")
    );
    assert!(journal.is_empty());
}

#[test]
fn a_path_that_cannot_be_opened_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for path in [folder.path().to_owned(), folder.path().join("none/run")] {
        let message = open(&path).unwrap_err().to_string();
        assert!(
            message.starts_with(&path.display().to_string()),
            "{message}"
        );
    }
}
