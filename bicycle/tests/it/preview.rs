//! The gains of a previewing rider against solutions made another way.

use bicycle::rider::riccati::{self, Problem};
use bicycle::rider::{Gains, Manner, sampled};
use bicycle::{Formulation, Output, Parameters, State};
use nalgebra::{DMatrix, DVector};

#[test]
fn one_state_has_its_closed_form() {
    // p = q + a² p − a² b² p²/(r + b² p)
    let (a, b, q, r): (f64, f64, f64, f64) = (1.3, 0.7, 2.0, 0.5);
    let half = r - r * a * a - q * b * b;
    let p = (-half + (half * half + 4.0 * b * b * q * r).sqrt()) / (2.0 * b * b);
    let solved = riccati::solve(&Problem {
        transition: DMatrix::from_element(1, 1, a),
        input: DVector::from_element(1, b),
        state_cost: DMatrix::from_element(1, 1, q),
        input_cost: r,
    })
    .expect("controllable");
    // a dozen roundings
    assert!((solved.cost_to_go[0] - p).abs() < 1e-14 * p);
    assert!((solved.gain[0] - a * b * p / (r + b * b * p)).abs() < 1e-14);
}

#[test]
fn an_unstable_state_out_of_reach_has_no_solution() {
    let out_of_reach = Problem {
        transition: DMatrix::from_row_slice(2, 2, &[1.1, 0.0, 0.0, 0.5]),
        input: DVector::from_column_slice(&[0.0, 1.0]),
        state_cost: DMatrix::identity(2, 2),
        input_cost: 1.0,
    };
    assert_eq!(riccati::solve(&out_of_reach), None);
    let not_finite = Problem {
        input_cost: f64::NAN,
        ..out_of_reach
    };
    assert_eq!(riccati::solve(&not_finite), None);
}

const RIDDEN: [Formulation; 3] = [
    Formulation::Repaired,
    Formulation::Whipple,
    Formulation::WhippleSlip,
];

#[test]
fn the_riccati_equation_holds_at_every_speed_and_load() {
    for formulation in RIDDEN {
        for rear_load in [0.0, 20.0] {
            let p = Parameters {
                rear_load,
                ..Parameters::default()
            };
            for n in 1..=40 {
                let speed = 0.5 * f64::from(n);
                let gains = Gains::new(&p, formulation, &Manner::default(), speed);
                let residual = gains.expect("rideable").residual;
                // roundings of products of 10 × 10 matrices whose entries span many decades
                assert!(
                    residual < 1e-11,
                    "{residual:e} at {speed} m/s, {formulation:?}"
                );
            }
        }
    }
}

/// The problem as Sharp and Valtetsiotis (2001) pose it, the course ahead as a shift register among
/// the states, by the naive backward recursion over a long horizon.
#[test]
fn gains_are_those_of_the_backward_recursion_with_a_shift_register() {
    RIDDEN.into_iter().for_each(backward_recursion_agrees);
}

fn backward_recursion_agrees(formulation: Formulation) {
    let p = Parameters {
        rear_load: 20.0,
        ..Parameters::default()
    };
    let manner = Manner {
        sample_time: 0.05,
        horizon: 1.0,
        ..Manner::default()
    };
    let speed = 3.0;
    let gains = Gains::new(&p, formulation, &manner, speed).expect("rideable");
    let design = sampled(&p, formulation, &manner, speed).expect("finite");
    let Problem {
        transition,
        input,
        state_cost,
        input_cost,
    } = &design.problem;

    let (n, ahead) = (input.len(), gains.preview.len());
    assert_eq!(ahead, 20);
    // states, curvatures of this sample and the next twenty; the last one stays
    let all = n + ahead + 1;
    let mut a = DMatrix::zeros(all, all);
    a.view_mut((0, 0), (n, n)).copy_from(transition);
    a.view_mut((0, n), (n, 1)).copy_from(&design.course);
    for i in n..all {
        a[(i, (i + 1).min(all - 1))] = 1.0;
    }
    let mut b = DVector::zeros(all);
    b.rows_mut(0, n).copy_from(input);
    let mut q = DMatrix::zeros(all, all);
    q.view_mut((0, 0), (n, n)).copy_from(state_cost);

    let (mut cost, mut gain) = (q.clone(), DVector::zeros(all));
    // 100 s, some two hundred time constants of the closed loop
    for _ in 0..2000 {
        let pb = &cost * &b;
        gain = a.transpose() * &pb / (input_cost + b.dot(&pb));
        cost = &q + a.transpose() * &cost * (&a - &b * gain.transpose());
        cost = (&cost + cost.transpose()) * 0.5;
    }
    let mut found = DVector::zeros(all);
    for (i, row) in State::TABLE[..n - 2].iter().enumerate() {
        found[i] = gains
            .output
            .get(Output::index(row.name).expect("an output"));
    }
    found[n - 2] = gains.offset;
    found[n - 1] = gains.heading;
    found.rows_mut(n, ahead).copy_from_slice(&gains.preview);
    found[all - 1] = gains.beyond;
    // the recursion's roundings, 2000 of them, against gains up to 1e3
    let off = (&found - &gain).amax();
    assert!(off < 1e-8 * gain.amax(), "{off:e}\n{found}{gain}");
}
