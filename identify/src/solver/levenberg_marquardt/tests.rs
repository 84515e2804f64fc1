#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
use super::*;
use crate::progress::Event;
use crate::solver::tests::{Least, box_of};
use nalgebra::DMatrix;
use std::sync::{Arc, Mutex};

fn search(limits: &Limits) -> Search<'_> {
    Search {
        limits,
        held: &[],
        tolerance: 1e-16,
        max_iterations: 200,
        watch: Watch::default(),
    }
}

fn run(landscape: &impl Landscape, start: &[f64], limits: &Limits) -> Outcome {
    let start = DVector::from_column_slice(start);
    minimise(landscape, start, &search(limits)).unwrap()
}

fn everywhere(n: usize) -> Limits {
    box_of(&vec![-1e9; n], &vec![1e9; n])
}

/// Rosenbrock's valley as least squares.
fn valley(z: &[f64]) -> Vec<f64> {
    vec![10.0 * (z[1] - z[0] * z[0]), 1.0 - z[0]]
}

/// The same, NaN left of −1.5.
fn valley_with_a_hole(z: &[f64]) -> Vec<f64> {
    valley(z)
        .iter()
        .map(|r| if z[0] < -1.5 { f64::NAN } else { *r })
        .collect()
}

fn near(found: &DVector<f64>, expected: &[f64], relative: f64) {
    for (found, expected) in found.iter().zip(expected) {
        let error = (found - expected).abs();
        assert!(
            error <= relative * expected.abs().max(1e-8),
            "{found} for {expected}"
        );
    }
}

#[test]
fn the_valley_is_walked_to_its_end_and_the_work_counted() {
    let mut limits = box_of(&[-2.0; 2], &[2.0; 2]);
    limits.reach.fill(1.0);
    let outcome = run(&Least(valley_with_a_hole), &[-1.2, 1.0], &limits);
    near(&outcome.point, &[1.0, 1.0], 1e-8);
    assert!(outcome.converged && outcome.iterations < 30, "{outcome:?}");
    assert!(outcome.cost_evaluations >= outcome.iterations);
}

#[test]
fn certified_and_published_minima_are_found() {
    // Misra1a of NIST's Statistical Reference Datasets, from its first start; certified to 11
    // digits, of which central differences keep 8
    let misra = |b: &[f64]| -> Vec<f64> {
        let x = [
            77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1,
            689.1, 760.0,
        ];
        let y = [
            10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40,
            75.47, 81.78,
        ];
        let model = |x: f64| b[0] * (1.0 - (-b[1] * x).exp());
        x.iter().zip(y).map(|(&x, y)| model(x) - y).collect()
    };
    let outcome = run(&Least(misra), &[500.0, 1e-4], &everywhere(2));
    assert!(outcome.converged, "{outcome:?}");
    near(&outcome.point, &[238.94212918, 5.5015643181e-4], 1e-8);
    near(
        &DVector::from_element(1, 2.0 * outcome.cost),
        &[0.12455138894],
        1e-9,
    );

    // Bard, and Kowalik and Osborne: problems 8 and 15 of Moré, Garbow, Hillstrom 1981, which
    // print six digits
    let bard = |z: &[f64]| -> Vec<f64> {
        let y = [
            0.14, 0.18, 0.22, 0.25, 0.29, 0.32, 0.35, 0.39, 0.37, 0.58, 0.73, 0.96, 1.34, 2.10,
            4.39,
        ];
        let residual = |(i, y): (usize, &f64)| {
            let (u, v) = (i as f64 + 1.0, 15.0 - i as f64);
            y - (z[0] + u / (v * z[1] + u.min(v) * z[2]))
        };
        y.iter().enumerate().map(residual).collect()
    };
    let kowalik = |z: &[f64]| -> Vec<f64> {
        let y = [
            0.1957, 0.1947, 0.1735, 0.1600, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235, 0.0246,
        ];
        let u = [
            4.0, 2.0, 1.0, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625,
        ];
        let model = |u: f64| z[0] * (u * u + u * z[1]) / (u * u + u * z[2] + z[3]);
        u.iter().zip(y).map(|(&u, y)| y - model(u)).collect()
    };
    let outcomes = [
        (run(&Least(bard), &[1.0; 3], &everywhere(3)), 8.21487e-3),
        (
            run(&Least(kowalik), &[0.25, 0.39, 0.415, 0.39], &everywhere(4)),
            3.07505e-4,
        ),
    ];
    for (outcome, published) in outcomes {
        assert!(outcome.converged && outcome.iterations < 40, "{outcome:?}");
        near(
            &DVector::from_element(1, 2.0 * outcome.cost),
            &[published],
            1e-5,
        );
    }
}

#[test]
fn a_bound_holds_and_the_rest_is_optimal_on_it() {
    // with x ≤ ½ the least of the valley is at x = ½, y = ¼
    let limits = box_of(&[-2.0; 2], &[0.5, 2.0]);
    let outcome = run(&Least(valley), &[-1.2, 1.0], &limits);
    // the search ends within 1e-8 of a cost of ⅛: 5e-6 of y, most of which the last step takes
    near(&outcome.point, &[0.5, 0.25], 1e-6);
    assert_eq!(outcome.point[0], 0.5);
    assert!(outcome.converged, "{outcome:?}");
    // and from that bound back into the box, when that is where the least is
    let open = box_of(&[0.5, -2.0], &[2.0; 2]);
    near(
        &run(&Least(valley), &[0.5, 0.25], &open).point,
        &[1.0, 1.0],
        1e-8,
    );
}

#[test]
fn along_a_valley_that_runs_into_a_bound_the_search_slides_to_the_best_on_it() {
    // two frictions that enter as their sum but for a thousandth: the free least (3, −2) is
    // outside, that with y ≥ 0 is at y = 0 and the closed form's x
    let sum = |z: &[f64]| vec![z[0] + z[1] - 1.0, 1e-3 * (z[0] - z[1] - 5.0)];
    let x = (1.0 + 1e-6 * 5.0) / (1.0 + 1e-6);
    let outcome = run(&Least(sum), &[0.2, 0.9], &box_of(&[0.0; 2], &[10.0; 2]));
    near(&outcome.point, &[x, 0.0], 1e-8);
    assert!(outcome.converged && outcome.iterations <= 10, "{outcome:?}");
}

#[test]
fn a_singular_curvature_is_walked_like_any_other() {
    // only x + y enters; neither runs away
    let sum = |z: &[f64]| vec![z[0] + z[1] - 1.0, (z[0] + z[1]).powi(2) - 1.5];
    let outcome = run(&Least(sum), &[5.0, -3.0], &everywhere(2));
    // s minimises (s − 1)² + (s² − 1.5)²: 2 s³ − 2 s − 1 = 0, of slope 6.5; 1e-8 of the cost is
    // 1e-5 of s
    let s = outcome.point.sum();
    assert!(
        (2.0 * s.powi(3) - 2.0 * s - 1.0).abs() < 1e-4,
        "{outcome:?}"
    );
    assert!(
        outcome.converged && outcome.point.amax() < 10.0,
        "{outcome:?}"
    );
    // a variable without any influence stays
    let none = |z: &[f64]| vec![z[0] - 2.0, 0.0];
    let outcome = run(&Least(none), &[0.0, 7.0], &everywhere(2));
    near(&outcome.point, &[2.0, 7.0], 1e-8);
    // Powell 1962: singular at the least itself, where convergence is linear
    let powell = |z: &[f64]| {
        vec![
            z[0] + 10.0 * z[1],
            5.0_f64.sqrt() * (z[2] - z[3]),
            (z[1] - 2.0 * z[2]).powi(2),
            10.0_f64.sqrt() * (z[0] - z[3]).powi(2),
        ]
    };
    let outcome = run(&Least(powell), &[3.0, -1.0, 0.0, 1.0], &everywhere(4));
    assert!(outcome.converged && outcome.cost < 1e-14, "{outcome:?}");
}

#[test]
fn units_change_nothing_and_bad_scaling_little() {
    // the valley in units that differ by a power of two, so that no rounding differs
    let unit = 2.0_f64.powi(30);
    let scaled = move |z: &[f64]| valley(&[z[0] / unit, z[1]]);
    let metres = run(&Least(valley), &[-1.2, 1.0], &everywhere(2));
    let wide = box_of(&[-1e9 * unit, -1e9], &[1e9 * unit, 1e9]);
    let nanometres = run(&Least(scaled), &[-1.2 * unit, 1.0], &wide);
    assert_eq!(metres.cost_evaluations, nanometres.cost_evaluations);
    near(&nanometres.point, &[unit, 1.0], 1e-8);
    // Powell 1970, badly scaled: six decades between the variables
    let powell = |z: &[f64]| {
        vec![
            1e4 * z[0] * z[1] - 1.0,
            (-z[0]).exp() + (-z[1]).exp() - 1.0001,
        ]
    };
    let outcome = run(&Least(powell), &[0.0, 1.0], &everywhere(2));
    near(&outcome.point, &[1.098159e-5, 9.106146], 1e-6);
    assert!(outcome.converged, "{outcome:?}");
}

#[test]
fn a_step_into_the_void_is_too_long_and_counted() {
    // √(x − 1) is NaN below 1, and the first step from 9 goes to −3
    let root = |z: &[f64]| vec![(z[0] - 1.0).sqrt() - 0.5];
    let outcome = run(&Least(root), &[9.0], &everywhere(1));
    near(&outcome.point, &[1.25], 1e-7);
    assert!(outcome.converged && outcome.failures > 0, "{outcome:?}");
}

#[test]
fn a_cliff_before_the_least_is_no_convergence() {
    // the least at 0 cannot be computed, nor anything below 1
    let cliff = |z: &[f64]| vec![if z[0] < 1.0 { f64::NAN } else { z[0] }];
    let outcome = run(&Least(cliff), &[5.0], &everywhere(1));
    assert!(!outcome.converged && outcome.failures > 0, "{outcome:?}");
    assert!((1.0..1.1).contains(&outcome.point[0]), "{outcome:?}");
    assert!(
        outcome
            .termination
            .starts_with("stalled: where the cost falls")
    );
}

#[test]
fn what_is_held_stays_and_the_rest_is_optimal() {
    let limits = everywhere(2);
    let search = Search {
        held: &[0],
        ..search(&limits)
    };
    let start = DVector::from_column_slice(&[-0.3, 5.0]);
    let outcome = minimise(&Least(valley), start, &search).unwrap();
    assert_eq!(outcome.point[0], -0.3);
    near(&outcome.point, &[-0.3, 0.09], 1e-8);
    assert!(outcome.converged);
    let search = Search {
        held: &[0, 1],
        ..search
    };
    let outcome = minimise(&Least(valley), outcome.point, &search).unwrap();
    assert!(
        outcome.converged && outcome.cost_evaluations == 1,
        "{outcome:?}"
    );
}

#[test]
fn a_stopped_search_returns_the_best_so_far_and_told_of_every_step() {
    let heard = Arc::new(Mutex::new(Vec::new()));
    let stop: Arc<Mutex<Option<Watch>>> = Arc::default();
    let watch = Watch::new({
        let (heard, stop) = (Arc::clone(&heard), Arc::clone(&stop));
        move |event| {
            let Event::Iteration { iteration, cost } = event else {
                panic!("{event:?}")
            };
            heard.lock().unwrap().push(cost);
            if iteration == 3 {
                stop.lock().unwrap().as_ref().unwrap().stop();
            }
        }
    });
    *stop.lock().unwrap() = Some(watch.clone());
    let limits = everywhere(2);
    let search = Search {
        watch,
        ..search(&limits)
    };
    let start = DVector::from_column_slice(&[-1.2, 1.0]);
    let outcome = minimise(&Least(valley), start, &search).unwrap();
    assert!(outcome.stopped && !outcome.converged, "{outcome:?}");
    assert!(outcome.termination.starts_with("stopped"));
    let heard = heard.lock().unwrap();
    assert_eq!((outcome.iterations, heard.len()), (3, 3));
    assert!(heard.is_sorted_by(|a, b| a >= b) && heard[2] == outcome.cost);
    // so is one that runs out of iterations
    let search = Search {
        max_iterations: 2,
        watch: Watch::default(),
        ..search
    };
    let start = DVector::from_column_slice(&[-1.2, 1.0]);
    let outcome = minimise(&Least(valley), start, &search).unwrap();
    assert_eq!(outcome.termination, "gave up after 2 iterations");
    assert!(!outcome.stopped && !outcome.converged && outcome.cost == heard[1]);
}

/// The valley, whose slope is lost right of 0.
struct Half(Least);
impl Landscape for Half {
    fn cost(&self, z: &DVector<f64>) -> f64 {
        self.0.cost(z)
    }
    fn quadratic(&self, z: &DVector<f64>) -> Result<Quadratic> {
        if z[0] > 0.0 {
            return Err(Error::Search("nothing to the right".into()));
        }
        self.0.quadratic(z)
    }
}

#[test]
fn a_start_without_a_cost_is_an_error_and_a_lost_slope_keeps_the_best() {
    let limits = everywhere(2);
    let start = DVector::from_column_slice(&[-2.0, 1.0]);
    let error = minimise(&Least(valley_with_a_hole), start, &search(&limits)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the search failed: expected a finite cost at the start, found NaN"
    );
    let start = DVector::from_column_slice(&[-1.2, 1.0]);
    let half = Half(Least(valley));
    let outcome = minimise(&half, start, &search(&limits)).unwrap();
    assert!(!outcome.converged && outcome.point[0] > 0.0, "{outcome:?}");
    assert_eq!(outcome.cost, half.cost(&outcome.point));
    assert!(outcome.termination.ends_with("nothing to the right"));
    let start = DVector::from_column_slice(&[0.5, 1.0]);
    assert!(minimise(&half, start, &search(&limits)).is_err());
}

#[test]
fn the_blocks_behind_the_shared_variables_are_searched_too() {
    /// One shared variable and one block of one: (x + y − 3)² + (x − 1)² + (y − 1)².
    struct Two;
    impl Landscape for Two {
        fn cost(&self, z: &DVector<f64>) -> f64 {
            0.5 * ((z.sum() - 3.0).powi(2) + (z[0] - 1.0).powi(2) + (z[1] - 1.0).powi(2))
        }
        fn quadratic(&self, z: &DVector<f64>) -> Result<Quadratic> {
            let (both, own) = (z.sum() - 3.0, z[1] - 1.0);
            Ok(Quadratic {
                gradient: DVector::from_element(1, both + z[0] - 1.0),
                curvature: DMatrix::from_element(1, 1, 2.0),
                blocks: vec![crate::solver::Block {
                    gradient: DVector::from_element(1, both + own),
                    share: DVector::from_element(1, both),
                    own: DMatrix::from_element(1, 1, 1.0),
                    curvature: DMatrix::from_element(1, 1, 2.0),
                    cross: DMatrix::from_element(1, 1, 1.0),
                }],
            })
        }
        fn blocks(&self) -> usize {
            1
        }
    }
    let limits = box_of(&[-5.0], &[1.2]);
    let start = DVector::zeros(1 + Two.blocks());
    let outcome = minimise(&Two, start, &search(&limits)).unwrap();
    // free (4/3, 4/3); with x ≤ 1.2 y = (3 − 1.2 + 1)/2
    near(&outcome.point, &[1.2, 1.4], 1e-8);
}
