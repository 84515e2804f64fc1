#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
use super::*;
use crate::error::Error;
use crate::solver::tests::{Least, box_of};
use crate::solver::{Search, minimise};
use crate::starts::sobol;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// Two valleys over x, the deeper at x > 0; y is bent with x, w enters nothing; no way from y > 4.
fn two_valleys(z: &[f64]) -> Vec<f64> {
    vec![
        z[0] * z[0] - 4.0,
        0.3 * (z[0] - 3.0),
        z[1] - z[0].sin(),
        0.0 * z[2],
    ]
}

/// A problem that counts its searches and can make the last of them wait.
#[derive(Default)]
struct Toy {
    searches: AtomicUsize,
    /// After so many searches the others never end.
    patience: Option<usize>,
}

impl Searchable for Toy {
    fn search(&self, start: &DVector<f64>, watch: &Watch) -> Result<Outcome> {
        let before = self.searches.fetch_add(1, Ordering::SeqCst);
        if self.patience.is_some_and(|patience| before >= patience) {
            // longer than any test waits; it is killed
            std::thread::sleep(Duration::from_mins(2));
        }
        if start[1] > 4.0 {
            return Err(Error::Search("no way from here".into()));
        }
        let search = Search {
            limits: &limits(),
            held: &[],
            tolerance: 1e-12,
            max_iterations: 100,
            watch: watch.clone(),
        };
        minimise(&Least(two_valleys), start.clone(), &search)
    }
}

fn limits() -> crate::solver::Limits {
    box_of(&[-5.0; 3], &[5.0; 3])
}

fn starts(count: usize) -> Vec<DVector<f64>> {
    sobol(&limits(), 11).take(count).collect()
}

fn run(toy: &Toy, count: usize, journal: &Journal<Attempt>) -> Starts {
    multistart(toy, &starts(count), journal, &Watch::default()).unwrap()
}

fn file(path: &Path) -> Journal<Attempt> {
    Journal::open(path, "multistart", "a toy").unwrap()
}

/// Every number of `starts` by its bits.
fn bits(starts: &Starts) -> Vec<u64> {
    let outcome = |attempt: &Attempt| {
        let outcome = attempt.outcome.as_ref().ok()?;
        Some(
            outcome
                .point
                .iter()
                .copied()
                .chain([outcome.cost])
                .collect(),
        )
    };
    let numbers = starts.attempts.iter().flat_map(|attempt| {
        let outcome: Vec<f64> = outcome(attempt).unwrap_or_default();
        attempt
            .start
            .iter()
            .copied()
            .chain(outcome)
            .collect::<Vec<f64>>()
    });
    numbers.map(f64::to_bits).collect()
}

#[test]
fn the_deepest_end_is_the_best_and_those_that_agree_are_told_from_the_rest() {
    let starts = run(&Toy::default(), 32, &Journal::in_memory());
    let best = starts.outcome().unwrap();
    assert!(best.converged && best.point[0] > 1.9 && !starts.stopped());
    assert_eq!((starts.attempts.len(), starts.planned), (32, 32));
    let none_from = starts.attempts.iter().filter(|a| a.start[1] > 4.0).count();
    assert!(none_from > 0 && starts.failures() == none_from);
    // the deeper valley's ends agree in what is determined, whatever the third variable
    let agreeing = starts.agreeing(&[(0, 1e-3), (1, 1e-3)]);
    for (attempt, agrees) in starts.attempts.iter().zip(&agreeing) {
        let there = attempt.outcome.as_ref().is_ok_and(|o| o.point[0] > 0.0);
        assert_eq!(*agrees, there, "{attempt:?}");
    }
    let count = agreeing.iter().filter(|a| **a).count();
    assert!((10..25).contains(&count), "{count} of 32");
    // the third lies wherever it began: with it there is no agreement
    let strict = starts.agreeing(&[(0, 1e-3), (2, 1e-3)]);
    assert_eq!(strict.iter().filter(|a| **a).count(), 1);
}

#[test]
fn any_number_of_threads_gives_the_same() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| run(&Toy::default(), 20, &Journal::in_memory()))
    };
    let one = with(1);
    for threads in [2, 7] {
        assert_eq!(with(threads), one);
    }
}

#[test]
fn no_start_and_no_way_from_any_are_results() {
    let none = run(&Toy::default(), 0, &Journal::in_memory());
    assert!(none.best.is_none() && none.outcome().is_none() && !none.stopped());
    let nowhere = [DVector::from_column_slice(&[0.0, 4.5, 0.0])];
    let journal = Journal::in_memory();
    let lost = multistart(&Toy::default(), &nowhere, &journal, &Watch::default()).unwrap();
    assert_eq!((lost.best, lost.failures()), (None, 1));
    assert_eq!(lost.agreeing(&[]), [false]);
    // a failure is a result: it is not tried again
    assert_eq!(journal.len(), 1);
}

#[test]
fn a_stopped_run_goes_on_where_it_was_and_more_starts_may_be_asked_for() {
    let whole = run(&Toy::default(), 24, &Journal::in_memory());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("starts.journal");
    let stop: Arc<Mutex<Option<Watch>>> = Arc::default();
    let told = Arc::new(AtomicUsize::new(0));
    let watch = Watch::new({
        let (stop, told) = (Arc::clone(&stop), Arc::clone(&told));
        move |event| {
            let Event::Done { done, of: 16, best } = event else {
                panic!("{event:?}")
            };
            assert_eq!(told.fetch_add(1, Ordering::SeqCst) + 1, done as usize);
            assert!(best.is_some() || done < 5);
            if done == 5 {
                stop.lock().unwrap().as_ref().unwrap().stop();
            }
        }
    });
    *stop.lock().unwrap() = Some(watch.clone());
    let journal = file(&path);
    let part = multistart(&Toy::default(), &starts(16), &journal, &watch).unwrap();
    assert!(part.stopped() && part.planned == 16 && part.best.is_some());
    let finished = journal.len();
    assert!((5..16).contains(&finished), "{finished} finished");
    drop(journal);
    // to its end, then on to 24
    for (count, known) in [(16, finished), (24, 16)] {
        let toy = Toy::default();
        let starts = run(&toy, count, &file(&path));
        assert_eq!(toy.searches.load(Ordering::SeqCst), count - known);
        assert_eq!(starts.attempts, whole.attempts[..count]);
    }
    // the journal of the same problem from other starts answers for none of them
    let other: Vec<_> = sobol(&limits(), 12).take(4).collect();
    let again = multistart(&Toy::default(), &other, &file(&path), &Watch::default()).unwrap();
    let fresh = Journal::in_memory();
    let fresh = multistart(&Toy::default(), &other, &fresh, &Watch::default()).unwrap();
    assert_eq!(again, fresh);
}

#[test]
fn a_journal_cut_at_any_byte_gives_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("starts.journal");
    let whole = run(&Toy::default(), 5, &file(&path));
    let bytes = std::fs::read(&path).unwrap();
    let records = |bytes: &[u8]| bytes.split(|&b| b == b'\n').count().saturating_sub(2);
    for length in 0..bytes.len() {
        std::fs::write(&path, &bytes[..length]).unwrap();
        let toy = Toy::default();
        let resumed = run(&toy, 5, &file(&path));
        assert_eq!(bits(&resumed), bits(&whole), "{length} bytes");
        let searches = toy.searches.load(Ordering::SeqCst);
        assert_eq!(searches, 5 - records(&bytes[..length]), "{length} bytes");
    }
}

/// Where the child process is told to keep its journal.
const CHILD: &str = "WOBBLE_TEST_JOURNAL";

#[test]
#[ignore = "the child process of the next test, which kills it"]
fn a_run_to_be_killed() {
    let Some(path) = std::env::var_os(CHILD) else {
        return;
    };
    let toy = Toy {
        patience: Some(4),
        ..Toy::default()
    };
    run(&toy, 12, &file(Path::new(&path)));
}

#[test]
fn a_killed_run_goes_on_to_the_same_numbers() {
    let whole = run(&Toy::default(), 12, &Journal::in_memory());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("starts.journal");
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args([
            "--exact",
            "--ignored",
            "solver::multistart::tests::a_run_to_be_killed",
        ])
        .env(CHILD, &path)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let finished = || {
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        text.matches('\n').count().saturating_sub(1)
    };
    while finished() < 4 {
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        std::thread::sleep(Duration::from_millis(5));
    }
    // another run is refused while that one lives
    let refused = Journal::<Attempt>::open(&path, "multistart", "a toy");
    assert!(matches!(refused, Err(Error::JournalInUse { .. })));
    // SIGKILL, which no process can answer
    child.kill().unwrap();
    child.wait().unwrap();
    let toy = Toy::default();
    let resumed = run(&toy, 12, &file(&path));
    assert_eq!(bits(&resumed), bits(&whole));
    assert_eq!(resumed, whole);
    assert_eq!(
        toy.searches.load(Ordering::SeqCst),
        12 - 4,
        "nothing was lost"
    );
}
