//! Connections as typed: `source=target`, each with or without its participant.

use crate::error::{Error, Result};
use fmi_import::master::{Connection, Direction, Member, Terminal};

/// What `text` connects.
pub fn connection(text: &str, members: &[Member]) -> Result<Connection> {
    let typed = |cause: Error| cause.typed(format!("--connect {text}"));
    let (source, target) = text.split_once('=').ok_or_else(|| {
        typed(Error::Form {
            expected: "SOURCE=TARGET",
            found: text.into(),
        })
    })?;
    let end = |name: &str, direction| terminal(name.trim(), direction, members).map_err(typed);
    Ok(Connection {
        source: end(source, Direction::Output)?,
        target: end(target, Direction::Input)?,
    })
}

/// The terminal that `name` means: `participant.variable`, or a variable that only one participant
/// has as an output or input.
fn terminal(name: &str, direction: Direction, members: &[Member]) -> Result<Terminal> {
    let is_member = |name: &str| members.iter().any(|member| member.name == name);
    if let Some((participant, _)) = name.split_once('.')
        && is_member(participant)
    {
        return Ok(name.parse::<Terminal>()?);
    }
    let having = members.iter().filter(|member| {
        let mut ports = member.participant.ports().iter();
        ports.any(|port| port.direction == direction && port.name == name)
    });
    let having: Vec<&str> = having.map(|member| member.name.as_str()).collect();
    let what = match direction {
        Direction::Input => "input",
        _ => "output",
    };
    match having.as_slice() {
        [one] => Ok(Terminal {
            participant: (*one).to_owned(),
            variable: name.to_owned(),
        }),
        [] => {
            let all = members.iter().flat_map(|member| {
                let ports = member.participant.ports().iter();
                let known = ports.filter(|port| port.direction == direction);
                known.map(|port| format!("{}.{}", member.name, port.name))
            });
            let all: Vec<String> = all.collect();
            Err(Error::unknown(what, name, all.iter().map(String::as_str)))
        }
        several => Err(Error::Form {
            expected: "PARTICIPANT.VARIABLE",
            found: format!("{name}, which {} have", several.join(" and ")),
        }),
    }
}
