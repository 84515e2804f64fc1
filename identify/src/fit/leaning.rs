//! On which held tyres an estimate leans. Friction and tyres both take energy out of the steering:
//! a fit that holds the tyres has settled by decree what its windows would have to tell apart.

use crate::error::{Error, Result};
use crate::free::{Free, has};
use crate::plan::Plan;
use crate::problem::{Problem, Rides};
use crate::solver::Landscape;
use crate::verdict::Estimate;
use bicycle::Formulation;
use nalgebra::{DMatrix, DVector};

/// The rows of the tyres: of the front, then of the rear, which only four bodies that slip have.
const TYRES: [&str; 4] = [
    "cornering_stiffness",
    "camber_stiffness",
    "rear_cornering_stiffness",
    "rear_camber_stiffness",
];

/// What a held row would change.
#[derive(Debug, Clone)]
struct Leaning {
    held: Free,
    /// To where it would be moved [SI]: the end of its measured range that is farther off.
    to: f64,
    /// By how much each free parameter would follow [SI].
    shifts: Vec<f64>,
}

/// Names on each of `estimates` the held tyres that could move it by more than its standard error,
/// and says so in words. Of replayed windows, at the end `point` of their search.
pub(super) fn lean(
    problem: &Problem,
    point: &DVector<f64>,
    plan: &Plan,
    estimates: &mut [Estimate],
) -> Result<Vec<String>> {
    let mut notes = Vec::new();
    for Leaning { held, to, shifts } in leanings(problem, point, plan)? {
        let name = held.row.name;
        for (estimate, shift) in estimates.iter_mut().zip(shifts) {
            if estimate.std_error.is_none_or(|error| shift.abs() <= error) {
                continue;
            }
            estimate.trades_against.push(format!("{name} (held)"));
            notes.push(format!(
                "{} leans on {name}, which was held: with {to} {} of it, an end of what the \
                 literature measured, it would be some {shift:+.2} {} off",
                estimate.label(),
                held.row.unit.symbol,
                estimate.unit
            ));
        }
    }
    Ok(notes)
}

/// With a held row moved, the free ones follow to where the gradient is 0 again.
fn leanings(problem: &Problem, point: &DVector<f64>, plan: &Plan) -> Result<Vec<Leaning>> {
    let Rides::Time(rides) = &problem.rides else {
        return Ok(Vec::new());
    };
    if plan.model.foreign().is_some() {
        return Ok(Vec::new());
    }
    let slips = plan.formulation == Formulation::WhippleSlip;
    let moves = |name: &str| {
        problem.variables.iter().any(|v| v.free.row.name == name)
            || plan.ties.iter().any(|tie| tie.follower().name == name)
    };
    let held = TYRES
        .into_iter()
        .filter(|name| has(plan.formulation, name) && (slips || !name.starts_with("rear")))
        .filter(|name| !moves(name))
        .map(Free::new)
        .collect::<Result<Vec<Free>>>()?;
    let (n, k) = (problem.shared(), held.len());
    if n == 0 || k == 0 {
        return Ok(Vec::new());
    }
    let mut wider = rides.clone();
    let start = wider.members[0].landscape.unknowns.start.variables(&held);
    for member in &mut wider.members {
        member.landscape.unknowns.free.extend(&held);
        member.variables.extend(n..n + k);
    }
    wider.priors.extend(vec![None; k]);
    let shared = point.iter().take(n).chain(start.iter());
    let blocks = point.iter().skip(n);
    let z = DVector::from_vec(shared.chain(blocks).copied().collect());
    let quadratic = wider.quadratic(&z)?;
    let reduced = quadratic.reduce(0.0).or_else(|| quadratic.reduce(1e-9));
    let curvature = reduced
        .ok_or_else(|| Error::Search("the curvature of a window is not finite".into()))?
        .curvature;
    let own: DMatrix<f64> = curvature.view((0, 0), (n, n)).into_owned();
    let Some(own) = own.cholesky() else {
        // what the windows do not see leans on anything
        return Ok(Vec::new());
    };
    let values = problem.values(point);
    let leaning = |(j, held): (usize, Free)| {
        let at = held.value(start[j]);
        let (low, high) = held.row.measured.unwrap_or((at, at));
        let to = if high - at > at - low { high } else { low };
        let step = (to - at) / held.slope(at);
        let moved = own.solve(&curvature.view((0, n + j), (n, 1)).into_owned()) * -step;
        let shifts = (problem.variables.iter().zip(&values).zip(moved.iter()))
            .map(|((variable, value), moved)| moved * variable.free.slope(*value))
            .collect();
        Leaning { held, to, shifts }
    };
    Ok(held.into_iter().enumerate().map(leaning).collect())
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
    use super::*;
    use crate::effort::Effort;
    use crate::fit::{Fit, fit};
    use crate::objective::Objective;
    use crate::plan::Ridden;
    use crate::progress::Watch;
    use crate::ride::Ride;
    use bicycle::simulate::Simulation;
    use bicycle::{Input, Parameters};

    /// Two seconds of a four-body bicycle with tyres left to itself, twice, at 100 Hz.
    fn ridden() -> Ride {
        let (mut steer, mut roll_rate) = (Vec::new(), Vec::new());
        for start in [0.03, -0.02] {
            let parameters = Parameters {
                roll_start: start,
                ..Parameters::default()
            };
            let input = Input {
                speed: 4.0,
                ..Input::default()
            };
            let slips = Formulation::WhippleSlip;
            let mut ride = Simulation::new(&parameters, slips, input, 0.0).unwrap();
            for i in 0..200 {
                ride.advance(0.01 * f64::from(i)).unwrap();
                steer.push(ride.state().steer);
                roll_rate.push(ride.state().roll_rate);
            }
        }
        let mut ride = Ride::new(0.0, 0.01, steer.len());
        ride.insert("speed", vec![4.0; steer.len()]).unwrap();
        ride.insert("steer", steer).unwrap();
        ride.insert("roll_rate", roll_rate).unwrap();
        ride.law_in_loop = Some(true);
        ride
    }

    fn plan(formulation: Formulation, cornering_stiffness: f64) -> Plan {
        Plan {
            parameters: Parameters {
                cornering_stiffness,
                ..Parameters::default()
            },
            formulation,
            objective: Some(Objective::FreeResponse),
            noise: Some(vec![1e-3, 1e-2]),
            ..Plan::default()
        }
    }

    fn fitted(ride: &Ride, plan: &Plan) -> (Problem, Fit) {
        let ridden = Ridden {
            windows: vec![0..200, 200..400],
            ..plan.ridden(ride)
        };
        fit(&[ridden], plan, &Effort::default(), &Watch::default()).unwrap()
    }

    #[test]
    fn friction_moves_with_the_held_tyre_as_predicted() {
        let ride = ridden();
        let plan_of = |stiffness| plan(Formulation::WhippleSlip, stiffness);
        let (problem, at) = fitted(&ride, &plan_of(14.0));
        let held: Vec<usize> = vec![0];
        let settled = problem
            .search(
                &problem.at(&[at.parameters[0].value]),
                &held,
                &Watch::default(),
            )
            .unwrap();
        let predicted = leanings(&problem, &settled.outcome.point, &plan_of(14.0)).unwrap();
        assert_eq!(predicted.len(), 4);
        let front = &predicted[0];
        assert_eq!(front.held.row.name, "cornering_stiffness");
        let slope = front.shifts[0] / (front.to - 14.0);
        // the difference quotient of two whole fits; its error is of the order of the step squared
        let friction = |stiffness| fitted(&ride, &plan_of(stiffness)).1.parameters[0].value;
        let quotient = (friction(14.2) - friction(13.8)) / 0.4;
        assert!(
            (slope / quotient - 1.0).abs() < 0.05,
            "predicted {slope}, found {quotient}"
        );
        // rides without noise leave an error so small that friction leans on the tyre
        let friction = &at.parameters[0];
        assert!(
            friction
                .trades_against
                .contains(&"cornering_stiffness (held)".to_owned()),
            "{friction:?}"
        );
        assert!(
            at.notes
                .iter()
                .any(|note| note.contains("leans on cornering_stiffness"))
        );
    }

    #[test]
    fn wheels_that_do_not_slip_have_no_tyre_to_lean_on() {
        let ride = ridden();
        let (problem, fit) = fitted(&ride, &plan(Formulation::Whipple, 14.0));
        assert!(fit.parameters[0].trades_against.is_empty());
        let plan = plan(Formulation::Whipple, 14.0);
        let point = problem.start();
        assert!(leanings(&problem, &point, &plan).unwrap().is_empty());
    }
}
