//! Derivatives by dual numbers against difference quotients, and the parts against the whole.

use bicycle::dynamics::{self, Nonlinear, derivative, derivative_with, output};
use bicycle::linear::{
    apart, eigenvalues, fastest_growth, linearize, state_equations, steady_turn,
};
use bicycle::{Bicycle, Formulation, Input, Output, Parameters, Path, State};
use nalgebra::{Complex, DMatrix, DVector, RowDVector};

/// Widths at which differences of 1e-5 still resolve the smoothed jumps.
fn smooth() -> Parameters {
    Parameters {
        steer_smoothing: 0.05,
        steer_rate_smoothing: 0.5,
        rear_load: 20.0,
        ..Parameters::default()
    }
}

const UPRIGHT: State = State::ZERO;

const LEANING: State = State {
    roll_rate: 0.4,
    steer_rate: -1.1,
    roll: -0.3,
    steer: 0.5,
    yaw_rate: 0.9,
    lateral_velocity: -0.2,
    front_lateral_force: 30.0,
    rear_lateral_force: -50.0,
};

const STEERING: State = State {
    roll_rate: -0.2,
    steer_rate: 0.3,
    roll: 0.1,
    steer: -0.9,
    yaw_rate: -1.5,
    lateral_velocity: 0.1,
    front_lateral_force: -20.0,
    rear_lateral_force: 10.0,
};

fn input() -> Input {
    Input {
        speed: 3.0,
        steer_torque: 1.5,
        assist_torque: -0.5,
        roll_moment: 4.0,
    }
}

#[test]
fn dual_numbers_agree_with_differences() {
    let h = 1e-5;
    for formulation in Formulation::ALL {
        let b = Bicycle::new(&smooth(), formulation);
        let n = b.order();
        for x in [UPRIGHT, LEANING, STEERING] {
            let u = input();
            let linear = linearize(&b, &x, &u);
            let (state, seen) = (join(&linear.a, &linear.b), join(&linear.c, &linear.d));
            let at = |j: usize, step: f64| {
                let (mut x, mut u) = (x, u);
                if j < n {
                    x.set(j, x.get(j) + step);
                } else {
                    u.set(j - n, u.get(j - n) + step);
                }
                (
                    derivative(&b, &x, &u).to_array()[..n].to_vec(),
                    output(&b, &x, &Path::default(), &u).to_array().to_vec(),
                )
            };
            for j in 0..n + Input::LEN {
                let (up, down) = (at(j, h), at(j, -h));
                for (matrix, up, down) in [(&state, up.0, down.0), (&seen, up.1, down.1)] {
                    let quotient = (DVector::from(up) - DVector::from(down)) / (2.0 * h);
                    // h²/6 of a third derivative over the narrowest width, .05 rad: 1e-8 of a
                    // slope; round-off 1e-16/h = 1e-11 of the values
                    assert!(
                        (matrix.column(j) - quotient).norm() < 1e-7 * (1.0 + matrix.norm()),
                        "{formulation:?} {x:?} {j}"
                    );
                }
            }
        }
    }
}

fn join(left: &DMatrix<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
    let mut both = left
        .clone()
        .resize_horizontally(left.ncols() + right.ncols(), 0.0);
    both.columns_mut(left.ncols(), right.ncols())
        .copy_from(right);
    both
}

#[test]
fn parts_make_the_whole() {
    for formulation in Formulation::ALL {
        let p = smooth();
        let u = Input {
            speed: 3.0,
            ..Input::ZERO
        };
        let linear = linearize(&Bicycle::new(&p, formulation), &UPRIGHT, &u);
        let parts = apart(&p, formulation, u.speed);
        let slope = |row: &str| {
            let mut along = RowDVector::zeros(linear.a.nrows());
            if let Some(entry) = along.iter_mut().nth(State::index(row).expect("a state")) {
                *entry = 1.0;
            }
            along
        };
        // the slopes at rest: 1/ε of the smoothed sign θ̇, L/V of the arctangent; sign θ
        // multiplies products of states and has none
        let whole = parts.state
            + parts.steer_rate_sign * slope("steer_rate") / p.steer_rate_smoothing
            + parts.path_angle * slope("yaw_rate") * (p.wheelbase / u.speed);
        // the same products, summed in another order
        assert!(
            (whole - &linear.a).norm() < 1e-13 * linear.a.norm(),
            "{formulation:?}"
        );
        assert_eq!(parts.input, linear.b);
        for (row, seen) in State::TABLE.iter().zip(parts.seen.row_iter()) {
            let output = Output::index(row.name).expect("every state is seen");
            let moves = linear.states().iter().any(|state| state.name == row.name);
            if moves || row.name == "yaw_rate" {
                assert_eq!(seen, linear.c.row(output), "{formulation:?} {}", row.name);
            }
        }
    }
}

#[test]
fn products_with_the_steer_sign_agree_with_differences() {
    let h = 1e-3;
    let p = smooth();
    for formulation in Formulation::ALL {
        if formulation.has_four_bodies() {
            assert!(apart(&p, formulation, 3.0).steer_sign.is_empty());
            continue;
        }
        let b = Bicycle::new(&p, formulation);
        let u = Input {
            speed: 3.0,
            ..Input::default()
        };
        // what multiplies sign θ in each state derivative
        let factor = |x: &State| {
            let with = |steer_sign| {
                let n = Nonlinear {
                    steer_sign,
                    steer_rate_sign: 0.0,
                    path_angle: x.yaw_rate * p.wheelbase / u.speed,
                };
                DVector::from(derivative_with(&b, x, &u, &n).to_array().to_vec())
            };
            with(1.0) - with(0.0)
        };
        let hessians = apart(&p, formulation, u.speed).steer_sign;
        let largest = hessians.iter().map(DMatrix::norm).fold(0.0, f64::max);
        assert!(largest > 1.0, "there is something to compare: {largest}");
        for j in 0..5 {
            for k in 0..5 {
                let at = |s: f64, t: f64| {
                    let mut x = UPRIGHT;
                    x.set(j, x.get(j) + s * h);
                    x.set(k, x.get(k) + t * h);
                    factor(&x)
                };
                let second =
                    (at(1.0, 1.0) - at(1.0, -1.0) - at(-1.0, 1.0) + at(-1.0, -1.0)) / (4.0 * h * h);
                for (i, hessian) in hessians.iter().enumerate() {
                    // fourth derivatives of sines: h² = 1e-6 of the largest; round-off 1e-16/h²
                    let error = (second[i] - hessian[(j, k)]).abs();
                    assert!(
                        error < 3e-6 * largest,
                        "{formulation:?} {i} {j} {k}: {error}"
                    );
                }
            }
        }
    }
}

/// `apart` leaves the jumps out, so the growth does not know their widths.
#[test]
fn growth_of_the_ridden_and_of_the_riderless_bicycle() {
    let p = Parameters::<f64>::default();
    let growth = |p: &Parameters| fastest_growth(p, Formulation::Repaired, 8.0 / 3.6).re;
    let exact = Parameters {
        steer_smoothing: 0.0,
        steer_rate_smoothing: 0.0,
        ..p
    };
    assert_eq!(growth(&p), growth(&exact));
    // the nominal gains are chosen to stabilise: slowest pole −2.8 to −4.2 1/s over the trails of
    // Table 3 and 0–30 kg
    for trail in bicycle::cases::TRAILS {
        for rear_load in [0.0, 30.0] {
            let slowest = growth(&Parameters {
                trail,
                rear_load,
                ..p
            });
            assert!(
                (-4.25..-2.75).contains(&slowest),
                "{trail} {rear_load}: {slowest}"
            );
        }
    }
    // without a rider a bicycle at walking pace falls
    let riderless = Parameters {
        rider_roll_gain: 0.0,
        rider_roll_rate_gain: 0.0,
        rider_steer_gain: 0.0,
        rider_steer_rate_gain: 0.0,
        ..p
    };
    assert!(growth(&riderless) > 0.5);
}

#[test]
fn eigenvalues_are_the_characteristic_roots() {
    let p = smooth();
    let u = Input {
        speed: 3.0,
        ..Input::default()
    };
    let (a, _) = state_equations(&Bicycle::new(&p, Formulation::Repaired), &UPRIGHT, &u);
    let values = eigenvalues(&a);
    let sum: f64 = values.iter().map(|l| l.re).sum();
    let product: Complex<f64> = values.iter().product();
    // backward stable: errors of the size of ε ‖A‖ in each
    assert!((sum - a.trace()).abs() < 1e-12 * a.norm());
    assert!((product - a.determinant()).norm() < 1e-10 * a.determinant().abs());
    assert!(values.windows(2).all(|pair| pair[0].re >= pair[1].re));
}

/// The state matrix of a bicycle within its ranges on which the QR iteration does not converge.
#[test]
fn eigenvalues_of_a_matrix_that_goes_round_in_circles() {
    let a = DMatrix::from_columns(&[
        DVector::from(vec![0.0, -837.7995943568543, 1.0, 0.0, 0.0]),
        DVector::from(vec![0.3976463975882485, -1687.825060177486, 0.0, 1.0, 0.0]),
        DVector::from(vec![
            1.0604661656123913,
            -2247.900323440016,
            0.0,
            0.0,
            -5.237334691594566,
        ]),
        DVector::from(vec![
            -0.1499828922377729,
            -2187.0343510778944,
            0.0,
            0.0,
            14.714629820246014,
        ]),
        DVector::from(vec![
            0.051379927127939935,
            1445.849475498739,
            0.0,
            0.0,
            -19.82856115378217,
        ]),
    ]);
    let sum: Complex<f64> = eigenvalues(&a).iter().sum();
    // backward stable: errors of the size of ε ‖A‖
    assert!((sum - a.trace()).norm() < 1e-12 * a.norm(), "{sum}");
}

#[test]
fn path_is_the_integral_of_speed() {
    let path = Path {
        heading: 0.6,
        x: 1.0,
        y: 2.0,
    };
    let b = Bicycle::new(&Parameters::default(), Formulation::Repaired);
    let rolling = State {
        lateral_velocity: 0.0,
        ..LEANING
    };
    let rate = dynamics::path_derivative(&b, &rolling, &path, 3.0);
    assert_eq!(rate.heading, LEANING.yaw_rate);
    // left positive: heading left of x moves towards +y; sines from two libraries, an ulp apart
    assert!((rate.x - 3.0 * 0.6f64.cos()).abs() < 1e-15);
    assert!((rate.y - 3.0 * 0.6f64.sin()).abs() < 1e-15);
    // sideways is left of the heading
    let sliding = dynamics::path_derivative(&b, &LEANING, &path, 0.0);
    let sideways = LEANING.lateral_velocity;
    assert!((sliding.x + sideways * 0.6f64.sin()).abs() < 1e-15);
    assert!((sliding.y - sideways * 0.6f64.cos()).abs() < 1e-15);
}

/// A steady turn stands still and leans into the turn in every formulation; it mirrors in those
/// that pass the mirror law.
#[test]
fn steady_turns_stand_still() {
    let smooth = Parameters {
        coulomb_friction: 0.0,
        ..Parameters::default().riderless()
    };
    for formulation in Formulation::ALL {
        let b = Bicycle::new(&smooth, formulation);
        let left = steady_turn(&b, 4.0, 0.03);
        let right = steady_turn(&b, 4.0, -0.03);
        let (x, u) = left.expect("a turn");
        let (mirrored, opposite) = right.expect("a turn");
        for rate in derivative(&b, &x, &u).to_array() {
            // the convergence asked for, 1e-12, times slopes of 1e3
            assert!(rate.abs() < 1e-8, "{formulation:?} {rate:e}");
        }
        assert!(x.roll < 0.0 && x.roll > -0.3, "{formulation:?} {x:?}");
        assert_eq!((x.steer, x.steer_rate, x.roll_rate), (0.03, 0.0, 0.0));
        // as printed, (9) has an arm that does not mirror
        if !matches!(formulation, Formulation::Printed | Formulation::Minimal) {
            assert!((x.roll + mirrored.roll).abs() < 1e-12);
            assert!((u.steer_torque + opposite.steer_torque).abs() < 1e-10);
        }
    }
}

/// Without slip the turn is linear: Meijaard et al. 2007, (5.3) with all rates zero.
#[test]
fn the_steady_turn_of_the_benchmark_is_in_closed_form() {
    let p = crate::published::benchmark_bicycle();
    let b = Bicycle::new(&p, Formulation::Whipple);
    let (v, steer) = (5.0, 0.05);
    let (x, u) = steady_turn(&b, v, steer).expect("a turn");
    let four = b.four_bodies.expect("four bodies");
    let k =
        |i: usize, j: usize| p.gravity * four.stiffness[i][j] + v * v * four.speed_stiffness[i][j];
    let delta = -steer;
    let roll = -k(0, 1) * delta / k(0, 0);
    let torque = -(k(1, 0) * roll + k(1, 1) * delta);
    assert!((x.roll - roll).abs() < 1e-14, "{} {roll}", x.roll);
    // 1e-14 of terms of 50 N m
    assert!(
        (u.steer_torque - torque).abs() < 1e-12,
        "{} {torque}",
        u.steer_torque
    );
}
