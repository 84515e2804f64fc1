//! `wobble demo --full`: the paper's experiment with synthetic riders, from files to Figs. 8 to 10.

use super::{LOAD, recipe, synthesis};
use crate::output::{Output, Progress};
use anyhow::{Context, Result};
use bicycle::cases::TRAILS;
use identify::bicycles::{Bicycle, Changes};
use identify::compare;
use identify::study::Study;
use identify::{figure, file};
use serde_json::json;
use std::fmt::Write as _;
use std::path::Path;

/// The paper's Table 6.
const RIDERS: [&str; 3] = ["82kg,1.78m", "53kg,1.68m", "75kg,1.78m"];

/// Writes 18 rides and their study into `folder`, reads them back and compares.
pub fn run(folder: &Path, json: bool) -> Result<()> {
    let progress = Progress::new();
    std::fs::create_dir_all(folder.join("rides"))
        .with_context(|| format!("{}: cannot be made", folder.display()))?;
    let mut study = "# Synthetic: the riders and trails of the paper's Tables 5 and 6.\n\
        name = \"Three riders, three trails, without and with a load\"\n\
        bicycle = \"nominal\"\n"
        .to_owned();
    let mut written = Vec::new();
    for (nth, rider) in (1..).zip(RIDERS) {
        for trail in TRAILS {
            for load in [0.0, LOAD] {
                progress.say(&format!("riding {} of 18", written.len() + 1));
                let changes = Changes {
                    rider: Some(rider.into()),
                    load: Some(format!("{load}kg")),
                    set: vec![format!("trail={trail}")],
                    ..Changes::default()
                };
                let bicycle = Bicycle::open("nominal", &changes)?;
                let ride = synthesis(&bicycle, 101 + written.len() as u64).ride()?;
                let millimetres = (trail * 1000.0).round();
                let name = format!("rides/rider_{nth}_trail_{millimetres}mm_load_{load}kg.csv");
                let path = folder.join(&name);
                ride.write(&path)?;
                written.push(path);
                writeln!(
                    study,
                    "\n[[ride]]\nfile = \"{name}\"\nrider = \"{rider}\"\ntrail = \
                     \"{millimetres} mm\"\nload = \"{load} kg\""
                )?;
            }
        }
    }
    let path = folder.join("study.toml");
    file::write(&path, study)?;
    progress.say("comparing");
    let found = compare::loads(&Study::read(&path)?.rides, "steer", &recipe())?;
    let table = found.table();
    written.push(path);
    for (name, text) in [
        ("loads.txt", table.clone()),
        ("loads.json", serde_json::to_string_pretty(&found)? + "\n"),
        ("loads.svg", figure::loads(&found)),
    ] {
        let path = folder.join(name);
        file::write(&path, text)?;
        written.push(path);
    }
    drop(progress);
    eprint!("{table}\nwrote\n");
    for path in &written {
        eprintln!("  {}", path.display());
    }
    if json {
        let files: Vec<_> = written
            .iter()
            .map(|path| path.display().to_string())
            .collect();
        let output = Output {
            json: true,
            out: None,
        };
        output.json_or(&json!({ "wrote": files, "loads": found }), String::new)?;
    }
    Ok(())
}
