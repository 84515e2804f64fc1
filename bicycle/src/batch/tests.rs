use super::*;
use crate::dynamics::{Nonlinear, derivative, derivative_with};
use crate::lanes::Lanes;
use crate::parameters::Parameters;
use crate::simulate::{Simulation, rk4};
use crate::state::Input;
use step::Remainder;

const SPEED: f64 = 8.0 / 3.6;

/// Table 2's start and slow-moving torques that no ride of 5 s repeats.
fn standard(trail: f64) -> (Lane, Vec<f64>) {
    let lane = Lane {
        parameters: Parameters {
            trail,
            ..Parameters::default()
        },
        speed: SPEED,
        start: State {
            roll: -5.0_f64.to_radians(),
            steer: 1.0_f64.to_radians(),
            yaw_rate: 2.0,
            ..State::ZERO
        },
    };
    let torque = |k: usize| {
        let t = 5e-3 * k as f64;
        2.0 * (2.5 * t).sin() + 1.2 * (7.1 * t + 1.0).sin() + 0.8 * (19.3 * t + 2.0).sin()
    };
    (lane, (0..=1000).map(torque).collect())
}

/// Steer angles of all lanes, sample by sample.
struct Steer<T>(Vec<T>);

impl<T: Pack> See<T> for Steer<T> {
    fn sample(&mut self, k: usize, x: &State<T>) {
        assert_eq!(k, self.0.len(), "samples come in order");
        self.0.push(x.steer);
    }
}

fn steer<T: Pack>(lanes: &[Lane], plan: &Plan, torque: &[f64]) -> (Vec<T>, Outcome) {
    let mut seen = Steer(Vec::new());
    let outcome = ride(lanes, Formulation::Repaired, plan, torque, &mut seen).expect("ridable");
    (seen.0, outcome)
}

/// The same smoothed model by the reference method at 16 kHz.
fn reference(lane: &Lane, formulation: Formulation, samples: usize, torque: &[f64]) -> Vec<f64> {
    let b = Bicycle::new(&lane.parameters, formulation);
    let (pieces, mut x, mut steer) = (80, lane.start, Vec::new());
    for k in 0..samples {
        steer.push(x.steer);
        for piece in 0..pieces {
            x = rk4(x, 5e-3 / f64::from(pieces), |fraction, x| {
                let at = (f64::from(piece) + fraction) / f64::from(pieces);
                let steer_torque = torque[k] + (torque[k + 1] - torque[k]) * at;
                let input = Input {
                    speed: lane.speed,
                    steer_torque,
                    ..Input::ZERO
                };
                derivative(&b, x, &input)
            });
        }
    }
    steer
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    apart.fold(0.0, f64::max)
}

/// A thousand odd states, angles up to 80°.
fn states() -> impl Iterator<Item = State> {
    (0..1000).map(|i| {
        let draw = |n: f64| (f64::from(i) * n).sin();
        State {
            roll_rate: 2.0 * draw(1.3),
            steer_rate: 5.0 * draw(2.7),
            roll: 1.4 * draw(0.37) * draw(5.1),
            steer: 1.4 * draw(0.77) * draw(3.9),
            yaw_rate: 3.0 * draw(1.9),
            lateral_velocity: draw(4.3),
            front_lateral_force: 100.0 * draw(0.9),
            rear_lateral_force: 100.0 * draw(1.1),
        }
    })
}

#[test]
fn derivatives_on_lanes_are_the_scalars() {
    for formulation in Formulation::ALL {
        let p = Parameters::default();
        let b = Bicycle::new(&p, formulation);
        let wide = Bicycle::new(&p.map(Lanes::<4>::from), formulation);
        for x in states() {
            let u = Input {
                steer_torque: 3.0,
                ..Input::default()
            };
            let plain = derivative(&b, &x, &u).to_array();
            let lanes = derivative(&wide, &x.map(Lanes::from), &u.map(Lanes::from)).to_array();
            // what the terms of a row cancel is lost to both: rounding is that of the largest, some
            // hundred times the row at most
            let size = plain.iter().fold(1.0_f64, |m, v| m.max(v.abs()));
            for (lane, plain) in lanes.iter().zip(plain) {
                let off = (lane.0[3] - plain).abs();
                assert!(off <= 1e-13 * size, "{formulation:?}: {off:e} of {size:e}");
            }
        }
    }
}

#[test]
fn linear_part_remainder_and_jumps_are_the_equations() {
    let (lane, _) = standard(0.11);
    let b = Bicycle::new(&lane.parameters, Formulation::Repaired);
    let upright = Upright::<5>::new(&b).at(SPEED);
    let paper = Paper::<f64>::new(&[(b, SPEED)]);
    let inertia = b.steering_inertia;
    for x in states() {
        let u = Input {
            speed: SPEED,
            steer_torque: 1.7,
            ..Input::ZERO
        };
        let whole = derivative(&b, &x, &u).to_array();
        let rows: [f64; 5] = std::array::from_fn(|i| x.get(i));
        let rest = paper.at(&rows);
        let n = Nonlinear::at(&b, &x, SPEED);
        let jumps = rest.sign_torque * n.steer_sign - paper.friction() * n.steer_rate_sign;
        let mut sum = (upright * nalgebra::SVector::from(rows)).data.0[0];
        for (row, value) in Paper::<f64>::ROWS.into_iter().zip(rest.smooth) {
            sum[row] += value;
        }
        sum[1] += (u.steer_torque + jumps) / inertia;
        let size = whole.iter().fold(1.0_f64, |m, v| m.max(v.abs()));
        for (sum, whole) in sum.into_iter().zip(whole) {
            // s(θ) in the remainder is within 1e-11; terms up to a hundred times the sum cancel
            assert!((sum - whole).abs() <= 1e-10 * size, "{sum} and {whole}");
        }
    }
    // and nothing is left upright, with the jumps taken away
    let none = Nonlinear {
        steer_sign: 0.0,
        steer_rate_sign: 0.0,
        path_angle: 0.0,
    };
    let upright = Input {
        speed: SPEED,
        ..Input::ZERO
    };
    assert_eq!(
        derivative_with(&b, &State::ZERO, &upright, &none),
        State::ZERO
    );
}

#[test]
fn powers_are_the_series() {
    let (lane, _) = standard(0.085);
    let b = Bicycle::new(&lane.parameters, Formulation::Repaired);
    let upright = Upright::<5>::new(&b).at(SPEED);
    let matrix = std::array::from_fn(|i| std::array::from_fn(|j| upright[(i, j)]));
    let h = 2.5e-3;
    let weights = exponential::Powers::new(&matrix, h).weights(Paper::<f64>::ROWS, &[0.0; 5]);
    // the naive way: Taylor's series of the whole step, which converges by itself, slowly
    let z = upright * h;
    let mut phi = [nalgebra::SMatrix::<f64, 5, 5>::zeros(); 4];
    for (k, phi) in phi.iter_mut().enumerate() {
        let mut factorial: f64 = (1..=k).map(|n| n as f64).product();
        let mut power = nalgebra::SMatrix::<f64, 5, 5>::identity();
        for n in 1..80 {
            *phi += power / factorial;
            factorial *= (n + k) as f64;
            power *= z;
        }
    }
    for i in 0..5 {
        for j in 0..5 {
            assert!((weights.free[i][j] - phi[0][(i, j)]).abs() < 1e-12 * phi[0].amax());
        }
        for (r, j) in Paper::<f64>::ROWS.into_iter().enumerate() {
            let bend = h * (0.5 * phi[2][(i, j)] + phi[3][(i, j)]);
            assert!((weights.first[i][r] - h * phi[1][(i, j)]).abs() < 1e-12);
            assert!((weights.second[i][r] - h * phi[2][(i, j)]).abs() < 1e-12);
            assert!((weights.bend[i][r] - bend).abs() < 1e-12);
        }
    }
}

#[test]
fn batch_is_the_reference_stepper_within_its_error() {
    let trails = [0.13, 0.085, -0.035];
    let lanes = trails.map(|trail| standard(trail).0);
    let (_, torque) = standard(0.085);
    for (steps_per_sample, bound) in [(1, 1.5e-4), (2, 2e-5)] {
        let plan = Plan {
            steps_per_sample,
            ..Plan::of(5.0)
        };
        let (seen, outcome) = steer::<Lanes<4>>(&lanes, &plan, &torque);
        assert_eq!(outcome.stops, [None; 3]);
        for (i, lane) in lanes.iter().enumerate() {
            let exact = reference(lane, Formulation::Repaired, plan.samples, &torque);
            let mine: Vec<f64> = seen.iter().map(|s| s.0[i]).collect();
            let off = distance(&mine, &exact);
            assert!(off < bound, "trail {}: {off:e} rad", trails[i]);
        }
    }
}

#[test]
fn lanes_and_plain_numbers_agree() {
    let lanes = [0.13, 0.085, -0.035].map(|trail| standard(trail).0);
    let (_, torque) = standard(0.085);
    let plan = Plan::of(5.0);
    let (wide, outcome) = steer::<Lanes<4>>(&lanes, &plan, &torque);
    for (i, lane) in lanes.iter().enumerate() {
        let (plain, alone) = steer::<f64>(&[*lane], &plan, &torque);
        let of_lane: Vec<f64> = wide.iter().map(|s| s.0[i]).collect();
        // rounding of 1e-16 a step, grown by the friction's slope until it is damped
        assert!(distance(&plain, &of_lane) < 1e-9);
        assert_eq!(alone.derivatives, outcome.derivatives);
    }
}

#[test]
fn work_is_one_derivative_a_step_and_the_start() {
    let (lane, torque) = standard(0.085);
    let plan = Plan::of(5.0);
    let (_, outcome) = steer::<f64>(&[lane], &plan, &torque);
    // 999 intervals of two steps; the first 36 of them in 464 steps
    assert_eq!(outcome.derivatives, 1 + 464 + 2 * (999 - 36));
}

#[test]
fn lane_that_falls_says_when_and_disturbs_nobody() {
    let (mut good, _) = standard(0.085);
    let torque = vec![0.0; 1000];
    // where the reference stepper's own start is
    let State {
        roll,
        steer: theta,
        yaw_rate,
        ..
    } = good.start;
    good.parameters.roll_start = roll;
    good.parameters.steer_start = theta;
    good.parameters.yaw_rate_start = yaw_rate;
    let bad = Lane {
        parameters: good.parameters.riderless(),
        ..good
    };
    let plan = Plan::of(5.0);
    let (both, outcome) = steer::<Lanes<2>>(&[good, bad], &plan, &torque);
    let (alone, _) = steer::<Lanes<2>>(&[good], &plan, &torque);
    let column = |all: &[Lanes<2>]| all.iter().map(|s| s.0[0]).collect::<Vec<_>>();
    assert_eq!(column(&both), column(&alone));
    assert_eq!(outcome.stops[0], None);
    let stop = outcome.stops[1].expect("nobody rides it");
    let input = Input {
        speed: SPEED,
        ..Input::ZERO
    };
    let mut alone =
        Simulation::new(&bad.parameters, Formulation::Repaired, input, 0.0).expect("a bicycle");
    let exact = alone.advance(5.0).expect_err("nobody rides it");
    assert_eq!(stop.name(), exact.name());
    // the sample before
    assert!(
        (0.0..5e-3).contains(&(exact.time() - stop.time())),
        "{stop:?}, {exact:?}"
    );
}

#[test]
fn other_formulations_go_by_the_reference_method() {
    let (lane, torque) = standard(0.085);
    let plan = Plan::of(1.0);
    for formulation in [Formulation::Whipple, Formulation::WhippleSlip] {
        let riderless = Lane {
            parameters: lane.parameters.riderless(),
            start: State {
                yaw_rate: 0.0,
                ..lane.start
            },
            ..lane
        };
        let mut seen = Steer::<Lanes<2>>(Vec::new());
        let shared = torque.as_slice();
        ride(&[riderless], formulation, &plan, shared, &mut seen).expect("ridable");
        let mine: Vec<f64> = seen.0.iter().map(|s| s.0[0]).collect();
        let exact = reference(&riderless, formulation, plan.samples, &torque);
        let off = distance(&mine, &exact);
        // the reference method at 1 ms against itself at 16 kHz
        assert!(off < 2e-4, "{formulation:?}: {off:e} rad");
    }
}

#[test]
fn what_cannot_be_ridden_is_refused() {
    let (lane, torque) = standard(0.085);
    let refusal = |lanes: &[Lane]| {
        let mut seen = Steer::<Lanes<2>>(Vec::new());
        let shared = torque.as_slice();
        ride(
            lanes,
            Formulation::Repaired,
            &Plan::of(1.0),
            shared,
            &mut seen,
        )
        .expect_err("unfit")
    };
    let mut jumping = lane;
    jumping.parameters.steer_smoothing = 0.0;
    let name = "steer_smoothing";
    assert_eq!(refusal(&[lane, jumping]), Unfit::Jump { lane: 1, name });
    let backwards = Lane {
        speed: -1.0,
        ..lane
    };
    assert!(matches!(refusal(&[backwards]), Unfit::Lane { lane: 0, .. }));
    assert_eq!(refusal(&[]), Unfit::Lanes { found: 0, most: 2 });
    assert_eq!(refusal(&[lane; 3]), Unfit::Lanes { found: 3, most: 2 });
}
