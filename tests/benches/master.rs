//! What the master costs beyond the FMUs' own time, in one run:
//! `cargo build --release -p fmi-export --examples`, then
//! `cargo bench -p tests --no-default-features --features benchmarks --bench master`.

#![expect(clippy::print_stdout, reason = "a benchmark tells what it found")]

use fmi_export::Package;
use fmi_import::master::{Foreign, Master, Member, Participant, Plan, by_name};
use fmi_import::{Fmu, Step, Value};
use model_description::Platform;
use std::path::{Path, PathBuf};
use std::time::Instant;
use tempfile::TempDir;

const STEP: f64 = 0.005;
const STEPS: u32 = 4000;
const STOP: f64 = 20.0;
/// Rides that are timed; the fastest counts.
const RIDES: u32 = 30;

fn main() {
    let Some((_folder, plant, controller)) = fmus() else {
        eprintln!("no library of the example roll_assist: build it first, see above");
        return;
    };
    let timed = |ride: &dyn Fn() -> f64| {
        let start = Instant::now();
        let roll = ride();
        (start.elapsed().as_secs_f64(), roll)
    };
    // in turn, for the machine changes its speed
    let (mut coupled, mut end) = (f64::INFINITY, f64::NAN);
    let (mut alone, mut same) = (f64::INFINITY, f64::NAN);
    for _ in 0..RIDES {
        let (time, roll) = timed(&|| by_master(&plant, &controller));
        (coupled, end) = (coupled.min(time), roll);
        let (time, roll) = timed(&|| by_hand(&plant, &controller));
        (alone, same) = (alone.min(time), roll);
    }
    assert_eq!(end.to_bits(), same.to_bits(), "the same ride");
    let calls = f64::from(STEPS) * 2.0;
    println!(
        "a ride of {STOP} s with its controller, {} steps: {:.2} ms",
        STEPS,
        1e3 * coupled
    );
    println!("the same calls by hand: {:.2} ms", 1e3 * alone);
    println!(
        "the master: {:.0} ns for each FMU and step",
        1e9 * (coupled - alone) / calls
    );
}

/// Bicycle and controller, loaded.
fn fmus() -> Option<(TempDir, Fmu, Fmu)> {
    let folder = tempfile::tempdir().expect("a folder");
    let plant = folder.path().join("plant.fmu");
    fmu::pack(&fmu::built_library().expect("built"), &plant).expect("packed");
    let controller = folder.path().join("controller.fmu");
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fmi-export/examples");
    let mut package = Package::from_xml(&examples.join("roll_assist.xml")).expect("a description");
    package.libraries.push((Platform::current()?, example()?));
    package.write(&controller).expect("packed");
    let open = |path: &Path| Fmu::open(path).expect("loaded");
    let (plant, controller) = (open(&plant), open(&controller));
    Some((folder, plant, controller))
}

fn example() -> Option<PathBuf> {
    let this = std::env::current_exe().expect("a running benchmark");
    let folder = this.ancestors().nth(2)?.join("examples");
    let name = format!(
        "{}roll_assist{}",
        std::env::consts::DLL_PREFIX,
        std::env::consts::DLL_SUFFIX
    );
    Some(folder.join(name)).filter(|path| path.is_file())
}

fn starts() -> Vec<(String, Value)> {
    vec![
        ("roll_start".to_owned(), Value::Real(0.05)),
        ("rear_load".to_owned(), Value::Real(20.0)),
    ]
}

fn by_master(plant: &Fmu, controller: &Fmu) -> f64 {
    let member = |name: &str, foreign| Member {
        name: name.to_owned(),
        participant: Box::new(foreign),
        step: None,
    };
    let members = vec![
        member(
            "controller",
            Foreign::new(controller, "controller", &[]).expect("made"),
        ),
        member(
            "plant",
            Foreign::new(plant, "plant", &starts()).expect("made"),
        ),
    ];
    let connections = by_name(&members, &[]);
    let mut master = Master::new(members, connections).expect("connected");
    let run = master.run(&Plan {
        start_time: 0.0,
        stop_time: STOP,
        step: STEP,
        algorithm: fmi_import::master::Algorithm::Jacobi,
        tolerance: None,
        initial_exchange: true,
        record: vec!["plant.roll".parse().expect("a terminal")],
    });
    *run.expect("ran").columns[1].last().expect("a row")
}

/// What the master calls, and no more.
fn by_hand(plant: &Fmu, controller: &Fmu) -> f64 {
    let mut plant_side = Foreign::new(plant, "plant", &starts()).expect("made");
    let mut other = Foreign::new(controller, "controller", &[]).expect("made");
    let reference = |fmu: &Fmu, name: &str| {
        fmu.description()
            .variable(name)
            .expect("a variable")
            .value_reference
    };
    let seen = ["roll", "roll_rate"].map(|name| reference(plant, name));
    let wanted = ["roll", "roll_rate"].map(|name| reference(controller, name));
    let given = [reference(controller, "assist_torque")];
    let taken = [reference(plant, "assist_torque")];

    let (mut roll, mut torque) = ([0.0; 2], [0.0]);
    plant_side.enter_initialization(0.0, STOP).expect("entered");
    other.enter_initialization(0.0, STOP).expect("entered");
    plant_side
        .instance()
        .get_real(&seen, &mut roll)
        .expect("read");
    other.instance().set_real(&wanted, &roll).expect("set");
    plant_side.exit_initialization().expect("left");
    other.exit_initialization().expect("left");
    let mut rolls = Vec::new();
    for n in 0..STEPS {
        let (from, to) = (f64::from(n) * STEP, f64::from(n + 1) * STEP);
        other.instance().set_real(&wanted, &roll).expect("set");
        let stepped = other.instance().do_step(from, to - from);
        assert_eq!(stepped.expect("stepped"), Step::Complete);
        plant_side
            .instance()
            .set_real(&taken, &torque)
            .expect("set");
        let stepped = plant_side.instance().do_step(from, to - from);
        assert_eq!(stepped.expect("stepped"), Step::Complete);
        other
            .instance()
            .get_real(&given, &mut torque)
            .expect("read");
        plant_side
            .instance()
            .get_real(&seen, &mut roll)
            .expect("read");
        rolls.push(roll[0]);
    }
    *rolls.last().expect("a row")
}
