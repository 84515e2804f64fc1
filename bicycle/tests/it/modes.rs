//! Modes by name: published numbers, and names that do not depend on how they were asked for.

use crate::published::{benchmark, benchmark_bicycle, delft, on_even_tyres, riderless};
use bicycle::linear::{apart, eigenvalues, state_equations};
use bicycle::modes::{Mode, Root, crossings, over_speeds, over_values, stable_speeds};
use bicycle::{Bicycle, Formulation, Input, Parameters, State};
use nalgebra::Complex;

fn speeds(from: f64, to: f64, count: usize) -> Vec<f64> {
    (0..=count)
        .map(|i| from + (to - from) * i as f64 / count as f64)
        .collect()
}

fn of_mode(roots: &[Root], mode: Mode) -> Vec<Complex<f64>> {
    let of_mode = roots.iter().filter(|root| root.mode == mode);
    of_mode.map(|root| root.value).collect()
}

/// Riderless and ridden, upright and with unusual laws.
fn bicycles() -> [Parameters; 5] {
    let nominal = Parameters::default();
    [
        nominal,
        nominal.riderless(),
        benchmark_bicycle(),
        // the motor's steer-into-lean law of the Delft bicycle
        Parameters {
            viscous_friction: 0.2,
            rider_roll_rate_gain: 13.256,
            rider_roll_rate_gain_slope: -2.132,
            ..riderless(&delft())
        },
        Parameters {
            rear_load: 30.0,
            trail: -0.035,
            ..nominal
        },
    ]
}

#[test]
fn the_benchmark_has_its_published_modes() {
    let file = benchmark();
    let b = Bicycle::new(&benchmark_bicycle(), Formulation::Whipple);
    let speeds = speeds(0.0, 10.0, 10);
    for (speed, roots) in speeds.iter().zip(over_speeds(&b, &speeds)) {
        let published = &file["eigenvalues"][speed.to_string()];
        let mut expected: Vec<Complex<f64>> = published
            .as_array()
            .expect("a list")
            .iter()
            .map(|pair| {
                let part = |i: usize| pair[i].as_f64().expect("a number");
                Complex::new(part(0), part(1))
            })
            .collect();
        // Meijaard et al. 2007, Fig. 3 and Table 2: castering decays fastest at every speed,
        // capsize is the real one left over; weave is real below .68 m/s, where it is unstable
        expected.sort_by(|a, b| b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im)));
        let castering = expected.pop().expect("four");
        let capsize = if *speed == 0.0 {
            expected.pop().expect("three")
        } else {
            let real = expected.iter().position(|v| v.im.abs() < 1e-30);
            expected.remove(real.expect("capsize is real"))
        };
        for (mode, expected) in [
            (Mode::Weave, expected),
            (Mode::Capsize, vec![capsize]),
            (Mode::Castering, vec![castering]),
        ] {
            let found = of_mode(&roots, mode);
            assert_eq!(
                found.len(),
                expected.len(),
                "{mode:?} at {speed}: {roots:?}"
            );
            for (found, expected) in found.iter().zip(&expected) {
                // round-off of a 4 × 4 eigenvalue problem with entries of 1e2
                let error = (found - expected).norm();
                assert!(error < 1e-10, "{mode:?} at {speed}: {error:e}");
            }
        }
    }
}

#[test]
fn the_benchmark_has_its_published_speeds() {
    let file = benchmark();
    let b = Bicycle::new(&benchmark_bicycle(), Formulation::Whipple);
    // the ends of the range do not matter as long as the speeds lie between them
    for (slowest, fastest) in [(0.0, 10.0), (4.0, 20.0), (1.3, 6.1)] {
        let found = crossings(&b, slowest, fastest);
        for (found, name) in [(found.weave, "v_weave"), (found.capsize, "v_capsize")] {
            let expected = file[name].as_f64().expect("a number");
            let error = (found.expect("a crossing") - expected).abs();
            // round-off of the eigenvalues over their slope in speed, .04 1/m and more
            assert!(error < 1e-12, "{name}: {error:e}");
        }
    }
    let between = crossings(&b, 4.5, 6.0);
    assert_eq!((between.weave, between.capsize), (None, None));
}

/// The stiffer the tyres, the nearer the weave speed to that without slip. The capsize speed is
/// that of a steady turn with nothing to steer against, and tyres of equal stiffness per load slip
/// equally there: the turn is the same, only yawed.
#[test]
fn stiff_tyres_have_the_speeds_of_no_slip() {
    let speeds = |stiffness: f64, formulation| {
        let p = on_even_tyres(stiffness);
        let found = crossings(&Bicycle::new(&p, formulation), 1.0, 10.0);
        [found.weave, found.capsize].map(|speed| speed.expect("a crossing"))
    };
    let rigid = speeds(1e3, Formulation::Whipple);
    let [coarse, fine] = [1e3, 1e4].map(|stiffness| {
        let slipping = speeds(stiffness, Formulation::WhippleSlip);
        // round-off: eigenvalues of 1e5 1/s beside one whose slope is .04 1/m
        assert!(
            (slipping[1] - rigid[1]).abs() < 1e-7,
            "capsize {slipping:?}"
        );
        slipping[0] - rigid[0]
    });
    // first order in 1/C: a tenth, the second order of 1e-3 beside it
    assert!(
        (coarse / fine - 10.0).abs() < 0.1,
        "weave {coarse:e}, {fine:e}"
    );
}

#[test]
fn names_do_not_depend_on_step_direction_or_ends() {
    let dense = speeds(0.25, 12.0, 470);
    for p in bicycles() {
        for formulation in Formulation::ALL {
            let b = Bicycle::new(&p, formulation);
            let expected = over_speeds(&b, &dense);
            let backwards: Vec<f64> = dense.iter().rev().copied().collect();
            let mut found = over_speeds(&b, &backwards);
            found.reverse();
            assert_eq!(found, expected, "{formulation:?} backwards");
            for stride in [7, 47, 235] {
                let coarse: Vec<f64> = dense.iter().step_by(stride).copied().collect();
                let found = over_speeds(&b, &coarse);
                let expected = expected.iter().step_by(stride);
                for ((speed, found), expected) in coarse.iter().zip(&found).zip(expected) {
                    assert_eq!(found, expected, "{formulation:?} {p:?} {speed} of {stride}");
                }
            }
            let last = *dense.last().expect("not empty");
            let alone = over_speeds(&b, &[last]);
            assert_eq!(alone[0], expected[dense.len() - 1], "{formulation:?} alone");
        }
    }
}

/// Names are given to the eigenvalues of the linear system, all of them, and nothing else.
#[test]
fn every_eigenvalue_has_a_name() {
    for p in bicycles() {
        for formulation in Formulation::ALL {
            let b = Bicycle::new(&p, formulation);
            let speeds = [0.5, 2.0, 4.0, 9.0];
            for (speed, mut roots) in speeds.into_iter().zip(over_speeds(&b, &speeds)) {
                let parts = apart(&p, formulation, speed);
                let mut a = parts.state;
                if let Some(mut yaw) = a.column_iter_mut().nth(4) {
                    yaw.axpy(p.wheelbase / speed, &parts.path_angle, 1.0);
                }
                let expected = eigenvalues(&a);
                roots.sort_by(|a, b| {
                    let (a, b) = (a.value, b.value);
                    b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im))
                });
                assert_eq!(roots.len(), expected.len());
                for (root, expected) in roots.iter().zip(expected) {
                    // round-off of two orders of summing up, against entries of 1e3
                    let error = (root.value - expected).norm();
                    assert!(
                        error < 1e-8 * (1.0 + expected.norm()),
                        "{formulation:?} {speed}"
                    );
                }
            }
        }
    }
}

/// Of the nominal bicycle on tyres that relax, the modes are those without slip and two pairs:
/// one swings the steering at 6–10 Hz, which riders know as wobble (Plöchl et al. 2012), one the
/// rear wheel.
#[test]
fn slipping_tyres_add_wobble() {
    let riderless = Parameters::default().riderless();
    let speeds = speeds(0.5, 14.0, 27);
    let whipple = over_speeds(&Bicycle::new(&riderless, Formulation::Whipple), &speeds);
    let slip = over_speeds(&Bicycle::new(&riderless, Formulation::WhippleSlip), &speeds);
    for ((speed, whipple), slip) in speeds.iter().zip(&whipple).zip(&slip) {
        for mode in [Mode::Weave, Mode::Capsize, Mode::Castering] {
            let (rigid, slipping) = (of_mode(whipple, mode), of_mode(slip, mode));
            assert_eq!(rigid.len(), slipping.len(), "{mode:?} at {speed}");
        }
        let wobble = of_mode(slip, Mode::Wobble);
        assert_eq!(wobble.len(), 2, "{slip:?}");
        let frequency = wobble[0].im / std::f64::consts::TAU;
        assert!(
            (6.0..10.0).contains(&frequency),
            "{frequency} Hz at {speed}"
        );
        assert_eq!(of_mode(slip, Mode::Tyre).len(), 2);
    }
    let stiff = Parameters {
        relaxation_length: 0.0,
        ..riderless
    };
    let b = Bicycle::new(&stiff, Formulation::WhippleSlip);
    let roots = &over_speeds(&b, &[3.0])[0];
    assert_eq!(of_mode(roots, Mode::Tyre).len(), 2, "{roots:?}");
    assert!(of_mode(roots, Mode::Wobble).is_empty());
}

/// The yaw rate of the paper's equations is what its tyre adds; faster, it joins the castering
/// to the wobble.
#[test]
fn the_yaw_pole_joins_castering_to_wobble() {
    use Mode::{Capsize, Castering, Tyre, Weave, Wobble};
    let b = Bicycle::new(&Parameters::default().riderless(), Formulation::Repaired);
    let rows = over_speeds(&b, &[1.0, 6.0]);
    let modes = |roots: &[Root]| roots.iter().map(|root| root.mode).collect::<Vec<_>>();
    assert_eq!(modes(&rows[0]), [Weave, Weave, Capsize, Castering, Tyre]);
    assert_eq!(modes(&rows[1]), [Weave, Weave, Capsize, Wobble, Wobble]);
}

#[test]
fn what_has_no_linear_system_has_no_eigenvalues() {
    let p = Parameters::default().riderless();
    for formulation in [Formulation::Repaired, Formulation::WhippleSlip] {
        let b = Bicycle::new(&p, formulation);
        let roots = &over_speeds(&b, &[0.0])[0];
        assert_eq!(roots.len(), b.order());
        assert!(roots.iter().all(|root| root.value.re.is_nan()), "{roots:?}");
    }
}

/// At riding speed the swing is weave and the slow mode capsize at every trail, though slow
/// bicycles lose their weave pair on the way from trail to no trail, about 5 mm.
#[test]
fn riding_speed_has_its_weave_at_every_trail() {
    for millimetres in -30..150 {
        let p = Parameters {
            trail: 1e-3 * f64::from(millimetres),
            ..Parameters::default().riderless()
        };
        for formulation in [Formulation::Whipple, Formulation::WhippleSlip] {
            let roots = &over_speeds(&Bicycle::new(&p, formulation), &[6.0])[0];
            let (weave, capsize) = (of_mode(roots, Mode::Weave), of_mode(roots, Mode::Capsize));
            assert_eq!(weave.len(), 2, "{millimetres} mm: {roots:?}");
            assert!(weave[0].im > 1.0, "{millimetres} mm: {roots:?}");
            assert!(capsize[0].im == 0.0, "{millimetres} mm: {roots:?}");
        }
    }
}

/// Between weave and capsize speed every mode of the benchmark decays, and nowhere else.
#[test]
fn stable_speeds_lie_between_weave_and_capsize() {
    let b = Bicycle::new(&benchmark_bicycle(), Formulation::Whipple);
    let [[from, to]] = stable_speeds(&b, 0.0, 10.0)[..] else {
        panic!("one range")
    };
    // Meijaard et al. 2007, to the digits that double precision has
    assert!((from - 4.292382536341104).abs() < 1e-12, "{from}");
    assert!((to - 6.024262015388359).abs() < 1e-12, "{to}");
    assert_eq!(stable_speeds(&b, 0.0, 4.0), Vec::<[f64; 2]>::new());
    assert_eq!(stable_speeds(&b, 5.0, 6.0), [[5.0, 6.0]]);
}

/// A steady turn knows no relaxation: the capsize speed, where A is singular, is the same whatever
/// the relaxation length, and A changes the sign of its determinant there.
#[test]
fn capsize_is_where_the_determinant_vanishes() {
    let at = |relaxation_length: f64| {
        let p = Parameters {
            relaxation_length,
            ..benchmark_bicycle()
        };
        let b = Bicycle::new(&p, Formulation::WhippleSlip);
        (b, crossings(&b, 1.0, 10.0).capsize.expect("a crossing"))
    };
    let (_, without) = at(0.0);
    for relaxation_length in [0.175, 0.01, 1e-3] {
        let (b, speed) = at(relaxation_length);
        let determinant = |speed: f64| {
            let u = Input {
                speed,
                ..Input::ZERO
            };
            state_equations(&b, &State::ZERO, &u).0.determinant()
        };
        // round-off of eigenvalues up to v/σ beside one whose slope over speed is .04 1/m
        let slack = 1e-14 * speed / relaxation_length / 0.04 * 10.0;
        assert!(
            (speed - without).abs() < 1e-9 + slack,
            "{relaxation_length}: {speed}"
        );
        assert!(determinant(speed - slack - 1e-9) * determinant(speed + slack + 1e-9) < 0.0);
    }
}

/// A pair has one name.
#[test]
fn both_members_of_a_pair_have_its_name() {
    for formulation in Formulation::ALL {
        for trail in [-0.035, 0.13] {
            let p = Parameters {
                trail,
                ..Parameters::default()
            };
            for roots in over_speeds(&Bicycle::new(&p, formulation), &[0.5, 2.0, 5.0]) {
                for root in roots.iter().filter(|root| root.value.im > 0.0) {
                    let partner = roots.iter().find(|r| r.value == root.value.conj());
                    assert_eq!(partner.map(|r| r.mode), Some(root.mode), "{formulation:?}");
                }
            }
        }
    }
}

/// Over a row names are carried from the bicycle's own value: neither order nor step of the values
/// changes one, and where nothing is in doubt they are those that speed gives.
#[test]
fn names_over_a_row_do_not_depend_on_how_it_is_swept() {
    let loads: Vec<f64> = (0..=6).map(|i| 5.0 * f64::from(i)).collect();
    let speeds = [8.0 / 3.6, 5.0];
    for formulation in [
        Formulation::Repaired,
        Formulation::Whipple,
        Formulation::WhippleSlip,
    ] {
        let b = |rear_load: f64| {
            let p = Parameters {
                rear_load,
                ..Parameters::default()
            };
            Bicycle::new(&p, formulation)
        };
        let up = over_values(&b, 0.0, &loads, &speeds);
        let backwards: Vec<f64> = loads.iter().rev().copied().collect();
        let mut down = over_values(&b, 0.0, &backwards, &speeds);
        down.reverse();
        assert_eq!(up, down, "{formulation:?}");
        assert_eq!(
            over_values(&b, 0.0, &[30.0], &speeds)[0],
            up[6],
            "{formulation:?}"
        );
        assert_eq!(up[0], over_speeds(&b(0.0), &speeds), "{formulation:?}");
    }
}

/// A relaxation length of 0 takes two states away: names are given anew there.
#[test]
fn a_row_may_change_the_number_of_states() {
    let b = |relaxation_length: f64| {
        let p = Parameters {
            relaxation_length,
            ..Parameters::default()
        };
        Bicycle::new(&p, Formulation::WhippleSlip)
    };
    let found = over_values(&b, 0.175, &[0.0, 0.1, 0.2], &[3.0]);
    let counts: Vec<_> = found.iter().map(|rows| rows[0].len()).collect();
    assert_eq!(counts, [6, 8, 8]);
}
