//! `wobble`: rides in, parameters with their uncertainty and a report out.
//!
//! Human text goes to stderr, data to stdout or the file that `--out` names. Exit code 1 is a run
//! that failed, 2 a call that was wrong.

mod arguments;
mod bench;
mod cases;
mod cosim;
mod course;
mod demo;
mod files;
mod fitted;
mod fitting;
mod fmu;
mod foreign;
mod linear;
mod model;
mod modelling;
mod output;
mod report;
mod rides;
mod stability;
mod validate;

use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};
use identify::error::Error;
use identify::stop;
use std::process::ExitCode;

/// Bicycles with a rear load wobble: simulate them, measure them, find their parameters.
///
/// Values are SI unless they carry a unit: 8km/h, 5ms, 20deg, 75kg.
#[derive(Parser)]
#[command(name = "wobble", version, arg_required_else_help = true)]
struct Program {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Write an FMU, the nine cases of the paper and six synthetic rides; fit one and report
    Demo(demo::Demo),
    /// The parameter table, with a bicycle's values
    Parameters(model::ListParameters),
    /// What is in a ride file or an FMU, and what is odd about it
    Inspect(rides::Inspect),
    /// Simulate a bicycle, with a remnant a synthetic ride; or any FMU
    Simulate(model::Simulate),
    /// The nine cases of the paper's section 3, or the same with loads on the carrier
    Cases(cases::Cases),
    /// The spectrum of a ride's residual
    Spectrum(rides::Spectrum),
    /// Rides beside the first: which bands rise, which fall
    Compare(rides::Compare),
    /// Eigenvalues by mode over speed and over any row of the table; weave and capsize speed
    Stability(stability::Stability),
    /// The linear system A, B, C, D with its names, as JSON or MAT-file
    Linear(linear::Linear),
    /// Fit parameters to a ride
    Fit(fitting::Fit),
    /// A fit on rides it was not made of; other formulations beside it
    Validate(validate::Validate),
    /// The report of a fit, one HTML file
    Report(report::Report),
    /// Couple the bicycle's FMU with an assist controller, or any FMUs with each other
    Cosim(cosim::Cosim),
    /// Pack the bicycle, or any model, as an FMU
    Fmu(fmu::Fmu),
    /// How fast this machine simulates and fits, and with what error
    Bench(bench::Bench),
}

fn main() -> ExitCode {
    let mut command = Program::command();
    let matches = command.get_matches_mut();
    let program = Program::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let outcome = match files_apart(&command, &matches) {
        Ok(()) => run(program.command),
        Err(error) => Err(error.into()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if output::is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("wobble: {}", output::words(&error));
            let typed = error.downcast_ref::<Error>().is_some_and(Error::is_typed);
            ExitCode::from(if typed { 2 } else { 1 })
        }
    }
}

/// Looks at the files that the subcommand names.
fn files_apart(program: &clap::Command, matches: &ArgMatches) -> identify::error::Result<()> {
    let called = matches.subcommand();
    let called = called.and_then(|(name, own)| Some((program.find_subcommand(name)?, own)));
    called.map_or(Ok(()), |(command, own)| files::check(command, own))
}

fn run(command: Command) -> anyhow::Result<()> {
    match command {
        Command::Demo(command) => command.run(),
        Command::Parameters(command) => command.run(),
        Command::Inspect(command) => command.run(),
        Command::Simulate(command) => command.run(),
        Command::Cases(command) => command.run(),
        Command::Spectrum(command) => command.run(),
        Command::Compare(command) => command.run(),
        Command::Stability(command) => command.run(),
        Command::Linear(command) => command.run(),
        Command::Fit(command) => {
            stop::on_interrupt();
            command.run()
        }
        Command::Validate(command) => command.run(),
        Command::Report(command) => command.run(),
        Command::Cosim(command) => command.run(),
        Command::Fmu(command) => command.run(),
        Command::Bench(command) => command.run(),
    }
}
