#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]

use super::native::alone;
use super::*;
use crate::closed_loop::ClosedLoop;
use crate::effort::Effort;
use crate::fit::{Fit, fit};
use crate::model::{Model, Seeds};
use crate::objective::Objective;
use crate::plan::Plan;
use crate::progress::Watch;
use crate::ride::Ride;
use crate::spectrum::{Recipe, Taper};
use crate::synthesis::Synthesis;

/// A rider on roll and roll rate alone, on the nominal bicycle.
fn rider() -> Parameters {
    Parameters::default().steered_by_roll(150.0, 60.0)
}

fn ride(duration: f64) -> Ride {
    let synthesis = Synthesis {
        parameters: rider(),
        duration,
        seed: 41,
        ..Synthesis::default()
    };
    synthesis.ride().unwrap()
}

fn drive(intensity: f64) -> Drive {
    Drive {
        speed: 8.0 / 3.6,
        remnant_intensity: intensity,
        remnant_corner: 2.0,
        lines: Vec::new(),
    }
}

/// Rides as long as `duration` [s], and what was measured.
fn simulated(
    formulation: Formulation,
    channels: &[&'static str],
    duration: f64,
    seeds: usize,
) -> (Simulated, Measured) {
    let recipe = Recipe {
        taper: Taper::of(channels.len()),
        ..Recipe::default()
    };
    let noise = vec![1e-3; channels.len()];
    let measured =
        Measured::new(&ride(duration), channels, &recipe, 8.0 / 3.6, Some(&noise)).unwrap();
    let excitation = Excitation::default();
    let simulated = Simulated::new(
        Engine::Native(formulation),
        &measured,
        &excitation,
        (seeds, 7),
    )
    .unwrap();
    (simulated, measured)
}

/// On average over the bands the linearisation is good for 4 % of amplitude between 1° and 7.6° rms.
/// The mean power of 384 rides over the 12 bins of the narrowest band scatters by 1/√(384 · 12) =
/// 1.5 %, its amplitude by .7 %.
#[test]
fn simulated_spectra_are_the_linearised_ones() {
    let (rides, measured) = simulated(Formulation::Repaired, &["steer"], 24.0, 384);
    let frequencies = measured.analysis.frequencies();
    let mut found = Vec::new();
    for intensity in [0.36, 0.5, 0.8, 1.2, 1.6, 2.2] {
        let setting = (rider(), drive(intensity));
        let closed_loop = ClosedLoop::new(&setting.0, Formulation::Repaired, &setting.1).unwrap();
        let kernel = measured.analysis.kernel();
        let expected = closed_loop.expected(&kernel, &[3], &measured.noise, measured.step);
        let mean = rides.spectra(&[setting]).pop().unwrap().unwrap();
        let ratios = [(0.3, 0.8), (0.8, 2.0), (2.0, 3.0)].map(|(low, high)| {
            let amplitude = |bins: &[Bin]| -> f64 {
                let inside = frequencies.iter().zip(bins);
                let inside = inside.filter(|(f, _)| (low..high).contains(*f));
                inside.map(|(_, bin)| bin[(0, 0)].re.sqrt()).sum()
            };
            amplitude(&mean) / amplitude(&expected)
        });
        found.push((closed_loop.steer_deviation().to_degrees(), ratios));
    }
    for (steering, ratios) in &found {
        let average = ratios.iter().sum::<f64>() / 3.0;
        assert!((average - 1.0).abs() < 0.04, "{steering}°: {found:?}");
    }
    assert!(
        found[0].0 < 1.3 && found[5].0 > 7.0,
        "hardly the range: {found:?}"
    );
}

/// Both methods are within 1.4e-4 rad of the exact ride: of a steering of some 3e-2 rad half a
/// per cent at worst, and of its largest bin less.
#[test]
fn lanes_ride_as_the_reference_does() {
    let channels = ["steer", "roll_rate", "yaw_rate"];
    for formulation in [Formulation::Repaired, Formulation::Whipple] {
        let (rides, _) = simulated(formulation, &channels, 10.0, 2);
        let mut parameters = rider();
        if formulation == Formulation::Whipple {
            // the slip-free bicycle stands at a higher speed
            parameters.coulomb_friction = 0.0;
        }
        let mut drive = drive(0.8);
        drive.speed = 4.0;
        let setting = (parameters, drive);
        let jobs = [0, 1].map(|seed| Job {
            setting: &setting,
            seed,
        });
        let together = native::ride(&rides, formulation, &jobs);
        for (job, together) in jobs.iter().zip(together) {
            let together = together.unwrap();
            let torque = rides.record.torque(job);
            let alone = alone(&rides.record, formulation, job, &torque).unwrap();
            for (channel, (a, b)) in channels.iter().zip(together.iter().zip(&alone)) {
                let size = b.iter().map(|y| y.norm()).fold(0.0, f64::max);
                let apart = a
                    .iter()
                    .zip(b)
                    .map(|(a, b)| (a - b).norm())
                    .fold(0.0, f64::max);
                assert!(size > 0.0, "{channel} does not move");
                assert!(
                    apart < 0.01 * size,
                    "{formulation:?} {channel}: {apart} of {size}"
                );
            }
        }
    }
}

#[test]
fn a_candidate_rides_the_same_whoever_rides_beside_it() {
    let (rides, _) = simulated(Formulation::Repaired, &["steer"], 6.0, 5);
    let mut settings = [0.5, 1.0, 60.0, 1.5, 0.8].map(|intensity| (rider(), drive(intensity)));
    // nobody rides at a standstill
    settings[1].1.speed = 0.0;
    let together = rides.spectra(&settings);
    for (setting, together) in settings.iter().zip(together) {
        let alone = rides.spectra(std::slice::from_ref(setting)).pop().unwrap();
        assert_eq!(alone.is_ok(), together.is_ok());
        if let (Ok(alone), Ok(together)) = (alone, together) {
            assert_eq!(alone, together);
        }
    }
}

/// Torque of intensity 2 is twice that of 1 to the last bit, another corner makes other noise of
/// the same seed, and no seed is another's.
#[test]
fn every_candidate_rides_under_the_same_noise() {
    let (rides, _) = simulated(Formulation::Repaired, &["steer"], 6.0, 3);
    let torque = |setting: &Setting, seed| rides.record.torque(&Job { setting, seed });
    let one = (rider(), drive(1.0));
    let two = (rider(), drive(2.0));
    let doubled: Vec<f64> = torque(&one, 1).iter().map(|t| 2.0 * t).collect();
    assert_eq!(torque(&two, 1), doubled);
    assert_ne!(torque(&one, 0), torque(&one, 1));
    let mut slower = one.clone();
    slower.1.remnant_corner = 1.5;
    let (a, b) = (torque(&one, 2), torque(&slower, 2));
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let correlation = dot(&a, &b) / (dot(&a, &a) * dot(&b, &b)).sqrt();
    // two first-order filters of one noise: 2 √(ω₁ ω₂)/(ω₁ + ω₂) = .990
    assert!(a != b && correlation > 0.98, "{correlation}");
}

#[test]
fn falls_are_counted_and_the_earlier_the_worse() {
    let (rides, _) = simulated(Formulation::Repaired, &["steer"], 10.0, 16);
    let cut = |intensity| match rides.spectra(&[(rider(), drive(intensity))]).pop() {
        Some(Err(Error::Fell {
            fallen, of, cut, ..
        })) => {
            assert!(of == 16 && fallen > 0 && fallen <= of);
            cut
        }
        other => panic!("{other:?}"),
    };
    let cuts = [20.0, 40.0, 80.0].map(cut);
    assert!(cuts.is_sorted_by(|a, b| a < b), "{cuts:?}");
    assert!(cuts[0] > 0.0 && cuts[2] < 1.0, "{cuts:?}");
}

/// Under common noise a slope is that of any difference: over 1e-3 and 2e-4 of a variable the same
/// to the curvature of the wider one.
#[test]
fn slopes_are_smooth_in_the_parameters() {
    let (rides, _) = simulated(Formulation::Repaired, &["steer"], 10.0, 4);
    let setting = |z: &DVector<f64>| {
        let parameters = Parameters {
            viscous_friction: 0.3 * z[0],
            ..rider()
        };
        (parameters, drive(1.2 * z[1].exp()))
    };
    let z = DVector::from_row_slice(&[1.0, 0.0]);
    let expansion = rides.expansion(&z, setting).unwrap();
    for i in 0..2 {
        let moved = [2e-4, -2e-4].map(|h| {
            let mut moved = z.clone();
            moved[i] += h;
            rides.spectra(&[setting(&moved)]).pop().unwrap().unwrap()
        });
        let wide: Vec<f64> = expansion.slopes[i]
            .iter()
            .map(|bin| bin[(0, 0)].re)
            .collect();
        let size = wide.iter().fold(0.0, |m: f64, s| m.max(s.abs()));
        for (k, wide) in wide.iter().enumerate() {
            let narrow = (moved[0][k][(0, 0)].re - moved[1][k][(0, 0)].re) / 4e-4;
            assert!(
                (wide - narrow).abs() < 1e-3 * size,
                "{i}, {k}: {wide} and {narrow}"
            );
        }
    }
}

fn fitted(ride: &Ride, model: Model) -> Fit {
    let plan = Plan {
        parameters: rider(),
        objective: Some(Objective::Amplitude),
        model,
        ..Plan::default()
    };
    fit(
        &[plan.ridden(ride)],
        &plan,
        &Effort::default(),
        &Watch::default(),
    )
    .unwrap()
    .1
}

/// The mean of K rides scatters by 1/√K of a standard error of one ride: with 64 of them by an
/// eighth, and the linearisation adds a few hundredths of the value.
#[test]
fn a_fit_by_simulated_rides_is_that_by_the_linearised_loop() {
    let ride = ride(24.0);
    let seeds = Seeds {
        count: Some(64),
        seed: 3,
    };
    let linearised = fitted(&ride, Model::Equations);
    let simulated = fitted(&ride, Model::Simulated(seeds));
    assert!(simulated.converged, "{}", simulated.termination);
    for (a, b) in linearised.parameters.iter().zip(&simulated.parameters) {
        let (error, other) = (a.std_error.unwrap(), b.std_error.unwrap());
        assert!(
            (a.value - b.value).abs() < 0.6 * error,
            "{}: {} and {}, standard error {error}",
            a.name,
            a.value,
            b.value
        );
        assert!(
            (other / error - 1.0).abs() < 0.3,
            "{}: {error} and {other}",
            a.name
        );
    }
    assert!(
        simulated
            .notes
            .iter()
            .any(|note| note.contains("64 simulated rides"))
    );
}

#[test]
fn a_single_seed_and_other_objectives_are_refused() {
    let ride = ride(10.0);
    let refused = |objective, count| {
        let plan = Plan {
            parameters: rider(),
            objective: Some(objective),
            model: Model::Simulated(Seeds { count, seed: 1 }),
            ..Plan::default()
        };
        let error = crate::problem::Problem::new(&[plan.ridden(&ride)], &plan).err();
        error.unwrap().to_string()
    };
    assert_eq!(
        refused(Objective::Amplitude, Some(1)),
        "expected simulated rides of at least 2 seeds, found `1`"
    );
    let whittle = refused(Objective::Whittle, None);
    assert!(
        whittle.contains("amplitude") && whittle.contains("whittle"),
        "{whittle}"
    );
}

/// Each of K seeds is shared by all rides: their scatter adds rides/K to the covariance.
#[test]
fn seeds_scatter_in_the_covariance() {
    let seeds = |count| Seeds { count, seed: 1 };
    assert_eq!(seeds(None).of(6).unwrap(), 96);
    assert_eq!(seeds(None).covariance_factor(6).unwrap(), 1.0 + 1.0 / 16.0);
    assert_eq!(seeds(Some(12)).covariance_factor(6).unwrap(), 1.5);
}
