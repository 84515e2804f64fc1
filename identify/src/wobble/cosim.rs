//! The command cosim: the bicycle's FMU coupled with a controller, or with any FMUs.

mod against;

use crate::arguments::{SpectrumArguments, quantity};
use crate::model::positive;
use crate::output::{Output, Progress, typed};
use against::StudyArguments;
use anyhow::{Result, bail};
use bicycle::quantity::S;
use clap::Args;
use fmi_import::master::{End, Run};
use identify::assist::Study;
use identify::bicycles::Changes;
use identify::cosim::{
    Cases, Coupling, Hung, PLANT, Ran, Setup, Typed, algorithm, guarded, html, study, write_ssp,
};
use identify::error::Error;
use identify::{assist, file, trajectory};
use serde_json::json;
use std::path::PathBuf;
use std::time::Duration;

#[derive(Args)]
pub struct Cosim {
    /// What to couple, as a TOML file or an SSP archive, in place of --plant and --controller
    #[arg(value_name = "SYSTEM", required_unless_present = "plant", conflicts_with_all = ["plant", "controller"])]
    system: Option<PathBuf>,
    /// The bicycle's FMU
    #[arg(long, value_name = "FILE")]
    plant: Option<PathBuf>,
    /// The controller's FMU; without one the plant runs alone
    #[arg(long, value_name = "FILE", requires = "plant")]
    controller: Option<PathBuf>,
    /// Connect an output to an input, e.g. steer=delta or plant.steer=controller.delta; what has
    /// equal names is connected by itself
    #[arg(long, value_name = "SOURCE=TARGET")]
    connect: Vec<String>,
    /// Set a start value of the plant or of the remnant; of another FMU as controller.NAME=VALUE
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// Another bicycle in the plant: named set or TOML file [default: the FMU's start values]
    #[arg(long, value_name = "NAME|FILE")]
    bicycle: Option<String>,
    /// Load on the rear carrier
    #[arg(long, value_name = "MASS", allow_hyphen_values = true)]
    load: Option<String>,
    /// Put another rider on, e.g. 75kg,1.78m
    #[arg(
        long,
        value_name = "MASS,HEIGHT",
        requires = "bicycle",
        allow_hyphen_values = true
    )]
    rider: Option<String>,
    /// The equations of the plant
    #[arg(long, value_name = "NAME")]
    formulation: Option<String>,
    /// Communication step, and from row to row [default: 5ms]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    step: Option<String>,
    /// The controller's own communication step [default: the step its FMU suggests]
    #[arg(
        long,
        value_name = "TIME",
        requires = "controller",
        allow_hyphen_values = true
    )]
    controller_step: Option<String>,
    /// Until when [default: 20s, or the end of the course]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    stop: Option<String>,
    /// jacobi: all step from the values at the communication point; gauss-seidel: each from the
    /// newest, the controller before the plant [default: jacobi]
    #[arg(long, value_name = "NAME")]
    algorithm: Option<String>,
    /// Cut steps so that they put exchanged values off by no more than this within a second
    #[arg(long, value_name = "NUMBER", allow_hyphen_values = true)]
    tolerance: Option<f64>,
    /// Make the first step with the inputs' own start values, as fmpy's SSP simulation does
    #[arg(long)]
    no_initial_exchange: bool,
    /// Follow a course in place of the rider law
    #[arg(long, value_name = "NAME")]
    course: Option<String>,
    /// Set a row of the course or of the rider's manner
    #[arg(long, value_name = "NAME=VALUE")]
    course_set: Vec<String>,
    /// Seed of the remnant
    #[arg(long, value_name = "NUMBER")]
    seed: Option<u64>,
    #[command(flatten)]
    study: StudyArguments,
    /// Write the run, or the study, as an HTML page with figures
    #[arg(long, value_name = "FILE", conflicts_with = "ssp")]
    report: Option<PathBuf>,
    /// Write what is coupled as an SSP archive, and do not run it
    #[arg(long, value_name = "FILE")]
    ssp: Option<PathBuf>,
    #[command(flatten)]
    spectrum: SpectrumArguments,
    /// How long an FMU may take for one call
    #[arg(long, value_name = "TIME", default_value = "10s")]
    timeout: String,
    #[command(flatten)]
    output: Output,
}

/// What a guarded thread brings back.
enum Done {
    Ran(Ran),
    Studied(Study),
    Written(PathBuf),
}

fn tell(note: &str) {
    eprintln!("note: {note}");
}

impl Cosim {
    pub fn run(&self) -> Result<()> {
        let setup = self.setup()?;
        let timeout = Duration::try_from_secs_f64(quantity("--timeout", &self.timeout, S)?)
            .map_err(|_| form("a time of 0 s or more", &self.timeout).typed("--timeout"))?;
        let cases = self.study.cases(self.spectrum.recipe()?)?;
        let progress = Progress::new();
        progress.say("loading");
        let ssp = self.ssp.clone();
        let all = cases.as_ref().map_or(1, Cases::runs);
        let done = guarded(
            timeout,
            move |begun| -> Result<Done, Error> {
                let mut coupling = Coupling::open(&setup, &mut tell)?;
                if let Some(path) = ssp {
                    write_ssp(&coupling, &path)?;
                    return Ok(Done::Written(path));
                }
                let Some(mut cases) = cases else {
                    let ran = coupling.run(&coupling.as_typed(), begun)?;
                    return Ok(Done::Ran(ran));
                };
                against::prepare(&mut coupling, &mut cases);
                Ok(Done::Studied(study(&coupling, &cases, begun)?))
            },
            |runs, call| progress.say(&format!("run {runs} of at most {all}, {:.2} s", call.time)),
        );
        drop(progress);
        match done {
            Ok(done) => match done? {
                Done::Ran(ran) => self.write(ran),
                Done::Studied(study) => self.write_study(&study),
                Done::Written(path) => {
                    eprintln!("wrote {}", path.display());
                    Ok(())
                }
            },
            Err(hung) => self.write_hung(&hung),
        }
    }

    /// What was typed.
    fn setup(&self) -> Result<Setup> {
        let mut setup = match (&self.system, &self.plant) {
            (Some(path), _) => Setup::read(path)?,
            (None, plant) => Setup {
                fmus: self.members(plant.as_ref())?,
                ..Setup::default()
            },
        };
        let time = |flag: &'static str, text: &Option<String>| {
            text.as_deref().map(|text| positive(flag, text)).transpose()
        };
        setup.step = time("--step", &self.step)?.unwrap_or(setup.step);
        setup.stop = time("--stop", &self.stop)?.or(setup.stop);
        if let Some(name) = &self.algorithm {
            setup.algorithm =
                algorithm(name).map_err(|e| e.typed(format!("--algorithm {name}")))?;
        }
        setup.tolerance = self.tolerance.or(setup.tolerance);
        setup.initial_exchange &= !self.no_initial_exchange;
        setup.bicycle = self.bicycle.clone().or(setup.bicycle);
        setup.course = self.course.clone().or(setup.course);
        setup.course_set.extend(self.course_set.iter().cloned());
        setup.connect.extend(self.connect.iter().cloned());
        setup.seed = self.seed.unwrap_or(setup.seed);
        setup.changes = Changes {
            rider: self.rider.clone(),
            load: self.load.clone(),
            set: self.set.clone(),
            formulation: self.formulation.clone(),
        };
        Ok(setup)
    }

    /// The controller before the plant: under Gauss–Seidel its torque acts at once.
    fn members(&self, plant: Option<&PathBuf>) -> Result<Vec<Typed>> {
        let own = self.controller_step.as_deref();
        let step = own
            .map(|text| positive("--controller-step", text))
            .transpose()?;
        let typed = |name: &str, file: &PathBuf, step| Typed {
            name: name.to_owned(),
            file: file.clone(),
            set: Vec::new(),
            step,
        };
        let controller = self
            .controller
            .iter()
            .map(|file| typed("controller", file, step));
        let plant = plant.iter().map(|file| typed(PLANT, file, None));
        Ok(controller.chain(plant).collect())
    }

    /// Writes what was recorded, then says how the run ended.
    fn write(&self, ran: Ran) -> Result<()> {
        for connection in ran.between_fmus() {
            eprintln!("{connection}");
        }
        for ring in &ran.loops {
            eprintln!("note: algebraic loop {ring}: values around it lag by one step");
        }
        if !ran.run.settled && !ran.loops.is_empty() {
            eprintln!("note: initial values did not settle");
        }
        if ran.run.forced > 0 {
            eprintln!(
                "note: {} steps could not be cut as far as the tolerance needs",
                ran.run.forced
            );
        }
        let last = ran.run.columns[0].last().copied().unwrap_or(0.0);
        if matches!(ran.run.end, End::Complete) && ran.stop - last > 1e-9 {
            eprintln!(
                "note: a participant takes steps of one length only: the last row is at {last} s, \
                 before {} s",
                ran.stop
            );
        }
        let Run {
            names,
            columns,
            end,
            steps,
            taken_back,
            ..
        } = &ran.run;
        let ended = match end {
            End::Complete => "end",
            End::Stopped => "stopped",
            End::Early { .. } => "early",
            End::Failed(_) => "failed",
        };
        let json = json!({
            "stop": ended, "time": columns[0], "outputs": outputs(names, columns),
            "connections": ran.connections.iter().map(ToString::to_string).collect::<Vec<_>>(), "algebraic_loops": ran.loops,
            "steps": steps, "steps_taken_back": taken_back,
        });
        self.output
            .json_or(&json, || csv(names, &ran.units, columns))?;
        self.write_page(|typed| html(&ran, typed))?;
        match ran.run.end {
            End::Complete | End::Stopped => Ok(()),
            End::Early { member, time, log } => {
                eprintln!("note: {member} ended early, at {time} s");
                for line in log {
                    eprintln!("note: {line}");
                }
                // a bicycle may fall; anything else was to go on
                if member == PLANT {
                    Ok(())
                } else {
                    Err(Error::EndedEarly { member, time }.into())
                }
            }
            End::Failed(error) => Err(error.into()),
        }
    }

    /// Writes a study: the table or JSON, the page.
    fn write_study(&self, study: &Study) -> Result<()> {
        for line in assist::headline(study) {
            eprintln!("{line}");
        }
        self.output.json_or(study, || assist::table(study))?;
        self.write_page(|typed| assist::html(study, typed))
    }

    /// Writes the page that `page` makes of what was typed, if one was asked for.
    fn write_page(&self, page: impl FnOnce(&str) -> String) -> Result<()> {
        if let Some(path) = &self.report {
            file::write(path, page(&typed()))?;
            eprintln!("wrote {}", path.display());
        }
        Ok(())
    }

    /// Writes what was reached of a run that hangs; the process ends with it.
    fn write_hung(&self, hung: &Hung) -> Result<()> {
        // of a study nothing is whole yet
        let Some(begun) = hung.begun.as_ref().filter(|_| !self.study.is_asked()) else {
            bail!("{hung}")
        };
        let rows = begun.watch.rows();
        let width = begun.names.len();
        let column = |c| rows.iter().skip(c).step_by(width).copied().collect();
        let columns: Vec<Vec<f64>> = (0..width).map(column).collect();
        let json = json!({
            "stop": "failed", "time": columns[0], "outputs": outputs(&begun.names, &columns),
        });
        self.output
            .json_or(&json, || csv(&begun.names, &begun.units, &columns))?;
        bail!("{hung}")
    }
}

fn outputs(names: &[String], columns: &[Vec<f64>]) -> serde_json::Map<String, serde_json::Value> {
    let named = names.iter().zip(columns).skip(1);
    named
        .map(|(name, column)| (name.clone(), json!(column)))
        .collect()
}

fn csv(names: &[String], units: &[Option<String>], columns: &[Vec<f64>]) -> String {
    let heads = names
        .iter()
        .map(String::as_str)
        .zip(units.iter().map(Option::as_deref));
    trajectory::to_csv(heads, columns)
}

fn form(expected: &'static str, found: &str) -> Error {
    Error::Form {
        expected,
        found: found.to_owned(),
    }
}
