//! The bicycle coupled with a controller of another maker, from outside.

use crate::wobble::{Called, json, pack_example, wobble};
use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;
use tempfile::TempDir;

/// A folder with `plant.fmu` and `assist.fmu`, the controller in C.
static FMUS: LazyLock<TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a folder");
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("foreign");
    let library = folder.path().join("RollAssist.so");
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    let compiled = Command::new(compiler)
        .args(["-shared", "-fPIC", "-O2", "-std=c99", "-o"])
        .arg(&library)
        .arg(sources.join("roll_assist.c"))
        .arg("-lm")
        .status()
        .expect("a C compiler");
    assert!(compiled.success());
    let description = sources.join("modelDescription.xml");
    let pack = format!(
        "fmu --description {} --library RollAssist.so -o assist.fmu",
        description.display()
    );
    for call in ["fmu -o plant.fmu", &pack] {
        let packed = wobble(folder.path(), call);
        assert_eq!(packed.code, 0, "{}", packed.err);
    }
    folder
});

const COUPLED: &str = "cosim --plant plant.fmu --controller assist.fmu --set roll_start=3deg";

fn run(arguments: &str) -> Called {
    wobble(FMUS.path(), &format!("{COUPLED} {arguments}"))
}

/// The last time in a CSV [s], and the number of its rows.
fn last(csv: &str) -> (f64, usize) {
    let rows: Vec<&str> = csv.lines().skip(1).collect();
    let last = rows
        .last()
        .expect("a row")
        .split(',')
        .next()
        .expect("a cell");
    (last.parse().expect("a number"), rows.len())
}

#[test]
fn a_ride_with_a_controller_is_a_ride_file() {
    let called = run("--load 20 --stop 2s --report run.html");
    assert_eq!(called.code, 0, "{}", called.err);
    assert!(
        called
            .err
            .contains("plant.roll_rate → controller.roll_rate"),
        "{}",
        called.err
    );
    assert!(
        called
            .err
            .contains("controller.assist_torque → plant.assist_torque")
    );
    let head = called.out.lines().next().expect("a head");
    assert!(head.starts_with("time[s],"), "{head}");
    for column in ["steer[rad]", "speed[m/s]", "controller.assist_torque[N.m]"] {
        assert!(
            head.split(',').any(|name| name == column),
            "{column} in {head}"
        );
    }
    assert_eq!(last(&called.out), (2.0, 401));
    let page = fs::read_to_string(FMUS.path().join("run.html")).expect("written");
    for said in [
        "To the stop at 2 s",
        "controller.assist_torque [N",
        "roll_rate [°/s]",
    ] {
        assert!(page.contains(said), "{said}");
    }
    let file = FMUS.path().join("ride.csv");
    fs::write(&file, &called.out).expect("written");
    let spectrum = json(FMUS.path(), "spectrum ride.csv --average 1s --json");
    assert!(spectrum.is_object() || spectrum.is_array());
}

#[test]
fn every_way_of_saying_it_gives_the_same_ride() {
    let typed = run("--stop 1s --set controller.roll_gain=20");
    let system = r#"
        stop = "1s"
        connect = ["plant.roll = controller.roll", "roll_rate=roll_rate"]
        [[fmu]]
        name = "controller"
        file = "assist.fmu"
        set = { roll_gain = 20 }
        [[fmu]]
        name = "plant"
        file = "plant.fmu"
        set = { roll_start = "3deg" }
    "#;
    fs::write(FMUS.path().join("system.toml"), system).expect("written");
    let written = wobble(FMUS.path(), "cosim system.toml");
    assert_eq!(written.code, 0, "{}", written.err);
    assert_eq!(typed.out, written.out);
    // Jacobi does not see the order
    let again = run("--stop 1s --set controller.roll_gain=20 --algorithm jacobi");
    assert_eq!(typed.out, again.out);
}

#[test]
fn a_system_written_for_other_tools_runs_here_as_it_was() {
    let coupled = "--load 20 --formulation minimal --stop 1s --set controller.roll_gain=20";
    let typed = run(coupled);
    let written = run(&format!("{coupled} --ssp system.ssp"));
    assert_eq!(
        (written.code, written.out.as_str()),
        (0, ""),
        "{}",
        written.err
    );
    let read = wobble(FMUS.path(), "cosim system.ssp");
    assert_eq!(read.code, 0, "{}", read.err);
    assert_eq!(typed.out, read.out);
}

#[test]
fn a_controller_runs_at_its_own_sample_time() {
    let held = |arguments: &str| {
        let coupled = json(
            FMUS.path(),
            &format!("{COUPLED} --stop .1s --json {arguments}"),
        );
        let torque = coupled["outputs"]["controller.assist_torque"]
            .as_array()
            .expect("a column")
            .clone();
        torque.windows(2).filter(|pair| pair[0] == pair[1]).count()
    };
    // the step it suggests is 5 ms: four of five rows are held
    assert_eq!(held("--step 1ms"), 80);
    assert_eq!(held("--step 1ms --controller-step 1ms"), 0);
    assert_eq!(held("--step 10ms"), 0);
}

#[test]
fn what_an_fmu_does_wrong_ends_the_run_with_what_was_reached() {
    let failing = |fault: u32, arguments: &str| {
        run(&format!(
            "--set controller.fault={fault} --set controller.fault_time=0.5 --stop 2s {arguments}"
        ))
    };
    for (fault, code, words) in [
        (1, 1, "controller at 0.5 s: fmi2DoStep returned Error"),
        (
            2,
            1,
            "expected controller to go on to the stop, found its end at 0.5 s",
        ),
        (3, 1, "controller at 0.5 s: fmi2DoStep returned Fatal"),
        (
            4,
            1,
            "controller at 0.5 s: expected an answer within 0.5 s, found none",
        ),
        (
            5,
            1,
            "expected controller to go on to the stop, found its end at 0.5 s",
        ),
        (
            6,
            1,
            "plant at 0.505 s: assist_torque: expected a finite value, found NaN from controller.assist_torque",
        ),
    ] {
        let called = failing(fault, "--timeout .5s");
        assert_eq!(called.code, code, "fault {fault}: {}", called.err);
        assert!(called.err.contains(words), "fault {fault}: {}", called.err);
        let (time, rows) = last(&called.out);
        assert!(
            (0.5..=0.505).contains(&time) && rows >= 101,
            "fault {fault}: {time} s, {rows} rows"
        );
    }
}

#[test]
fn a_tolerance_ends_whoever_rides() {
    let ridden = "--set remnant_intensity=1.2 --stop .2s --json --tolerance";
    for tolerance in ["1e-1", "1e-30"] {
        let run = json(FMUS.path(), &format!("{COUPLED} {ridden} {tolerance}"));
        assert_eq!(run["stop"], "end");
    }
    let course = format!("{COUPLED} --course slalom --stop .2s --tolerance 1e-2 --json");
    assert_eq!(json(FMUS.path(), &course)["stop"], "end");
}

#[test]
fn a_fall_is_an_end_and_its_time_the_last_row() {
    let called = run("--bicycle section3 --set trail=-.035 --set roll_start=-5deg --stop 5s");
    assert_eq!(called.code, 0, "{}", called.err);
    assert!(
        called.err.contains("note: plant ended early"),
        "{}",
        called.err
    );
    let (time, _) = last(&called.out);
    assert!(time < 1.0, "{time} s");
}

#[test]
fn each_controller_lowers_the_oscillation_where_it_says_so() {
    for (example, fmu) in [
        ("disturbance_observer", "Observer.fmu"),
        ("roll_assist", "Roll.fmu"),
    ] {
        pack_example(FMUS.path(), example, fmu);
        for bicycle in [
            "--bicycle section3 --trails .13,.085 --loads 0",
            "--trails .13,.085,-.035 --loads 20kg",
        ] {
            let call = format!(
                "cosim --plant plant.fmu --controller {fmu} {bicycle} --against none --rides 3 --json"
            );
            let study = json(FMUS.path(), &call);
            for row in study["rows"].as_array().expect("rows") {
                let change = &row["bands"][1]["change"]["value"];
                assert_eq!(change["verdict"], "falls", "{fmu} {bicycle}: {row}");
            }
        }
    }
}

#[test]
fn the_eigenvalues_of_the_closed_loop_are_how_it_grows() {
    pack_example(
        FMUS.path(),
        "disturbance_observer",
        "DisturbanceObserver.fmu",
    );
    let falling = "cosim --plant plant.fmu --controller DisturbanceObserver.fmu --bicycle section3";
    let study =
        format!("{falling} --against none --trails -.035 --loads 0 --rides 1 --stop 10s --json");
    let study = json(FMUS.path(), &study);
    let modes = &study["rows"][0]["modes"]["with"]["value"];
    let fastest = &modes["eigenvalues"][0];
    let [re, im] = [0, 1].map(|part| fastest[part].as_f64().expect("a number"));
    // a ride so small that nothing bends, without what has no slope
    let small = format!(
        "{falling} --set trail=-.035 --set coulomb_friction=0 --set roll_start=1e-7 \
         --set controller.steer_resolution=0 --stop .6s --json"
    );
    let small = json(FMUS.path(), &small);
    let steer = small["outputs"]["steer"].as_array().expect("a column");
    let steer: Vec<f64> = steer
        .iter()
        .map(|v| v.as_f64().expect("a number"))
        .collect();
    // the last of it is one growing swing: s₂ = a s₁ + b s₀ by least squares
    let (mut n11, mut n12, mut n22, mut r1, mut r2) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for s in steer[steer.len() / 2..].windows(3) {
        n11 += s[1] * s[1];
        n12 += s[1] * s[0];
        n22 += s[0] * s[0];
        r1 += s[1] * s[2];
        r2 += s[0] * s[2];
    }
    let det = n11 * n22 - n12 * n12;
    let (a, b) = ((r1 * n22 - r2 * n12) / det, (n11 * r2 - n12 * r1) / det);
    // z² = a z + b with complex z: |z|² = −b, Re z = a/2; samples are 5 ms apart
    let growth = 0.5 * (-b).ln() / 0.005;
    let omega = (0.5 * a / (-b).sqrt()).acos() / 0.005;
    assert!((re - growth).abs() < 0.05 * growth, "{re} {growth}");
    assert!((im.abs() - omega).abs() < 0.05 * omega, "{im} {omega}");
}

#[track_caller]
fn refused(arguments: &str, code: i32, words: &str) {
    let called = wobble(FMUS.path(), arguments);
    assert_eq!(called.code, code, "{arguments}: {}", called.err);
    assert!(called.err.contains(words), "{arguments}: {}", called.err);
    assert_eq!(called.out, "", "{arguments}");
}

#[test]
fn what_cannot_be_coupled_is_refused() {
    let coupled = |arguments: &str, code, words: &str| {
        refused(&format!("{COUPLED} {arguments}"), code, words);
    };
    coupled(
        "--connect plant.rol=controller.roll",
        2,
        "expected a variable of plant, found \"rol\"; the nearest: roll",
    );
    coupled("--connect rol=roll", 2, "unknown output `rol`; nearest: ");
    coupled("--connect roll", 2, "expected SOURCE=TARGET, found `roll`");
    coupled(
        "--connect plant.roll=controller.speed",
        2,
        "expected units that convert, found rad to m/s",
    );
    coupled(
        "--connect plant.roll=controller.assist_torque",
        2,
        "expected an input as its target, found an output",
    );
    coupled(
        "--connect plant.roll=controller.roll --connect plant.steer=controller.roll",
        2,
        "controller.roll: expected one source, found two, plant.roll and plant.steer",
    );
    coupled(
        "--connect plant.roll=plant.steer_torque --course slalom",
        2,
        "expected the rider as the source of plant.steer_torque",
    );
    coupled("--set controller.fault=9", 2, "outside 0 to 6");
    coupled("--step 3ms", 2, "expected 0.005 s, the step of controller");
    coupled(
        "--step 2ms --controller-step 5ms",
        2,
        "the step of controller",
    );
    coupled("--step 0", 2, "expected a time above 0 s");
    coupled("--stop -1s", 2, "expected a time above 0 s");
    coupled(
        "--tolerance 0",
        2,
        "tolerance: expected a positive number, found 0",
    );
    coupled(
        "--algorithm euler",
        2,
        "unknown algorithm `euler`; nearest: ",
    );
    coupled(
        "--course slalm",
        2,
        "unknown course `slalm`; nearest: slalom",
    );
    coupled(
        "--set controller.roll_gian=1",
        2,
        "unknown variable `roll_gian`; nearest: roll_gain",
    );
    coupled("--set trial=.1", 2, "nearest: trail");
    coupled("--load 300", 2, "rear_load");
    coupled("--against none --rides 0", 2, "--rides");
    coupled("--against none --trails 1m", 2, "trail");
    coupled(
        "--course slalom --ssp x.ssp",
        2,
        "expected a rider who is the law in the plant",
    );
    refused("cosim --controller assist.fmu", 2, "--plant");
    refused("cosim --plant nowhere.fmu", 1, "nowhere.fmu");
    refused(
        "cosim --plant assist.fmu --load 20",
        2,
        "expected a participant `plant` with the rows of the bicycle's table, found `RollAssist`",
    );
    let bike = "[[fmu]]\nname = \"bike\"\nfile = \"plant.fmu\"\n";
    fs::write(FMUS.path().join("bike.toml"), bike).expect("written");
    refused(
        "cosim bike.toml --load 20",
        2,
        "expected a participant `plant`",
    );
    fs::write(
        FMUS.path().join("bad.toml"),
        "step = 5\nfmu = []\nsteps = 1\n",
    )
    .expect("written");
    refused("cosim bad.toml", 1, "bad.toml");
}
