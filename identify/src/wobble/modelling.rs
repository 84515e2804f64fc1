//! What stands for the bicycle in a fit, as typed.

use clap::Args;
use identify::error::{Error, Result};
use identify::foreign::Foreign;
use identify::model::{Model, Seeds};
use std::path::Path;

/// What stands for the bicycle.
#[derive(Args)]
pub struct ModelArguments {
    /// What stands for the bicycle: equations; simulated, for the mean spectrum of simulated rides;
    /// an FMU, or a TOML file that says what is what in one
    #[arg(long, value_name = "NAME|FILE", default_value = "equations")]
    model: String,
    /// Seeds of simulated rides, else 16 for each ride
    #[arg(long, value_name = "K")]
    seeds: Option<usize>,
}

impl ModelArguments {
    /// The model meant; the noise of its rides follows from `seed`.
    pub fn open(&self, seed: u64) -> Result<Model> {
        let seeds = Seeds {
            count: self.seeds,
            seed,
        };
        let path = Path::new(&self.model);
        let is_file = path.extension().is_some() || path.exists();
        match (self.model.as_str(), self.seeds) {
            ("equations", None) => Ok(Model::Equations),
            ("equations", Some(count)) => Err(Error::Form {
                expected: "--seeds with simulated rides",
                found: "--model equations".into(),
            }
            .typed(format!("--seeds {count}"))),
            ("simulated", _) => Ok(Model::Simulated(seeds)),
            _ if is_file => Ok(Model::Foreign(Foreign::open(path)?, seeds)),
            (other, _) => {
                let names = ["equations", "simulated"];
                let unknown = Error::unknown("model", other, names);
                Err(unknown.typed(format!("--model {other}")))
            }
        }
    }
}
