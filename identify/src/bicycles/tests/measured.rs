//! The measured bicycles against the numbers they come from, and matter that cannot be.

use super::*;

/// The measured bicycles of `BicycleParameters`, as numbers there: name of the set, and the 25.
fn measured() -> Vec<(String, serde_json::Value)> {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../tests/data/measured_bicycles.json"
    );
    let file: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let bicycles = file["bicycles"].as_object().unwrap();
    bicycles
        .iter()
        .map(|(name, values)| (name.to_lowercase().replace('+', "-"), values.clone()))
        .collect()
}

#[test]
fn measured_bicycles_have_the_measured_lumps() {
    let measured = measured();
    assert_eq!(measured.len(), 9);
    for (name, values) in measured {
        let value = |key: &str| values[key].as_f64().unwrap();
        let p = open(&name).parameters;
        // Meijaard et al. 2007, (A 1)–(A 5): mass, x, −z, I_xx, I_zz, I_xz of each body
        let bodies = [
            ["mR", "", "rR", "IRxx", "IRxx", ""],
            ["mB", "xB", "zB", "IBxx", "IBzz", "IBxz"],
            ["mH", "xH", "zH", "IHxx", "IHzz", "IHxz"],
            ["mF", "w", "rF", "IFxx", "IFxx", ""],
        ]
        .map(|keys| keys.map(|key| if key.is_empty() { 0.0 } else { value(key) }));
        let sum = |of: &dyn Fn([f64; 6]) -> f64| bodies.into_iter().map(of).sum::<f64>();
        let mass = sum(&|[m, ..]| m);
        for (row, found, expected) in [
            ("total_mass", p.total_mass, mass),
            (
                "cog_to_rear",
                p.cog_to_rear,
                sum(&|[m, x, ..]| m * x) / mass,
            ),
            (
                "cog_height",
                p.cog_height,
                sum(&|[m, _, z, ..]| m * z.abs()) / mass,
            ),
            (
                "roll_inertia",
                p.roll_inertia,
                sum(&|[m, _, z, xx, ..]| xx + m * z * z),
            ),
            (
                "yaw_inertia",
                p.yaw_inertia,
                sum(&|[m, x, _, _, zz, _]| zz + m * x * x),
            ),
            (
                "cross_inertia",
                p.cross_inertia,
                sum(&|[m, x, z, _, _, xz]| xz + m * x * z.abs()),
            ),
            ("wheelbase", p.wheelbase, value("w")),
            ("trail", p.trail, value("c")),
            ("caster_angle", p.caster_angle, value("lam")),
            ("rear_wheel_radius", p.rear_wheel_radius, value("rR")),
            ("front_wheel_radius", p.front_wheel_radius, value("rF")),
            ("rear_wheel_inertia", p.rear_wheel_inertia, value("IRyy")),
            ("front_wheel_inertia", p.front_wheel_inertia, value("IFyy")),
            ("gravity", p.gravity, value("g")),
            (
                "front_assembly_mass",
                p.front_assembly_mass,
                value("mH") + value("mF"),
            ),
        ] {
            // two orders of four terms: round-off only
            assert!(
                (found / expected - 1.0).abs() < 1e-13,
                "{name}: {row} {found}, measured {expected}"
            );
        }
    }
}

#[test]
fn measured_bicycles_ride_with_four_bodies() {
    for (name, _) in measured() {
        let bicycle = open(&name);
        assert_eq!(bicycle.formulation, Formulation::Whipple);
        for formulation in [Formulation::Whipple, Formulation::WhippleSlip] {
            let four = bicycle::Bicycle::new(&bicycle.parameters, formulation)
                .four_bodies
                .unwrap();
            let [[xx, xy], [yx, yy]] = four.mass;
            assert!(xx > 0.0 && xx * yy > xy * yx, "{name}: {:?}", four.mass);
            bicycle::simulate::Simulation::new(
                &bicycle.parameters,
                formulation,
                bicycle.input,
                0.0,
            )
            .unwrap();
        }
        // riders are in the two that are named after them, and on the others one can be put
        let rider = Changes {
            rider: Some("75kg,1.78m".into()),
            load: Some("20kg".into()),
            ..Changes::default()
        };
        let ridden = Bicycle::open(&name, &rider);
        assert_eq!(ridden.is_err(), name.contains('-'), "{name}");
    }
}

#[test]
fn measured_riders_hold_their_bicycles() {
    for name in ["browser-jason", "rigidcl-luke"] {
        let bicycle = open(name);
        for formulation in [Formulation::Whipple, Formulation::WhippleSlip] {
            let growth = bicycle::linear::fastest_growth(
                &bicycle.parameters,
                formulation,
                bicycle.input.speed,
            );
            assert!(growth.re < 0.0, "{name}, {}: {growth}", formulation.name());
        }
    }
}

#[test]
fn a_body_that_cannot_be_is_named() {
    let text = SHIPPED
        .iter()
        .find(|(name, _)| *name == "browser")
        .unwrap()
        .1;
    for (key, value, expected) in [
        (
            "mR",
            "-3.11",
            "a rear wheel of positive mass and positive definite inertia, found -3.110 kg",
        ),
        (
            "IBxz",
            "0.7",
            "a rear frame of positive mass and positive definite inertia, found 9.860 kg and 0.530 (xx), 0.757 (zz), 0.700 (xz)",
        ),
        ("IHzz", "-0.1", "a front frame of positive mass"),
        ("IFxx", "0", "a front wheel of positive mass"),
    ] {
        let changed: String = text
            .lines()
            .map(|line| match line.split_once(" = ") {
                Some((name, _)) if name == key => format!("{key} = {value}\n"),
                _ => format!("{line}\n"),
            })
            .collect();
        let error = Bicycle::parse("my.toml", &changed, &Changes::default()).unwrap_err();
        let words = error.to_string();
        let start = format!("my.toml: [bodies.literature]: expected {expected}");
        assert!(words.starts_with(&start), "{words}");
    }
}

#[test]
fn a_load_far_behind_is_said_then_refused() {
    let with = |load: &str| {
        let changes = Changes {
            load: Some(load.into()),
            ..set(&["rear_load_x=-0.9"])
        };
        Bicycle::open("nominal", &changes)
    };
    assert_eq!(with("20kg").unwrap().notes, Vec::<String>::new());
    // L₁ = (92.5 · .339 − 31 · .9)/123.5 = .028 m: 2.8 % of the wheelbase
    assert_eq!(
        with("31kg").unwrap().notes,
        ["the front wheel carries 2.8 % of the weight (34 N): little is left to steer with"]
    );
    let error = with("36kg").unwrap_err();
    assert!(error.is_typed());
    let words = error.to_string();
    assert!(
        words.starts_with(
            "--load 36kg --set rear_load_x=-0.9: expected a front wheel on the ground, found a \
             front load of -"
        ),
        "{words}"
    );
}
