//! What the rows of the tables promise.

use bicycle::quantity::UNITS;
use bicycle::{
    Derived, Excitation, Input, Instruments, Output, Parameters, Path, Quantity, State, Variability,
};
use std::collections::HashSet;

/// The tables whose rows a user meets, each name once.
fn tables() -> [&'static [Quantity]; 7] {
    [
        Parameters::TABLE,
        Excitation::TABLE,
        Instruments::TABLE,
        State::TABLE,
        Path::TABLE,
        Input::TABLE,
        Derived::TABLE,
    ]
}

fn every_row() -> impl Iterator<Item = &'static Quantity> {
    tables().into_iter().chain([Output::TABLE]).flatten()
}

#[test]
fn every_row_can_be_traced() {
    for row in every_row() {
        assert!(!row.what.trim().is_empty(), "{}: no description", row.name);
        assert!(!row.source.trim().is_empty(), "{}: no source", row.name);
        assert!(!row.symbol.is_empty(), "{}: no symbol", row.name);
        assert!(
            UNITS.contains(&row.unit),
            "{}: {}",
            row.name,
            row.unit.symbol
        );
    }
    // a number that nobody printed or measured says so, or says how it came about
    let origins = [
        "paper",
        "composition",
        "assumed: ",
        "identified: ",
        "Moore",
        "Dressel",
        "Batavus Browser",
        "as ",
        "standard",
    ];
    let seekable = [Parameters::TABLE, Excitation::TABLE, Instruments::TABLE];
    for row in seekable.into_iter().flatten() {
        let traced = origins.iter().any(|origin| row.source.starts_with(origin));
        assert!(traced, "{}: source '{}'", row.name, row.source);
    }
}

#[test]
fn ranges_hold_what_they_should() {
    for row in every_row() {
        assert!(row.min < row.max, "{}", row.name);
        assert!(row.admits(row.nominal), "{}", row.name);
        assert!(!row.admits(f64::NAN), "{}", row.name);
        if let Some((low, high)) = row.measured {
            assert!(
                low < high && row.admits(low) && row.admits(high),
                "{}",
                row.name
            );
        }
    }
    for row in Parameters::TABLE
        .iter()
        .chain(Excitation::TABLE)
        .chain(Instruments::TABLE)
        .chain(Input::TABLE)
    {
        assert!(row.min.is_finite() && row.max.is_finite(), "{}", row.name);
    }
}

#[test]
fn names_are_unique_and_written_one_way() {
    let mut seen = HashSet::new();
    for row in tables().into_iter().flatten() {
        assert!(seen.insert(row.name), "{} twice", row.name);
        let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        assert!(row.name.chars().all(plain), "{}", row.name);
    }
    let outputs: HashSet<_> = Output::TABLE.iter().map(|row| row.name).collect();
    assert_eq!(outputs.len(), Output::LEN);
    // an output that repeats a state or a place is that row, unit and all
    for row in State::TABLE.iter().chain(Path::TABLE) {
        let output = Output::TABLE.iter().find(|o| o.name == row.name);
        let output = output.unwrap_or_else(|| panic!("{} is not seen", row.name));
        assert_eq!((output.symbol, output.unit), (row.symbol, row.unit));
    }
    for unit in UNITS {
        assert_eq!(UNITS.iter().filter(|u| u.symbol == unit.symbol).count(), 1);
    }
}

/// The names are an interface (files, command line, FMU): adding is free, renaming is not.
#[test]
fn names_do_not_change() {
    let names = |table: &[Quantity]| {
        table
            .iter()
            .map(|row| row.name)
            .collect::<Vec<_>>()
            .join(" ")
    };
    expect_test::expect!["total_mass cog_to_rear cog_height roll_inertia yaw_inertia cross_inertia wheelbase caster_angle front_wheel_radius rear_wheel_radius trail front_wheel_mass steer_inertia front_assembly_mass front_assembly_x front_assembly_h front_assembly_inertia_xx front_assembly_inertia_xz front_assembly_inertia_zz front_wheel_inertia rear_wheel_inertia cornering_stiffness camber_stiffness rear_cornering_stiffness rear_camber_stiffness viscous_friction coulomb_friction steer_smoothing steer_rate_smoothing steer_limit rear_load rear_load_x rear_load_h rear_load_roll_gyration rear_load_yaw_gyration gravity rider_roll_gain rider_roll_rate_gain rider_steer_gain rider_steer_rate_gain rider_roll_gain_slope rider_roll_rate_gain_slope rider_steer_gain_slope rider_steer_rate_gain_slope relaxation_length internal_step roll_rate_start steer_rate_start roll_start steer_start yaw_rate_start"]
    .assert_eq(&names(Parameters::TABLE));
    assert_eq!(
        names(Excitation::TABLE),
        "remnant_intensity remnant_corner effective_damping"
    );
    assert_eq!(
        names(Instruments::TABLE),
        "torque_gain torque_offset roll_rate_offset steer_rate_offset roll_offset steer_offset yaw_rate_offset"
    );
    assert_eq!(
        names(State::TABLE),
        "roll_rate steer_rate roll steer yaw_rate lateral_velocity front_lateral_force rear_lateral_force"
    );
    assert_eq!(
        names(Input::TABLE),
        "speed steer_torque assist_torque roll_moment"
    );
    assert_eq!(
        names(Output::TABLE),
        "roll steer roll_rate steer_rate yaw_rate heading x y slip_angle camber_angle \
         effective_trail lateral_force camber_thrust rear_lateral_force lateral_velocity \
         front_load rider_torque steer_acceleration roll_acceleration \
         yaw_acceleration x_rate y_rate front_lateral_force lateral_velocity_rate front_lateral_force_rate rear_lateral_force_rate"
    );
}

#[test]
fn rows_and_fields_are_the_same() {
    let mut p = Parameters::<f64>::default();
    for (i, row) in Parameters::TABLE.iter().enumerate() {
        assert_eq!(p.get(i), row.nominal);
        assert_eq!(Parameters::index(row.name), Some(i));
    }
    let trail = Parameters::index("trail").expect("a row");
    p.set(trail, 0.11);
    assert_eq!(p.trail, 0.11);
    assert_eq!(Parameters::index("tail"), None);
}

/// What acts once at the start cannot be tuned later.
#[test]
fn start_values_and_the_step_are_fixed() {
    for row in Parameters::TABLE {
        let fixed = row.name.ends_with("_start")
            || ["internal_step", "relaxation_length"].contains(&row.name);
        assert_eq!(row.variability == Variability::Fixed, fixed, "{}", row.name);
    }
}

/// The paper's geometry is nominal; its steering inertia is kept as a number nobody else measures.
#[test]
fn table_4_is_nominal_but_for_the_steering_inertia() {
    let [mass, radius, wheelbase, caster, cog, steer_inertia] = bicycle::cases::TABLE_4;
    let p = Parameters::<f64>::default();
    let frame = bicycle::mass::PAPER_BICYCLE;
    assert_eq!((frame.mass, frame.x), (mass, cog));
    assert_eq!(
        (p.front_wheel_radius, p.rear_wheel_radius),
        (radius, radius)
    );
    assert_eq!(
        (p.wheelbase, p.caster_angle),
        (wheelbase, caster.to_radians())
    );
    let row = Parameters::TABLE[Parameters::index("steer_inertia").expect("a row")];
    let (low, high) = row.measured.expect("a measured range");
    assert_eq!(steer_inertia, 0.00181);
    assert!(steer_inertia < low / 10.0 && (low..high).contains(&p.steer_inertia));
}

/// The cases of section 3 are the paper's numbers.
#[test]
fn cases_are_those_of_tables_3_and_5() {
    let cases = bicycle::cases::all();
    assert_eq!(cases.map(|case| case.number), [1, 2, 3, 4, 5, 6, 7, 8, 9]);
    let cog = bicycle::cases::Rearward::CogToRear(0.37);
    assert_eq!((cases[5].trail, cases[5].rearward), (0.085, cog));
    let nominal = Parameters::default();
    let p = cases[6].parameters(&nominal);
    assert_eq!((p.trail, p.cog_to_rear), (-0.035, 0.68));
    assert_eq!(
        (p.roll_start, p.steer_start),
        ((-5f64).to_radians(), 1f64.to_radians())
    );
    assert_eq!(
        (p.roll_rate_start, p.steer_rate_start, p.yaw_rate_start),
        (0.0, 0.0, 2.0)
    );
    // the centre of mass moves, the inertias about it do not
    let (before, after) = (nominal.lumps().body(), p.lumps().body());
    assert!((before.yaw_inertia - after.yaw_inertia).abs() < 1e-13 * p.yaw_inertia);
    // Table 5, step +4: .055 and .025 before, −.035 after; equal steps of .03 say −.005
    let trails = bicycle::cases::TABLE_5.map(|(_, trail)| trail);
    for three in trails[3..].windows(3) {
        assert!(
            (three[0] - 2.0 * three[1] + three[2]).abs() < 1e-15,
            "{trails:?}"
        );
    }
}
