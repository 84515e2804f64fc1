mod rides;
mod said;

use super::*;
use bicycle::Parameters;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

/// 20 s at 100 Hz.
const STEP: f64 = 0.01;
const SAMPLES: usize = 2000;

fn ride(channels: &[(&str, Vec<f64>)]) -> Ride {
    let mut ride = Ride::new(0.0, STEP, channels[0].1.len());
    for (name, samples) in channels {
        ride.insert(name, samples.clone()).expect("a channel");
    }
    ride
}

fn stood(ride: Ride) -> Ridden {
    Ridden { ride, fell: None }
}

fn sampled(f: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..SAMPLES).map(|i| f(i as f64 * STEP)).collect()
}

/// A ride whose steering swings with `amplitude` [rad] at `frequency` [Hz], which is a bin, under
/// a motor of the torque that `torque` makes of steer and steer rate.
fn swinging(amplitude: f64, frequency: f64, torque: impl Fn(f64, f64) -> f64) -> Ride {
    let turn = TAU * frequency;
    let steer = |t: f64| amplitude * (turn * t).sin();
    let rate = |t: f64| amplitude * turn * (turn * t).cos();
    ride(&[
        ("steer", sampled(steer)),
        ("steer_rate", sampled(rate)),
        ("assist_torque", sampled(|t| torque(steer(t), rate(t)))),
    ])
}

fn pair(without: Ride, with: Ride) -> Pair<Ridden> {
    Pair {
        without: stood(without),
        with: stood(with),
    }
}

fn fell(after: usize) -> Ridden {
    let full = swinging(0.1, 1.0, |_, _| 0.0);
    let mut short = Ride::new(0.0, STEP, after);
    for (row, samples) in full.channels() {
        short
            .insert(row.name, samples[..after].to_vec())
            .expect("a channel");
    }
    Ridden {
        ride: short,
        fell: Some(Fall {
            time: after as f64 * STEP,
            why: "steer limit".into(),
        }),
    }
}

fn case(trail: f64, load: f64) -> Case {
    let row = |name| &Parameters::TABLE[Parameters::index(name).expect("a row")];
    Case(vec![(row("trail"), trail), (row("rear_load"), load)])
}

fn unknown() -> Pair<std::result::Result<Vec<Complex<f64>>, String>> {
    let reason = || Err("the controller lists no states".to_owned());
    Pair {
        without: reason(),
        with: reason(),
    }
}

fn of(pairs: &[Pair<Ridden>]) -> Result<Worth> {
    worth(case(0.13, 10.0), pairs, &Recipe::default(), &unknown())
}

fn swings(without: f64, with: f64) -> Pair<Ridden> {
    let ride = |amplitude| swinging(amplitude, 1.0, |_, rate| -2.0 * rate);
    pair(ride(without), ride(with))
}

#[test]
fn a_halved_sine_has_half_the_band_and_its_amplitude_in_the_spectrum() {
    let found = of(&[swings(0.1, 0.05), swings(0.2, 0.1)]).expect("rides");
    let c = found.judged().expect("both stood");
    // two sines, .1 and .2: √((.1² + .2²)/2)/√2. Where the moving average shrinks at the ends of the
    // record it holds up to 1/(2π · 1 Hz · 2.5 s) = 6 % of the sine, in a quarter of the record
    let rms = 0.025_f64.sqrt() * FRAC_1_SQRT_2;
    assert!((c.rms.without / rms - 1.0).abs() < 0.02, "{c:?}");
    // everything is linear: round-off
    assert!((c.ratio - 0.5).abs() < 1e-12, "{c:?}");
    assert!((c.interval.0 - 0.5).abs() < 1e-12 && (c.interval.1 - 0.5).abs() < 1e-12);
    assert_eq!(c.verdict, Change::Falls);
    let Spectra {
        frequency,
        amplitude,
    } = &found.spectra;
    let bin = frequency
        .iter()
        .position(|f| (f - 1.0).abs() < 1e-9)
        .expect("a bin");
    let peak = amplitude.with.value().expect("stood")[bin];
    assert!((peak / 0.025_f64.sqrt() - 0.5).abs() < 0.02, "{peak}");
    // what leaks into the other bands is far below
    let slow = found.bands[0].change.value().expect("stood");
    assert!(slow.rms.without < 0.03 * rms, "{slow:?}");
    // the other way round it rises, and against itself nothing changes
    let up = of(&[swings(0.05, 0.1), swings(0.1, 0.2)]).expect("rides");
    assert_eq!(up.judged().expect("both stood").verdict, Change::Rises);
    let same = of(&[swings(0.1, 0.1), swings(0.1, 0.1)]).expect("rides");
    assert_eq!(same.judged().expect("both stood").verdict, Change::None);
}

#[test]
fn a_damping_motor_takes_work_out_a_driving_one_delivers_it() {
    let (a, k, turn) = (0.1, 2.0, TAU);
    let motor = |torque: &dyn Fn(f64, f64) -> f64| {
        let ride = swinging(a, 1.0, torque);
        *of(&[pair(ride.clone(), ride)])
            .expect("a ride")
            .motor
            .value()
            .expect("stood")
    };
    let duration = SAMPLES as f64 * STEP;
    // ∫ k θ̇² dt over whole periods, which equidistant samples give exactly
    let work = k * (a * turn).powi(2) * duration / 2.0;
    let brake = motor(&|_, rate| -k * rate);
    assert!((brake.net_energy + work).abs() < 1e-9 * work, "{brake:?}");
    assert_eq!((brake.delivered_energy, brake.mean_power), (0.0, 0.0));
    assert!((brake.peak_torque - k * a * turn).abs() < 1e-12);
    assert!((brake.rms_torque - k * a * turn * FRAC_1_SQRT_2).abs() < 1e-12);
    let drive = motor(&|_, rate| k * rate);
    assert!((drive.net_energy - work).abs() < 1e-9 * work, "{drive:?}");
    assert_eq!(drive.delivered_energy, drive.net_energy);
    assert!((drive.mean_power - work / duration).abs() < 1e-9 * work);
    // a spring gives back what it takes: ∫ max(k θ θ̇, 0) dt = k a² ω T/2π. The kinks of the positive
    // part cost (2ωh)²/12 = 1.3e-3 of it at 100 samples a swing
    let spring = motor(&|steer, _| -k * steer);
    let delivered = k * a * a * turn * duration / TAU;
    assert!(spring.net_energy.abs() < 1e-9, "{spring:?}");
    assert!(
        (spring.delivered_energy / delivered - 1.0).abs() < 2e-3,
        "{spring:?}"
    );
}

/// `seeds` pairs of white steering, of which `shared` of the variance is the same in both, `factor`
/// times as much with the assist. 10 s at 20 Hz: quick, and 9 bins in the judged band.
fn noise(
    seeds: usize,
    shared: f64,
    factor: f64,
    rng: &mut Xoshiro256PlusPlus,
) -> Vec<Pair<Ridden>> {
    let mut white = || -> Vec<f64> { (0..200).map(|_| StandardNormal.sample(rng)).collect() };
    let ride = |common: &[f64], own: Vec<f64>, factor: f64| {
        let mix = |(common, own): (&f64, &f64)| {
            factor * (shared.sqrt() * common + (1.0 - shared).sqrt() * own)
        };
        let steer: Vec<f64> = common.iter().zip(&own).map(mix).collect();
        let mut ride = Ride::new(0.0, 0.05, steer.len());
        for (name, samples) in [
            ("steer", steer),
            ("steer_rate", own.clone()),
            ("assist_torque", own),
        ] {
            ride.insert(name, samples).expect("a channel");
        }
        ride
    };
    (0..seeds)
        .map(|_| {
            let common = white();
            pair(ride(&common, white(), 1.0), ride(&common, white(), factor))
        })
        .collect()
}

#[test]
fn the_interval_holds_the_truth_in_95_of_100_studies() {
    const STUDIES: usize = 400;
    let factor = 0.8;
    // (seeds, shared): one seed's interval takes the two rides for independent
    for (seeds, shared) in [(1, 0.0), (2, 0.5), (4, 0.5), (8, 0.9)] {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
        let holds = |_: &usize| {
            let found = of(&noise(seeds, shared, factor, &mut rng)).expect("rides");
            let (low, high) = found.judged().expect("all stood").interval;
            low < factor && factor < high
        };
        let held = (0..STUDIES).filter(holds).count();
        // binomial of 400 at .95: 380, standard deviation 4.4; three and a half of them either way
        assert!(
            (365..=395).contains(&held),
            "{seeds} seeds: {held} of {STUDIES}"
        );
    }
}

#[test]
fn one_seed_has_the_interval_of_two_rides_taken_for_noise() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let pairs = noise(1, 0.5, 0.8, &mut rng);
    let found = of(&pairs).expect("rides");
    let rides = [&pairs[0].without, &pairs[0].with].map(|ridden| ridden.ride.clone());
    let rows = crate::compare::bands(&rides, "steer", &Recipe::default()).expect("rides");
    for (band, rows) in found.bands.iter().zip(rows.chunks(2)) {
        let c = band.change.value().expect("stood");
        assert_eq!(
            (c.ratio, c.interval, c.verdict),
            (rows[1].ratio, rows[1].interval, rows[1].verdict)
        );
        assert_eq!((c.rms.without, c.rms.with), (rows[0].rms, rows[1].rms));
    }
}

#[test]
fn the_closed_loop_shows_its_least_damped_oscillation_and_its_growth() {
    let known = |values: Vec<Complex<f64>>| Pair {
        without: Err("no derivatives".to_owned()),
        with: Ok(values),
    };
    let found = |modes| {
        worth(
            case(0.13, 0.0),
            &[swings(0.1, 0.1)],
            &Recipe::default(),
            &modes,
        )
    };
    // −3 ± 4i: damping ratio .6 at 4/2π Hz; −1 ± 20i: about .05
    let both = |re: f64, im: f64| [Complex::new(re, im), Complex::new(re, -im)];
    let values = [both(-3.0, 4.0), both(-1.0, 20.0)].concat();
    let modes = found(known([values, vec![Complex::new(0.2, 0.0)]].concat()))
        .expect("rides")
        .modes;
    assert_eq!(modes.without.reason(), Some("no derivatives"));
    let with = modes.with.value().expect("known");
    let least = with.least_damped.value().expect("two oscillate");
    assert!((least.frequency - 10.0 / PI).abs() < 1e-12);
    assert!((least.damping_ratio - 1.0 / 401f64.sqrt()).abs() < 1e-12);
    assert_eq!((with.growth, with.eigenvalues.len()), (0.2, 5));
    let real = found(known(vec![Complex::new(-1.0, 0.0)]))
        .expect("rides")
        .modes;
    let reason = real.with.value().expect("known").least_damped.reason();
    assert_eq!(reason, Some("no eigenvalue is complex"));
    let said = found(known(vec![Complex::new(f64::NAN, 0.0)]))
        .expect_err("no number")
        .to_string();
    assert!(
        said.contains("expected finite eigenvalues, found NaN"),
        "{said}"
    );
}
