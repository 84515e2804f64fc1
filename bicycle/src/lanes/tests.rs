use super::*;
use std::f64::consts::FRAC_PI_2;

/// How far `found` is from `exact`, in units of the last place of `exact`.
fn ulps(found: f64, exact: f64) -> f64 {
    let size = exact.abs().max(f64::MIN_POSITIVE);
    (found - exact).abs() / (size.next_up() - size)
}

/// Largest distance of `f` from `exact` over `points`, four at a time.
fn worst(
    points: impl Iterator<Item = f64>,
    f: impl Fn(Lanes<4>) -> Lanes<4>,
    exact: impl Fn(f64) -> f64,
) -> f64 {
    let points: Vec<f64> = points.collect();
    let distance = |four: &[f64]| {
        let found = f(Lanes::from_fn(|i| four[i]));
        (0..4)
            .map(|i| ulps(found.0[i], exact(four[i])))
            .fold(0.0, f64::max)
    };
    points.chunks_exact(4).map(distance).fold(0.0, f64::max)
}

/// A million points between ± `reach`, no multiple of anything.
fn dense(reach: f64) -> impl Iterator<Item = f64> {
    (0..1_000_000).map(move |i| reach * (f64::from(i) * 2.0000013e-6 - 1.0))
}

// The yardstick is libm, itself within 1 ulp: a found 2 means 1.5 at worst plus its half.
const ULPS: f64 = 2.0;

#[test]
fn sine_and_cosine_are_those_of_libm() {
    for reach in [0.1, 1.0, 10.0, 1e3, 1e6] {
        let sin = worst(dense(reach), Real::sin, libm::sin);
        let cos = worst(dense(reach), Real::cos, libm::cos);
        assert!(sin <= ULPS, "sine: {sin} ulp within {reach}");
        assert!(cos <= ULPS, "cosine: {cos} ulp within {reach}");
    }
}

#[test]
fn next_to_multiples_of_a_right_angle_the_error_is_that_of_ulps_of_one() {
    // within 1e-7 of a zero the rest of π/2 is cut at its 106th bit, which 500 turns make 1e-29:
    // nothing beside the 1e-16 of a right answer near 1
    let near = |i: u32| (f64::from(i / 40) - 500.0) * FRAC_PI_2 + (f64::from(i % 40) - 20.0) * 3e-9;
    for i in (0..40_000).step_by(4) {
        let four = Lanes::<4>::from_fn(|k| near(i + k as u32));
        let (sin, cos) = four.sin_cos();
        for k in 0..4 {
            let (s, c) = libm::sincos(four.0[k]);
            assert!(
                (sin.0[k] - s).abs() <= f64::EPSILON,
                "sine of {}",
                four.0[k]
            );
            assert!(
                (cos.0[k] - c).abs() <= f64::EPSILON,
                "cosine of {}",
                four.0[k]
            );
        }
    }
}

#[test]
fn arctangent_is_that_of_libm() {
    for reach in [0.1, 0.45, 3.0, 100.0, 1e12] {
        let atan = worst(dense(reach), Real::atan, libm::atan);
        assert!(atan <= ULPS, "{atan} ulp within {reach}");
    }
    let edges = [TAN_PI_8, TAN_3_PI_8].map(|x| [x.next_down(), x, x.next_up(), -x]);
    let atan = worst(edges.into_iter().flatten(), Real::atan, libm::atan);
    assert!(atan <= ULPS, "{atan} ulp at the edges");
}

#[test]
fn what_is_no_number_stays_none() {
    let odd = Lanes([f64::NAN, f64::INFINITY, 0.0, -0.0]);
    let (sin, cos) = odd.sin_cos();
    assert!(sin.0[0].is_nan() && cos.0[1].is_nan());
    assert_eq!((sin.0[2], cos.0[2]), (0.0, 1.0));
    let atan = odd.atan();
    assert!(atan.0[0].is_nan());
    assert_eq!(atan.0[1], FRAC_PI_2);
    assert!(atan.0[3].is_sign_negative());
    assert!(!odd.all_small(f64::INFINITY));
    let picked = odd.pick_small(1.0, Lanes::from(1.0), Lanes::from(2.0));
    assert_eq!(picked, Lanes([2.0, 2.0, 1.0, 1.0]));
}
