//! Rides of several kinds and rides beside each other, from outside.

use crate::wobble::{data, json, wobble};
use std::path::{Path, PathBuf};

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("data/rides")
        .join(name)
}

#[test]
fn a_mat_file_is_a_ride_like_any_other() {
    let folder = tempfile::tempdir().expect("a folder");
    let call = format!(
        "inspect {} --json --html page.html",
        file("struct.mat").display()
    );
    let found = json(folder.path(), &call);
    assert_eq!(
        (&found["samples"], &found["rate"]),
        (&40.into(), &200.0.into())
    );
    let page = std::fs::read_to_string(folder.path().join("page.html")).expect("written");
    assert!(
        page.contains("<svg") && !page.contains("http"),
        "self-contained"
    );
}

/// The study of the paper from nothing: 18 rides, read back, compared.
#[test]
fn a_whole_study_is_written_and_compared() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let demo = json(path, "demo --full -o full --json");
    let cells = demo["loads"]["cells"].as_array().expect("cells");
    assert_eq!(
        (cells.len(), demo["wrote"].as_array().expect("files").len()),
        (9, 22)
    );
    for cell in cells {
        for band in cell["bands"].as_array().expect("bands") {
            let ratio = band["ratio"].as_f64().expect("a number");
            let [low, high] = [0, 1].map(|end| band["interval"][end].as_f64().expect("a number"));
            assert!(0.0 < low && low < ratio && ratio < high, "{band}");
            let verdict = match (low > 1.0, high < 1.0) {
                (true, _) => "rises",
                (_, true) => "falls",
                _ => "no change",
            };
            assert_eq!(band["verdict"], verdict);
        }
    }
    // the same by the study's file
    let line = "--line 1.1111111111111112Hz";
    let again = json(
        path,
        &format!("compare --study full/study.toml {line} --json --figure f.svg"),
    );
    assert_eq!(
        again["cells"][4]["bands"],
        demo["loads"]["cells"][4]["bands"]
    );
    let figures = ["f.svg", "full/loads.svg"]
        .map(|name| std::fs::read_to_string(path.join(name)).expect("written"));
    assert_eq!(figures[0], figures[1]);
    let refused = wobble(path, "compare --study full/study.toml --channel stear");
    assert_eq!(refused.code, 2, "{}", refused.err);
}

/// A speed that was ridden is ridden again.
#[test]
fn a_recorded_speed_drives_a_simulation() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let rows = (0..=40).map(|i| format!("{},{}\n", f64::from(i) * 0.1, 2.0 + f64::from(i) * 0.05));
    let text = rows.fold("time[s],speed[m/s]\n".to_owned(), |text, row| text + &row);
    std::fs::write(path.join("v.csv"), text).expect("written");
    let run = json(
        path,
        "simulate --speed-from v.csv --set roll_start=2deg --json",
    );
    let times = run["time"].as_array().expect("times");
    assert_eq!(times.last().and_then(serde_json::Value::as_f64), Some(4.0));
    // x of a nearly straight ride: the integral of the speed, 2 · 4 + .5 · .5 · 4² = 12 m
    let x = run["outputs"]["x"]
        .as_array()
        .and_then(|x| x.last()?.as_f64())
        .expect("m");
    assert!((x - 12.0).abs() < 0.2, "{x}");
    let ride = json(
        path,
        "simulate --ride --speed-from v.csv --step 50ms --json",
    );
    let speed = ride["channels"]["speed"].as_array().expect("samples");
    assert_eq!(speed.len(), 81);
    assert!(
        (speed[1].as_f64().expect("m/s") - 2.025).abs() < 1e-12,
        "halfway"
    );
    std::fs::write(path.join("none.csv"), "time[s],steer[rad]\n0,1\n1,2\n").expect("written");
    let refused = wobble(path, "simulate --speed-from none.csv");
    assert!(
        refused.err.contains("no channel `speed`"),
        "{}",
        refused.err
    );
}

/// What is wrong in the recorded runs: standstill in five; and four that begin before the steer
/// encoder was heard, so that its angle stays at 0 for ten samples and its first difference is a
/// glitch, −22 rad/s and −75 rad/s at worst (literature signs).
#[test]
fn the_flaws_of_recorded_rides_are_found_and_no_others() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let (mut stands, mut glitches, mut dropouts) = (Vec::new(), Vec::new(), Vec::new());
    for entry in std::fs::read_dir(data.join("sbw-delft")).expect("the data set") {
        let path = entry.expect("an entry").path();
        let name = path
            .file_stem()
            .and_then(|n| n.to_str())
            .unwrap_or_default()
            .to_owned();
        if !(name.starts_with("bode") || name.starts_with("eigen")) {
            continue;
        }
        let call = format!("inspect {} --map sbw-delft --json", path.display());
        let found = json(folder.path(), &call);
        for finding in found["findings"].as_array().expect("findings") {
            let number = |key: &str| finding[key].as_f64().expect("a number");
            match finding["kind"].as_str().expect("a kind") {
                "standstill" => stands.push(name.clone()),
                "glitch" if finding["at"]["rows"][0] == 2 && finding["channel"] == "steer_rate" => {
                    glitches.push((name.clone(), number("value")));
                }
                "dropout" if finding["channels"][0] == "steer" => {
                    assert_eq!(finding["span"]["rows"], serde_json::json!([2, 11]));
                    dropouts.push(name.clone());
                }
                _ => {}
            }
        }
    }
    for names in [&mut stands, &mut dropouts] {
        names.sort();
    }
    glitches.sort_by(|a, b| a.0.cmp(&b.0));
    assert_eq!(
        stands,
        [
            "bode_normal_4mps_1.2Hz",
            "bode_normal_4mps_2.6Hz",
            "bode_normal_4mps_3.0Hz",
            "eigen_mm_sil6.5n2_5.4kph",
            "eigen_normal_sil6.5n2_7.2kph"
        ]
    );
    let start = [
        ("bode_normal_4mps_2.6Hz", 22.14),
        ("eigen_mm_sil6.5n2_16.2kph", -1.5816),
        ("eigen_mm_sil6.5n2_5.4kph", 75.053),
        ("eigen_normal_sil6.5n2_7.2kph", -4.8882),
    ];
    assert_eq!(
        glitches,
        start.map(|(name, value)| (name.to_owned(), value))
    );
    assert_eq!(dropouts, start.map(|(name, _)| name.to_owned()));
}
