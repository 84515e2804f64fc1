//! An FMU as the model of a fit: the bicycle's own, so that there is something to compare with.

use crate::wobble::{json, wobble};
use bicycle::Parameters;
use identify::effort::Effort;
use identify::fit::{Fit, fit};
use identify::foreign::Foreign;
use identify::free::Free;
use identify::model::{Model, Seeds};
use identify::objective::Objective;
use identify::plan::Plan;
use identify::problem::{Problem, Rides};
use identify::progress::Watch;
use identify::ride::Ride;
use identify::synthesis::Synthesis;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A rider on roll and roll rate alone, on the nominal bicycle.
fn rider() -> Parameters {
    Parameters::default().steered_by_roll(150.0, 60.0)
}

/// A folder with the bicycle's FMU, and what `described` says of it.
fn folder(described: &str) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let library = fmu::built_library().expect("cargo builds it as a dependency");
    fmu::pack(&library, &folder.path().join("Bike.fmu")).expect("packed");
    let text = format!("fmu = \"Bike.fmu\"\n{described}");
    fs::write(folder.path().join("bike.toml"), text).expect("written");
    folder
}

fn open(folder: &TempDir) -> Foreign {
    Foreign::open(&folder.path().join("bike.toml")).expect("an FMU")
}

fn ride(duration: f64, torque_recorded: bool) -> Ride {
    let synthesis = Synthesis {
        parameters: rider(),
        duration,
        torque_recorded,
        seed: 41,
        ..Synthesis::default()
    };
    synthesis.ride().expect("a ride that does not fall")
}

fn seeds(count: usize) -> Seeds {
    Seeds {
        count: Some(count),
        seed: 7,
    }
}

fn plan(parameters: &Parameters, model: Model) -> Plan {
    Plan {
        parameters: *parameters,
        objective: Some(Objective::Amplitude),
        model,
        ..Plan::default()
    }
}

fn fitted(ride: &Ride, plan: &Plan) -> Fit {
    let (_, fit) = fit(
        &[plan.ridden(ride)],
        plan,
        &Effort::default(),
        &Watch::default(),
    )
    .expect("a fit");
    fit
}

/// With exact jumps the native source rides by the stepper that is in the FMU: on the same grid of
/// 1 ms they differ by rounding, which a ride does not make grow.
#[test]
fn it_costs_what_the_same_equations_cost_natively() {
    let parameters = Parameters {
        steer_smoothing: 0.0,
        steer_rate_smoothing: 0.0,
        ..rider()
    };
    let folder = folder("step = \"1ms\"");
    let foreign = open(&folder);
    let ride = ride(8.0, false);
    let costs = [
        Model::Simulated(seeds(3)),
        Model::Foreign(foreign.clone(), seeds(3)),
    ]
    .map(|model| {
        let plan = plan(&parameters, model);
        let problem = Problem::new(&[plan.ridden(&ride)], &plan).expect("a problem");
        let start = problem.start();
        let points = [start.clone(), start.map(|z| 0.9 * z + 0.02)];
        points.map(|z| problem.cost(&z))
    });
    for (native, foreign) in costs[0].iter().zip(costs[1]) {
        assert!(
            (native - foreign).abs() < 1e-9 * native,
            "{native} and {foreign}"
        );
    }
    assert!((costs[0][0] - costs[0][1]).abs() > 1e-3 * costs[0][0]);
    assert_eq!(foreign.spent().instantiations, 1);
}

/// The FMU stands in for the bicycle that rode: damping and intensity come back within three
/// standard errors, by one instance.
#[test]
fn a_fit_by_it_recovers_what_made_the_ride() {
    let folder = folder("");
    let foreign = open(&folder);
    let model = Model::Foreign(foreign.clone(), seeds(8));
    let fit = fitted(&ride(16.0, false), &plan(&rider(), model));
    assert!(fit.converged, "{}", fit.termination);
    // √(2/π) .15/.21 + .3: the Coulomb friction at the steer rate of this ride is some .5 rad/s
    for (name, truth) in [("effective_damping", 0.53), ("remnant_intensity", 1.2)] {
        let estimate = fit.estimate(name).expect("free");
        let error = estimate.std_error.expect("a standard error");
        assert!(
            (estimate.value - truth).abs() < 3.0 * error,
            "{name}: {} ± {error} for {truth}",
            estimate.value
        );
    }
    let spent = foreign.spent();
    assert_eq!(spent.instantiations, 1);
    assert_eq!(spent.rides % 8, 0);
    let evaluations = fit.work.cost_evaluations + 5 * fit.work.curvature_evaluations;
    assert!(
        spent.rides >= 8 * evaluations,
        "{spent:?} for {:?}",
        fit.work
    );
}

/// A fall ends a ride and costs a candidate its cost; the instance goes on as if it had not been.
#[test]
fn a_fall_is_a_failed_simulation_and_no_end() {
    let folder = folder("");
    let foreign = open(&folder);
    let plan = plan(&rider(), Model::Foreign(foreign.clone(), seeds(2)));
    let ride = ride(6.0, false);
    let problem = Problem::new(&[plan.ridden(&ride)], &plan).expect("a problem");
    let z = problem.start();
    let before = problem.cost(&z);
    assert_eq!(foreign.spent().failures, 0);
    let wild = problem.at(&[0.5, 99.0]);
    let costs = problem.costs(&[wild, z.clone()]);
    assert!(costs[0].failed() && !costs[1].failed());
    let spent = foreign.spent();
    // at the bound of 20 N.m one of the two rides may last
    assert!((1..=2).contains(&spent.failures), "{spent:?}");
    assert_eq!(spent.instantiations, 1);
    assert_eq!(problem.cost(&z), before);
}

/// The rider law closed outside, held over a step of 1 ms, is a rider who is .5 ms late: that takes
/// damping from the loop and adds 5 % of power. A law of another sign or gain does not ride at all.
#[test]
fn our_rider_rides_an_fmu_without_one() {
    let ours = folder("step = \"1ms\"");
    let off = "rider_roll_gain = 0\nrider_roll_rate_gain = 0";
    let without = folder(&format!("step = \"1ms\"\nrider = true\n[set]\n{off}"));
    let ride = ride(8.0, false);
    let [inside, outside] = [ours, without].map(|folder| {
        let plan = plan(&rider(), Model::Foreign(open(&folder), seeds(2)));
        let problem = Problem::new(&[plan.ridden(&ride)], &plan).expect("a problem");
        let Rides::Amplitude(spectra) = &problem.rides else {
            panic!("amplitude")
        };
        let spectral = &spectra.members[0].landscape.spectral;
        let bins = spectral.expected(&problem.start()).expect("upright");
        bins.iter().map(|bin| bin[(0, 0)].re).collect::<Vec<_>>()
    });
    let (a, b) = (inside.iter().sum::<f64>(), outside.iter().sum::<f64>());
    assert!((a / b - 1.0).abs() < 0.1, "{a} and {b}");
    assert_ne!(inside, outside);
}

fn windows(model: Model) -> Plan {
    let free = ["cornering_stiffness", "viscous_friction"];
    Plan {
        objective: Some(Objective::Time),
        channels: Some(vec!["steer", "roll_rate", "yaw_rate"]),
        free: Some(free.map(|name| Free::new(name).expect("a row")).to_vec()),
        parameters: Parameters {
            cornering_stiffness: 12.0,
            viscous_friction: 0.4,
            ..rider()
        },
        model,
        ..Plan::default()
    }
}

/// The windows of `time` replayed by the FMU say what those of the equations say; both methods are
/// good to a hundredth of a standard error of so short a ride.
#[test]
fn windows_are_replayed_by_it() {
    let folder = folder("step = \"1ms\"");
    let foreign = open(&folder);
    let ride = ride(6.0, true);
    let native = fitted(&ride, &windows(Model::Equations));
    let foreign_fit = fitted(&ride, &windows(Model::Foreign(foreign.clone(), seeds(2))));
    assert!(foreign_fit.converged, "{}", foreign_fit.termination);
    for (a, b) in native.parameters.iter().zip(&foreign_fit.parameters) {
        let (error, other) = (a.std_error.expect("one"), b.std_error.expect("one"));
        assert!(
            (a.value - b.value).abs() < 0.1 * error,
            "{}: {} and {}, standard error {error}",
            a.name,
            a.value,
            b.value
        );
        assert!((other / error - 1.0).abs() < 0.05, "{}", a.name);
    }
    assert_eq!(foreign.spent().instantiations, 1);
}

#[test]
fn what_it_lacks_is_named() {
    let misspelt = |described: &str| {
        let folder = folder(described);
        Foreign::open(&folder.path().join("bike.toml"))
            .expect_err("refused")
            .to_string()
    };
    let message = misspelt("[outputs]\nsteer = \"stear\"");
    assert!(
        message.contains("bike.toml") && message.contains("`stear`"),
        "{message}"
    );
    let message = misspelt("[inputs]\nsteer_torque = \"trail\"");
    assert!(
        message.contains("trail") && message.contains("N.m"),
        "{message}"
    );
    let message = misspelt("[inputs]\nspeed = \"steer_torque\"");
    assert!(message.contains("m/s"), "{message}");
    let message = misspelt("speed = 3");
    assert!(message.contains("bike.toml"), "{message}");
}

fn fit_by(folder: &Path, model: &str) -> serde_json::Value {
    let call = format!(
        "fit ride.csv --objective amplitude --seeds 2 --max-iterations 3 --model {model} -o fit.json"
    );
    let called = wobble(folder, &call);
    assert_eq!(called.code, 0, "{}", called.err);
    let text = fs::read_to_string(folder.join("fit.json")).expect("written");
    serde_json::from_str(&text).expect("JSON")
}

/// What stood for the bicycle is on record, and a report is made of the same model only.
#[test]
fn the_program_records_which_model_it_was() {
    let folder = folder("");
    let path = folder.path();
    let call = "simulate --ride --set remnant_intensity=2 --duration 6s -o ride.csv";
    assert_eq!(wobble(path, call).code, 0);
    let simulated = fit_by(path, "simulated");
    assert_eq!(simulated["asked"]["model"]["kind"], "simulated");
    assert_eq!(simulated["asked"]["model"]["count"], 2);

    let by_fmu = fit_by(path, "bike.toml");
    let model = &by_fmu["asked"]["model"];
    assert_eq!(model["kind"], "fmu");
    assert_eq!(model["file"], "bike.toml");
    assert_eq!(model["fmu_sha256"].as_str().map(str::len), Some(64));
    let report = wobble(path, "report fit.json -o report.html");
    assert_eq!(report.code, 0, "{}", report.err);
    let _ = json(path, "report fit.json --json");

    fs::write(
        path.join("bike.toml"),
        "fmu = \"Bike.fmu\"\nrider = false\n",
    )
    .expect("written");
    let report = wobble(path, "report fit.json -o report.html");
    assert_eq!(report.code, 1);
    assert!(report.err.contains("SHA-256"), "{}", report.err);

    for (arguments, word) in [
        ("--model bike.toml --bicycle section3", "--set"),
        ("--model simulated --objective whittle", "amplitude"),
        ("--model equatoins", "equations"),
        ("--seeds 4", "simulated"),
    ] {
        let called = wobble(path, &format!("fit ride.csv {arguments}"));
        assert_ne!(called.code, 0, "{arguments}");
        assert!(called.err.contains(word), "{arguments}: {}", called.err);
    }
}
