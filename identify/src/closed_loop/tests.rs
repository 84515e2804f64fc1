#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
use super::*;
use crate::spectrum::{Analysis, Kernel, Recipe};
use bicycle::State;
use nalgebra::Complex;

/// The two loops of the fits: a rider who only leans, and the nominal one; the four-body bicycles
/// with all orders that they have.
fn loops() -> Vec<(Parameters, Formulation)> {
    let leaning = Parameters::default().steered_by_roll(150.0, 60.0);
    let unsmoothed = Parameters {
        steer_smoothing: 0.0,
        steer_rate_smoothing: 0.0,
        ..leaning
    };
    let at_once = Parameters {
        relaxation_length: 0.0,
        ..Parameters::default()
    };
    vec![
        (leaning, Formulation::Repaired),
        (unsmoothed, Formulation::Repaired),
        (Parameters::default(), Formulation::Repaired),
        (Parameters::default(), Formulation::Whipple),
        (Parameters::default(), Formulation::WhippleSlip),
        (at_once, Formulation::WhippleSlip),
    ]
}

fn drive(speed: f64, intensity: f64, lines: &[LineMotion]) -> Drive {
    Drive {
        speed,
        remnant_intensity: intensity,
        remnant_corner: 2.0,
        lines: lines.to_vec(),
    }
}

const LINES: [LineMotion; 2] = [
    LineMotion {
        frequency: 1.11,
        steer_amplitude: 0.05,
    },
    LineMotion {
        frequency: 0.6,
        steer_amplitude: 0.02,
    },
];

/// Kernel of an 8 s ride at 50 Hz.
fn kernel() -> Kernel {
    let recipe = Recipe {
        average: 2.0,
        ..Recipe::default()
    };
    Analysis::new(&recipe, 0.02, 400).unwrap().kernel()
}

/// (2πif − A)⁻¹ B, one frequency at a time.
fn solved(a: &DMatrix<f64>, b: &DVector<f64>, f: f64) -> DVector<Complex<f64>> {
    let mut m = a.map(|v| Complex::from(-v));
    for i in 0..m.nrows() {
        m[(i, i)] += Complex::new(0.0, TAU * f);
    }
    m.lu().solve(&b.map(Complex::from)).unwrap()
}

/// The fixed point by nothing but passes, until they change it by their round-off alone.
fn by_passes(closed_loop: &ClosedLoop) -> DMatrix<f64> {
    let ClosedLoop { gains, drive, .. } = closed_loop;
    let n = gains.parts.state.nrows();
    let mut p = DMatrix::zeros(n, n);
    p[(STEER_RATE, STEER_RATE)] = 0.09;
    p[(STEER, STEER)] = 1e-6;
    for _ in 0..200 {
        p = Pass::new(gains, drive, &p).unwrap().covariance;
    }
    p
}

/// The round-off of a pass is some 5e-13.
#[test]
fn newtons_method_arrives_where_the_passes_do() {
    for (parameters, formulation) in loops() {
        for (intensity, lines) in [(0.1, &[][..]), (1.2, &[]), (1.2, &LINES), (8.0, &[])] {
            let drive = drive(2.2, intensity, lines);
            let closed_loop = ClosedLoop::new(&parameters, formulation, &drive).unwrap();
            let p = by_passes(&closed_loop);
            // in units of the deviations
            let scale =
                DMatrix::from_fn(p.nrows(), p.nrows(), |i, j| (p[(i, i)] * p[(j, j)]).sqrt());
            let off = (&p - &closed_loop.covariance).component_div(&scale).amax();
            assert!(off < 2e-12, "{formulation:?} {intensity} N m: {off:.1e}");
        }
    }
}

#[test]
fn the_stationary_covariance_solves_lyapunov() {
    for (parameters, formulation) in loops() {
        let closed_loop = ClosedLoop::new(&parameters, formulation, &drive(2.2, 1.0, &[])).unwrap();
        let (a, b) = (&closed_loop.state, torque(&closed_loop.gains));
        let n = a.nrows();
        // the noise as one more state: A₊ P₊ + P₊ A₊ᵀ + Q = 0
        let mut a_plus = a.clone().resize(n + 1, n + 1, 0.0);
        a_plus.view_mut((0, n), (n, 1)).copy_from(&b);
        a_plus[(n, n)] = -12.0;
        let p = Stationary::new(a, &b, 12.0).unwrap();
        let c = (a - DMatrix::identity(n, n) * 12.0)
            .lu()
            .solve(&-&b)
            .unwrap();
        let mut p_plus = p.covariance.clone().resize(n + 1, n + 1, 0.0);
        p_plus.view_mut((0, n), (n, 1)).copy_from(&c);
        p_plus.view_mut((n, 0), (1, n)).copy_from(&c.transpose());
        p_plus[(n, n)] = 1.0;
        let product = &a_plus * &p_plus;
        let mut rest = &product + product.transpose();
        rest[(n, n)] += 24.0;
        // in units of the deviations and of the fastest rate
        let deviation = p_plus.diagonal().map(f64::sqrt);
        let rate = (0..=n)
            .flat_map(|i| (0..=n).map(move |j| (i, j)))
            .map(|(i, j)| (a_plus[(i, j)] * deviation[j] / deviation[i]).abs())
            .fold(0.0, f64::max);
        for (i, j) in entries(n + 1) {
            let off = rest[(i, j)].abs() / (rate * deviation[i] * deviation[j]);
            assert!(off < 1e-12, "{formulation:?} {i} {j}: {off:.1e}");
        }
    }
}

/// The integral over all frequencies of the response's power is the covariance: two ways that
/// share nothing but A and B.
#[test]
fn the_density_integrates_to_the_covariance() {
    let (parameters, formulation) = loops()[0];
    let closed_loop = ClosedLoop::new(&parameters, formulation, &drive(2.2, 1.2, &[])).unwrap();
    let b = torque(&closed_loop.gains);
    let rate = closed_loop.drive.rate();
    let df = 0.005;
    let variance: f64 = (0..20_000)
        .map(|k| {
            let f = (f64::from(k) + 0.5) * df;
            let power = 1.44 * 2.0 * rate / (rate * rate + (TAU * f).powi(2));
            2.0 * df * power * solved(&closed_loop.state, &b, f)[STEER].norm_sqr()
        })
        .sum();
    assert!((variance.sqrt() / closed_loop.steer_deviation() - 1.0).abs() < 1e-6);
}

#[test]
fn the_response_is_that_of_a_solver_at_each_frequency() {
    let omega: Vec<f64> = (0..201).map(|k| TAU * 0.025 * f64::from(k)).collect();
    let check = |a: &DMatrix<f64>, b: &DVector<f64>, name: &str| {
        let all = DMatrix::identity(a.nrows(), a.nrows());
        let x = response::response(&all, a, b, &omega);
        for (k, w) in omega.iter().enumerate() {
            let exact = solved(a, b, w / TAU);
            for i in 0..a.nrows() {
                let found = Complex::new(x.re[(k, i)], x.im[(k, i)]);
                let off = (found - exact[i]).norm() / exact.norm();
                assert!(off < 1e-11, "{name}, row {i} at {w} 1/s: {off:.1e}");
            }
        }
    };
    for (parameters, formulation) in loops() {
        let closed_loop = ClosedLoop::new(&parameters, formulation, &drive(2.2, 1.2, &[])).unwrap();
        let units = closed_loop.covariance.diagonal().map(f64::sqrt);
        let a = DMatrix::from_fn(units.len(), units.len(), |i, j| {
            closed_loop.state[(i, j)] * units[j] / units[i]
        });
        let b = torque(&closed_loop.gains).component_div(&units);
        check(&a, &b, formulation.name());
        check(&a.transpose(), &b, formulation.name());
    }
    // one eigenvector for all: a chain of equal lags
    let mut lags = DMatrix::identity(5, 5) * -2.0;
    for i in 1..5 {
        lags[(i, i - 1)] = 3.0;
    }
    let mut first = DVector::zeros(5);
    first[0] = 1.0;
    check(&lags, &first, "defective");
    // and what torque does not reach
    let apart = DMatrix::from_diagonal(&DVector::from_vec(vec![-1.0, -2.0, -2.0, -3.0, -4.0]));
    check(
        &apart,
        &DVector::from_vec(vec![1.0, 1.0, 1.0, 0.0, 0.0]),
        "unreached",
    );
    check(&apart, &(first * 1e-9), "faint");
}

/// Central differences of whole loops over 1e-4 leave 1e-8 of curvature and 1e-9 of round-off.
#[test]
fn the_slopes_are_those_of_whole_loops() {
    const H: f64 = 1e-4;
    let kernel = kernel();
    let named = |name: &str| State::index(name).unwrap();
    for (parameters, formulation) in loops() {
        let channels = match formulation {
            Formulation::Whipple => vec![named("steer"), named("yaw_rate")],
            _ => vec![named("steer"), named("roll_rate"), named("yaw_rate")],
        };
        let noise = vec![1e-3; channels.len()];
        for lines in [&[][..], &LINES] {
            let at = |which: usize, h: f64| {
                let (mut p, mut d) = (parameters, drive(2.2, 1.2, lines));
                match which {
                    0 => p.viscous_friction += h,
                    1 => p.coulomb_friction += h,
                    2 => p.cornering_stiffness *= 1.0 + h,
                    3 => p.wheelbase *= 1.0 + h,
                    4 => p.steer_inertia *= 1.0 + h,
                    5 => d.remnant_intensity *= h.exp(),
                    _ => d.remnant_corner += h,
                }
                (p, d)
            };
            let expected = |(p, d): (Parameters, Drive)| {
                let closed_loop = ClosedLoop::new(&p, formulation, &d).unwrap();
                closed_loop.expected(&kernel, &channels, &noise, 0.02)
            };
            let variables: Vec<_> = (0..7).map(|v| [at(v, -H), at(v, H)]).collect();
            let closed_loop =
                ClosedLoop::new(&parameters, formulation, &drive(2.2, 1.2, lines)).unwrap();
            let expansion = closed_loop
                .expansion(&kernel, &channels, &noise, 0.02, (&variables, 2.0 * H))
                .unwrap();
            for (with, alone) in expansion.expected.iter().zip(expected(at(0, 0.0))) {
                assert!((with - &alone).norm() < 1e-13 * alone.norm());
            }
            for (v, slopes) in expansion.slopes.iter().enumerate() {
                let (down, up) = (expected(at(v, -H)), expected(at(v, H)));
                for (k, slope) in slopes.iter().enumerate() {
                    let difference = (&up[k] - &down[k]) / Complex::from(2.0 * H);
                    let off = (slope - &difference).norm();
                    let size = difference.norm() + 1e-3 * expansion.expected[k].norm();
                    assert!(
                        off < 1e-5 * size,
                        "{formulation:?}, variable {v}, bin {k}: {:.1e}",
                        off / size
                    );
                }
            }
        }
    }
}

#[test]
fn an_unstable_loop_is_named() {
    let error = ClosedLoop::new(
        &Parameters::default().riderless(),
        Formulation::Repaired,
        &drive(2.2, 1.0, &[]),
    )
    .unwrap_err();
    assert!(
        matches!(error, Error::Unstable { growth, .. } if growth > 1.0),
        "{error}"
    );
}
