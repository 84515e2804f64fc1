//! `wobble demo`: the whole way once, from nothing to a report; or a whole study.

mod full;

use crate::cases::courses;
use crate::fitting;
use crate::output::{Output, Progress};
use anyhow::{Context, Result};
use bicycle::{Excitation, cases};
use clap::Args;
use identify::bicycles::{Bicycle, Changes};
use identify::effort::Effort;
use identify::import::Import;
use identify::plan::Plan;
use identify::run::{Run, Source};
use identify::spectrum::{Line, Recipe};
use identify::synthesis::{Synthesis, TorqueLine};
use identify::{figure, file, report};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Load of the loaded rides [kg].
const LOAD: f64 = 20.0;
/// Cones 1 m apart are passed alternately at 8 km/h: a sine of V/(2 · 1 m); its torque is assumed.
const SLALOM: TorqueLine = TorqueLine {
    frequency: 8.0 / 3.6 / 2.0,
    amplitude: 4.0,
};
/// Remnant of the riders, assumed [N m rms].
const REMNANT: f64 = 2.0;

#[derive(Args)]
pub struct Demo {
    /// Folder to write into
    #[arg(short, long, value_name = "FOLDER", default_value = "demo")]
    out: PathBuf,
    /// Write a study instead: three riders, three trails, without and with a load, compared
    #[arg(long)]
    full: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// A synthetic ride on disk and the bicycle that made it.
struct Ridden {
    path: PathBuf,
    bicycle: Bicycle,
}

impl Demo {
    pub fn run(&self) -> Result<()> {
        if self.full {
            return full::run(&self.out, self.json);
        }
        let progress = Progress::new();
        let mut written = Vec::new();

        std::fs::create_dir_all(self.out.join("rides"))
            .with_context(|| format!("{}: cannot be made", self.out.display()))?;
        // all the rest needs no shared library beside the program
        let mut unpacked = None;
        match fmu::built_library() {
            Ok(library) => {
                progress.say("packing the FMU");
                let fmu = self.out.join("RearLoadBicycle.fmu");
                fmu::pack(&library, &fmu)?;
                written.push((fmu, "the bicycle as an FMI 2.0 co-simulation FMU"));
            }
            Err(cause) => unpacked = Some(cause),
        }

        progress.say("running the nine cases");
        let section3 = Bicycle::open("section3", &Changes::default())?;
        let figure = self.out.join("cases.svg");
        file::write(&figure, figure::cases(&courses(&section3, &cases::all())?))?;
        written.push((figure, "the nine cases of the paper's section 3"));

        progress.say("riding six slaloms");
        let rides = ride_all(&self.out.join("rides"))?;
        for ridden in &rides {
            written.push((ridden.path.clone(), "a synthetic ride of 24 s"));
        }

        progress.say("fitting one of them");
        let ridden = &rides[2];
        let (run, html) = fit(ridden)?;
        for (name, text, what) in [
            ("fit.json", run.to_json() + "\n", "the fit, reproducible"),
            ("report.html", html, "its report"),
        ] {
            let path = self.out.join(name);
            file::write(&path, text)?;
            written.push((path, what));
        }
        drop(progress);
        if let Some(cause) = unpacked {
            eprintln!("note: no FMU was packed: {cause}");
        }

        let truth = truth(&run, ridden);
        eprintln!("{}", report::table(&run.fit));
        eprintln!("truth beside estimate, {}:", ridden.path.display());
        for (name, truth) in &truth {
            let e = run.fit.estimate(name).context("a row of the fit")?;
            let error = e
                .std_error
                .map_or_else(|| "?".into(), |s| format!("{s:.3}"));
            eprintln!(
                "  {name:22} {truth:>8.3}   {:>8.3} ± {error} {}   {}",
                e.value,
                e.unit,
                e.verdict.name()
            );
        }
        eprintln!("\nwrote");
        for (path, what) in &written {
            eprintln!("  {:40} {what}", path.display().to_string());
        }
        if self.json {
            let files: Vec<_> = written
                .iter()
                .map(|(path, _)| path.display().to_string())
                .collect();
            let truth: serde_json::Map<_, _> = truth
                .iter()
                .map(|(name, value)| ((*name).to_owned(), json!(value)))
                .collect();
            let json = json!({ "wrote": files, "truth": truth, "parameters": run.fit.parameters });
            Output {
                json: true,
                out: None,
            }
            .json_or(&json, String::new)?;
        }
        Ok(())
    }
}

/// Six rides as the paper rode them: three trails, without and with a load.
fn ride_all(folder: &Path) -> Result<Vec<Ridden>> {
    let mut rides = Vec::new();
    for trail in cases::TRAILS {
        for load in [0.0, LOAD] {
            let changes = Changes {
                load: Some(format!("{load}kg")),
                set: vec![format!("trail={trail}")],
                ..Changes::default()
            };
            let bicycle = Bicycle::open("nominal", &changes)?;
            let ride = synthesis(&bicycle, 1 + rides.len() as u64).ride()?;
            let millimetres = (trail * 1000.0).round();
            let path = folder.join(format!("trail_{millimetres}mm_load_{load}kg.csv"));
            ride.write(&path)?;
            rides.push(Ridden { path, bicycle });
        }
    }
    Ok(rides)
}

/// A slalom on a bicycle.
fn synthesis(bicycle: &Bicycle, seed: u64) -> Synthesis {
    Synthesis {
        parameters: bicycle.parameters,
        input: bicycle.input,
        excitation: Excitation {
            remnant_intensity: REMNANT,
            ..Excitation::default()
        },
        line: Some(SLALOM),
        seed,
        ..Synthesis::default()
    }
}

/// Spectra without the slalom.
fn recipe() -> Recipe {
    Recipe {
        lines: vec![Line {
            frequency: SLALOM.frequency,
        }],
        ..Recipe::default()
    }
}

/// Fits a ride, read back from its file as anyone's would be.
fn fit(ridden: &Ridden) -> Result<(Run, String)> {
    let ride = Import::default().read(&ridden.path)?;
    let plan = Plan {
        parameters: ridden.bicycle.parameters,
        recipe: recipe(),
        ..Plan::default()
    };
    let (rides, source) = ([plan.ridden(&ride)], Source::of(&ride));
    let effort = Effort {
        seed: 1000,
        ..Effort::default()
    };
    let run = fitting::run(
        &rides,
        &plan,
        &effort,
        vec![(source, ridden.bicycle.name.as_str())],
    )?;
    let html = report::html(&run, std::slice::from_ref(&ride))?;
    Ok((run, html))
}

/// The values behind a ride, of those parameters that a fit sought.
fn truth(run: &Run, ridden: &Ridden) -> Vec<(&'static str, f64)> {
    let p = &ridden.bicycle.parameters;
    // the steer rate of the fitted loop stands for that of the ride
    let deviation = run.fit.explained[0].steer_rate_deviation;
    let gain = deviation.map_or(0.0, identify::closed_loop::sign_gain);
    [
        ("cornering_stiffness", p.cornering_stiffness),
        ("camber_stiffness", p.camber_stiffness),
        (
            "effective_damping",
            p.viscous_friction + gain * p.coulomb_friction,
        ),
        ("remnant_intensity", REMNANT),
    ]
    .into_iter()
    .filter(|(name, _)| run.fit.estimate(name).is_some())
    .collect()
}
