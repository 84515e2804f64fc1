//! The linear system as a laboratory loads it.

use crate::arguments::quantity;
use crate::output::Output;
use crate::stability::Riding;
use anyhow::Result;
use bicycle::quantity::RAD;
use clap::{Args, ValueEnum};
use identify::error::Error;
use identify::file;
use identify::map;
use identify::stability::linear::system;
use std::path::PathBuf;

/// Sign conventions by name.
#[derive(Clone, Copy, ValueEnum)]
enum Signs {
    /// z up; roll right +, steer and yaw left +
    Iso8855,
    /// Meijaard et al. 2007: z down; roll, steer and yaw right +
    Literature,
}

#[derive(Args)]
pub struct Linear {
    #[command(flatten)]
    riding: Riding,
    /// The speed
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true)]
    speed: String,
    /// In the steady turn of this steer angle, left positive, instead of upright
    #[arg(
        long,
        value_name = "ANGLE",
        default_value = "0",
        allow_hyphen_values = true
    )]
    steer: String,
    /// Sign convention of what is written
    #[arg(long, default_value = "iso8855")]
    signs: Signs,
    /// Write a MAT-file, level 5, to the file that --out names, as one called .mat is anyway
    #[arg(long, requires = "out", conflicts_with = "json")]
    mat: bool,
    #[command(flatten)]
    output: Output,
}

impl Linear {
    pub fn run(&self) -> Result<()> {
        let (_, plan) = self.riding.plan(&self.speed)?;
        let argument = format!("--speed {}", self.speed);
        if plan.speeds.len() > 1 {
            let form = Error::Form {
                expected: "one speed",
                found: self.speed.clone(),
            };
            return Err(form.typed(argument).into());
        }
        let signs = match self.signs {
            Signs::Iso8855 => map::Signs::Iso8855,
            Signs::Literature => map::Signs::Literature,
        };
        let steer = quantity("--steer", &self.steer, RAD)?;
        let system = system(&plan, steer, signs).map_err(|cause| match cause {
            Error::Refused(bicycle::simulate::Refusal::Speed { .. }) => cause.typed(argument),
            Error::Form { .. } => cause.typed(format!("--steer {}", self.steer)),
            _ => cause,
        })?;
        for note in &system.notes {
            eprintln!("note: {note}");
        }
        let is_mat = |path: &PathBuf| path.extension().is_some_and(|e| e == "mat");
        match &self.output.out {
            Some(path) if self.mat || is_mat(path) => Ok(file::write(path, system.to_mat())?),
            _ => self.output.json_or(&system.to_json(), || system.table()),
        }
    }
}
