//! Eigenvalues by mode over speed and over any row of the table.

use crate::arguments::BicycleArguments;
use crate::output::{Output, typed};
use anyhow::Result;
use bicycle::Input;
use clap::Args;
use identify::bicycles::Bicycle;
use identify::error::{Error, Result as Typed};
use identify::figure;
use identify::file;
use identify::stability::{self, Plan, Sweep, points, words};
use std::path::{Path, PathBuf};

/// What `stability` and `linear` ask of the bicycle.
#[derive(Args)]
pub struct Riding {
    #[command(flatten)]
    bicycle: BicycleArguments,
    /// Close the loop with the rider law of the bicycle (hands off without it)
    #[arg(long)]
    rider_law: bool,
}

impl Riding {
    /// The bicycle, and what is asked of it at `speeds`.
    pub fn plan(&self, speeds: &str) -> Result<(Bicycle, Plan)> {
        let set = self.bicycle.open()?;
        let row = &Input::TABLE[Input::index("speed").expect("an input")];
        let read = || {
            let speeds = points(speeds, row.unit, row.name)?;
            for end in speeds.first().into_iter().chain(speeds.last()) {
                identify::bicycles::admit(row, *end)?;
            }
            Ok(speeds)
        };
        let speeds = read().map_err(|cause: Error| cause.typed(format!("--speed {speeds}")))?;
        let mut plan = Plan::new(&set, speeds);
        plan.rider_law = self.rider_law;
        Ok((set, plan))
    }
}

#[derive(Args)]
pub struct Stability {
    #[command(flatten)]
    riding: Riding,
    /// One speed, or from, to and step
    #[arg(
        long,
        value_name = "SPEED|FROM:TO:STEP",
        default_value = "0.5:10:0.1",
        allow_hyphen_values = true
    )]
    speed: String,
    /// Sweep a row of the parameter table as well, e.g. rear_load=0:30:1
    #[arg(long, value_name = "NAME=FROM:TO:STEP")]
    sweep: Option<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Figure to write besides: SVG, or HTML with the tables
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl Stability {
    pub fn run(&self) -> Result<()> {
        let form = self.out.as_deref().map(Form::of).transpose()?;
        let (set, mut plan) = self.riding.plan(&self.speed)?;
        if let Some(text) = &self.sweep {
            let sweep = Sweep::read(text).map_err(|e| e.typed(format!("--sweep {text}")))?;
            plan.sweep = Some(sweep);
        }
        let found = stability::stability(&plan).map_err(said)?;
        for note in &found.notes {
            eprintln!("note: {note}");
        }
        if let (Some(path), Some(form)) = (&self.out, form) {
            let text = match form {
                Form::Svg => figure::stability(&found),
                Form::Html => stability::html(&plan, &found, &set.name, &typed()),
            };
            file::write(path, text)?;
        }
        let output = Output {
            json: self.json,
            out: None,
        };
        output.json_or(&words::to_json(&found), || words::table(&found))
    }
}

/// A speed or a number of points that cannot be was typed.
fn said(cause: Error) -> Error {
    match cause {
        Error::Points { .. } => cause.typed("--speed, --sweep"),
        Error::Refused(bicycle::simulate::Refusal::Speed { .. }) => cause.typed("--speed"),
        _ => cause,
    }
}

/// A form of the figure, by the file's extension.
enum Form {
    Svg,
    Html,
}

impl Form {
    fn of(path: &Path) -> Typed<Self> {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("svg") => Ok(Self::Svg),
            Some("html" | "htm") => Ok(Self::Html),
            _ => {
                let found = path.display().to_string();
                let form = Error::Form {
                    expected: "a file .svg or .html",
                    found: found.clone(),
                };
                Err(form.typed(format!("--out {found}")))
            }
        }
    }
}
