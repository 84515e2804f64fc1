//! What is odd about an FMU, by which rules.

mod package;
mod structure;
mod variables;

use super::VariableRow;
use crate::Archive;
use model_description::ScalarVariable;
use serde::Serialize;
use std::fmt;

/// How bad an oddity is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Against the standard, or the FMU cannot be run here.
    Fault,
    /// Allowed; whoever couples or simulates the FMU should know.
    Remark,
}

/// Something odd about an FMU.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Oddity {
    /// How bad it is.
    pub severity: Severity,
    /// The rule, a name that does not change.
    pub rule: &'static str,
    /// What is odd.
    pub what: String,
    /// The variables, files or units that are, all of them.
    pub concerns: Vec<String>,
}

impl fmt::Display for Oddity {
    /// With the first of those it concerns.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        const FIRST: usize = 5;
        write!(f, "{}", self.what)?;
        if !self.concerns.is_empty() {
            let first = &self.concerns[..self.concerns.len().min(FIRST)];
            write!(f, ": {}", first.join(", "))?;
        }
        if self.concerns.len() > FIRST {
            write!(f, " and {} more", self.concerns.len() - FIRST)?;
        }
        Ok(())
    }
}

/// Everything odd, faults first.
pub(super) fn find(archive: &Archive, rows: &[VariableRow]) -> Vec<Oddity> {
    let mut list = List(Vec::new());
    let d = archive.description();
    list.header(archive, d);
    list.files(archive);
    if let Some(co_simulation) = &d.co_simulation {
        list.co_simulation(archive, co_simulation);
    } else {
        list.fault(
            "model-exchange-only",
            "for model exchange only, cannot be stepped",
            [],
        );
    }
    list.names(d);
    list.kinds(d);
    list.starts(d, rows);
    list.ranges(rows);
    list.enumerations(d, rows);
    list.units(d, rows);
    list.structure(d);
    let mut oddities = list.0;
    // stable: the order of the rules within a severity
    oddities.sort_by_key(|oddity| oddity.severity);
    oddities
}

struct List(Vec<Oddity>);

impl List {
    fn add(&mut self, severity: Severity, rule: &'static str, what: &str, concerns: Vec<String>) {
        self.0.push(Oddity {
            severity,
            rule,
            what: what.to_owned(),
            concerns,
        });
    }

    /// Of the FMU as a whole, or of those in `concerns`.
    fn fault<const N: usize>(&mut self, rule: &'static str, what: &str, concerns: [String; N]) {
        self.add(Severity::Fault, rule, what, concerns.into());
    }

    /// As [`List::fault`].
    fn remark<const N: usize>(&mut self, rule: &'static str, what: &str, concerns: [String; N]) {
        self.add(Severity::Remark, rule, what, concerns.into());
    }

    /// Of each of `concerns`, if there are any.
    fn each(
        &mut self,
        severity: Severity,
        rule: &'static str,
        what: &str,
        concerns: impl IntoIterator<Item = impl Into<String>>,
    ) {
        let concerns: Vec<String> = concerns.into_iter().map(Into::into).collect();
        if !concerns.is_empty() {
            self.add(severity, rule, what, concerns);
        }
    }
}

fn names<'a>(variables: impl Iterator<Item = &'a ScalarVariable>) -> impl Iterator<Item = &'a str> {
    variables.map(|variable| variable.name.as_str())
}
