#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
use super::*;
use crate::distribution::gamma_quantile;
use crate::free::{Candidate, Free};
use crate::ride::Ride;
use crate::solver::{Limits, Search, minimise};
use crate::synthesis::Synthesis;
use crate::verdict::spread;
use bicycle::simulate::Simulation;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Density of the gusts [N m/√Hz] beside a torque of 1 N m/√Hz: coherences of .7 to .95.
const GUST: f64 = 1.0;

/// A ride of the nominal bicycle with its law in the loop and a torque of many sines besides:
/// `seconds` at 100 Hz.
fn ridden(formulation: Formulation, seconds: usize) -> Ride {
    let parameters = Parameters {
        internal_step: 0.5e-3,
        ..Parameters::default()
    };
    // no two in phase, no two multiples of one another
    let torque = |t: f64| -> f64 {
        (1..=24)
            .map(|k| {
                let k = f64::from(k);
                (TAU * 0.127 * k.powf(1.03) * t + k * k).sin()
            })
            .sum()
    };
    let mut input = Input {
        speed: 4.0,
        ..Input::default()
    };
    let mut simulation = Simulation::new(&parameters, formulation, input, 0.0).unwrap();
    let n = 100 * seconds;
    let mut ride = Ride::new(0.0, 0.01, n);
    let (mut steer, mut roll_rate, mut torques) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..n {
        let t = 0.01 * i as f64;
        steer.push(simulation.state().steer);
        roll_rate.push(simulation.state().roll_rate);
        torques.push(torque(t));
        for piece in 0..10 {
            let t = t + 1e-3 * f64::from(piece);
            input.steer_torque = torque(t + 0.5e-3);
            simulation.set_input(input).unwrap();
            simulation.advance(t + 1e-3).unwrap();
        }
    }
    ride.insert("speed", vec![4.0; n]).unwrap();
    ride.insert("steer", steer).unwrap();
    ride.insert("roll_rate", roll_rate).unwrap();
    ride.insert("steer_torque", torques).unwrap();
    ride.law_in_loop = Some(true);
    ride
}

fn landscape(ride: &Ride, formulation: Formulation, free: &[&str], start: &Parameters) -> Frf {
    let unknowns = Unknowns {
        free: free.iter().map(|name| Free::new(name).unwrap()).collect(),
        ties: Vec::new(),
        start: Candidate {
            parameters: *start,
            ..Candidate::default()
        },
    };
    let channels = ["steer", "roll_rate"];
    Frf::new(
        ride,
        &channels,
        unknowns,
        formulation,
        (4.0, 10.0),
        (0.3, 3.0),
    )
    .unwrap()
}

#[test]
fn a_linear_bicycle_is_its_own_response() {
    let ride = ridden(Formulation::Whipple, 120);
    let smooth = Parameters {
        coulomb_friction: 0.0,
        ..Parameters::default()
    };
    let frf = landscape(&ride, Formulation::Whipple, &["viscous_friction"], &smooth);
    let z = frf.unknowns.start.variables(&frf.unknowns.free);
    // Coulomb friction of the ride apart, magnitudes within 1 dB and phases within 10°
    let (costs, all) = frf.costs(&z).unwrap();
    assert!((costs.iter().sum::<f64>() - all).abs() < 1e-9 * all);
    assert!(all < 100.0, "{costs:?}");
    for (points, model) in frf.points.iter().zip(frf.model(&z).unwrap()) {
        assert!(points.len() > 8, "{} bins", points.len());
        for (point, model) in points.iter().zip(model) {
            assert!(
                (point.response / model).ln().norm() < 0.25,
                "{point:?} {model}"
            );
        }
    }
}

/// Where the search of `frf` from its start ends, and the covariance of the variables there.
fn sought(frf: &Frf) -> (DVector<f64>, DMatrix<f64>) {
    let free = &frf.unknowns.free;
    let bound = |value: fn(&Free) -> f64| {
        DVector::from_iterator(free.len(), free.iter().map(|f| f.variable(value(f))))
    };
    let limits = Limits {
        lower: bound(|f| f.lower),
        upper: bound(|f| f.upper),
        reach: DVector::from_element(free.len(), 0.7),
    };
    let search = Search {
        limits: &limits,
        held: &[],
        tolerance: 1e-9,
        max_iterations: 100,
        watch: crate::progress::Watch::default(),
    };
    let found = minimise(frf, frf.unknowns.start.variables(free), &search).unwrap();
    assert!(found.converged, "{}", found.termination);
    let covariance = spread(&frf.information(&found.point).unwrap()).covariance;
    (found.point, covariance)
}

#[test]
fn tyres_and_friction_come_back_from_responses() {
    let synthesis = Synthesis {
        excitation: Excitation {
            remnant_intensity: 2.0,
            ..Excitation::default()
        },
        torque_recorded: true,
        duration: 240.0,
        ..Synthesis::default()
    };
    let ride = synthesis.ride().unwrap();
    let truth = Parameters::default();
    let names = ["cornering_stiffness", "viscous_friction"];
    let start = Parameters {
        cornering_stiffness: 9.0,
        viscous_friction: 0.8,
        ..truth
    };
    let frf = landscape(&ride, Formulation::Repaired, &names, &start);
    let (point, covariance) = sought(&frf);
    for (i, name) in names.iter().enumerate() {
        let free = &frf.unknowns.free[i];
        let value = free.value(point[i]);
        let error = covariance[(i, i)].sqrt() * free.slope(value);
        let expected = truth.get(Parameters::index(name).unwrap());
        // one ride of four minutes: four standard errors, and those are 3 to 4 % of the values
        let told = format!("{name}: {value} ± {error}, expected {expected}");
        assert!((value - expected).abs() < 4.0 * error, "{told}");
        assert!(error < 0.06 * expected, "{told}");
    }
}

/// `seconds` at 50 Hz of a linear bicycle under a torque and a roll moment, gusts say, of
/// `gust` [N m/√Hz]: Gaussian, and exact at every sample, since they are sums of sines.
fn gusty(parameters: &Parameters, gust: f64, seconds: f64, seed: u64) -> Ride {
    let parts = linear::apart(parameters, Formulation::Whipple, 4.0);
    let n = parts.state.nrows();
    let rows = ["steer", "roll_rate"].map(|name| State::index(name).unwrap());
    let column = |name: &str| {
        parts
            .input
            .column(Input::index(name).unwrap())
            .map(Complex::from)
    };
    let (torque, moment) = (column("steer_torque"), column("roll_moment"));
    let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(seed);
    let samples = (50.0 * seconds) as usize;
    let mut signals = [(); 3].map(|()| vec![0.0; samples]);
    for k in 1..(4.0 * seconds) as usize {
        let f = k as f64 / seconds;
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let scale = (1.0 / seconds).sqrt();
        let x = Complex::new(normal(), normal()) * scale;
        let d = Complex::new(normal(), normal()) * (scale * gust);
        let mut m = parts.state.map(|v| Complex::from(-v));
        for i in 0..n {
            m[(i, i)] += Complex::new(0.0, TAU * f);
        }
        let state = m.lu().solve(&(&torque * x + &moment * d)).unwrap();
        let mut lines = vec![x];
        lines.extend(rows.map(|row| {
            let seen = parts.seen.row(row);
            seen.iter()
                .zip(state.iter())
                .map(|(c, x)| x * *c)
                .sum::<Complex<f64>>()
        }));
        let turn = Complex::from_polar(1.0, TAU * f / 50.0);
        for (signal, line) in signals.iter_mut().zip(lines) {
            let mut now = line;
            for y in signal.iter_mut() {
                *y += now.re;
                now *= turn;
            }
        }
    }
    let mut ride = Ride::new(0.0, 0.02, samples);
    for (name, signal) in ["steer_torque", "steer", "roll_rate"].iter().zip(signals) {
        ride.insert(name, signal).unwrap();
    }
    ride.law_in_loop = Some(true);
    ride
}

/// One gust moves steering and roll: the errors of both channels go together.
#[test]
fn intervals_from_channels_that_one_gust_moves_hold_the_truth_as_often_as_they_say() {
    let truth = Parameters {
        coulomb_friction: 0.0,
        ..Parameters::default()
    };
    let names = ["viscous_friction", "rider_roll_rate_gain"];
    let rides = 100;
    let (mut squares, mut held, mut bias) = ([0.0; 2], [0; 2], [0.0; 2]);
    for seed in 0..rides {
        let ride = gusty(&truth, GUST, 240.0, seed);
        let frf = landscape(&ride, Formulation::Whipple, &names, &truth);
        let (point, covariance) = sought(&frf);
        let start = frf.unknowns.start.variables(&frf.unknowns.free);
        for i in 0..2 {
            let off = (point[i] - start[i]) / covariance[(i, i)].sqrt();
            squares[i] += off * off;
            held[i] += u32::from(off.abs() < 1.96);
            bias[i] += off / rides as f64;
        }
    }
    let told = format!("{squares:?} {held:?} {bias:?}");
    for (squares, held) in squares.into_iter().zip(held) {
        // the sum of 100 squares of a standard normal variable, 99.8 % of it: channels taken for
        // independent give 149 and more; and 95 of 100
        let range = [0.001, 0.999].map(|p| 2.0 * gamma_quantile(0.5 * rides as f64, p));
        assert!((range[0]..range[1]).contains(&squares), "{told}");
        assert!((87..=100).contains(&held), "{told}");
    }
}

#[test]
fn a_channel_counted_twice_tells_nothing_new() {
    let truth = Parameters {
        coulomb_friction: 0.0,
        ..Parameters::default()
    };
    let ride = gusty(&truth, GUST, 120.0, 1);
    let deviation = |channels: &[&'static str]| {
        let unknowns = Unknowns {
            free: vec![Free::new("viscous_friction").unwrap()],
            ties: Vec::new(),
            start: Candidate {
                parameters: truth,
                ..Candidate::default()
            },
        };
        let z = unknowns.start.variables(&unknowns.free);
        let formulation = Formulation::Whipple;
        let (speed, band) = ((4.0, 10.0), (0.3, 3.0));
        let frf = Frf::new(&ride, channels, unknowns, formulation, speed, band).unwrap();
        spread(&frf.information(&z).unwrap()).covariance[(0, 0)].sqrt()
    };
    let (once, twice) = (deviation(&["steer"]), deviation(&["steer", "steer"]));
    assert!((once / twice - 1.0).abs() < 1e-9, "{once} {twice}");
}

#[test]
fn what_a_response_cannot_know_is_refused() {
    let ride = ridden(Formulation::Whipple, 30);
    let unknowns = |name: &str| Unknowns {
        free: vec![Free::new(name).unwrap()],
        ties: Vec::new(),
        start: Candidate::default(),
    };
    let frf = |name: &str, window: f64, band: (f64, f64)| {
        let whipple = Formulation::Whipple;
        Frf::new(
            &ride,
            &["steer"],
            unknowns(name),
            whipple,
            (4.0, window),
            band,
        )
    };
    for (refused, message) in [
        (frf("torque_offset", 10.0, (0.3, 3.0)), "torque_offset"),
        (
            frf("remnant_intensity", 10.0, (0.3, 3.0)),
            "remnant_intensity",
        ),
        (
            frf("viscous_friction", 10.0, (3.0, 60.0)),
            "50 Hz (Nyquist)",
        ),
        (
            frf("viscous_friction", 25.0, (0.3, 3.0)),
            "30 s (the record)",
        ),
        (frf("viscous_friction", 10.0, (40.0, 45.0)), "found 0"),
    ] {
        let error = refused.unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}
