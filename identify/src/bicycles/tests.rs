#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
mod measured;

use super::*;
use bicycle::mass;

fn open(name: &str) -> Bicycle {
    Bicycle::open(name, &Changes::default()).unwrap()
}

fn set(assignments: &[&str]) -> Changes {
    Changes {
        set: assignments.iter().map(|&s| s.to_owned()).collect(),
        ..Changes::default()
    }
}

/// The message of the file `rest` under a name.
fn message(rest: &str) -> String {
    Bicycle::parse(
        "my.toml",
        &format!("name = 'my'\n{rest}"),
        &Changes::default(),
    )
    .unwrap_err()
    .to_string()
}

const LUMPS: &str = "[lumps]\nabout = 'rear_contact'\ntotal_mass = 92.5\ncog_to_rear = 0.339\n\
    cog_height = '968 mm'\nroll_inertia = 100.5\nyaw_inertia = 16.75\ncross_inertia = 27.32\n";

#[test]
fn nominal_is_the_nominal_column_of_the_table() {
    let nominal = open("nominal");
    assert_eq!(nominal.parameters, Parameters::default());
    assert_eq!(nominal.input, Input::default());
    assert_eq!(nominal.notes, Vec::<String>::new());
    assert!(nominal.source.contains("Tables 4 and 6"));
}

#[test]
fn every_shipped_bicycle_opens_under_its_own_name() {
    for (name, _) in SHIPPED {
        let bicycle = open(name);
        assert_eq!(bicycle.name, *name);
        assert_eq!(bicycle.notes, Vec::<String>::new());
        assert!(!bicycle.description.is_empty() && !bicycle.source.is_empty());
    }
}

#[test]
fn section3_moves_its_own_inertias_to_the_rear_contact() {
    let p = open("section3").parameters;
    let (m, x, h) = (73.2169, 0.68, 0.96028);
    // the same three sums in another order: round-off only
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12 * b, "{a} {b}");
    near(p.roll_inertia, 14.52883 + m * h * h);
    near(p.yaw_inertia, 8.8278 + m * x * x);
    near(p.cross_inertia, -3.027 + m * x * h);
    assert_eq!((p.trail, p.caster_angle), (0.13, 20.0_f64.to_radians()));
    assert_eq!((p.rider_steer_gain, p.rider_steer_rate_gain), (0.0, 0.0));
    assert_eq!(open("section3").input.speed, 8.0 / 3.6);
}

#[test]
fn benchmark_has_the_published_lumps() {
    // Meijaard et al. 2007: m_T, x_T, z_T, I_T and I_Aλλ recomputed at 40 digits; our double
    // sums agree to round-off.
    let p = open("benchmark").parameters;
    for (value, published) in [
        (p.total_mass, 94.0),
        (p.cog_to_rear, 0.3421276595744681),
        (p.cog_height, 0.8611702127659574),
        (p.roll_inertia, 80.81722),
        (p.yaw_inertia, 17.01908),
        (p.cross_inertia, 28.93344),
        (p.steer_inertia, 0.1538973160142678),
        (p.wheelbase, 1.02),
        (p.caster_angle, 0.3141592653589793),
    ] {
        assert!(
            (value / published - 1.0).abs() < 1e-13,
            "{value} {published}"
        );
    }
}

#[test]
fn delft_rides_without_a_rider_under_its_motors_law() {
    let delft = open("sbw-delft");
    let p = delft.parameters;
    assert!(delft.law_in_loop && !open("nominal").law_in_loop);
    assert!(
        (p.total_mass - 33.4).abs() < 1e-12,
        "four masses, to round-off"
    );
    // T = 2 (6.5 − x) φ̇ at the encoder's x of 4 m/s true speed
    let gain = p.rider_roll_rate_gain + p.rider_roll_rate_gain_slope * 4.0;
    let law = 2.0 * (6.5 - (1.066 * 4.0 - 0.128));
    assert!((gain - law).abs() < 1e-12, "{gain} {law}");
}

#[test]
fn a_rider_replaces_the_rider() {
    let with = |rider: &str| Changes {
        rider: Some(rider.into()),
        ..Changes::default()
    };
    let light = Bicycle::open("nominal", &with("53kg,1.68m"))
        .unwrap()
        .parameters;
    let bodies = [mass::PAPER_BICYCLE, mass::rider(53.0, 1.68)];
    assert_eq!(light.lumps(), mass::compose(&bodies));
    // onto a bicycle without one
    let delft = Bicycle::open("sbw-delft", &with("75,178cm"))
        .unwrap()
        .parameters;
    assert!(
        (delft.total_mass - 108.4).abs() < 1e-12,
        "five masses, to round-off"
    );

    let message = |bicycle, rider| {
        let error = Bicycle::open(bicycle, &with(rider)).unwrap_err();
        assert!(error.is_typed());
        error.to_string()
    };
    for (bicycle, rider, expected) in [
        (
            "section3",
            "75kg,1.78m",
            "--rider 75kg,1.78m: bicycle section3: a rider cannot be put on: \
             its masses are given as [lumps], with the rider in them",
        ),
        (
            "benchmark",
            "75kg,1.78m",
            "--rider 75kg,1.78m: bicycle benchmark: a rider cannot be put on: \
             its 25 parameters include one (rider_included = true)",
        ),
        (
            "nominal",
            "75kg",
            "--rider 75kg: expected mass,height such as 75kg,1.78m, found `75kg`",
        ),
        (
            "nominal",
            "75kg,178",
            "--rider 75kg,178: height of the rider: expected 0.8 to 2.5 m, found 178 m",
        ),
        (
            "nominal",
            "1.78m,75kg",
            "--rider 1.78m,75kg: mass of the rider: expected a unit of the dimension of kg, found `m`",
        ),
    ] {
        assert_eq!(message(bicycle, rider), expected);
    }
}

#[test]
fn load_and_set_change_rows() {
    let changes = Changes {
        load: Some("20kg".into()),
        ..set(&[
            "trail=-35mm",
            "speed=12km/h",
            "remnant_intensity=1.2",
            "formulation=minimal",
        ])
    };
    let bicycle = Bicycle::open("nominal", &changes).unwrap();
    assert_eq!(bicycle.parameters.rear_load, 20.0);
    assert_eq!(bicycle.parameters.trail, -0.035);
    assert_eq!(bicycle.input.speed, 12.0 * 1000.0 / 3600.0);
    assert_eq!(bicycle.excitation.remnant_intensity, 1.2);
    assert_eq!(bicycle.formulation, Formulation::Minimal);
    assert_eq!(bicycle.notes, Vec::<String>::new());
}

#[test]
fn moving_the_centre_of_mass_alone_is_said() {
    let bicycle = Bicycle::open("nominal", &set(&["cog_to_rear=.33"])).unwrap();
    let nominal = Parameters::default();
    assert_eq!(
        bicycle.parameters,
        Parameters {
            cog_to_rear: 0.33,
            ..nominal
        }
    );
    assert_eq!(
        bicycle.notes,
        [
            "cog_to_rear alone was set to .33: the inertias about the rear contact stay what they were",
        ]
    );
}

#[test]
fn matter_that_cannot_be_is_refused() {
    // 16.748 − 92.5 · .52² kg m²
    let error = Bicycle::open("nominal", &set(&["cog_to_rear=.52"])).unwrap_err();
    let words = error.to_string();
    assert!(
        words.contains("found bicycle, rider and load with 92.5000 kg"),
        "{words}"
    );
    assert!(words.contains("-8.2636 (zz)"), "{words}");
}

#[test]
fn what_was_typed_wrong_is_named() {
    let message = |assignment| {
        let error = Bicycle::open("nominal", &set(&[assignment])).unwrap_err();
        assert!(error.is_typed());
        error.to_string()
    };
    for (assignment, expected) in [
        ("trail", "--set trail: expected name=value, found `trail`"),
        (
            "trial=.1",
            "--set trial=.1: unknown parameter `trial`; nearest: trail",
        ),
        (
            "trail=1m",
            "--set trail=1m: trail: expected -0.1 to 0.2 m, found 1 m",
        ),
        (
            "trail=1kg",
            "--set trail=1kg: trail: expected a unit of the dimension of m, found `kg`",
        ),
        (
            "trail=long",
            "--set trail=long: trail: expected a number or a number with a unit, found `long`",
        ),
        (
            "speed=-1",
            "--set speed=-1: speed: expected 0 to 20 m/s, found -1 m/s",
        ),
        (
            "formulation=prnted",
            "--set formulation=prnted: unknown formulation `prnted`; nearest: printed",
        ),
    ] {
        assert_eq!(message(assignment), expected);
    }
    assert_eq!(
        Bicycle::open("nominl", &Changes::default())
            .unwrap_err()
            .to_string(),
        "unknown bicycle `nominl`; nearest: nominal"
    );
    let nearest = |name| {
        let error = Bicycle::open(name, &Changes::default()).unwrap_err();
        error.to_string()
    };
    assert!(nearest("browser-jasn").contains("nearest: browser-jason"));
    assert!(nearest("Pista").contains("nearest: pista"));
}

#[test]
fn what_is_wrong_in_a_file_is_named() {
    let bicycle = "[bodies.bicycle]\nmass = 17.5\nx = 0.5\nh = 0.5\nroll_inertia = 1.2\n\
                   yaw_inertia = 3.2\n";
    for (rest, expected) in [
        (
            String::new(),
            "my.toml: expected exactly one of [lumps], [bodies.bicycle] and [bodies.literature], found 0",
        ),
        (
            format!("{LUMPS}{bicycle}cross_inertia = 0"),
            "my.toml: expected exactly one of [lumps], [bodies.bicycle] and [bodies.literature], found 2",
        ),
        (
            bicycle.into(),
            "my.toml: [bodies.bicycle]: expected `cross_inertia`, found none",
        ),
        (
            format!("{bicycle}cross_inerta = 0"),
            "my.toml: [bodies.bicycle]: unknown key `cross_inerta`; \
             nearest: cross_inertia, roll_inertia",
        ),
        (
            format!("{bicycle}cross_inertia = '0 kg m'"),
            "my.toml: [bodies.bicycle]: cross_inertia: \
             expected a unit of the dimension of kg.m2, found `kg m`",
        ),
        (
            format!("{bicycle}cross_inertia = true"),
            "my.toml, row 8: expected a number (SI) or a text with a unit such as \"20 deg\"",
        ),
        (
            format!("{LUMPS}[bodies.rider]\nmass = 75\nheight = 1.78"),
            "my.toml: bicycle my: a rider cannot be put on: \
             its masses are given as [lumps], with the rider in them",
        ),
        (
            format!("{LUMPS}[parameters]\ntrial = 0.1"),
            "my.toml: unknown parameter `trial`; nearest: trail",
        ),
        (
            format!("{LUMPS}[parameters]\ntrail = 0.3"),
            "my.toml: trail: expected -0.1 to 0.2 m, found 0.3 m",
        ),
        (
            format!("{LUMPS}[parameters]\ntotal_mass = 90"),
            "my.toml: total_mass: given under [parameters] and determined by [lumps]",
        ),
        (
            format!("{LUMPS}[inputs]\nsped = 2"),
            "my.toml: unknown input `sped`; nearest: speed",
        ),
        (
            LUMPS.replace("92.5", "925"),
            "my.toml: total_mass: expected 5 to 250 kg, found 925 kg",
        ),
        (
            LUMPS.replace("rear_contact", "hub"),
            "my.toml, row 3: unknown variant `hub`, expected `cog` or `rear_contact`",
        ),
        (
            format!("colour = 'red'\n{LUMPS}"),
            "my.toml, row 2: unknown field `colour`, expected one of `name`, `description`, `source`, \
             `law_in_loop`, `formulation`, `bodies`, `lumps`, `parameters`, `inputs`",
        ),
    ] {
        assert_eq!(message(&rest), expected);
    }
}

#[test]
fn inertias_about_either_point_are_the_same_bicycle() {
    let about_contact =
        Bicycle::parse("a", &format!("name = 'a'\n{LUMPS}"), &Changes::default()).unwrap();
    let own = about_contact.parameters.lumps().body();
    let text = format!(
        "name = 'a'\n[lumps]\nabout = 'cog'\ntotal_mass = {}\ncog_to_rear = {}\ncog_height = {}\n\
         roll_inertia = {}\nyaw_inertia = {}\ncross_inertia = {}\n",
        own.mass, own.x, own.h, own.roll_inertia, own.yaw_inertia, own.cross_inertia
    );
    let about_cog = Bicycle::parse("a", &text, &Changes::default()).unwrap();
    let pairs = about_contact
        .parameters
        .to_array()
        .into_iter()
        .zip(about_cog.parameters.to_array());
    for (a, b) in pairs {
        assert!(
            (a - b).abs() <= 1e-14 * a.abs(),
            "{a} {b}: more than round-off"
        );
    }
}
