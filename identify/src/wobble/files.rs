//! The files that a call names, looked at before anything is done.

use clap::{Arg, ArgMatches, Command};
use identify::error::Result;
use identify::file;
use std::path::PathBuf;

/// Options that name a file to write.
const WRITTEN: [&str; 7] = ["out", "report", "html", "figure", "ssp", "ssv", "toml"];
/// What stands for a value that names a folder.
const FOLDER: &str = "FOLDER";

/// Refuses to write over what the call reads, to write two things to one file, and to begin what
/// could not be written in the end. `command` is the subcommand that was called.
pub fn check(command: &Command, matches: &ArgMatches) -> Result<()> {
    let (mut written, mut read): (Vec<PathBuf>, Vec<PathBuf>) = (Vec::new(), Vec::new());
    for argument in command.get_arguments().filter(|a| is_file(a)) {
        let id = argument.get_id().as_str();
        let values = matches.try_get_raw(id).ok().flatten().into_iter().flatten();
        for value in values {
            if WRITTEN.contains(&id) {
                written.push(value.into());
            } else {
                read.push(value.into());
                // --controller NAME=FILE
                let file = value.to_str().and_then(|text| text.split_once('='));
                read.extend(file.map(|(_, file)| file.into()));
            }
        }
    }
    let [apart, from] = [&written, &read].map(|paths| paths.iter().map(PathBuf::as_path));
    file::check_apart(apart, from)?;
    written
        .iter()
        .try_for_each(|path| file::check_writable(path))
}

/// Whether `argument` takes what may be the name of a file.
fn is_file(argument: &Arg) -> bool {
    let folder = |names: &[clap::builder::Str]| names.iter().any(|name| name == FOLDER);
    argument.get_action().takes_values() && !argument.get_value_names().is_some_and(folder)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    /// Whoever adds an option that writes has to name it above.
    #[test]
    fn every_option_that_writes_is_known() {
        let mut found = Vec::new();
        for command in crate::Program::command().get_subcommands() {
            for argument in command.get_arguments().filter(|a| is_file(a)) {
                let help = argument
                    .get_help()
                    .map(ToString::to_string)
                    .unwrap_or_default();
                let writes = help.starts_with("Write ") || help.contains(" to write");
                let id = argument.get_id().as_str();
                assert_eq!(
                    writes && id != "resume",
                    WRITTEN.contains(&id),
                    "{id}: {help}"
                );
                found.extend(WRITTEN.iter().find(|known| **known == id));
            }
        }
        assert!(
            WRITTEN.iter().all(|name| found.contains(&name)),
            "{found:?}"
        );
    }
}
