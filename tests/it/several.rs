//! Several rides in one fit: what they share is known better, what each has of its own stays so.

use bicycle::{Excitation, Formulation, Parameters};
use identify::effort::Effort;
use identify::error::Error;
use identify::fit::{Fit, fit};
use identify::free::{Free, Scope, Tie};
use identify::objective::Objective;
use identify::plan::{Change, Plan, Ridden};
use identify::progress::Watch;
use identify::ride::Ride;
use identify::synthesis::Synthesis;

fn rider() -> Parameters {
    Parameters::default().steered_by_roll(150.0, 60.0)
}

fn ride(seed: u64, parameters: &Parameters) -> Ride {
    let synthesis = Synthesis {
        parameters: Parameters {
            internal_step: 0.5e-3,
            ..*parameters
        },
        excitation: Excitation {
            remnant_intensity: 1.2,
            ..Excitation::default()
        },
        seed,
        ..Synthesis::default()
    };
    synthesis.ride().expect("a ride that does not fall")
}

fn plan() -> Plan {
    Plan {
        parameters: rider(),
        objective: Some(Objective::Whittle),
        ..Plan::default()
    }
}

fn fitted(rides: &[Ridden], plan: &Plan) -> Fit {
    let (_, fit) = fit(rides, plan, &Effort::default(), &Watch::default()).expect("a fit");
    assert!(fit.converged, "{}", fit.termination);
    fit
}

fn error_of(fit: &Fit, name: &str) -> f64 {
    let estimate = fit.estimate(name).expect("sought");
    estimate.std_error.expect("seen by the data")
}

#[test]
fn four_rides_know_what_they_share_twice_as_well_as_one() {
    let rides: Vec<Ride> = (0..4).map(|k| ride(700 + k, &rider())).collect();
    let plan = plan();
    let ridden: Vec<_> = rides.iter().map(|ride| plan.ridden(ride)).collect();
    let (one, four) = (fitted(&ridden[..1], &plan), fitted(&ridden, &plan));
    for name in ["cornering_stiffness", "camber_stiffness"] {
        // √4, but for the scatter of the rides' own estimates
        let ratio = error_of(&one, name) / error_of(&four, name);
        assert!((1.7..2.3).contains(&ratio), "{name}: {ratio}");
        let estimate = four.estimate(name).expect("sought");
        let truth = rider().get(Parameters::index(name).expect("a row"));
        let off = (estimate.value - truth).abs() / error_of(&four, name);
        assert!(off < 3.5, "{name}: {off} standard errors off");
    }
    // each ride has an intensity of its own
    let intensities = four
        .parameters
        .iter()
        .filter(|p| p.name == "remnant_intensity");
    let of: Vec<_> = intensities
        .map(|p| p.of.clone().expect("a ride's"))
        .collect();
    assert_eq!(of.len(), 4);
    assert_eq!(four.explained.len(), 4);
    assert!((four.misfit - 1.0).abs() < 0.2, "{}", four.misfit);
}

#[test]
fn a_loaded_and_an_unloaded_ride_share_their_tyres_on_bicycles_of_their_own() {
    // a rider who stands with a load as well
    let loads = [("empty", 0.0), ("loaded", 20.0)];
    let bicycles = loads.map(|(_, rear_load)| Parameters {
        rear_load,
        ..Parameters::default()
    });
    let rides = [ride(710, &bicycles[0]), ride(711, &bicycles[1])];
    let plan = Plan {
        parameters: Parameters::default(),
        changes: vec![("effective_damping", Change::Scope(Scope::Condition))],
        ..plan()
    };
    let ridden = (0..2).map(|i| Ridden {
        parameters: bicycles[i],
        condition: loads[i].0.into(),
        ..plan.ridden(&rides[i])
    });
    let fit = fitted(&ridden.collect::<Vec<_>>(), &plan);
    let labels: Vec<_> = fit
        .parameters
        .iter()
        .map(identify::verdict::Estimate::label)
        .collect();
    assert_eq!(
        labels,
        [
            "cornering_stiffness",
            "camber_stiffness",
            "effective_damping of empty",
            "effective_damping of loaded",
            "remnant_intensity of ride #1",
            "remnant_intensity of ride #2"
        ]
    );
    // as if the load were forgotten: the second ride is no longer explained as well
    let unloaded: Vec<_> = rides.iter().map(|ride| plan.ridden(ride)).collect();
    let plain = Plan {
        changes: Vec::new(),
        ..plan.clone()
    };
    assert!(fitted(&unloaded, &plain).cost > fit.cost + 4.0);
}

#[test]
fn a_prior_narrows_what_the_ride_leaves_open() {
    let ride = ride(720, &rider());
    let plain = plan();
    let with = Plan {
        changes: vec![("effective_damping", Change::Prior(None))],
        ..plan()
    };
    let (before, after) = (
        fitted(&[plain.ridden(&ride)], &plain),
        fitted(&[with.ridden(&ride)], &with),
    );
    // 1/s² = 1/s₀² + 1/p², p = .8/√12 the deviation over the measured interval of .2 to 1
    let (s0, s, p) = (
        error_of(&before, "effective_damping"),
        error_of(&after, "effective_damping"),
        0.8 / 12f64.sqrt(),
    );
    let expected = 1.0 / (1.0 / (s0 * s0) + 1.0 / (p * p)).sqrt();
    // the ride's own information is taken at another point
    assert!((s / expected - 1.0).abs() < 0.15, "{s} against {expected}");
}

#[test]
fn a_tied_row_follows_and_bad_ties_are_refused() {
    // tyres softer than the plan's, front and rear alike
    let truth = Parameters {
        cornering_stiffness: 10.0,
        rear_cornering_stiffness: 10.0,
        ..Parameters::default()
    };
    let formulation = Formulation::WhippleSlip;
    let synthesis = Synthesis {
        parameters: truth,
        formulation,
        torque_recorded: true,
        excitation: Excitation {
            remnant_intensity: 2.0,
            ..Excitation::default()
        },
        seed: 730,
        ..Synthesis::default()
    };
    let ride = synthesis.ride().expect("a ride that does not fall");
    let tied = |ties: &[(&str, &str)]| Plan {
        formulation,
        ties: ties
            .iter()
            .map(|(follower, leader)| Tie::new(follower, leader).expect("rows"))
            .collect(),
        ..Plan::default()
    };
    let both = tied(&[("rear_cornering_stiffness", "cornering_stiffness")]);
    let both = fitted(&[both.ridden(&ride)], &both);
    let estimate = both.estimate("cornering_stiffness").expect("sought");
    let off = (estimate.value - 10.0).abs() / error_of(&both, "cornering_stiffness");
    assert!(off < 4.0, "{off} standard errors off");
    let told = |fit: &Fit| {
        fit.notes
            .iter()
            .any(|note| note.contains("only the front tyre"))
    };
    assert!(!told(&both));
    // a rear tyre that stays stiff is another bicycle
    let alone = tied(&[]);
    let alone = fitted(&[alone.ridden(&ride)], &alone);
    let value = |fit: &Fit| fit.estimate("cornering_stiffness").expect("sought").value;
    assert!(told(&alone) && (value(&alone) - value(&both)).abs() > 1e-3);

    for (follower, leader) in [
        ("rear_cornering_stiffness", "trail"),
        ("camber_stiffness", "cornering_stiffness"),
    ] {
        let plan = tied(&[(follower, leader)]);
        let rides = [plan.ridden(&ride)];
        let refused = fit(&rides, &plan, &Effort::default(), &Watch::default()).map(drop);
        assert!(matches!(refused, Err(Error::Tie { .. })), "{refused:?}");
    }
}

#[test]
fn no_ride_and_the_same_ride_twice_are_refused() {
    let ride = ride(740, &rider());
    let plan = plan();
    let none = fit(&[], &plan, &Effort::default(), &Watch::default()).map(drop);
    assert!(matches!(none, Err(Error::NoRides)), "{none:?}");
    let twice = fit(
        &[plan.ridden(&ride), plan.ridden(&ride)],
        &plan,
        &Effort::default(),
        &Watch::default(),
    )
    .map(drop);
    assert!(matches!(twice, Err(Error::SameRide { .. })), "{twice:?}");
    let prior = Free::new("trail").expect("a row").with_prior(None);
    assert!(matches!(prior, Err(Error::NoPrior { .. })), "{prior:?}");
}
