#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
use super::*;
use crate::progress::Event;
use crate::solver::Landscape;
use crate::solver::tests::{Least, box_of};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

fn plan<'a>(limits: &'a Limits, start: &'a DVector<f64>, budget: u64) -> Evolution<'a> {
    Evolution {
        limits,
        start,
        population: None,
        budget,
        tolerance: 1e-12,
        seed: 5,
        watch: Watch::default(),
    }
}

/// Searches the box from its middle.
fn run(landscape: &impl Landscape, limits: &Limits, budget: u64) -> Outcome {
    let start = 0.5 * (&limits.lower + &limits.upper);
    let costs = |points: &[DVector<f64>]| landscape.costs(points);
    evolve(&costs, &plan(limits, &start, budget), &Journal::in_memory()).unwrap()
}

fn bits(outcome: &Outcome) -> Vec<u64> {
    let numbers = outcome.point.iter().copied().chain([outcome.cost]);
    numbers.map(f64::to_bits).collect()
}

fn rastrigin(z: &[f64]) -> Vec<f64> {
    use std::f64::consts::TAU;
    let term = |x: &f64| (2.0 * (x * x + 10.0 - 10.0 * (TAU * x).cos())).sqrt();
    z.iter().map(|x| term(&(x - 0.7))).collect()
}

fn rosenbrock(z: &[f64]) -> Vec<f64> {
    let pairs = z.windows(2);
    pairs
        .flat_map(|w| [10.0 * (w[1] - w[0] * w[0]), 1.0 - w[0]])
        .collect()
}

#[test]
fn the_least_of_smooth_curved_and_many_valleyed_landscapes_is_found() {
    let five = box_of(&[-4.0, -1.0, -9.0, -2.0, -2.0], &[5.0, 2.0, 1.0, 2.0, 2.0]);
    let shifted = |z: &[f64]| -> Vec<f64> {
        z.iter()
            .enumerate()
            .map(|(i, x)| x - 0.3 * i as f64 + 0.5)
            .collect()
    };
    // 140 evaluations a variable and decade of cost would be poor: Hansen 2016 needs some 30
    let sphere = run(&Least(shifted), &five, 2_000);
    assert!(sphere.cost < 1e-9 && sphere.converged, "{sphere:?}");
    let valley = run(&Least(rosenbrock), &box_of(&[-3.0; 4], &[3.0; 4]), 8_000);
    assert!(valley.cost < 1e-9 && valley.converged, "{valley:?}");
    assert!((valley.point.add_scalar(-1.0)).amax() < 1e-4);
    // 11³ valleys
    let many = run(&Least(rastrigin), &box_of(&[-5.0; 3], &[5.0; 3]), 20_000);
    assert!(many.cost < 1e-9 && many.converged, "{many:?}");
    for outcome in [sphere, valley, many] {
        assert!(outcome.cost_evaluations <= 20_000 && outcome.failures == 0);
    }
}

#[test]
fn a_least_at_a_bound_is_found_on_it() {
    let outside = |z: &[f64]| vec![z[0] + 1.0, z[1] - 0.4, z[2] - 7.0];
    let outcome = run(&Least(outside), &box_of(&[0.0; 3], &[1.0, 1.0, 5.0]), 3_000);
    let corner = DVector::from_column_slice(&[0.0, 0.4, 5.0]);
    // the tolerance of 1e-12 leaves the linear variables 1e-12, the quadratic one 1e-6
    assert!((&outcome.point - corner).amax() < 1e-5, "{outcome:?}");
    assert!((outcome.cost - 2.5).abs() < 1e-10 && outcome.converged);
    // a variable without room stays where it is
    let outcome = run(
        &Least(outside),
        &box_of(&[0.5, 0.0, 0.0], &[0.5, 1.0, 5.0]),
        3_000,
    );
    assert_eq!(outcome.point[0], 0.5);
    assert!(
        (outcome.cost - (0.5 * 1.5 * 1.5 + 2.0)).abs() < 1e-8,
        "{outcome:?}"
    );
}

/// A sphere about 1 where |z| stays within a shell, and how far the rest is from that.
struct Shell {
    slope: bool,
    radius: f64,
}

impl Landscape for Shell {
    fn cost(&self, z: &DVector<f64>) -> f64 {
        let far = z.add_scalar(-1.0).norm();
        if far > self.radius {
            f64::NAN
        } else {
            far * far
        }
    }
    fn quadratic(&self, _: &DVector<f64>) -> Result<crate::solver::Quadratic> {
        unreachable!("a population asks for no slope")
    }
    fn excess(&self, z: &DVector<f64>) -> f64 {
        if self.slope {
            z.add_scalar(-1.0).norm() - self.radius
        } else {
            0.0
        }
    }
}

#[test]
fn penalties_lead_to_where_there_is_a_cost() {
    // a part in 10⁹ of the box has a cost
    let limits = box_of(&[-10.0; 3], &[10.0; 3]);
    let sloped = Shell {
        slope: true,
        radius: 0.01,
    };
    let outcome = run(&sloped, &limits, 3_000);
    assert!(outcome.cost < 1e-9 && outcome.converged, "{outcome:?}");
    assert!(outcome.failures > 50 && outcome.failures < outcome.cost_evaluations);
    // a third of the box without one, and no slope there
    let half = |z: &[f64]| {
        let lost = z[0] + z[1] < -1.0;
        vec![if lost { f64::NAN } else { z[0] + 0.4 }, z[1] + 0.4, z[2]]
    };
    let outcome = run(&Least(half), &box_of(&[-2.0; 3], &[2.0; 3]), 3_000);
    assert!(outcome.cost < 1e-9 && outcome.failures > 0, "{outcome:?}");
}

#[test]
fn a_landscape_without_a_cost_ends_in_a_finite_penalty() {
    let nowhere = Shell {
        slope: false,
        radius: -1.0,
    };
    let outcome = run(&nowhere, &box_of(&[-1.0; 2], &[1.0; 2]), 500);
    assert!(
        !outcome.converged && outcome.cost.is_finite(),
        "{outcome:?}"
    );
    assert_eq!(outcome.failures, outcome.cost_evaluations);
    // and so does a budget too small for a single generation
    let outcome = run(&nowhere, &box_of(&[-1.0; 2], &[1.0; 2]), 3);
    assert_eq!((outcome.cost_evaluations, outcome.iterations), (0, 0));
    assert!(outcome.cost.is_finite() && !outcome.converged && !outcome.stopped);
}

#[test]
fn the_seed_decides_and_the_number_of_threads_does_not() {
    let limits = box_of(&[-5.0; 3], &[5.0; 3]);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| run(&Least(rastrigin), &limits, 900))
    };
    assert_eq!(with(1), with(4));
    let start = DVector::zeros(3);
    let seeded = |seed| {
        let plan = Evolution {
            seed,
            ..plan(&limits, &start, 300)
        };
        let costs = |points: &[DVector<f64>]| Least(rastrigin).costs(points);
        evolve(&costs, &plan, &Journal::in_memory()).unwrap()
    };
    assert_eq!(seeded(1), seeded(1));
    assert_ne!(bits(&seeded(1)), bits(&seeded(2)));
}

/// A run over Rastrigin's landscape with the journal at `path`; and how often it was evaluated.
fn journaled(path: &Path, budget: u64, watch: Watch) -> (Outcome, usize) {
    let limits = box_of(&[-5.0; 2], &[5.0; 2]);
    let start = DVector::from_column_slice(&[4.0, -3.0]);
    let plan = Evolution {
        watch,
        ..plan(&limits, &start, budget)
    };
    let evaluated = AtomicUsize::new(0);
    let costs = |points: &[DVector<f64>]| {
        evaluated.fetch_add(points.len(), Ordering::SeqCst);
        Least(rastrigin).costs(points)
    };
    let journal = Journal::open(path, "population", "rastrigin").unwrap();
    let outcome = evolve(&costs, &plan, &journal).unwrap();
    (outcome, evaluated.into_inner())
}

#[test]
fn a_stopped_run_goes_on_to_the_same_numbers_and_its_budget_may_grow() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("population.journal");
    let (whole, _) = journaled(&folder.path().join("whole"), 2_000, Watch::default());
    let stop: Arc<Mutex<Option<Watch>>> = Arc::default();
    let watch = Watch::new({
        let stop = Arc::clone(&stop);
        move |event| {
            let Event::Done { done, of: 600, .. } = event else {
                panic!("{event:?}")
            };
            if done > 200 {
                stop.lock().unwrap().as_ref().unwrap().stop();
            }
        }
    });
    *stop.lock().unwrap() = Some(watch.clone());
    let (stopped, first) = journaled(&path, 600, watch);
    assert!(stopped.stopped && stopped.cost.is_finite(), "{stopped:?}");
    assert_eq!(stopped.cost_evaluations as usize, first);
    let (middle, second) = journaled(&path, 600, Watch::default());
    assert!(!middle.stopped && middle.cost <= stopped.cost);
    let (resumed, third) = journaled(&path, 2_000, Watch::default());
    assert_eq!(resumed, whole);
    // no generation was computed twice
    assert_eq!((first + second + third) as u64, whole.cost_evaluations);
    // and one that has ended evaluates nothing more
    assert_eq!(journaled(&path, 2_000, Watch::default()), (whole, 0));
}

#[test]
fn a_journal_cut_at_any_byte_gives_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("population.journal");
    let (whole, _) = journaled(&path, 36, Watch::default());
    let bytes = std::fs::read(&path).unwrap();
    for length in 0..bytes.len() {
        std::fs::write(&path, &bytes[..length]).unwrap();
        let (resumed, _) = journaled(&path, 36, Watch::default());
        assert_eq!(resumed, whole, "{length} bytes");
        assert_eq!(bits(&resumed), bits(&whole), "{length} bytes");
    }
}
