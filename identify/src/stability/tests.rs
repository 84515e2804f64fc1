//! Ranges, refusals, and the linear system turned and written.

#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
use super::*;
use crate::bicycles::Changes;
use crate::map::Signs;
use bicycle::quantity::{KG, M_PER_S};

fn plan(name: &str, speeds: &str, sweep: Option<&str>) -> Plan {
    let set = Bicycle::open(name, &Changes::default()).unwrap();
    let mut plan = Plan::new(&set, points(speeds, M_PER_S, "speed").unwrap());
    plan.formulation = Formulation::Whipple;
    plan.sweep = sweep.map(|text| Sweep::read(text).unwrap());
    plan
}

#[test]
fn ranges_are_read_to_the_last_digit() {
    let read = |text| points(text, M_PER_S, "speed").unwrap();
    let tenths = read("0:10:0.1");
    assert_eq!(tenths.len(), 101);
    assert_eq!((tenths[3], tenths[7], tenths[100]), (0.3, 0.7, 10.0));
    assert_eq!(read("4"), [4.0]);
    assert_eq!(read("8km/h"), [8.0 / 3.6]);
    assert_eq!(read("10:0:-5"), [10.0, 5.0, 0.0]);
    assert_eq!(read("1:2:0.4"), [1.0, 1.4, 1.8]);
    assert_eq!(read("2:2:1"), [2.0]);
    assert_eq!(
        points("0kg:30kg:10kg", KG, "rear_load").unwrap(),
        [0.0, 10.0, 20.0, 30.0]
    );
}

#[test]
fn mistyped_ranges_are_named() {
    let said = |text| points(text, M_PER_S, "speed").unwrap_err().to_string();
    assert_eq!(
        said("0:10:0"),
        "expected a step other than 0, found `0:10:0`"
    );
    assert_eq!(
        said("0:10:-1"),
        "expected a step in the direction from FROM to TO, found `0:10:-1`"
    );
    assert_eq!(said("0:10"), "expected VALUE or FROM:TO:STEP, found `0:10`");
    assert_eq!(
        said("0:10:1e-4"),
        "expected 1 to 100000 points, found `0:10:1e-4`"
    );
    assert!(said("0:inf:1").contains("found `inf`"));
    assert!(said("0:10 kg:1").contains("kg"));
    let sweep = |text| Sweep::read(text).unwrap_err().to_string();
    assert!(sweep("rear_lod=0:30:1").contains("nearest: rear_load"));
    assert_eq!(
        sweep("caster_angle=0:90deg:10deg"),
        "caster_angle: expected -0.2 to 0.8 rad, found 1.5707963267948966 rad"
    );
    assert_eq!(sweep("trail"), "expected NAME=FROM:TO:STEP, found `trail`");
}

#[test]
fn what_cannot_be_ridden_is_refused_at_its_point() {
    let said = |plan: &Plan| stability(plan).unwrap_err().to_string();
    // 92.5 kg · .339 m before the rear contact, the load 1 m behind it
    let far = "rear_load=0:100:10";
    let mut lifted = plan("nominal", "3", Some(far));
    lifted.parameters.rear_load_x = -1.0;
    let message = said(&lifted);
    assert!(
        message.starts_with("rear_load = 40 kg: expected a front wheel"),
        "{message}"
    );
    let thin = plan("nominal", "3", Some("roll_inertia=100:10:-10"));
    assert!(said(&thin).starts_with("roll_inertia = 80 kg.m2: expected bodies of positive mass"));
    let mut standing = plan("nominal", "0:3:1", None);
    assert!(stability(&standing).is_ok());
    standing.formulation = Formulation::WhippleSlip;
    assert_eq!(
        said(&standing),
        "speed: expected above 0 m/s with whipple_slip, found 0 m/s"
    );
    assert!(said(&plan("nominal", "-1", None)).contains("found -1 m/s"));
    let mut many = plan("nominal", "0:10:0.001", Some("rear_load=0:30:1"));
    assert!(said(&many).contains("found 310031 points"));
    many.speeds.clear();
    assert!(said(&many).contains("found 0 points"));
}

#[test]
fn the_benchmark_sweep_is_the_published_one() {
    let found = stability(&plan("benchmark", "0:10:0.1", None)).unwrap();
    let json = words::to_json(&found);
    let near = |name: &str, expected: f64| (json[name].as_f64().unwrap() - expected).abs() < 1e-9;
    // Meijaard et al. 2007, section 5, to the digits that double precision has
    assert!(
        near("weave_speed", 4.292382536341104),
        "{}",
        json["weave_speed"]
    );
    assert!(
        near("capsize_speed", 6.024262015388359),
        "{}",
        json["capsize_speed"]
    );
    let row = &json["rows"][50];
    assert_eq!(row["speed"], 5.0);
    assert_eq!(
        row["modes"].to_string(),
        r#"["weave","weave","capsize","castering"]"#
    );
    let weave = &row["eigenvalues"][0];
    assert!(
        (weave[0].as_f64().unwrap() + 0.7753418821958419).abs() < 1e-9,
        "{weave}"
    );
    let slow = stability(&plan("benchmark", "1:3:1", None)).unwrap();
    assert!(words::to_json(&slow)["weave_speed"].is_null());
}

#[test]
fn a_map_has_the_speeds_of_each_value() {
    let asked = plan("benchmark", "1:8:0.5", Some("rear_load=0:20:10"));
    let found = stability(&asked).unwrap();
    assert_eq!((found.points.len(), found.crossings.len()), (45, 3));
    let json = words::to_json(&found);
    assert_eq!(json["crossings"][2]["rear_load"], 20.0);
    assert_eq!(json["rows"][44]["rear_load"], 20.0);
    // a point of the map is the point of a sweep of its own
    let mut alone = plan("benchmark", "1:8:0.5", None);
    alone.parameters.rear_load = 20.0;
    let alone = stability(&alone).unwrap();
    assert_eq!(
        alone.crossings[0].weave_speed,
        found.crossings[2].weave_speed
    );
    assert_eq!(alone.points[7].roots, found.points[37].roots);
    for page in [
        crate::figure::stability(&found),
        crate::figure::stability(&alone),
        html(&asked, &found, "benchmark", "wobble stability <&>"),
    ] {
        crate::figure::tests::check_well_formed(&page);
    }
}

#[test]
fn moving_the_mass_keeps_its_own_inertias() {
    let p = Parameters::default();
    for text in [
        "cog_height=0.8:1:0.1",
        "cog_to_rear=0.3:0.5:0.1",
        "total_mass=80:90:5",
    ] {
        let sweep = Sweep::read(text).unwrap();
        let moved = sweep.apply(&p, sweep.values[0]);
        assert_eq!(
            moved.get(Parameters::index(sweep.row.name).unwrap()),
            sweep.values[0]
        );
        let (before, after) = (p.lumps().body(), moved.lumps().body());
        // round-off of adding and taking off m h², 90 kg m²
        assert!((before.roll_inertia - after.roll_inertia).abs() < 1e-12);
        assert!((before.yaw_inertia - after.yaw_inertia).abs() < 1e-12);
        assert!((before.cross_inertia - after.cross_inertia).abs() < 1e-12);
    }
}

#[test]
fn notes_say_what_is_left_out_and_what_is_odd() {
    let notes = |plan: &Plan| stability(plan).unwrap().notes.join("; ");
    assert!(notes(&plan("nominal", "3", None)).contains("Coulomb friction"));
    assert_eq!(notes(&plan("benchmark", "3", None)), "");
    let idle = notes(&plan("benchmark", "3", Some("rider_roll_gain=0:50:10")));
    assert_eq!(
        idle,
        "rider_roll_gain plays no part in whipple without its rider law"
    );
    let mut light = plan("benchmark", "3", Some("rear_load=0:30:10"));
    light.parameters.rear_load_x = -1.0;
    assert!(
        notes(&light).contains("at rear_load = 30 kg: little"),
        "{}",
        notes(&light)
    );
}

/// Mirrored signs leave what no sign is in: eigenvalues, and the transfer from what is turned to
/// what is turned.
#[test]
fn literature_signs_turn_what_points_left() {
    let asked = plan("benchmark", "4.6", None);
    let iso = linear::system(&asked, 0.0, Signs::Iso8855)
        .unwrap()
        .matrices;
    let literature = linear::system(&asked, 0.0, Signs::Literature)
        .unwrap()
        .matrices;
    let state = |name| bicycle::State::index(name).unwrap();
    let input = |name| Input::index(name).unwrap();
    let (roll, steer) = (state("roll_rate"), state("steer_rate"));
    assert_eq!(iso.a[(roll, steer)], -literature.a[(roll, steer)]);
    assert_eq!(iso.a[(steer, steer)], literature.a[(steer, steer)]);
    let torque = input("steer_torque");
    assert_eq!(iso.b[(steer, torque)], literature.b[(steer, torque)]);
    assert_eq!(iso.b[(roll, torque)], -literature.b[(roll, torque)]);
    // Meijaard et al. 2007, (5.3): −M⁻¹ v C1 in z-down signs, first row, second column
    let b = bicycle::Bicycle::new(&asked.parameters, Formulation::Whipple);
    let four = b.four_bodies.unwrap();
    let (m, c) = (four.mass, four.damping);
    let determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    let expected = -4.6 * (m[1][1] * c[0][1] - m[0][1] * c[1][1]) / determinant;
    let error = literature.a[(roll, steer)] - expected;
    assert!(
        error.abs() < 1e-12 * expected.abs().max(1.0),
        "{error:e}: round-off"
    );
}

/// Heading and place are no states: what hangs on them is left out, and the motion that changes are
/// counted from is told in full, in a turn as well.
#[test]
fn a_linear_system_says_what_it_is_about() {
    let mut asked = plan("nominal", "4", None);
    asked.formulation = Formulation::Repaired;
    let json = linear::system(&asked, 0.05, Signs::Iso8855)
        .unwrap()
        .to_json();
    let names =
        |group: &str| -> Vec<String> { serde_json::from_value(json[group].clone()).unwrap() };
    let outputs = names("outputs");
    for absent in ["heading", "x", "y", "x_rate", "y_rate"] {
        assert!(!outputs.iter().any(|name| name == absent), "{absent}");
    }
    assert_eq!(json["C"].as_array().unwrap().len(), outputs.len());
    let value = |list: &str, group: &str, name: &str| {
        let place = names(group).iter().position(|n| n == name).unwrap();
        json[list][place].as_f64().unwrap()
    };
    assert_eq!(value("x0", "states", "steer"), 0.05);
    assert_eq!(value("u0", "inputs", "speed"), 4.0);
    let (state, output) = (
        value("x0", "states", "yaw_rate"),
        value("y0", "outputs", "yaw_rate"),
    );
    assert_eq!(state, output);
    // V tan(θ − β)/L: camber thrust takes more than the turn asks for, so the front tyre slips back
    assert!(
        (1.0..1.2).contains(&(state / (4.0 * 0.05 / 1.015))),
        "{state}"
    );
    // steady: nothing accelerates
    for row in [
        "roll_acceleration",
        "steer_acceleration",
        "yaw_acceleration",
    ] {
        assert!(value("y0", "outputs", row).abs() < 1e-9, "{row}");
    }
    assert_eq!(json["formulation"], "repaired");
}

/// The element at `offset` of a MAT-file: its type, its data, and where the next one begins.
fn element(bytes: &[u8], offset: usize) -> (u32, &[u8], usize) {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let start = offset + 8;
    let end = start + word(offset + 4) as usize;
    (word(offset), &bytes[start..end], end.next_multiple_of(8))
}

#[test]
fn a_mat_file_reads_back() {
    let system = linear::system(&plan("benchmark", "4", None), 0.0, Signs::Iso8855).unwrap();
    let bytes = system.to_mat();
    assert_eq!(&bytes[..19], b"MATLAB 5.0 MAT-file");
    assert_eq!(&bytes[124..128], [0, 1, b'I', b'M']);
    let mut offset = 128;
    let mut names = Vec::new();
    while offset < bytes.len() {
        let (kind, array, next) = element(&bytes, offset);
        assert_eq!(kind, 14, "an array");
        let (_, flags, at) = element(array, 0);
        let (_, shape, at) = element(array, at);
        let (_, name, at) = element(array, at);
        names.push(String::from_utf8(name.to_vec()).unwrap());
        if name == b"B" {
            assert_eq!((flags[0], shape), (6, &[4, 0, 0, 0, 4, 0, 0, 0][..]));
            let (_, content, _) = element(array, at);
            let number = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().unwrap());
            let read: Vec<f64> = content.chunks(8).map(number).collect();
            assert_eq!(read, system.matrices.b.as_slice(), "by columns");
        }
        offset = next;
    }
    let expected = "A B C D states state_units inputs input_units outputs output_units x0 u0 y0 formulation signs";
    assert_eq!(names.join(" "), expected);
}
