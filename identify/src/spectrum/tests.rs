#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
use super::*;
use nalgebra::DMatrix;

const STEP: f64 = 0.005;
const SAMPLES: usize = 4800;

fn analysis(taper: Taper) -> Analysis {
    Analysis::new(
        &Recipe {
            taper,
            ..Recipe::default()
        },
        STEP,
        SAMPLES,
    )
    .unwrap()
}

fn sine(frequency: f64, amplitude: f64) -> Vec<f64> {
    (0..SAMPLES)
        .map(|i| amplitude * (TAU * frequency * STEP * i as f64 + 0.4).sin())
        .collect()
}

#[test]
fn an_even_window_takes_one_more_before_than_after_and_shrinks_at_the_ends() {
    let y = [1.0, 2.0, 4.0, 8.0, 16.0];
    // MATLAB: movmean([1 2 4 8 16], 4), movmean(…, 3)
    assert_eq!(
        moving_average(&y, 4),
        [1.5, 7.0 / 3.0, 3.75, 7.5, 28.0 / 3.0]
    );
    assert_eq!(
        moving_average(&y, 3),
        [1.5, 7.0 / 3.0, 14.0 / 3.0, 28.0 / 3.0, 12.0]
    );
}

#[test]
fn a_sine_on_a_bin_has_its_amplitude_there_times_the_moving_averages_gain() {
    // gain of the residual 1 − sin(5πf)/(5πf): 1.21, .87, 1.09 at .3, .5, .7 Hz
    for (f, gain) in [(0.3, 1.2122), (0.5, 0.8727), (0.7, 1.0909)] {
        let exact = 1.0 - (5.0 * PI * f).sin() / (5.0 * PI * f);
        assert!((exact - gain).abs() < 1e-4, "known gain at {f} Hz: {exact}");
        // ten minutes, so that the shrinking windows at the ends weigh under 1 %
        let n = 120_000;
        let recipe = Recipe {
            taper: Taper::Hann,
            ..Recipe::default()
        };
        let long = Analysis::new(&recipe, STEP, n).unwrap();
        let y: Vec<f64> = (0..n)
            .map(|i| 2.0 * (TAU * f * STEP * i as f64).sin())
            .collect();
        let bin = long
            .frequencies()
            .iter()
            .position(|b| (b - f).abs() < 1e-9)
            .unwrap();
        let amplitude = long.coefficients(&y)[bin].norm() * long.to_amplitude();
        assert!(
            (amplitude / 2.0 / gain - 1.0).abs() < 2e-3,
            "{f} Hz: {amplitude}"
        );
    }
    // and with both tapers on a 24 s record; the shrinking windows at its ends weigh .2 %
    for taper in [Taper::Rectangle, Taper::Hann] {
        let a = analysis(taper);
        let bin = a
            .frequencies()
            .iter()
            .position(|f| (f - 2.5).abs() < 1e-9)
            .unwrap();
        let amplitude = a.coefficients(&sine(2.5, 0.1))[bin].norm() * a.to_amplitude();
        let gain = 1.0 - (12.5 * PI).sin() / (12.5 * PI);
        assert!(
            (amplitude / 0.1 / gain - 1.0).abs() < 5e-3,
            "{taper:?}: {amplitude}"
        );
    }
}

#[test]
fn parseval() {
    let y: Vec<f64> = (0..SAMPLES)
        .map(|i| ((i * i) as f64 * 0.37).sin())
        .collect();
    let a = analysis(Taper::Rectangle);
    let power: f64 = a
        .transform(&y, &a.taper)
        .iter()
        .map(Complex::norm_sqr)
        .sum();
    let energy: f64 = residual(&y, 1000).iter().map(|z| z * z).sum();
    // Σ_k |Y_k|² = step · Σ_i z_i², to round-off
    assert!((power / (energy * STEP) - 1.0).abs() < 1e-12);
}

#[test]
fn the_kernel_carries_white_noise_and_a_sine_as_the_transform_does() {
    for taper in [Taper::Rectangle, Taper::Hann] {
        let a = analysis(taper);
        let kernel = a.kernel();
        // a sine of amplitude 1 between bins has the two-sided density ¼ at ± f
        let j = kernel.frequencies.len() / 3;
        let mut density = vec![0.0; kernel.frequencies.len()];
        density[j] = 0.25 / kernel.frequencies[1];
        let expected = kernel.expect_real(&DMatrix::from_vec(density.len(), 1, density));
        // mean over phases: that of a sine and a cosine
        let (s, c) = (
            sine(kernel.frequencies[j], 1.0),
            (0..SAMPLES)
                .map(|i| (TAU * kernel.frequencies[j] * STEP * i as f64 + 0.4).cos())
                .collect::<Vec<_>>(),
        );
        let (s, c) = (a.coefficients(&s), a.coefficients(&c));
        for (k, e) in expected.iter().enumerate() {
            let mean = 0.5 * (s[k].norm_sqr() + c[k].norm_sqr());
            assert!((mean - e).abs() < 1e-12 * expected.iter().fold(0.0, |a: f64, b| a.max(*b)));
        }
        // white noise of density 1, variance 1/step: the sum over its samples, one by one;
        // what leaks in from beyond the kernel's grid is below 1 %
        let mut exact = vec![0.0; kernel.white.len()];
        let mut impulse = vec![0.0; SAMPLES];
        for i in 0..SAMPLES {
            impulse[i] = 1.0;
            for (sum, y) in exact.iter_mut().zip(a.coefficients(&impulse)) {
                *sum += y.norm_sqr() / STEP;
            }
            impulse[i] = 0.0;
        }
        for (w, e) in kernel.white.iter().zip(&exact) {
            assert!((w / e - 1.0).abs() < 0.01, "{taper:?}: {w} {e}");
        }
    }
}

/// |W_k(f)|² and |W_k(−f)|² by the transform itself, of a cosine and a sine.
fn transformed(analysis: &Analysis, f: f64) -> Vec<(f64, f64)> {
    let (sine, cosine): (Vec<f64>, Vec<f64>) = (0..analysis.samples)
        .map(|i| (TAU * f * analysis.step * i as f64).sin_cos())
        .unzip();
    let (sine, cosine) = (analysis.coefficients(&sine), analysis.coefficients(&cosine));
    let pair = |(c, s): (&Complex<f64>, &Complex<f64>)| {
        let turn = Complex::<f64>::i() * s;
        ((c + turn).norm_sqr(), (c - turn).norm_sqr())
    };
    cosine.iter().zip(&sine).map(pair).collect()
}

#[test]
fn the_kernel_in_closed_form_is_the_transform_of_waves() {
    for (average, step, samples) in [
        (5.0, 0.005, 4800),
        (0.97, 0.01, 611), // an odd window, an odd record
        (2.0, 0.02, 404),
        (2.0, 0.02, 100), // the window is the record
        (1.98, 0.02, 99),
        (0.04, 0.02, 101), // two samples
    ] {
        for taper in [Taper::Rectangle, Taper::Hann] {
            let recipe = Recipe {
                average,
                taper,
                ..Recipe::default()
            };
            let a = Analysis::new(&recipe, step, samples).unwrap();
            let kernel = a.kernel();
            let count = kernel.frequencies.len();
            let spacing = kernel.frequencies[1];
            // every point of a short record, some of a long one
            let points: Vec<usize> = (0..count).step_by(count.div_ceil(60)).collect();
            let unit = |row: usize, column: usize| if row == points[column] { 1.0 } else { 0.0 };
            let picked = DMatrix::from_fn(count, points.len(), unit);
            let (even, odd) = (
                kernel.expect_real(&picked),
                kernel.expect_imaginary(&picked),
            );
            let largest = even.amax();
            for (column, &j) in points.iter().enumerate() {
                let waves = transformed(&a, kernel.frequencies[j]);
                for (k, (plus, minus)) in waves.into_iter().enumerate() {
                    let minus = if j == 0 { 0.0 } else { minus };
                    for (found, exact) in [
                        (even[(k, column)], (plus + minus) * spacing),
                        (odd[(k, column)], (plus - minus) * spacing),
                    ] {
                        assert!(
                            (found - exact).abs() < 1e-12 * largest,
                            "{average} s of {samples} {taper:?}: bin {k}, point {j}: {found} {exact}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn lines_are_masked_three_bins_to_each_side() {
    let recipe = Recipe {
        lines: vec![Line { frequency: 1.11 }],
        ..Recipe::default()
    };
    let f = Analysis::new(&recipe, STEP, SAMPLES).unwrap().frequencies();
    assert!(f.iter().all(|f| (f - 1.11).abs() > 3.0 / 24.0));
    assert_eq!(f.len(), analysis(Taper::Rectangle).frequencies().len() - 6);
    assert!(
        (analysis(Taper::Rectangle).line_amplitude(&sine(1.11, 0.2), 1.11) / 0.2 - 1.0).abs()
            < 0.02
    );
}

#[test]
fn what_cannot_be_analysed_is_said() {
    let message = |recipe: Recipe, n| Analysis::new(&recipe, STEP, n).err().unwrap().to_string();
    assert_eq!(
        message(
            Recipe {
                band: (3.0, 0.3),
                ..Recipe::default()
            },
            SAMPLES
        ),
        "band: expected 0 <= low < high <= 100 Hz (Nyquist), found 3 to 0.3 Hz"
    );
    assert_eq!(
        message(Recipe::default(), 600),
        "moving average: expected 0.01 s to 3 s (the record), found 5 s"
    );
    assert_eq!(
        message(
            Recipe {
                band: (0.30, 0.31),
                ..Recipe::default()
            },
            SAMPLES
        ),
        "band 0.3 to 0.31 Hz: no unmasked bin in it, bins are 0.042 Hz apart"
    );
}
