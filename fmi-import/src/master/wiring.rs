//! Connections, by name.

use super::{Direction, Member};
use crate::Error;
use std::fmt;
use std::str::FromStr;

/// A variable of a participant.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Terminal {
    /// Name of the participant.
    pub participant: String,
    /// Name of the variable.
    pub variable: String,
}

impl fmt::Display for Terminal {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}.{}", self.participant, self.variable)
    }
}

impl FromStr for Terminal {
    type Err = Error;

    /// `participant.variable`; the variable's name may have dots in it.
    fn from_str(text: &str) -> Result<Self, Error> {
        match text.split_once('.') {
            Some((participant, variable)) if !participant.is_empty() && !variable.is_empty() => {
                Ok(Self {
                    participant: participant.to_owned(),
                    variable: variable.to_owned(),
                })
            }
            _ => Err(Error::Terminal {
                found: text.to_owned(),
            }),
        }
    }
}

/// From an output to an input.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Connection {
    /// The output.
    pub source: Terminal,
    /// The input.
    pub target: Terminal,
}

impl fmt::Display for Connection {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} → {}", self.source, self.target)
    }
}

/// For each input that `connections` leave open the output of the same name, where exactly one
/// other member has it.
pub fn by_name(members: &[Member], connections: &[Connection]) -> Vec<Connection> {
    let mut found = Vec::new();
    for member in members {
        let inputs = member.participant.ports().iter();
        for input in inputs.filter(|port| port.direction == Direction::Input) {
            let target = Terminal {
                participant: member.name.clone(),
                variable: input.name.clone(),
            };
            if connections.iter().any(|other| other.target == target) {
                continue;
            }
            let has_it =
                |other: &&Member| {
                    other.name != member.name
                        && other.participant.ports().iter().any(|port| {
                            port.direction == Direction::Output && port.name == input.name
                        })
                };
            let mut sources = members.iter().filter(has_it);
            if let (Some(source), None) = (sources.next(), sources.next()) {
                found.push(Connection {
                    source: Terminal {
                        participant: source.name.clone(),
                        variable: input.name.clone(),
                    },
                    target,
                });
            }
        }
    }
    found
}
