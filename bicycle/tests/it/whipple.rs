//! The four-body bicycle against its published numbers, and its slipping tyres against it.

use crate::published::{benchmark, benchmark_bicycle, delft, file, on_even_tyres, riderless, text};
use bicycle::linear::{eigenvalues, linearize, state_equations};
use bicycle::simulate::{Refusal, Simulation};
use bicycle::whipple::{FourBodies, Matrix};
use bicycle::{Bicycle, Formulation, Input, Parameters, State, dynamics};
use nalgebra::{Complex, DMatrix, Matrix4, Vector4};
use serde_json::Value;

fn four_bodies(p: &Parameters) -> FourBodies {
    let b = Bicycle::new(p, Formulation::Whipple);
    b.four_bodies.expect("a four-body formulation")
}

fn at(speed: f64) -> Input {
    Input {
        speed,
        ..Input::ZERO
    }
}

fn modes(p: &Parameters, formulation: Formulation, speed: f64) -> Vec<Complex<f64>> {
    let b = Bicycle::new(p, formulation);
    eigenvalues(&state_equations(&b, &State::ZERO, &at(speed)).0)
}

fn published(values: &Value) -> Vec<Complex<f64>> {
    let pair = |v: &Value| Complex::new(v[0].as_f64().expect("re"), v[1].as_f64().expect("im"));
    values
        .as_array()
        .expect("eigenvalues")
        .iter()
        .map(pair)
        .collect()
}

/// The largest distance from an expected eigenvalue to the nearest found one, over `scale` of it.
fn distance(found: &[Complex<f64>], expected: &[Complex<f64>], scale: impl Fn(f64) -> f64) -> f64 {
    assert_eq!(found.len(), expected.len());
    let nearest = |e: &Complex<f64>| {
        let distances = found.iter().map(|f| (f - e).norm());
        distances.fold(f64::INFINITY, f64::min) / scale(e.norm())
    };
    expected.iter().map(nearest).fold(0.0, f64::max)
}

#[test]
fn the_benchmark_has_its_published_matrices() {
    let (file, bodies) = (benchmark(), four_bodies(&benchmark_bicycle()));
    for (name, found) in [
        ("M", bodies.mass),
        ("C1", bodies.damping),
        ("K0", bodies.stiffness),
        ("K2", bodies.speed_stiffness),
    ] {
        for (i, row) in found.iter().enumerate() {
            for (j, found) in row.iter().enumerate() {
                let expected = file[name][i][j].as_f64().expect("a number");
                // the file is computed at 40 digits
                let error = (found - expected).abs();
                assert!(
                    error < 1e-12 * expected.abs().max(1.0),
                    "{name}[{i}][{j}]: {error}"
                );
            }
        }
    }
}

#[test]
fn the_benchmark_has_its_published_eigenvalues() {
    let (file, p) = (benchmark(), benchmark_bicycle());
    for speed in 0..=10 {
        let expected = published(&file["eigenvalues"][speed.to_string()]);
        let found = modes(&p, Formulation::Whipple, f64::from(speed));
        let error = distance(&found, &expected, |_| 1.0);
        assert!(error < 1e-10, "{speed} m/s: {error}");
    }
}

/// Rows of a trajectory: time, roll, steer, roll rate, steer rate; literature's signs.
fn trajectory(name: &str) -> Vec<[f64; 5]> {
    let text = text(name);
    let number = |field: &str| field.parse::<f64>().expect("a number");
    let row = |line: &str| {
        let fields: Vec<f64> = line.split(',').map(number).collect();
        fields.try_into().expect("five columns")
    };
    text.lines().skip(1).map(row).collect()
}

/// The largest distance of the simulated benchmark, pushed at 4.6 m/s to a roll rate of .5 rad/s,
/// from a published trajectory: in roll and steer, and in all four.
fn distances(name: &str) -> [f64; 2] {
    let p = Parameters {
        roll_rate_start: 0.5,
        ..benchmark_bicycle()
    };
    let mut ride = Simulation::new(&p, Formulation::Whipple, at(4.6), 0.0).expect("1 ms");
    let (mut angles, mut all) = (0.0f64, 0.0f64);
    for [t, roll, steer, roll_rate, steer_rate] in trajectory(name) {
        ride.advance(t).expect("it stays up");
        let x = ride.state();
        angles = angles
            .max((x.roll - roll).abs())
            .max((x.steer + steer).abs());
        all = all
            .max((x.roll_rate - roll_rate).abs())
            .max((x.steer_rate + steer_rate).abs());
    }
    [angles, all.max(angles)]
}

#[test]
fn the_benchmark_rides_its_published_trajectories() {
    let [_, error] = distances("whipple_linear_benchmark.csv");
    // 1 ms steps of order 4: ((13e-3)⁵/120)/1e-3 of a mode at 13 1/s in its own time of .1 s
    assert!(error < 1e-9, "{error}");
    // that of the nonlinear bicycle is as far away as the published linear one: .0182 rad
    let [error, _] = distances("whipple_nonlinear_benchmark.csv");
    assert!(error < 0.019 && error > 0.017, "{error}");
}

/// With the tyres of a published case.
fn on_tyres(case: &Value) -> Parameters {
    let number = |name: &str| case[name].as_f64().expect("a number");
    Parameters {
        cornering_stiffness: number("C_theta_front"),
        camber_stiffness: number("C_phi_front"),
        rear_cornering_stiffness: number("C_theta_rear"),
        rear_camber_stiffness: number("C_phi_rear"),
        viscous_friction: number("viscous_friction"),
        relaxation_length: number("relaxation_length"),
        ..benchmark_bicycle()
    }
}

#[test]
fn slipping_tyres_have_the_published_eigenvalues() {
    let file = file("whipple_slip_eigenvalues.json");
    for case in file["cases"].as_array().expect("cases") {
        let speed = case["speed"].as_f64().expect("a number");
        let found = modes(&on_tyres(case), Formulation::WhippleSlip, speed);
        let expected = published(&case["eigenvalues"]);
        let error = distance(&found, &expected, |size| size);
        assert!(error < 1e-8, "{case}: {error}");
    }
}

#[test]
fn stiffer_tyres_slip_less() {
    let file = benchmark();
    for speed in [3.0, 5.0, 7.0] {
        let expected = published(&file["eigenvalues"][(speed as i32).to_string()]);
        let error = |stiffness: f64| {
            let p = on_even_tyres(stiffness);
            let mut found = modes(&p, Formulation::WhippleSlip, speed);
            // two fast modes of the tyres besides
            found.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
            distance(&found[..4], &expected, |_| 1.0)
        };
        for stiffness in [1e2, 1e3, 1e4, 1e5] {
            let ratio = error(stiffness) / error(10.0 * stiffness);
            // the next order is a share of some 20/C; above, round-off of 1e7 1/s takes over
            let next = 40.0 / stiffness + 0.02;
            assert!(
                (ratio - 10.0).abs() < 10.0 * next,
                "{speed} {stiffness}: {ratio}"
            );
        }
    }
}

#[test]
fn gyroscopic_torques_do_no_work() {
    let bodies = four_bodies(&benchmark_bicycle());
    for rates in [
        [0.3, -0.7, 1.1, 2.3],
        [-0.1, 0.9, -0.4, 1.7],
        [0.0, 0.0, 1.0, -1.0],
    ] {
        let torques = bodies.gyroscopic(4.0, rates);
        let power: f64 = torques.iter().zip(rates).map(|(t, r)| t * r).sum();
        let size: f64 = torques.iter().zip(rates).map(|(t, r)| (t * r).abs()).sum();
        // products that cancel in pairs
        assert!(power.abs() < 4.0 * f64::EPSILON * size, "{power} of {size}");
    }
}

fn square<const N: usize>(m: &Matrix<f64, N>) -> DMatrix<f64> {
    DMatrix::from_fn(N, N, |i, j| m[i][j])
}

/// v_y = 0, r = (v δ + c δ̇) cos λ/w, the tyre forces eliminated with the virtual motions that
/// these allow: the matrices without slip.
#[test]
fn without_slip_the_tyres_leave_the_published_matrices() {
    let p = benchmark_bicycle();
    let bodies = four_bodies(&p);
    let per_w = p.caster_angle.cos() / p.wheelbase;
    // q̇ = V (φ̇, δ̇) + v W (φ, δ)
    let by_rates = DMatrix::from_row_slice(4, 2, &[0., 0., 0., p.trail * per_w, 1., 0., 0., 1.]);
    let by_angles = DMatrix::from_row_slice(4, 2, &[0., 0., 0., per_w, 0., 0., 0., 0.]);
    let mass = square(&bodies.mass_with_slip);
    // D at v = 1, column by column
    let unit = |j: usize| std::array::from_fn(|i| f64::from(u8::from(i == j)));
    let d = DMatrix::from_fn(4, 4, |i, j| {
        let (gyroscopic, rates) = (bodies.gyroscopic(1.0, unit(j)), unit(j));
        gyroscopic[i] + bodies.centripetal(1.0, rates[1])[i]
    });
    // forces do no work on V: columns of V are the motions without slip
    let v_t = by_rates.transpose();
    for (name, found, expected) in [
        ("M", &v_t * &mass * &by_rates, bodies.mass),
        (
            "C1",
            &v_t * (&mass * &by_angles + &d * &by_rates),
            bodies.damping,
        ),
        ("K2", &v_t * &d * &by_angles, bodies.speed_stiffness),
    ] {
        let error = (found - square(&expected)).amax();
        assert!(error < 1e-12 * 80.0, "{name}: {error}");
    }
}

/// The mass matrix with slip is symmetric and positive definite, and what multiplies the rates is
/// its inverse.
#[test]
fn masses_are_positive() {
    for bicycle in [
        benchmark_bicycle(),
        riderless(&delft()),
        Parameters::default(),
    ] {
        let mass = Matrix4::from_fn(|i, j| four_bodies(&bicycle).mass_with_slip[i][j]);
        assert_eq!(mass, mass.transpose());
        assert!(mass.cholesky().is_some());
    }
}

#[test]
fn constraint_forces_are_those_of_stiff_tyres() {
    let x = State {
        roll_rate: 0.2,
        steer_rate: -0.3,
        roll: 0.05,
        steer: 0.04,
        ..State::ZERO
    };
    let u = Input {
        speed: 4.0,
        roll_moment: 3.0,
        steer_torque: 0.4,
        ..Input::ZERO
    };
    let p = benchmark_bicycle();
    let b = Bicycle::new(&p, Formulation::Whipple);
    let path = bicycle::Path::default();
    let seen = dynamics::output(&b, &x, &path, &u);
    // Newton sideways: both forces together push the centre of mass, v̇_y = 0
    let bodies = four_bodies(&p);
    let motion = Vector4::new(
        0.0,
        -seen.yaw_acceleration,
        seen.roll_acceleration,
        -seen.steer_acceleration,
    );
    let sideways = Vector4::from(bodies.mass_with_slip[0]).dot(&motion);
    let centripetal = b.lumps.total_mass * u.speed * seen.yaw_rate;
    let forces = seen.front_lateral_force + seen.rear_lateral_force;
    assert!((forces + sideways - centripetal).abs() < 1e-11, "{forces}");
    // in a steady turn the tyres that slip carry what the constraint carries
    let b = Bicycle::new(
        &Parameters {
            cornering_stiffness: 1e5,
            rear_cornering_stiffness: 1e5,
            camber_stiffness: 0.0,
            rear_camber_stiffness: 0.0,
            relaxation_length: 0.0,
            ..p
        },
        Formulation::WhippleSlip,
    );
    let mut slipping = State {
        yaw_rate: seen.yaw_rate,
        ..x
    };
    // the slips that make these forces
    slipping.lateral_velocity = -seen.rear_lateral_force / (1e5 * b.rear_wheel_load) * u.speed;
    let slip =
        seen.front_lateral_force / (1e5 * b.front_load) + slipping.lateral_velocity / u.speed;
    slipping.yaw_rate -= slip * u.speed / p.wheelbase;
    let found = dynamics::output(&b, &slipping, &path, &u);
    for (found, expected) in [
        (found.front_lateral_force, seen.front_lateral_force),
        (found.rear_lateral_force, seen.rear_lateral_force),
        (found.roll_acceleration, seen.roll_acceleration),
        (found.steer_acceleration, seen.steer_acceleration),
    ] {
        // slips of 1e-4 rad leave their share
        assert!(
            (found - expected).abs() < 1e-3 * expected.abs().max(1.0),
            "{found} {expected}"
        );
    }
}

/// `mechmotum/sbw_bicycle_with_model_matching`: matrices to five decimals, and the closed loop of
/// its steer-into-lean law T = 2 (6.5 − v) φ̇ on its encoder's speed, 1.066 v − .128 m/s.
#[test]
fn the_delft_bicycle_under_its_law() {
    let mut p = riderless(&delft());
    let bodies = four_bodies(&p);
    for (found, expected) in [
        (bodies.mass[0][0], 13.66926),
        (bodies.mass[0][1], 0.66789),
        (bodies.mass[1][1], 0.14014),
        (bodies.stiffness[0][0], -19.10782),
        (bodies.stiffness[0][1], -0.96045),
        (bodies.stiffness[1][1], -0.29998),
    ] {
        assert!((found - expected).abs() < 5e-6, "{found} for {expected}");
    }
    p.viscous_friction = 0.2;
    // literature's steer torque turns right: with the other sign it is k_p of the rider law
    p.rider_roll_rate_gain = 2.0 * (6.5 + 0.128);
    p.rider_roll_rate_gain_slope = -2.0 * 1.066;
    for (speed, expected) in [
        (4.0, Complex::new(-2.33, 8.63)),
        (5.0, Complex::new(-1.89, 8.33)),
    ] {
        let found = modes(&p, Formulation::Whipple, speed);
        let nearest = found
            .iter()
            .map(|l| (l - expected).norm())
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 0.02, "{speed}: {found:?}");
    }
}

#[test]
fn only_what_rolls_without_slip_may_stand() {
    let p = Parameters::default();
    for formulation in Formulation::ALL {
        let standing = Simulation::new(&p, formulation, at(0.0), 0.0);
        let backwards = Simulation::new(&p, formulation, at(-1.0), 0.0);
        let refused = |r: &Result<Simulation, Refusal>| matches!(r, Err(Refusal::Speed { .. }));
        assert_eq!(refused(&standing), formulation != Formulation::Whipple);
        assert!(refused(&backwards), "{formulation:?}");
    }
    // and a ramp may come down to rest
    let mut ride = Simulation::new(&p, Formulation::Whipple, at(1.0), 0.0).expect("nominal");
    let slope = at(-0.5);
    ride.set(&p, at(1.0), slope).expect("slower");
    assert_eq!(ride.check_until(2.0), Ok(()));
    assert!(ride.check_until(2.1).is_err());
    ride.set(&p, at(0.0), at(0.5)).expect("away from rest");
    assert_eq!(ride.check_until(8.0), Ok(()));
}

#[test]
fn impossible_bodies_are_named() {
    let nominal = Parameters::default();
    let light = Parameters {
        total_mass: 4.0,
        ..nominal
    };
    let skewed = Parameters {
        front_assembly_inertia_xz: 1.0,
        ..nominal
    };
    for (p, name) in [(light, "the rear frame"), (skewed, "the front assembly")] {
        let refusal = Simulation::new(&p, Formulation::WhippleSlip, Input::default(), 0.0);
        let words = refusal.expect_err(name).to_string();
        assert!(words.contains(name), "{words}");
    }
}

/// C is seen: the row of the algebraic yaw rate is (v δ + c δ̇) cos λ/w.
#[test]
fn the_yaw_rate_follows_the_steering() {
    let p = benchmark_bicycle();
    let b = Bicycle::new(&p, Formulation::Whipple);
    let linear = linearize(&b, &State::ZERO, &at(3.0));
    let row = bicycle::Output::index("yaw_rate").expect("an output");
    let per_w = p.caster_angle.cos() / p.wheelbase;
    let expected = [0.0, p.trail * per_w, 0.0, 3.0 * per_w];
    for (found, expected) in linear.c.row(row).iter().zip(expected) {
        assert!((found - expected).abs() < 1e-15);
    }
    let names: Vec<_> = linear.states().iter().map(|row| row.name).collect();
    assert_eq!(names, ["roll_rate", "steer_rate", "roll", "steer"]);
}

/// Exact friction: a held fork stays where it is while the bicycle falls, as long as the torque on
/// it is below the friction.
#[test]
fn friction_holds_the_fork_of_the_four_body_bicycle() {
    for formulation in [Formulation::Whipple, Formulation::WhippleSlip] {
        let p = Parameters {
            coulomb_friction: 1.0,
            steer_rate_smoothing: 0.0,
            roll_start: 1e-3,
            ..Parameters::default().riderless()
        };
        // the same without friction: how its fork would turn
        let free = Bicycle::new(
            &Parameters {
                coulomb_friction: 0.0,
                ..p
            },
            formulation,
        );
        let mut ride = Simulation::new(&p, formulation, at(2.0), 0.0).expect("1 ms");
        let held = |x: &State| x.steer_rate == 0.0;
        let mut last = 0.0;
        while ride.time() < 10.0 && held(ride.state()) {
            let (x, seen) = (ride.state(), ride.output());
            assert_eq!((x.steer, seen.steer_acceleration), (0.0, 0.0));
            // d over the inertia that θ̈ meets, the others free to move: what d alone brings about
            let alone = |coulomb_friction| {
                let pushed = State {
                    steer_rate: 1e-9,
                    ..*x
                };
                let p = Parameters {
                    coulomb_friction,
                    ..free.p
                };
                dynamics::derivative(&Bicycle::new(&p, formulation), &pushed, &at(2.0)).steer_rate
            };
            last = dynamics::derivative(&free, x, &at(2.0)).steer_rate / (alone(0.0) - alone(1.0));
            assert!(last.abs() <= 1.0 + 1e-9, "{formulation:?}: {last} of d");
            ride.advance(ride.time() + 1e-3).expect("it leans a little");
        }
        // it broke away within the last millisecond, in which the torque rises by some per cent
        assert!(
            !held(ride.state()) && last.abs() > 0.95,
            "{formulation:?}: {last} of d"
        );
    }
}

/// The work of a step: four evaluations where tyres as stiff as any roll at walking pace.
#[test]
fn stiff_tyres_at_walking_pace_are_stepped_as_any() {
    let p = Parameters {
        cornering_stiffness: 40.0,
        rear_cornering_stiffness: 40.0,
        roll_start: 0.02,
        ..Parameters::default()
    };
    for formulation in [
        Formulation::Repaired,
        Formulation::Whipple,
        Formulation::WhippleSlip,
    ] {
        let mut ride = Simulation::new(&p, formulation, at(1.0), 0.0).expect("1 ms is stable");
        let _ = ride.advance(1.0);
        let steps = (ride.time() / p.internal_step).round();
        // a stop is located in some sixty pieces
        assert!(
            ride.derivatives() as f64 <= 4.0 * (steps + 120.0),
            "{formulation:?}"
        );
    }
    // without relaxation the tyres' own modes are too fast for 1 ms, and that is said
    let stiff = Parameters {
        relaxation_length: 0.0,
        ..p
    };
    let refusal = Simulation::new(&stiff, Formulation::WhippleSlip, at(1.0), 0.0);
    assert!(matches!(refusal, Err(Refusal::StepTooLong { limit, .. }) if limit > 5e-4));
}
