use super::*;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

const STEP: f64 = 0.005;

/// Cuts noise into windows of so many samples.
type Cut = fn(&[f64], usize) -> Vec<Left>;

fn noise(seed: u64, n: usize) -> Vec<f64> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    (0..n).map(|_| StandardNormal.sample(&mut rng)).collect()
}

/// x_i = a x_{i−1} + white.
fn coloured(seed: u64, n: usize, a: f64) -> Vec<f64> {
    let mut x = 0.0;
    noise(seed, n)
        .into_iter()
        .map(|e| {
            x = a * x + e;
            x
        })
        .collect()
}

/// Windows of `length` samples of `e`, to which nothing was fitted.
fn windows(e: &[f64], length: usize) -> Vec<Left> {
    let window = |e: &[f64]| Left {
        residual: e.to_vec(),
        basis: DMatrix::zeros(e.len(), 0),
    };
    e.chunks(length).map(window).collect()
}

/// The same with five parameters fitted to each: a growing, turning and decaying start as that of a
/// bicycle.
fn fitted(e: &[f64], length: usize) -> Vec<Left> {
    let slopes = DMatrix::from_fn(length, 5, |i, j| {
        let t = i as f64 * STEP;
        match j {
            0 => 1.0,
            1 => (2.0 * t).exp() * (3.0 * t).cos(),
            2 => (2.0 * t).exp() * (3.0 * t).sin(),
            3 => (-10.0 * t).exp(),
            _ => t,
        }
    });
    let q = slopes.qr().q();
    let window = |e: &[f64]| {
        let e = DVector::from_column_slice(e);
        Left {
            residual: (&e - &q * (q.transpose() * &e)).as_slice().to_vec(),
            basis: q.clone(),
        }
    };
    e.chunks(length).map(window).collect()
}

#[test]
fn moments_are_those_of_the_whole_matrices() {
    let (n, most) = (12, 6);
    let basis = &fitted(&noise(1, n), n)[0].basis;
    let left = DMatrix::identity(n, n) - basis * basis.transpose();
    let shift = |k: usize| {
        DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
            0 if k == 0 => 1.0,
            d if d == k => 0.5,
            _ => 0.0,
        })
    };
    let (mean, covariance) = moments(basis, most);
    for k in 0..=most {
        let one = shift(k) * &left;
        assert!((mean[k] - one.trace()).abs() < 1e-12);
        for l in 0..=most {
            let both = 2.0 * (&one * shift(l) * &left).trace();
            assert!((covariance[(k, l)] - both).abs() < 1e-12, "{k} {l}");
        }
    }
}

/// White noise is rejected at 1 % in about 1 %, however many windows there are and whatever was
/// fitted to each. Of 200 records 2 ± 1.4: 99.9 % lie in 0 to 8. The mean of χ² over its freedom is
/// 1 ± √(2/50/200) = .014, and up to .01 is what windows of finite length add.
#[test]
fn white_noise_is_white_as_often_as_it_is_said_to_be() {
    let kinds: [Cut; 2] = [windows, fitted];
    for (kind, cut) in kinds.into_iter().enumerate() {
        for count in [8, 40] {
            let records = 200;
            let (mut rejected, mut mean, mut outside) = (0, 0.0, 0.0);
            for seed in 0..records {
                let w = whiteness(&cut(&noise(seed, 100 * count), 100), STEP);
                assert_eq!(w.freedom, 50);
                rejected += u32::from(w.probability < 0.01);
                mean += w.statistic / 50.0 / records as f64;
                outside += w.correlations.outside / records as f64;
            }
            let told = format!("{kind} {count}: {rejected}, {mean}, {outside}");
            assert!(rejected <= 8, "{told}");
            assert!((mean - 1.0).abs() < 0.06, "{told}");
            // 10 000 lags, nearly independent: .01 ± .001, and tails of few windows are not normal
            assert!((outside - 0.01).abs() < 0.005, "{told}");
        }
    }
}

#[test]
fn a_test_that_does_not_know_what_was_fitted_rejects_white_noise() {
    let forgotten = |w: Left| Left {
        basis: DMatrix::zeros(w.residual.len(), 0),
        ..w
    };
    let e = fitted(&noise(1, 30_000), 100);
    assert!(whiteness(&e, STEP).probability > 0.01);
    let e: Vec<Left> = e.into_iter().map(forgotten).collect();
    assert!(whiteness(&e, STEP).probability < 1e-6);
}

#[test]
fn coloured_noise_is_not_white_and_shows_its_pole() {
    let w = whiteness(&windows(&coloured(3, 4000, 0.6), 4000), STEP);
    assert!(w.probability < 1e-10, "{}", w.probability);
    // ρ_k = a^k, to three times 1/√n
    assert!((w.correlations.value[0] - 0.6).abs() < 0.05);
    assert!((w.correlations.value[1] - 0.36).abs() < 0.06);
    // a second of it
    assert!((w.correlations.lag.last().expect("lags") - 1.0).abs() < 1e-9);
    let w = whiteness(&fitted(&coloured(3, 4000, 0.3), 100), STEP);
    assert!(w.probability < 1e-10, "{}", w.probability);
}

/// With 1/√n alone a third of the lags of slow signals would lie outside; and of what a start leaves
/// the band is as true. Of 100 records of 41 lags, neighbours nearly alike: .01 ± .003.
#[test]
fn independent_slow_signals_stay_within_a_band_that_knows_they_are_slow() {
    let kinds: [Cut; 2] = [windows, fitted];
    for (kind, cut) in kinds.into_iter().enumerate() {
        let (mut outside, mut naive) = (0.0, 0.0);
        let records = 200;
        for seed in 0..records {
            let (e, u) = (coloured(seed, 4000, 0.9), coloured(1000 + seed, 4000, 0.9));
            let u: Vec<_> = u.chunks(100).map(<[f64]>::to_vec).collect();
            let c = cross_correlation(&cut(&e, 100), &u, STEP);
            outside += c.outside / records as f64;
            let beyond = |v: &&f64| v.abs() > 2.5758 / 4000_f64.sqrt();
            let beyond = c.value.iter().filter(beyond).count();
            naive += beyond as f64 / c.value.len() as f64 / records as f64;
        }
        assert!((0.004..0.016).contains(&outside), "{kind} {outside}");
        assert!(kind == 1 || naive > 0.2, "{naive}");
    }
}

#[test]
fn an_input_that_the_model_has_missed_shows_at_its_lag() {
    let u = noise(5, 2000);
    let e: Vec<f64> = noise(6, 2000)
        .iter()
        .enumerate()
        .map(|(i, n)| n + 0.5 * if i >= 7 { u[i - 7] } else { 0.0 })
        .collect();
    let u: Vec<_> = u.chunks(100).map(<[f64]>::to_vec).collect();
    let c = cross_correlation(&windows(&e, 100), &u, 0.01);
    let peak = (0..c.lag.len()).max_by(|&a, &b| c.value[a].abs().total_cmp(&c.value[b].abs()));
    let peak = peak.expect("lags");
    assert!((c.lag[peak] - 0.07).abs() < 1e-12);
    assert!(c.value[peak] > 3.0 * c.band[peak]);
    // one window alone tells nothing
    assert!(
        cross_correlation(&windows(&e, 2000), &u, 0.01)
            .lag
            .is_empty()
    );
}

#[test]
fn windows_are_not_joined() {
    // a jump between windows is no correlation inside them: 1, 1, −1, −1 in windows of two
    let w = whiteness(&windows(&[1.0, 1.0, -1.0, -1.0], 2), 1.0);
    assert_eq!(w.correlations.value, [1.0]);
}

#[test]
fn a_perfect_model_fits_all_and_the_mean_nothing() {
    let y = noise(1, 100);
    assert_eq!(fit_percent(&y, &y), 100.0);
    assert!(fit_percent(&y, &vec![mean(&y); 100]).abs() < 1e-12);
    let shifted: Vec<f64> = y.iter().map(|v| v + 3.0).collect();
    assert!(fit_percent(&y, &shifted) < 0.0);
    // half of the amplitude missing: 50 %
    let half: Vec<f64> = y.iter().map(|v| 0.5 * (v + mean(&y))).collect();
    assert!((fit_percent(&y, &half) - 50.0).abs() < 1e-9);
}
