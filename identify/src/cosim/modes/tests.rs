use super::*;
use crate::bicycles::Changes;
use crate::cosim::{Setup, Typed};
use ::bicycle::State;
use tempfile::TempDir;

/// The bicycle's FMU alone.
fn alone(changes: Changes) -> (TempDir, Coupling) {
    let folder = tempfile::tempdir().expect("temporary folder");
    let file = folder.path().join("RearLoadBicycle.fmu");
    let library = ::fmu::built_library().expect("cargo builds it as a dependency");
    ::fmu::pack(&library, &file).expect("packed");
    let setup = Setup {
        fmus: vec![Typed {
            name: PLANT.to_owned(),
            file,
            set: Vec::new(),
            step: None,
        }],
        changes,
        ..Setup::default()
    };
    let coupling = Coupling::open(&setup, &mut |_| {}).expect("loaded");
    (folder, coupling)
}

/// The values that a sample of 5 ms can tell, slow ones first.
fn slow(mut values: Vec<Complex<f64>>) -> Vec<Complex<f64>> {
    values.retain(|value| value.re > -150.0 && value.im >= 0.0);
    values.sort_by(|a, b| b.re.total_cmp(&a.re));
    values
}

#[test]
fn derivatives_and_pulses_find_the_same_eigenvalues_and_those_of_the_native_model() {
    for (formulation, states) in [("repaired", 5), ("whipple", 4), ("whipple_slip", 8)] {
        let (_folder, coupling) = alone(Changes {
            formulation: Some(formulation.to_owned()),
            load: Some("20kg".to_owned()),
            set: ["coulomb_friction=0", "steer_smoothing=.1"]
                .map(str::to_owned)
                .into(),
            ..Changes::default()
        });
        let variation = coupling.as_typed();
        let bicycle = coupling.bicycle.as_ref().expect("ours");
        let speed = bicycle.input.speed;
        let model = bicycle::Bicycle::new(&bicycle.parameters, bicycle.formulation);
        let (native, _) = linear::state_equations(&model, &State::default(), &bicycle.input);
        let native = slow(linear::eigenvalues(&native));
        let by_derivatives = coupling.by_derivatives(&variation).expect("ran");
        let by_derivatives = by_derivatives.expect("declared");
        assert_eq!(by_derivatives.len(), states, "{formulation}");
        let by_derivatives = slow(by_derivatives);
        let (by_pulses, _) = coupling
            .by_pulses(&variation, speed, &mut |_| {})
            .expect("ran")
            .expect("linear");
        let by_pulses = slow(by_pulses);
        for (n, value) in native.iter().enumerate() {
            let derived = (by_derivatives[n] - value).norm() / value.norm();
            assert!(
                derived < 1e-7,
                "{formulation}: {by_derivatives:?} {native:?}"
            );
            // found from differences of answers with some ten digits
            let pulsed = (by_pulses[n] - value).norm() / value.norm();
            assert!(pulsed < 1e-3, "{formulation}: {by_pulses:?} {native:?}");
        }
    }
}

#[test]
fn a_bicycle_that_nobody_rides_has_a_growing_mode() {
    let gains = [
        "rider_roll_gain",
        "rider_roll_rate_gain",
        "rider_steer_gain",
        "rider_steer_rate_gain",
    ];
    let (_folder, coupling) = alone(Changes {
        set: gains
            .map(|gain| format!("{gain}=0"))
            .into_iter()
            .chain(["coulomb_friction=0", "steer_smoothing=.1"].map(str::to_owned))
            .collect(),
        ..Changes::default()
    });
    let variation = coupling.as_typed();
    let (values, method) = coupling
        .modes(&variation, &mut |_| {})
        .expect("ran")
        .expect("known");
    assert_eq!(method, "directional derivatives");
    let growth = |values: &[Complex<f64>]| values.iter().map(|v| v.re).fold(0.0, f64::max);
    assert!(growth(&values) > 1.0, "{values:?}");
    let smooth = Variation {
        smooth: true,
        ..variation
    };
    let speed = coupling.bicycle.as_ref().expect("ours").input.speed;
    let (by_pulses, _) = coupling
        .by_pulses(&smooth, speed, &mut |_| {})
        .expect("ran")
        .expect("linear");
    let (found, expected) = (growth(&by_pulses), growth(&values));
    assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
}
