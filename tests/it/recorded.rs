//! The main job on a real recording: the Delft steer-by-wire bicycle on a treadmill.

use crate::wobble::{data, json};

/// Torque gains as uncertain as the friction, and sensors with offsets: no formulation explains
/// this bicycle's rides to the noise of its sensors. The fit must end and say so; the search, along
/// a valley that leads nowhere, is cut short.
#[test]
fn a_recorded_ride_is_fitted_and_its_misfit_told() {
    let Some(data) = data() else { return };
    let ride = data.join("sbw-delft/bode_normal_4mps_1.1Hz.csv");
    let folder = tempfile::tempdir().expect("a folder");
    let call = format!(
        "fit {} --map sbw-delft --bicycle sbw-delft --max-iterations 15 --json --report report.html",
        ride.display()
    );
    let fit = json(folder.path(), &call);
    assert_eq!(fit["objective"], "time");
    assert_eq!(fit["rides"][0]["start"]["law_in_loop"], true);
    // its wheels do not slip: friction alone is sought
    assert_eq!(fit["parameters"].as_array().expect("rows").len(), 2);
    let misfit = fit["misfit"].as_f64().expect("a number");
    assert!(
        misfit > 1.5,
        "the model explains the Delft bicycle? {misfit}"
    );
    // the paper's equations explain the same ride worse
    let lumped = json(folder.path(), &format!("{call} --formulation repaired"));
    assert!(lumped["misfit"].as_f64().expect("a number") > 2.0 * misfit);
    let replays = &fit["explained"][0]["replays"];
    for replay in replays.as_array().expect("channels") {
        assert!(replay["variance_accounted_for"].is_f64(), "{replay}");
    }
    // a model that does not describe the ride determines nothing of it
    for row in fit["parameters"].as_array().expect("rows") {
        assert_eq!(row["verdict"], "not determined", "{row}");
    }
    let report = std::fs::read_to_string(folder.path().join("report.html")).expect("written");
    assert!(report.contains("bode_normal_4mps_1.1Hz.csv"));
}

/// Every run of the set can be read with its map, and its known flaws are found.
#[test]
fn every_recorded_run_is_read_and_standstill_found_where_it_is() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let mut runs = 0;
    for entry in std::fs::read_dir(data.join("sbw-delft")).expect("the data set") {
        let path = entry.expect("an entry").path();
        let name = path
            .file_name()
            .and_then(|n| n.to_str())
            .unwrap_or_default()
            .to_owned();
        if !(name.starts_with("bode") || name.starts_with("eigen")) {
            continue;
        }
        runs += 1;
        let found = json(
            folder.path(),
            &format!("inspect {} --map sbw-delft --json", path.display()),
        );
        let stands = found["findings"]
            .as_array()
            .expect("findings")
            .iter()
            .any(|finding| finding.to_string().contains("standstill"));
        let known = [
            "4mps_1.2Hz",
            "4mps_2.6Hz",
            "4mps_3.0Hz",
            "normal_sil6.5n2_7.2kph",
            "mm_sil6.5n2_5.4kph",
        ];
        assert_eq!(stands, known.iter().any(|k| name.contains(k)), "{name}");
    }
    assert!(runs > 20, "{runs} runs");
}
