//! The discrete algebraic Riccati equation of a system with one input, by doubling.

use nalgebra::{DMatrix, DVector};

/// `x⁺ = Φ x + Γ u` with the cost `Σ xᵀ Q x + r u²`.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// Φ, n × n.
    pub transition: DMatrix<f64>,
    /// Γ, n.
    pub input: DVector<f64>,
    /// Q, n × n, symmetric and positive semidefinite.
    pub state_cost: DMatrix<f64>,
    /// r > 0.
    pub input_cost: f64,
}

/// The stabilising solution: `u = −K x` costs `x₀ᵀ P x₀`, and nothing costs less.
#[derive(Debug, Clone, PartialEq)]
pub struct Regulator {
    /// P, n × n.
    pub cost_to_go: DMatrix<f64>,
    /// K, n.
    pub gain: DVector<f64>,
    /// Φ − Γ K, n × n.
    pub closed_loop: DMatrix<f64>,
    /// `r + Γᵀ P Γ`.
    pub weight: f64,
    /// ‖Q + Φᵀ P (Φ − Γ K) − P‖ / ‖P‖, Frobenius.
    pub residual: f64,
}

/// Most doublings: the closed loop would take 2⁴⁰ steps to come to rest.
const DOUBLINGS: usize = 40;

/// Solves the equation by the structure-preserving doubling algorithm (Chu, Fan, Lin and Wang
/// 2004), each round of which looks twice as many steps ahead as the last: `None` where the cost of
/// no control is finite, or a number is not.
pub fn solve(problem: &Problem) -> Option<Regulator> {
    let Problem {
        transition,
        input,
        state_cost,
        input_cost,
    } = problem;
    let n = input.len();
    let (mut a, mut h) = (transition.clone(), state_cost.clone());
    let mut g = input * input.transpose() / *input_cost;
    for _ in 0..DOUBLINGS {
        // W = (I + G H)⁻¹; A ← A W A, G ← G + A W G Aᵀ, H ← H + Aᵀ H W A
        let lu = (DMatrix::identity(n, n) + &g * &h).lu();
        let (wa, wg) = (lu.solve(&a)?, lu.solve(&g)?);
        let (next_g, next_h) = (&a * wg * a.transpose(), a.transpose() * &h * &wa);
        a *= wa;
        g += next_g;
        h += next_h;
        // what is left of the start after 2ᵏ steps in closed loop; the error of H is its square
        let rest = a.norm();
        if !rest.is_finite() {
            return None;
        }
        if rest < 1e-10 {
            return Some(Regulator::of(problem, (&h + h.transpose()) * 0.5));
        }
    }
    None
}

impl Regulator {
    fn of(problem: &Problem, cost_to_go: DMatrix<f64>) -> Self {
        let Problem {
            transition,
            input,
            state_cost,
            input_cost,
        } = problem;
        let ahead = &cost_to_go * input;
        let weight = input_cost + input.dot(&ahead);
        let gain = transition.transpose() * ahead / weight;
        let closed_loop = transition - input * gain.transpose();
        let residual =
            (state_cost + transition.transpose() * &cost_to_go * &closed_loop - &cost_to_go).norm()
                / cost_to_go.norm();
        Self {
            cost_to_go,
            gain,
            closed_loop,
            weight,
            residual,
        }
    }
}
