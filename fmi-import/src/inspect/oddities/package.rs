//! The archive, and what the description says of the FMU as a whole.

use super::{List, Severity};
use crate::Archive;
use model_description::{CoSimulation, ModelDescription, Platform};

impl List {
    pub(super) fn header(&mut self, archive: &Archive, d: &ModelDescription) {
        if let Some(what) = archive.encoding() {
            self.fault("encoding", &format!("modelDescription.xml: {what}"), []);
        }
        if d.fmi_version != "2.0" {
            let what = format!("fmiVersion: expected \"2.0\", found {:?}", d.fmi_version);
            self.fault("fmi-version", &what, []);
        }
        if d.guid.is_empty() {
            self.fault("no-guid", "no guid: any binary would fit", []);
        }
        if d.generation_tool.is_none() {
            self.remark("no-generation-tool", "does not say what made it", []);
        }
        match d.default_experiment {
            None => self.remark(
                "no-default-experiment",
                "no default experiment: duration and step are a guess",
                [],
            ),
            Some(e) => {
                if e.step_size.is_none() {
                    self.remark(
                        "no-step-size",
                        "default experiment without stepSize: the step is a guess",
                        [],
                    );
                }
                if e.stop_time
                    .is_some_and(|stop| stop <= e.start_time.unwrap_or(0.0))
                {
                    self.fault(
                        "stop-time",
                        "default experiment that stops at its start",
                        [],
                    );
                }
            }
        }
    }

    pub(super) fn files(&mut self, archive: &Archive) {
        // FMI 2.0 §2.3; `extra` and `terminalsAndIcons` came with later revisions and layers.
        const FOLDERS: [&str; 7] = [
            "binaries",
            "documentation",
            "extra",
            "licenses",
            "resources",
            "sources",
            "terminalsAndIcons",
        ];
        let is_unexplained = |file: &&String| match file.split_once('/') {
            None => *file != "modelDescription.xml" && *file != "model.png",
            Some((folder, _)) => !FOLDERS.contains(&folder),
        };
        self.each(
            Severity::Remark,
            "unexplained-file",
            "files the standard gives no meaning to",
            archive.files().iter().filter(is_unexplained),
        );
        let mut platforms: Vec<&str> = archive
            .files()
            .iter()
            .filter_map(|file| file.strip_prefix("binaries/")?.split_once('/'))
            .map(|(platform, _)| platform)
            .filter(|platform| Platform::ALL.iter().all(|p| p.folder() != *platform))
            .collect();
        platforms.dedup();
        self.each(
            Severity::Remark,
            "unknown-platform",
            "binaries for platforms FMI 2.0 does not name",
            platforms,
        );
        self.each(
            Severity::Fault,
            "symbolic-link",
            "symbolic links, left out",
            archive.links(),
        );
    }

    pub(super) fn co_simulation(&mut self, archive: &Archive, c: &CoSimulation) {
        let platforms = archive.platforms();
        if platforms.is_empty() {
            self.fault(
                "no-binary",
                "no binary where modelIdentifier says",
                [c.model_identifier.clone()],
            );
        } else if Platform::current().is_none_or(|here| !platforms.contains(&here)) {
            let here = Platform::current().map_or("this machine", Platform::folder);
            self.fault("no-binary-here", &format!("no binary for {here}"), []);
        }
        let is_c_name = |name: &str| {
            !name.starts_with(|c: char| c.is_ascii_digit())
                && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        };
        if !is_c_name(&c.model_identifier) {
            self.fault(
                "model-identifier",
                "modelIdentifier is no name in C",
                [c.model_identifier.clone()],
            );
        }
        if c.needs_execution_tool {
            self.remark("needs-execution-tool", "needs its tool installed", []);
        }
        if c.can_be_instantiated_only_once_per_process {
            self.remark("only-once", "at most one instance in a process", []);
        }
        if !c.can_handle_variable_communication_step_size {
            self.remark(
                "fixed-step",
                "all communication steps must be of one length",
                [],
            );
        }
    }
}
