//! The program from outside: results, and a clear word for every kind of bad input.

use crate::wobble::{json, wobble};
use std::fs;
use std::path::Path;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

/// A ride of `seconds` made by the program itself.
fn ride(folder: &Path, seconds: u32, extra: &str) {
    let call = format!(
        "simulate --ride --set remnant_intensity=2 --duration {seconds}s {extra} -o ride.csv"
    );
    let called = wobble(folder, &call);
    assert_eq!(called.code, 0, "{}", called.err);
}

/// `call` fails with `code`, `message` in its words, and nothing new in the folder.
#[track_caller]
fn refused(folder: &Path, call: &str, code: i32, message: &str) {
    let list = || {
        let mut names: Vec<_> = fs::read_dir(folder)
            .expect("a folder")
            .map(|e| e.expect("an entry").file_name())
            .collect();
        names.sort();
        names
    };
    let before = list();
    let called = wobble(folder, call);
    assert_eq!(called.code, code, "wobble {call}: {}", called.err);
    assert!(
        called.err.contains(message),
        "wobble {call}: {}",
        called.err
    );
    assert_eq!(called.out, "", "wobble {call}");
    assert_eq!(list(), before, "wobble {call} left something behind");
}

#[test]
fn the_nine_cases_of_section3() {
    let cases = json(folder().path(), "cases --bicycle section3 --json");
    let cases = cases["cases"].as_array().expect("cases");
    assert_eq!(cases.len(), 9);
    for (i, case) in cases.iter().enumerate() {
        assert_eq!(case["case"], i + 1);
        let ended = i >= 6;
        assert_eq!(case["stop"], if ended { "steer_limit" } else { "end" });
        assert_eq!(case["amplitude_deg"].is_null(), ended);
        assert_eq!(case["end_time"].as_f64().expect("s") < 5.0, ended);
    }
}

#[test]
fn the_same_call_gives_the_same_bytes() {
    let folder = folder();
    for call in [
        "parameters --json",
        "cases --bicycle section3",
        "simulate --duration 2s --set roll_start=2deg",
        "simulate --ride --duration 6s --set remnant_intensity=1 --seed 7",
    ] {
        let [first, second] = [(); 2].map(|()| wobble(folder.path(), call).out);
        assert!(!first.is_empty() && first == second, "wobble {call}");
    }
}

#[test]
fn units_are_understood_and_the_table_listed() {
    let folder = folder();
    let rows = json(
        folder.path(),
        "parameters --json --set speed=9km/h --set caster_angle=18deg --load 20kg",
    );
    let value = |name: &str| {
        let rows = rows.as_array().expect("rows");
        rows.iter().find(|r| r["name"] == name).expect("a row")["value"]
            .as_f64()
            .expect("a number")
    };
    assert_eq!(value("speed"), 2.5);
    assert!(
        (value("caster_angle") - 18f64.to_radians()).abs() < 1e-15,
        "to round-off"
    );
    assert_eq!(value("rear_load"), 20.0);
}

#[test]
fn a_ride_is_simulated_inspected_fitted_and_reported() {
    let folder = folder();
    let path = folder.path();
    ride(path, 24, "--seed 3");
    let inspected = json(path, "inspect ride.csv --json");
    assert_eq!(inspected["samples"], 4800);
    let fit = json(path, "fit ride.csv --json");
    assert_eq!(fit["objective"], "whittle");
    let rows = fit["parameters"].as_array().expect("rows");
    let keys = [
        "name",
        "unit",
        "value",
        "std_error",
        "lower",
        "upper",
        "at_bound",
        "verdict",
        "trades_against",
    ];
    for row in rows {
        for key in keys {
            assert!(row.get(key).is_some(), "{key} in {row}");
        }
    }
    assert_eq!(rows[0]["name"], "cornering_stiffness");
    assert_eq!(rows[0]["verdict"], "determined");
    // on record, read again, drawn
    assert_eq!(
        wobble(path, "fit ride.csv -o fit.json --report first.html").code,
        0
    );
    assert_eq!(wobble(path, "report fit.json -o second.html").code, 0);
    let read = |name| fs::read_to_string(path.join(name)).expect("written");
    assert_eq!(read("first.html"), read("second.html"));
    assert!(!read("first.html").contains("src=\"http"));
    // with another ride in its place the record is refused
    ride(path, 24, "--seed 4");
    refused(
        path,
        "report fit.json -o third.html",
        1,
        "expected the ride of the fit (SHA-256 ",
    );
}

#[test]
fn free_all_runs_on_steering_alone_and_says_what_would_help() {
    let folder = folder();
    ride(folder.path(), 24, "");
    let called = wobble(
        folder.path(),
        "fit ride.csv --channels steer --objective amplitude --free all --json",
    );
    assert_eq!(called.code, 0, "{}", called.err);
    let fit: serde_json::Value = serde_json::from_str(&called.out).expect("JSON");
    let rows = fit["parameters"].as_array().expect("rows");
    let verdicts: Vec<_> = rows
        .iter()
        .map(|r| r["verdict"].as_str().expect("a word"))
        .collect();
    assert_eq!(
        verdicts,
        [
            "not determined",
            "not determined",
            "not determined",
            "not determined",
            "nuisance"
        ]
    );
    assert!(rows[2]["std_error"].is_null() && rows[3]["std_error"].is_null());
    let opening = called.err.split("parameter ").next().expect("an opening");
    let opening = opening.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(opening.contains("Roll rate and yaw rate"), "{}", called.err);
    assert!(
        opening.contains("measured steer torque would determine all four"),
        "{}",
        called.err
    );
}

#[test]
fn files_that_cannot_be_used() {
    let folder = folder();
    let path = folder.path();
    let write = |name: &str, text: &str| fs::write(path.join(name), text).expect("written");
    refused(
        path,
        "inspect nowhere.csv",
        1,
        "nowhere.csv: cannot be read",
    );
    write("empty.csv", "");
    refused(
        path,
        "inspect empty.csv",
        1,
        "empty.csv: expected a header and at least 2 rows",
    );
    write("one.csv", "time[s],steer[rad]\n0,0.1\n");
    refused(
        path,
        "fit one.csv",
        1,
        "one.csv: expected a header and at least 2 rows",
    );
    let rows = |bad: &str| {
        let row = |i: usize| match i {
            812 => format!("{},{bad}", 810.0 * 0.005),
            _ => format!("{},{}", (i - 2) as f64 * 0.005, (i as f64).sin()),
        };
        (2..2000)
            .map(row)
            .fold("time[s],steer[rad]".to_owned(), |text, row| {
                text + "\n" + &row
            })
    };
    write("nan.csv", &rows("NaN"));
    refused(path, "fit nan.csv -o fit.json", 1, "nan.csv, row 812");
    write("text.csv", &rows("n/a"));
    refused(path, "fit text.csv -o fit.json", 1, "text.csv, row 812");
    write(
        "unsorted.csv",
        "time[s],steer[rad]\n0,1\n0.01,2\n0.005,3\n0.02,4\n",
    );
    refused(path, "inspect unsorted.csv", 1, "unsorted.csv, row 4");
    write(
        "repeated.csv",
        "time[s],steer[rad]\n0,1\n0.01,2\n0.01,3\n0.02,4\n",
    );
    refused(path, "inspect repeated.csv", 1, "repeated.csv, row 4");
    let gap = |i: usize| {
        format!(
            "{},{}",
            i as f64 * 0.005 + if i > 700 { 1.0 } else { 0.0 },
            i % 7
        )
    };
    write(
        "gap.csv",
        &(0..2000)
            .map(gap)
            .fold("time[s],steer[rad]".to_owned(), |t, r| t + "\n" + &r),
    );
    refused(path, "fit gap.csv", 1, "gap.csv, row 703");
    write("unit.csv", "time[s],steer[kg]\n0,1\n0.01,2\n");
    refused(
        path,
        "inspect unit.csv",
        1,
        "expected a unit of the dimension of rad, found `kg`",
    );
    write("column.csv", "time[s],stear[rad]\n0,1\n0.01,2\n");
    refused(path, "inspect column.csv", 1, "nearest: steer");
    write("cut.json", "{\"program\": \"wobble\",");
    refused(path, "report cut.json", 1, "cut.json, row 1");
}

#[test]
fn rides_that_cannot_be_fitted() {
    let folder = folder();
    let path = folder.path();
    ride(path, 4, "");
    refused(
        path,
        "fit ride.csv -o fit.json",
        1,
        "moving average: expected 0.01 s to 4 s (the record), found 5 s",
    );
    ride(path, 24, "");
    let text = fs::read_to_string(path.join("ride.csv")).expect("a ride");
    // the speed is the last column
    let standing = text.replace(",2.2222222222222223\n", ",0\n");
    assert_ne!(standing, text);
    fs::write(path.join("standing.csv"), standing).expect("written");
    refused(
        path,
        "fit standing.csv",
        1,
        "expected a speed above 0.5 m/s, found standstill",
    );
    let zero: String = text
        .lines()
        .enumerate()
        .map(|(i, line)| {
            let mut cells: Vec<&str> = line.split(',').collect();
            if i > 1 || !line.starts_with(['#', 't']) {
                cells[1] = "0";
            }
            cells.join(",") + "\n"
        })
        .collect();
    fs::write(path.join("zero.csv"), zero).expect("written");
    refused(
        path,
        "fit zero.csv",
        1,
        "expected a signal in channel `steer`, found 0 rad throughout",
    );
    refused(
        path,
        "fit ride.csv --objective time",
        1,
        "no channel `steer_torque`",
    );
    refused(
        path,
        "fit ride.csv --free rear_load_x",
        1,
        "`rear_load_x` does not influence",
    );
    refused(
        path,
        "fit ride.csv --free effective_damping,coulomb_friction",
        1,
        "free either it or them",
    );
    refused(path, "fit ride.csv --band 0.3:300", 2, "100 Hz (Nyquist)");
    // 20 Hz: nothing above 10 Hz to take the noise from
    ride(path, 24, "--step 50ms --torque");
    for objective in ["time", "whittle"] {
        refused(
            path,
            &format!("fit ride.csv --objective {objective}"),
            1,
            "noise of `steer`: expected bins above 10 Hz",
        );
    }
    // a rider law plays no part where the whole torque is replayed
    ride(path, 24, "--torque");
    refused(
        path,
        "fit ride.csv --free rider_roll_gain",
        1,
        "`rider_roll_gain` does not influence the time objective",
    );
}

#[test]
fn a_fit_with_everything_at_a_bound_is_a_result() {
    let folder = folder();
    ride(folder.path(), 24, "");
    let call = "fit ride.csv --free remnant_intensity --bounds remnant_intensity=0.01:0.5 --json";
    let fit = json(folder.path(), call);
    assert_eq!(fit["parameters"][0]["at_bound"], true);
    assert!(fit["parameters"][0]["std_error"].is_null());
}

#[test]
fn the_speed_typed_counts_where_none_was_recorded() {
    let folder = folder();
    let path = folder.path();
    ride(path, 24, "--torque --set speed=5");
    let text = fs::read_to_string(path.join("ride.csv")).expect("a ride");
    let header = text
        .lines()
        .find(|line| line.starts_with("time"))
        .expect("a header");
    let speed = header
        .split(',')
        .position(|name| name.starts_with("speed"))
        .expect("a column");
    let without = |line: &str| {
        if line.starts_with('#') {
            return line.to_owned();
        }
        let cells = line.split(',').enumerate().filter(|(i, _)| *i != speed);
        cells.map(|(_, cell)| cell).collect::<Vec<_>>().join(",")
    };
    let cut = text.lines().map(without).collect::<Vec<_>>().join("\n");
    fs::write(path.join("cut.csv"), cut).expect("written");
    let value = |call| {
        json(path, call)["parameters"][0]["value"]
            .as_f64()
            .expect("a number")
    };
    let recorded = value("fit ride.csv --json");
    assert_eq!(value("fit cut.csv --set speed=5 --json"), recorded);
    assert_ne!(value("fit cut.csv --json"), recorded);
}

#[test]
fn an_unmasked_line_is_remarked_on() {
    let folder = folder();
    ride(folder.path(), 24, "--line 1.111Hz,4N.m");
    let line = "the steering has a line at 1.12 Hz";
    let told = |call| {
        let err = wobble(folder.path(), call).err;
        err.split_whitespace()
            .collect::<Vec<_>>()
            .join(" ")
            .contains(line)
    };
    assert!(told("fit ride.csv"));
    assert!(!told("fit ride.csv --line 1.111Hz"));
}

#[test]
fn calls_that_were_typed_wrong() {
    let folder = folder();
    let path = folder.path();
    ride(path, 24, "");
    for (call, message) in [
        (
            "simulate --set trial=3",
            "unknown parameter `trial`; nearest: trail",
        ),
        ("simulate --set trail=3kg", "trail"),
        (
            "simulate --set trail=3",
            "expected -0.1 to 0.2 m, found 3 m",
        ),
        ("simulate --set speed=-1", "speed"),
        ("simulate --duration 0s", "expected a time above 0 s"),
        ("simulate --at 5s", "expected TIME:NAME=VALUE"),
        ("cases --formulation repeared", "nearest: repaired"),
        ("fit ride.csv --free trial", "nearest: trail"),
        (
            "fit ride.csv --free trail --bounds trail=0.1:0.05",
            "expected lower < upper within -0.1 to 0.2 m",
        ),
        (
            "fit ride.csv --free trail --bounds wheelbase=1:2",
            "`wheelbase` is held, not free: expected one of trail, remnant_intensity",
        ),
        ("fit ride.csv --objective amplitud", "nearest: amplitude"),
        ("fit ride.csv --channels stear", "nearest: steer"),
        ("spectrum ride.csv --band 3", "expected LOW:HIGH"),
        ("spectrum ride.csv --channel stear", "nearest: steer"),
        (
            "fit ride.csv --line 0",
            "line: expected a frequency between 0 and 100 Hz",
        ),
        ("fit ride.csv --band 3:0.3", "expected 0 <= low < high"),
        ("fit ride.csv --free trail,trail", "expected each name once"),
        (
            "fit ride.csv --bounds cornering_stiffness=10:5",
            "expected lower < upper within 2 to 40 1/rad",
        ),
        ("fit ride.csv --noise steer=-1deg", "--noise"),
        (
            "simulate --at 1s:roll_start=1",
            "a row that may change under way",
        ),
        ("simulate --at 50s:speed=3", "a time within the simulation"),
        (
            "fit ride.csv --shared trail --per-ride trail --free trail",
            "expected one of --shared, --per-condition and --per-ride for a parameter, found `trail`",
        ),
        ("fit --study s.toml --load 20kg", "cannot be used with"),
        (
            "fit ride.csv --window 0.5s",
            "--window is offered for the objectives time, frf",
        ),
        (
            "fit ride.csv --bounds cornering_stiffness=20:30",
            "expected them to hold its start value 14 1/rad, found 20 to 30",
        ),
        (
            "fit ride.csv --times 5s:100s",
            "within 0 to 23.995 s, found 5 to 100 s",
        ),
        (
            "fit ride.csv --times=-5s:10s",
            "within 0 to 23.995 s, found -5 to 10 s",
        ),
        ("fit ride.csv --bootstrap 1", "expected 2 fits or more"),
        (
            "fit ride.csv --population 1",
            "expected 8 evaluations of the cost, one generation",
        ),
        (
            "fit ride.csv --objective free-response",
            "(--windows FILE), found none",
        ),
        (
            "fit ride.csv --prior coulomb_friction",
            "`coulomb_friction` is held, not free",
        ),
        (
            "fit ride.csv --free torque_offset --tie steer_offset=torque_offset",
            "starts at 0, so that there is no ratio to keep",
        ),
        ("compare ride.csv", "2 values required"),
        ("frobnicate", "unrecognized subcommand"),
    ] {
        refused(path, call, 2, message);
    }
}

#[test]
fn nothing_is_written_over_what_is_read_and_nothing_begun_that_cannot_be_written() {
    let folder = folder();
    let path = folder.path();
    ride(path, 24, "");
    fs::copy(path.join("ride.csv"), path.join("other.csv")).expect("copied");
    fs::create_dir(path.join("in")).expect("a folder");
    let fit = wobble(path, "fit ride.csv -o fit.json");
    assert_eq!(fit.code, 0, "{}", fit.err);
    let read = || ["ride.csv", "fit.json"].map(|name| fs::read(path.join(name)).expect("a file"));
    let before = read();
    let taken = "expected a file of its own to write to, found one that this call reads";
    for call in [
        "fit ride.csv -o ride.csv",
        "fit ride.csv -o in/../ride.csv",
        "inspect ride.csv --html ride.csv",
        "compare other.csv ride.csv --figure ride.csv",
        "report fit.json -o fit.json",
        "report fit.json -o ride.csv",
        "validate fit.json other.csv --report ride.csv",
        "parameters --fit fit.json --toml fit.json",
    ] {
        refused(path, call, 2, taken);
    }
    refused(
        path,
        "fit ride.csv -o x --report x",
        2,
        "found it named twice",
    );
    for call in [
        "fit ride.csv -o none/fit.json --report report.html",
        "inspect ride.csv --html none/page.html",
    ] {
        refused(
            path,
            call,
            1,
            "cannot be written: No such file or directory",
        );
    }
    refused(
        path,
        "fit ride.csv -o in",
        1,
        "cannot be written: is a directory",
    );
    assert_eq!(read(), before);
}

#[test]
fn rides_of_different_sampling_are_not_held_against_each_other() {
    let folder = folder();
    let path = folder.path();
    ride(path, 24, "--step 10ms --seed 2");
    fs::rename(path.join("ride.csv"), path.join("half.csv")).expect("renamed");
    ride(path, 24, "");
    assert_eq!(wobble(path, "fit ride.csv -o fit.json").code, 0);
    for call in [
        "fit ride.csv half.csv",
        "compare ride.csv half.csv",
        "validate fit.json half.csv",
    ] {
        refused(
            path,
            call,
            1,
            "half.csv: expected 200 Hz as in ride.csv, found 100 Hz",
        );
    }
    refused(
        path,
        "validate ride.csv half.csv",
        1,
        "expected a fit as `wobble fit -o` writes it",
    );
    refused(
        path,
        "fit ride.csv --band 1:1.1",
        1,
        "as many bins as the 4 free parameters, found 3",
    );
    // another run's journal: what to do, not two hashes
    let call = |seed| format!("fit ride.csv --starts 2 --seed {seed} --resume half");
    assert_eq!(wobble(path, &call(5)).code, 0);
    refused(path, &call(6), 1, "or name another file behind --resume");
}

#[test]
fn a_validation_and_a_comparison_become_pages_and_a_load_is_believed() {
    let folder = folder();
    let path = folder.path();
    ride(path, 24, "--seed 8 --load 20kg");
    fs::rename(path.join("ride.csv"), path.join("loaded.csv")).expect("renamed");
    ride(path, 24, "");
    let fit = wobble(path, "fit ride.csv -o fit.json --starts 2 --bootstrap 2");
    assert_eq!(fit.code, 0, "{}", fit.err);
    let said = fit.err.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        said.contains("2 of 2 searches ended where the best did"),
        "{said}"
    );
    assert!(
        said.contains("2 fits of data made again (simulated rides"),
        "{said}"
    );
    let call = "validate fit.json loaded.csv";
    let plain = wobble(path, &format!("{call} --json"));
    assert!(plain.err.contains("0 kg of load"), "{}", plain.err);
    let loaded = wobble(
        path,
        &format!("{call} --load 20kg --json --report page.html"),
    );
    assert_eq!(loaded.code, 0, "{}", loaded.err);
    assert_ne!(plain.out, loaded.out);
    let page = |name: &str| fs::read_to_string(path.join(name)).expect("a page");
    assert!(
        page("page.html").contains("<h2>Validation") && page("page.html").contains("loaded.csv")
    );
    let compared = wobble(path, "compare ride.csv loaded.csv --html compared.html");
    assert_eq!(compared.code, 0, "{}", compared.err);
    assert!(page("compared.html").contains("wobble compare ride.csv loaded.csv --html"));
}

#[test]
fn bicycles_that_cannot_be_ridden() {
    let folder = folder();
    let path = folder.path();
    refused(path, "simulate --bicycle nominall", 2, "nominal");
    refused(
        path,
        "simulate --bicycle section3 --rider 75kg,1.78m",
        2,
        "a rider cannot be put on",
    );
    refused(
        path,
        "simulate --load 90kg --set rear_load_x=-0.9",
        2,
        "expected a front wheel on the ground",
    );
    refused(
        path,
        "simulate --set internal_step=5ms --set coulomb_friction=3 --set steer_rate_smoothing=1e-4",
        1,
        "the stability limit of these parameters",
    );
}

#[test]
fn an_fmu_without_a_library_says_how_to_get_one() {
    let folder = folder();
    refused(
        folder.path(),
        "fmu --library nowhere.so -o out.fmu",
        1,
        "nowhere.so",
    );
}
