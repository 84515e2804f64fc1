//! The command bench: how fast this machine is, and how wrong.

use crate::output::{Output, Progress};
use anyhow::Result;
use clap::Args;
use identify::bench;
use std::path::PathBuf;

#[derive(Args)]
pub struct Bench {
    /// Compile and run a yardstick in C++ besides; its first line says how it is built
    #[arg(long, value_name = "FILE")]
    yardstick: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

impl Bench {
    pub fn run(&self) -> Result<()> {
        let progress = Progress::new();
        let measured = bench::measure(self.yardstick.as_deref(), &|what| progress.say(what))?;
        drop(progress);
        for note in &measured.notes {
            eprintln!("note: {note}");
        }
        self.output.json_or(&measured, || measured.table())
    }
}
