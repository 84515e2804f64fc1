//! Bodies to lumps, against published numbers.

use crate::draw;
use crate::published::{self, benchmark, literature};
use bicycle::mass::{self, Body, Lumps, loaded};
use bicycle::{Bicycle, Formulation, Parameters};
use expect_test::expect;
use proptest::prelude::*;
use std::fmt::Write;

/// The paper's bicycle, a rider of 75 kg and 1.78 m and a box on the carrier.
#[test]
fn rear_load_moves_the_lumps() {
    let mut table = String::new();
    for rear_load in [0.0, 10.0, 20.0, 30.0] {
        let p = Parameters {
            rear_load,
            ..Parameters::default()
        };
        let b = Bicycle::new(&p, Formulation::Repaired);
        let m = b.lumps;
        writeln!(
            table,
            "{rear_load:2} kg: M {:.1}, L_1 {:.3}, h {:.3}, I_xx {:.1}, I_zz {:.2}, I_xz {:.2}, \
             F_z {:.0}/{:.0}",
            m.total_mass,
            m.cog_to_rear,
            m.cog_height,
            m.roll_inertia,
            m.yaw_inertia,
            m.cross_inertia,
            b.front_load,
            m.total_mass * p.gravity - b.front_load,
        )
        .expect("a string");
    }
    expect![[r"
         0 kg: M 92.5, L_1 0.339, h 0.968, I_xx 100.5, I_zz 16.75, I_xz 27.32, F_z 303/604
        10 kg: M 102.5, L_1 0.304, h 0.952, I_xx 107.0, I_zz 16.96, I_xz 27.16, F_z 301/704
        20 kg: M 112.5, L_1 0.275, h 0.938, I_xx 113.5, I_zz 17.17, I_xz 27.00, F_z 299/804
        30 kg: M 122.5, L_1 0.251, h 0.927, I_xx 120.1, I_zz 17.39, I_xz 26.84, F_z 297/904
    "]]
    .assert_eq(&table);
}

proptest! {
    #[test]
    fn no_load_changes_no_bit(p in draw::parameters()) {
        let p = Parameters { rear_load: 0.0, ..p };
        prop_assert_eq!(loaded(&p), p.lumps());
    }
}

/// Σm, Σm x, Σm h: the load in closed form against the load as one more body.
#[test]
fn a_load_is_one_more_body() {
    let p = Parameters {
        rear_load: 23.0,
        rear_load_x: -0.1,
        rear_load_h: 0.7,
        rear_load_roll_gyration: 0.2,
        rear_load_yaw_gyration: 0.3,
        ..Parameters::default()
    };
    let load = Body {
        mass: 23.0,
        x: -0.1,
        h: 0.7,
        roll_inertia: 23.0 * 0.2 * 0.2,
        yaw_inertia: 23.0 * 0.3 * 0.3,
        cross_inertia: 0.0,
    };
    assert_close(&loaded(&p), &mass::compose(&[p.lumps().body(), load]));
}

#[test]
fn moved_keeps_the_inertias_about_the_centre_of_mass() {
    let lumps = Parameters::<f64>::default().lumps();
    let moved = lumps.moved(0.52, 1.1);
    assert_eq!(
        (moved.total_mass, moved.cog_to_rear, moved.cog_height),
        (lumps.total_mass, 0.52, 1.1)
    );
    let (before, after) = (lumps.body(), moved.body());
    for (a, b) in [
        (before.roll_inertia, after.roll_inertia),
        (before.yaw_inertia, after.yaw_inertia),
        (before.cross_inertia, after.cross_inertia),
    ] {
        // I − m h² + m h²: rounding of the larger, 112 kg m²
        assert!((a - b).abs() < 4.0 * f64::EPSILON * 112.0, "{a} {b}");
    }
    assert_close(&lumps.moved(lumps.cog_to_rear, lumps.cog_height), &lumps);
}

#[test]
fn a_rider_scales_with_mass_and_height_squared() {
    let (one, other) = (mass::rider(75.0, 1.78), mass::rider(60.0, 1.60));
    let scale = 60.0 / 75.0 * (1.60f64 / 1.78).powi(2);
    // products in another order
    assert!((other.roll_inertia - one.roll_inertia * scale).abs() < 1e-14);
    assert!((other.h - (0.62 + 0.47 * 1.60 / 1.83)).abs() < 1e-15);
}

fn assert_close(found: &Lumps, expected: &Lumps) {
    let both = |l: &Lumps| {
        [
            l.total_mass,
            l.cog_to_rear,
            l.cog_height,
            l.roll_inertia,
            l.yaw_inertia,
            l.cross_inertia,
        ]
    };
    for (a, b) in both(found).into_iter().zip(both(expected)) {
        // sums of three terms in another order
        assert!(
            (a - b).abs() < 1e-14 * b.abs().max(1.0),
            "{found:?} {expected:?}"
        );
    }
}

#[test]
fn the_benchmark_bicycle_has_its_published_lumps() {
    let file = benchmark();
    let number = |group: &str, name: &str| {
        let value = file[group][name].as_f64();
        value.unwrap_or_else(|| panic!("{group}.{name}"))
    };
    let bicycle = literature(|name| number("parameters", name));
    let mut p = Parameters::default();
    bicycle.write(&mut p, &[]);
    for (found, name, sign) in [
        (p.total_mass, "mT", 1.0),
        (p.cog_to_rear, "xT", 1.0),
        (p.cog_height, "zT", -1.0),
        (p.roll_inertia, "ITxx", 1.0),
        (p.yaw_inertia, "ITzz", 1.0),
        (p.cross_inertia, "ITxz", 1.0),
        (p.steer_inertia, "IAll", 1.0),
        (p.front_wheel_inertia / p.front_wheel_radius, "SF", 1.0),
        (p.rear_wheel_inertia / p.rear_wheel_radius, "SR", 1.0),
    ] {
        let expected = sign * number("derived", name);
        // the file is computed at 40 digits; ours are sums of a few rounded products
        assert!(
            (found - expected).abs() < 1e-12 * expected.abs(),
            "{name}: expected {expected}, found {found}"
        );
    }
    assert_eq!((p.wheelbase, p.trail), (1.02, 0.08));
}

/// The steer-by-wire bicycle of Delft (`mechmotum/sbw_bicycle_with_model_matching`).
#[test]
fn the_delft_bicycle_has_its_inertias() {
    let bicycle = published::delft();
    // M11 of its mass matrix, to five decimals
    let lumps = mass::compose(&bicycle.bodies());
    assert!((lumps.roll_inertia - 13.66926).abs() < 5e-6);
    // M22 body by body about the steer axis, which meets the ground at w + c
    let (sin, cos) = bicycle.lam.sin_cos();
    let about_the_axis = |b: Body| {
        let arm = (b.x - bicycle.w - bicycle.c) * cos + b.h * sin;
        let turned = b.roll_inertia * sin * sin + b.yaw_inertia * cos * cos;
        b.mass * arm * arm + turned + 2.0 * b.cross_inertia * sin * cos
    };
    let [_, _, frame, wheel] = bicycle.bodies();
    let expected = about_the_axis(frame) + about_the_axis(wheel);
    // the same sums in another order
    let mut p = Parameters::default();
    bicycle.write(&mut p, &[]);
    assert!((p.steer_inertia - expected).abs() < 1e-14);
    assert!((expected - 0.07090).abs() < 5e-6, "{expected}");
}

#[test]
fn riders_come_on_top_of_the_25_parameters() {
    let file = benchmark();
    let bicycle = literature(|name| file["parameters"][name].as_f64().expect("a number"));
    let rider = mass::rider(75.0, 1.78);
    let mut p = Parameters::default();
    bicycle.write(&mut p, &[rider]);
    assert_close(
        &p.lumps(),
        &mass::compose(&[mass::compose(&bicycle.bodies()).body(), rider]),
    );
}
