#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]

use super::Solved;
use super::bootstrap::{Bootstrap, Draw, Kind};
use crate::checkpoint::Journal;
use crate::effort::Effort;
use crate::fit::{Fit, fit};
use crate::free::{Free, Prior};
use crate::objective::Objective;
use crate::plan::{Plan, Ridden};
use crate::problem::Problem;
use crate::progress::Watch;
use crate::ride::Ride;
use crate::synthesis::Synthesis;
use bicycle::Parameters;

/// A rider on roll and roll rate alone, on the nominal bicycle.
fn rider() -> Parameters {
    Parameters::default().steered_by_roll(150.0, 60.0)
}

fn ride(duration: f64, torque_recorded: bool) -> Ride {
    let synthesis = Synthesis {
        parameters: rider(),
        duration,
        torque_recorded,
        seed: 41,
        ..Synthesis::default()
    };
    synthesis.ride().unwrap()
}

fn plan(objective: Objective, free: &[&str]) -> Plan {
    Plan {
        parameters: rider(),
        objective: Some(objective),
        free: Some(free.iter().map(|name| Free::new(name).unwrap()).collect()),
        ..Plan::default()
    }
}

fn fitted(ridden: &[Ridden], plan: &Plan) -> (Problem, Fit) {
    fit(ridden, plan, &Effort::default(), &Watch::default()).unwrap()
}

fn solved<'a>(problem: &'a Problem, fit: &Fit) -> Solved<'a> {
    let values: Vec<f64> = fit.parameters.iter().map(|p| p.value).collect();
    Solved::new(problem, &problem.at(&values)).unwrap()
}

#[test]
fn profiles_of_a_fit_lie_about_its_intervals() {
    let ride = ride(24.0, false);
    let plan = plan(Objective::Amplitude, &["effective_damping"]);
    let (problem, fit) = fitted(&[plan.ridden(&ride)], &plan);
    for (profile, estimate) in solved(&problem, &fit)
        .profiles()
        .iter()
        .zip(&fit.parameters)
    {
        let (low, high) = estimate.interval.unwrap();
        // a spectrum's cost is skew: the widths agree to a third, and the estimate is inside
        let width = profile.upper.unwrap() - profile.lower.unwrap_or(0.0);
        assert!(
            (width / (high - low) - 1.0).abs() < 1.0 / 3.0,
            "{profile:?} {estimate:?}"
        );
        assert!(profile.holds(estimate.value));
        // and at its ends the cost has risen by what a 95 % interval allows
        let last = profile.rise.iter().flatten().copied().fold(0.0, f64::max);
        assert!(last > 0.97 * profile.level, "{profile:?}");
        assert!(profile.fell < 1e-6, "{profile:?}");
    }
}

#[test]
fn the_rule_leaves_out_the_damping_and_keeps_the_tyres() {
    let ride = ride(24.0, false);
    let free = [
        "cornering_stiffness",
        "camber_stiffness",
        "effective_damping",
    ];
    let plan = plan(Objective::Whittle, &free);
    let (problem, fit) = fitted(&[plan.ridden(&ride)], &plan);
    let reduction = solved(&problem, &fit).reduce(1.0).unwrap().unwrap();
    let kept: Vec<_> = reduction.kept.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(
        kept,
        [
            "cornering_stiffness",
            "camber_stiffness",
            "remnant_intensity"
        ]
    );
    // one ride tells the damping to ± 30 % of its value, the tyres to 1 and 5 %
    let [dropped] = &reduction.dropped[..] else {
        panic!("{:?}", reduction.dropped);
    };
    assert_eq!(dropped.sensitivity.name, "effective_damping");
    assert!(dropped.sensitivity.cramer_rao.unwrap() > 0.2);
    assert_eq!(dropped.fixed_at, plan.excitation.effective_damping);
    assert!(dropped.cost_rise > 0.0);
}

#[test]
fn a_job_is_the_same_whenever_it_runs_and_known_ones_do_not_run_again() {
    let ride = ride(24.0, false);
    let plan = plan(Objective::Amplitude, &["effective_damping"]);
    let ridden = [plan.ridden(&ride)];
    let (problem, fit) = fitted(&ridden, &plan);
    let z = solved(&problem, &fit).z;
    let bootstrap = Bootstrap::new(&ridden, &plan, &problem, &z, 7).unwrap();
    assert_eq!(bootstrap.kind(), Kind::Rides);

    let watch = Watch::default();
    let journal = Journal::in_memory();
    let whole = bootstrap.run(6, &journal, &watch).unwrap();
    assert_eq!((journal.len(), whole.jobs, whole.failed), (6, 6, 0));
    assert_eq!(journal.get(4), bootstrap.draw(4, &watch));
    assert_ne!(journal.get(4), journal.get(5));

    // stopped after three, resumed: the same; nothing to do: nothing done
    let resumed = Journal::in_memory();
    let three = bootstrap.run(3, &resumed, &watch).unwrap();
    assert_eq!((three.jobs, resumed.len()), (3, 3));
    assert_eq!(bootstrap.run(6, &resumed, &watch).unwrap(), whole);

    // a failed job is counted and leaves the others; one in the journal is not done again
    let failed = Journal::in_memory();
    for job in 0..3 {
        failed.put(job, &Draw { z: None }).unwrap();
    }
    let partly = bootstrap.run(6, &failed, &watch).unwrap();
    assert_eq!((partly.jobs, partly.failed), (6, 3));

    // a stop does no more
    watch.stop();
    let stopped = bootstrap.run(6, &Journal::in_memory(), &watch).unwrap();
    assert_eq!((stopped.planned, stopped.jobs), (6, 0));
}

#[test]
fn windows_drawn_again_scatter_as_the_sandwich_says() {
    let ride = ride(12.0, true);
    let plan = plan(
        Objective::Time,
        &["cornering_stiffness", "viscous_friction"],
    );
    let ridden = [plan.ridden(&ride)];
    let (problem, fit) = fitted(&ridden, &plan);
    let z = solved(&problem, &fit).z;
    let bootstrap = Bootstrap::new(&ridden, &plan, &problem, &z, 1).unwrap();
    assert_eq!(bootstrap.kind(), Kind::Windows);
    let resampled = bootstrap
        .run(24, &Journal::in_memory(), &Watch::default())
        .unwrap();
    assert_eq!(resampled.failed, 0);
    for (row, estimate) in resampled.parameters.iter().zip(&fit.parameters) {
        // a deviation from 24 draws scatters by 15 %, the sandwich of 24 windows by as much, and
        // leverage sets the two apart by some more
        let ratio = row.scatter.unwrap().std_error / estimate.std_error.unwrap();
        assert!((0.5..2.0).contains(&ratio), "{row:?} {estimate:?}");
    }
}

#[test]
fn a_prior_is_drawn_again_with_the_data() {
    let ride = ride(24.0, false);
    let mut plan = plan(Objective::Amplitude, &["effective_damping"]);
    let prior = Prior {
        mean: 0.5,
        deviation: 0.05,
    };
    let free = Free::new("effective_damping").unwrap();
    plan.free = Some(vec![free.with_prior(Some(prior)).unwrap()]);
    let ridden = [plan.ridden(&ride)];
    let (problem, fit) = fitted(&ridden, &plan);
    let z = solved(&problem, &fit).z;
    let bootstrap = Bootstrap::new(&ridden, &plan, &problem, &z, 3).unwrap();
    let resampled = bootstrap
        .run(30, &Journal::in_memory(), &Watch::default())
        .unwrap();
    let (row, estimate) = (&resampled.parameters[0], &fit.parameters[0]);
    // the prior is sharper than the ride and decides; were its mean kept, the estimates would hardly
    // scatter. A deviation from 30 draws scatters by 13 %: three of those
    let ratio = row.scatter.unwrap().std_error / estimate.std_error.unwrap();
    assert!((0.6..1.4).contains(&ratio), "{row:?} {estimate:?}");
}

#[test]
fn a_prior_weighs_against_windows_by_its_variance() {
    let ride = ride(12.0, true);
    let mut plan = plan(Objective::Time, &["viscous_friction"]);
    let ridden = [plan.ridden(&ride)];
    let (_, alone) = fitted(&ridden, &plan);
    let alone = &alone.parameters[0];
    let deviation = alone.std_error.unwrap();
    let mean = alone.value + deviation;
    let free = Free::new("viscous_friction").unwrap();
    let known = Some(Prior { mean, deviation });
    plan.free = Some(vec![free.with_prior(known).unwrap()]);
    let (_, both) = fitted(&[plan.ridden(&ride)], &plan);
    let both = &both.parameters[0];
    // two of equal variance: half way, with 1/√2 of the error; the cost is no parabola
    let way = (both.value - alone.value) / deviation;
    assert!((way - 0.5).abs() < 0.1, "{way}");
    let error = both.std_error.unwrap() / deviation;
    assert!((error - 0.5_f64.sqrt()).abs() < 0.1, "{error}");
}
