//! The model spectrum against simulated rides.

use bicycle::{Excitation, Formulation, Parameters};
use identify::closed_loop::{ClosedLoop, Drive};
use identify::spectrum::{Analysis, Recipe};
use identify::synthesis::{SensorNoise, Synthesis};
use std::f64::consts::PI;

const RIDES: u64 = 64;

/// Mean amplitude over 64 rides within 5 % of the expected one in each band: the mean over rides
/// and twelve bins scatters by .5227/√(64 · 12) = 1.9 %, the linearisation is good for 4 % in power.
fn assert_model_spectrum(parameters: &Parameters, intensity: f64) {
    let analysis = Analysis::new(&Recipe::default(), 0.005, 4800).expect("a recipe");
    let drive = Drive {
        speed: 8.0 / 3.6,
        remnant_intensity: intensity,
        remnant_corner: 2.0,
        lines: Vec::new(),
    };
    let closed_loop = ClosedLoop::new(parameters, Formulation::Repaired, &drive).expect("stable");
    let noise = SensorNoise::INSTRUMENTED.steer;
    let expected = closed_loop.expected(&analysis.kernel(), &[3], &[noise], 0.005);
    let mut mean = vec![0.0; expected.len()];
    for seed in 0..RIDES {
        let ride = Synthesis {
            parameters: *parameters,
            excitation: Excitation {
                remnant_intensity: intensity,
                ..Excitation::default()
            },
            seed: 100 + seed,
            ..Synthesis::default()
        };
        let ride = ride.ride().expect("a ride that does not fall");
        let coefficients = analysis.coefficients(ride.channel("steer").expect("recorded"));
        for (sum, y) in mean.iter_mut().zip(coefficients) {
            *sum += y.norm() / RIDES as f64;
        }
    }
    for (low, high) in [(0.3, 0.8), (0.8, 2.0), (2.0, 3.0)] {
        let bins: Vec<usize> = analysis
            .frequencies()
            .iter()
            .enumerate()
            .filter(|(_, f)| (low..high).contains(*f))
            .map(|(k, _)| k)
            .collect();
        let simulated: f64 = bins.iter().map(|&k| mean[k]).sum();
        let modelled: f64 = bins
            .iter()
            .map(|&k| (0.25 * PI * expected[k][(0, 0)].re).sqrt())
            .sum();
        let ratio = simulated / modelled;
        assert!((ratio - 1.0).abs() < 0.05, "{low} to {high} Hz: {ratio}");
    }
}

#[test]
fn the_model_spectrum_is_the_mean_of_simulated_rides() {
    assert_model_spectrum(&Parameters::default(), 2.0);
}

#[test]
fn the_model_spectrum_holds_at_four_degrees_of_steering() {
    let rider = Parameters::default().steered_by_roll(150.0, 60.0);
    assert_model_spectrum(&rider, 1.2);
}
