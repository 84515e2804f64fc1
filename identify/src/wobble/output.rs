//! Where data and words go.

use anyhow::Result;
use clap::Args;
use identify::file;
use identify::progress::{Event, Watch};
use identify::report::quoted;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::io::{ErrorKind, Write};
use std::iter;
use std::path::PathBuf;
use std::time::Duration;

/// What is written, and where.
#[derive(Args)]
pub struct Output {
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// File to write to instead of stdout
    #[arg(short, long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

impl Output {
    /// Writes `text` to the file named, else to stdout.
    pub fn text(&self, text: &str) -> Result<()> {
        match &self.out {
            Some(path) => Ok(file::write(path, text)?),
            None => Ok(std::io::stdout().lock().write_all(text.as_bytes())?),
        }
    }

    /// Writes `value` as JSON if asked to, else the text that `text` makes.
    pub fn json_or(&self, value: &impl Serialize, text: impl FnOnce() -> String) -> Result<()> {
        if self.json {
            self.text(
                &(serde_json::to_string_pretty(value)?
                    + "
"),
            )
        } else {
            self.text(&text())
        }
    }
}

/// The command as it was typed, for the record.
pub fn typed() -> String {
    let words = std::env::args().skip(1).map(|word| quoted(&word));
    iter::once("wobble".to_owned())
        .chain(words)
        .collect::<Vec<_>>()
        .join(" ")
}

/// An error and its causes in one line, each fact once: some errors already quote their cause.
pub fn words(error: &anyhow::Error) -> String {
    let mut words = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if words.is_empty() {
            words = cause;
        } else if !words.contains(&cause) {
            words = format!("{words}: {cause}");
        }
    }
    words
}

/// Whether the reader of stdout has gone: no failure of ours.
pub fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<std::io::Error>()
        .is_some_and(|e| e.kind() == ErrorKind::BrokenPipe)
}

/// On a terminal a spinner, or a bar where the end is known, for what takes more than a moment;
/// silent elsewhere.
pub struct Progress(ProgressBar);

impl Progress {
    /// Starts.
    pub fn new() -> Self {
        let bar = ProgressBar::new_spinner();
        bar.set_style(style("{spinner} {elapsed} {msg}"));
        bar.enable_steady_tick(Duration::from_millis(100));
        Self(bar)
    }

    /// Says what is being done.
    pub fn say(&self, what: &str) {
        self.0.set_message(what.to_owned());
    }

    /// Shows what a search tells.
    pub fn watch(&self) -> Watch {
        let bar = self.0.clone();
        Watch::new(move |event| match event {
            Event::Phase(what) => {
                bar.unset_length();
                bar.set_style(style("{spinner} {elapsed} {msg}"));
                bar.set_message(what.to_owned());
            }
            Event::Iteration { iteration, cost } => {
                bar.set_message(format!("iteration {iteration}, cost {cost:.6}"));
            }
            Event::Done { done, of, best } => {
                if bar.length() != Some(of) {
                    bar.set_length(of);
                    bar.set_style(style("{elapsed} {bar:30} {pos}/{len}, {eta} left{msg}"));
                }
                bar.set_position(done);
                bar.set_message(best.map_or_else(String::new, |cost| format!(", cost {cost:.6}")));
            }
        })
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("a valid template")
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
