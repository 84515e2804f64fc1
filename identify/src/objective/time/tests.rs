#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
use super::*;
use crate::free::{Candidate, Free};
use crate::objective::together::{Member, Together};
use crate::synthesis::{SensorNoise, Synthesis};
use bicycle::simulate::rk4;
use bicycle::{Input, dynamics};
use num_dual::DualSVec64;

/// Directions of the oracle: more than any case here has.
const DIRECTIONS: usize = 20;

fn unknowns(free: &[&str], start: Candidate) -> Unknowns {
    Unknowns {
        free: free.iter().map(|name| Free::new(name).unwrap()).collect(),
        ties: Vec::new(),
        start,
    }
}

/// Three seconds of a ridden bicycle with its whole torque.
fn ridden(formulation: Formulation) -> Ride {
    let synthesis = Synthesis {
        formulation,
        duration: 3.0,
        torque_recorded: true,
        ..Synthesis::default()
    };
    synthesis.ride().unwrap()
}

/// The replay of a window by num-dual's numbers, window by window: what is seen of the channels
/// with its derivatives over free variables and initial state.
fn oracle(time: &Time, z: &DVector<f64>, window: usize) -> Vec<DualSVec64<DIRECTIONS>> {
    type Dual = DualSVec64<DIRECTIONS>;
    let shared = time.shared();
    let seed = |value: f64, slopes: &[(usize, f64)]| {
        let mut eps = nalgebra::SVector::<f64, DIRECTIONS>::zeros();
        for (direction, slope) in slopes {
            eps[*direction] += slope;
        }
        let mut dual = Dual::from(value);
        dual.eps = num_dual::Derivative::some(eps);
        dual
    };
    let candidate = time.unknowns.candidate(z);
    let of = |name: &str, value: f64| {
        let free = time.unknowns.free.iter().position(|f| f.row.name == name);
        let slopes: Vec<_> = free
            .map(|i| (i, time.unknowns.free[i].slope(value)))
            .into_iter()
            .collect();
        seed(value, &slopes)
    };
    let mut parameters = candidate.parameters.map(Dual::from);
    for (i, row) in Parameters::TABLE.iter().enumerate() {
        parameters.set(i, of(row.name, candidate.parameters.get(i)));
    }
    let instruments = candidate.instruments;
    let gain = of("torque_gain", instruments.torque_gain);
    let offset = of("torque_offset", instruments.torque_offset);
    let bicycle = Bicycle::new(&time.replayed(&parameters), time.formulation);
    let own = &z.as_slice()[shared + window * time.order..][..time.order];
    let mut state = State::ZERO.map(Dual::from);
    for (i, value) in own.iter().enumerate() {
        state.set(i, seed(*value, &[(shared + i, 1.0)]));
    }
    let pieces = time.pieces(z).unwrap();
    let range = time.windows[window].clone();
    let mut seen = vec![Vec::new(); time.channels.len()];
    for i in range.clone() {
        let mut shown = state;
        shown.yaw_rate = bicycle.yaw_rate(&state, Dual::from(time.speed[i]));
        for (c, (&index, samples)) in time.states.iter().zip(&mut seen).enumerate() {
            let name = Instruments::TABLE[time.offsets[c]].name;
            samples.push(shown.get(index) + of(name, instruments.get(time.offsets[c])));
        }
        let j = (i + 1).min(time.torque.len() - 1);
        let h = Dual::from(time.step / pieces as f64);
        for piece in 0..pieces {
            state = rk4(state, h, |fraction, x| {
                let at = (piece as f64 + fraction) / pieces as f64;
                let between = |y: &[f64]| Dual::from(y[i] * (1.0 - at) + y[j] * at);
                let input = Input {
                    speed: between(&time.speed),
                    steer_torque: (between(&time.torque) - offset) / gain,
                    assist_torque: Dual::from(0.0),
                    roll_moment: Dual::from(0.0),
                };
                dynamics::derivative(&bicycle, x, &input)
            });
        }
    }
    seen.concat()
}

/// Lanes and their dual numbers against num-dual's, window by window, for every formulation that
/// rides: values, gradient and curvature.
#[test]
fn lanes_replay_as_numbers_do() {
    let free = [
        "viscous_friction",
        "coulomb_friction",
        "trail",
        "torque_gain",
        "torque_offset",
        "steer_offset",
        "roll_rate_offset",
    ];
    for formulation in [
        Formulation::Repaired,
        Formulation::Whipple,
        Formulation::WhippleSlip,
    ] {
        let ride = ridden(formulation);
        let start = Candidate {
            instruments: Instruments {
                torque_gain: 1.1,
                torque_offset: 0.2,
                steer_offset: 0.01,
                ..Instruments::default()
            },
            ..Candidate::default()
        };
        let noise = [0.002, 0.004, 0.003];
        let channels = ["steer", "roll_rate", "yaw_rate"];
        let time = Time::new(
            &ride,
            &channels,
            unknowns(&free, start),
            formulation,
            (3.0, 0.25),
            Some(&noise),
        )
        .unwrap();
        let z = time.start();
        let (n, p) = (free.len() + time.order, free.len());
        let residuals = time.residuals(&z).unwrap();
        let quadratic = time.quadratic(&z).unwrap();
        assert_eq!(residuals.len(), 12);
        let mut gradient = DVector::zeros(p);
        for (window, residuals) in residuals.iter().enumerate() {
            let expected = oracle(&time, &z, window);
            let range = time.windows[window].clone();
            let measured = time.measured.iter().flat_map(|y| &y[range.clone()]);
            let noise = noise.iter().flat_map(|v| vec![*v; range.len()]);
            let mut jacobian = DMatrix::zeros(expected.len(), n);
            let mut own = DVector::zeros(expected.len());
            for (k, ((x, y), noise)) in expected.iter().zip(measured).zip(noise).enumerate() {
                own[k] = (y - x.re) / noise;
                let eps = x.eps.unwrap_generic(nalgebra::Const, nalgebra::Const);
                for i in 0..n {
                    jacobian[(k, i)] = -eps[i] / noise;
                }
                // lanes agree with numbers to 1e-13 in each derivative; a window of a quarter of a
                // second hardly lets that grow
                assert!(
                    (own[k] - residuals[k]).abs() < 1e-9 * own.amax().max(1.0),
                    "{formulation:?} window {window} sample {k}: {} {}",
                    own[k],
                    residuals[k]
                );
            }
            let curvature = jacobian.transpose() * &jacobian;
            let slope = jacobian.transpose() * own;
            gradient += slope.rows(0, p);
            let block = &quadratic.blocks[window];
            let scale = |i: usize| curvature[(i, i)].sqrt();
            for i in 0..time.order {
                for j in 0..n {
                    let found = match j.checked_sub(p) {
                        Some(j) => block.curvature[(i, j)],
                        None => block.cross[(i, j)],
                    };
                    let difference = (found - curvature[(p + i, j)]).abs();
                    // 1e-9: the slopes of the parameters over the variables are differences
                    assert!(
                        difference <= 1e-8 * scale(p + i) * scale(j),
                        "{formulation:?} {i} {j}: {found} {}",
                        curvature[(p + i, j)]
                    );
                }
            }
        }
        let difference = (&gradient - &quadratic.gradient).amax();
        assert!(
            difference < 1e-7 * gradient.amax(),
            "{formulation:?} {difference}"
        );
    }
}

/// Whatever the instructions, the same landscape.
#[test]
fn every_instruction_set_gives_the_same_windows() {
    let ride = ridden(Formulation::Repaired);
    let time = Time::new(
        &ride,
        &["steer", "roll_rate"],
        unknowns(&["cornering_stiffness"], Candidate::default()),
        Formulation::Repaired,
        (3.0, 0.25),
        Some(&[0.002, 0.004]),
    )
    .unwrap();
    let (model, shots) = time.model(&time.start()).unwrap();
    let at = |isa: kernel::Isa| {
        let work = Residuals {
            model: &model,
            shots: &shots,
        };
        kernel::run_with(isa, work)
    };
    let portable = at(kernel::Isa::Portable);
    for isa in kernel::Isa::ALL {
        for (one, other) in at(isa).iter().flatten().zip(portable.iter().flatten()) {
            // fused and other polynomials, over the noise of a sample
            assert!((one - other).abs() < 1e-9, "{isa:?}: {one} {other}");
        }
    }
}

#[test]
fn rows_at_standstill_and_glitches_are_in_no_window() {
    let mut ride = ridden(Formulation::Repaired);
    let n = ride.len();
    let mut speed = ride.channel("speed").unwrap().to_vec();
    speed[200..230].fill(0.0);
    ride.insert("speed", speed).unwrap();
    let mut steer = ride.channel("steer").unwrap().to_vec();
    steer[450] = 3.0;
    ride.insert("steer", steer).unwrap();
    let windows = windows::cut(&ride, 50);
    assert_eq!(n, 600);
    let starts: Vec<_> = windows.iter().map(|w| w.start).collect();
    assert_eq!(starts, [0, 50, 100, 150, 230, 280, 330, 380, 451, 501]);
    assert!(windows.iter().all(|w| w.len() == 50));
    assert!(windows::cut(&ride, 400).is_empty());
}

/// Gain and offsets of the sensors come back, and leave the bicycle's own where it was.
#[test]
fn gains_and_offsets_are_found_beside_the_friction() {
    let mut ride = Synthesis {
        torque_recorded: true,
        noise: SensorNoise::INSTRUMENTED,
        ..Synthesis::default()
    }
    .ride()
    .unwrap();
    for (channel, gain, offset) in [
        ("steer_torque", 0.8, 0.5),
        ("steer", 1.0, 0.03),
        ("roll_rate", 1.0, -0.02),
    ] {
        let recorded = ride.channel(channel).unwrap().iter();
        let recorded = recorded.map(|y| gain * y + offset).collect();
        ride.insert(channel, recorded).unwrap();
    }
    let expected = [
        ("viscous_friction", 0.30),
        ("torque_gain", 0.8),
        ("torque_offset", 0.5),
        ("steer_offset", 0.03),
        ("roll_rate_offset", -0.02),
    ];
    let time = Time::new(
        &ride,
        &["steer", "roll_rate", "yaw_rate"],
        unknowns(&expected.map(|(name, _)| name), Candidate::default()),
        Formulation::Repaired,
        (2.0, 0.5),
        None,
    )
    .unwrap();
    let free = &time.unknowns.free;
    let bound = |value: fn(&Free) -> f64| {
        DVector::from_iterator(free.len(), free.iter().map(|f| f.variable(value(f))))
    };
    let limits = crate::solver::Limits {
        lower: bound(|f| f.lower),
        upper: bound(|f| f.upper),
        reach: DVector::from_element(free.len(), 0.7),
    };
    let found = crate::solver::minimise(
        &time,
        time.start(),
        &crate::solver::Search {
            limits: &limits,
            held: &[],
            tolerance: 1e-5,
            max_iterations: 100,
            watch: crate::progress::Watch::default(),
        },
    )
    .unwrap();
    assert!(found.converged, "{}", found.termination);
    let rides = Together {
        priors: vec![None; free.len()],
        factor: 1.0,
        members: vec![Member {
            variables: (0..free.len()).collect(),
            landscape: time.clone(),
        }],
    };
    let information = information(&rides, &found.point).unwrap();
    let inverse = information.curvature.clone().try_inverse().unwrap();
    let covariance = &inverse * information.meat.unwrap() * &inverse;
    for (i, (name, expected)) in expected.iter().enumerate() {
        let value = free[i].value(found.point[i]);
        let error = covariance[(i, i)].sqrt() * free[i].slope(value);
        // one ride: four standard errors
        assert!(
            (value - expected).abs() < 4.0 * error,
            "{name}: {value} ± {error}, expected {expected}"
        );
    }
    let misfit = time.misfit(&found.point).unwrap();
    assert!((misfit - 1.0).abs() < 0.25, "{misfit}");
}
