//! The gains of a previewing rider against solutions made another way.

use bicycle::rider::riccati::{self, Problem};
use bicycle::rider::{Gains, Manner, Unridable, sampled};
use bicycle::{Formulation, Parameters, State};
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

const ROLL: usize = State::index("roll").expect("a state");

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

/// What the row of the horizon says: from .5 m/s on the nominal gains have died away after 1.9 s.
#[test]
fn the_horizon_is_long_enough() {
    let manner = Manner::default();
    for formulation in RIDDEN {
        for speed in [0.5, 1.0, 8.0 / 3.6, 5.0, 10.0] {
            let gains = Gains::new(&Parameters::default(), formulation, &manner, speed);
            let preview = gains.expect("rideable").preview;
            let largest = preview
                .iter()
                .fold(0.0f64, |most, gain| most.max(gain.abs()));
            let late = &preview[(1.9 / manner.sample_time) as usize..];
            assert!(
                late.iter().all(|gain| gain.abs() < 0.01 * largest),
                "{formulation:?} at {speed} m/s"
            );
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
    found.rows_mut(0, n).copy_from(&gains.state);
    found.rows_mut(n, ahead).copy_from_slice(&gains.preview);
    found[all - 1] = gains.beyond;
    // the recursion's roundings, 2000 of them, against gains up to 1e3
    let off = (&found - &gain).amax();
    assert!(off < 1e-8 * gain.amax(), "{off:e}\n{found}{gain}");
}

#[test]
fn gains_change_smoothly_with_speed() {
    let p = Parameters::default();
    let at =
        |speed| Gains::new(&p, Formulation::Repaired, &Manner::default(), speed).expect("rideable");
    let row = |g: &Gains| {
        let mut row = g.state.as_slice().to_vec();
        row.push(g.beyond);
        row.extend(&g.preview);
        row
    };
    let size = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    for n in 5..80 {
        let speed = 0.1 * f64::from(n);
        let [a, middle, b] = [0.0, 0.05, 0.1].map(|d| row(&at(speed + d)));
        let bend: Vec<_> = (0..a.len())
            .map(|i| 0.5 * (a[i] + b[i]) - middle[i])
            .collect();
        // a schedule's straight lines, 0.1 m/s long, against the design half way: worst at the
        // slow end, where the gains rise as the bicycle is about to stop obeying
        let bound = if speed < 0.95 { 0.03 } else { 0.002 };
        assert!(
            size(&bend) < bound * size(&middle),
            "{speed}: {}",
            size(&bend) / size(&middle)
        );
    }
}

#[test]
fn what_cannot_be_ridden_is_said() {
    let p = Parameters {
        rear_load: 20.0,
        ..Parameters::default()
    };
    let f = Formulation::Repaired;
    for speed in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let outcome = Gains::new(&p, f, &Manner::default(), speed);
        assert!(
            matches!(outcome, Err(Unridable::NoLinearSystem { .. })),
            "{outcome:?}"
        );
    }

    // between two walking speeds the torque that catches a fall changes its sign; there the fall is
    // out of its reach
    let design = |speed| Gains::new(&p, f, &Manner::default(), speed);
    let (mut slow, mut fast) = (0.1, 0.3);
    let lost = loop {
        let speed = 0.5 * (slow + fast);
        assert!(slow < speed && speed < fast, "no such speed");
        match design(speed) {
            Ok(gains) if gains.state[ROLL] < 0.0 => slow = speed,
            Ok(_) => fast = speed,
            Err(why) => break (why, speed),
        }
    };
    assert_eq!(lost.0, Unridable::Uncontrollable { speed: lost.1 });
}

/// Kleinman (1969): with the torque `d` samples late the optimum is the undelayed one at the
/// predicted state, K Φᵈ x + Σ K Φᵈ⁻¹⁻ⁱ Γ τ_i. Here by putting the torques on their way among the
/// states and solving anew.
#[test]
fn acting_on_the_predicted_state_is_the_optimum_of_a_late_rider() {
    let (p, manner) = (Parameters::default(), Manner::default());
    let gains = Gains::new(&p, Formulation::Repaired, &manner, 3.0).expect("rideable");
    let problem = &gains.sampled.problem;
    let (n, d) = (gains.state.len(), 20);
    let all = n + d;
    let mut late = Problem {
        transition: DMatrix::zeros(all, all),
        input: DVector::zeros(all),
        state_cost: DMatrix::zeros(all, all),
        input_cost: problem.input_cost,
    };
    let corner = |m: &mut DMatrix<f64>, block: &DMatrix<f64>| {
        m.view_mut((0, 0), (n, n)).copy_from(block);
    };
    corner(&mut late.transition, &problem.transition);
    corner(&mut late.state_cost, &problem.state_cost);
    late.transition
        .view_mut((0, n), (n, 1))
        .copy_from(&problem.input);
    for i in n..all - 1 {
        late.transition[(i, i + 1)] = 1.0;
    }
    late.input[all - 1] = 1.0;
    let solved = riccati::solve(&late).expect("as rideable as before");

    let mut row = gains.state.transpose();
    let mut predicted = DVector::zeros(all);
    for i in (n..all).rev() {
        predicted[i] = (&row * &problem.input)[0];
        row *= &problem.transition;
    }
    predicted.rows_mut(0, n).copy_from(&row.transpose());
    let off = (&solved.gain - &predicted).amax();
    // the doubling stops within 1e-10 of rest
    assert!(off < 1e-8 * predicted.amax(), "{off:e}");
}
