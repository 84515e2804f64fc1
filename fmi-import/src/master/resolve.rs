//! Connections checked: from names to numbers of members and ports.

use super::{Connection, Direction, Kind, Member, Port, Terminal};
use crate::Error;
use crate::error::nearest;
use model_description::Unit;

/// A connection checked, ends as numbers of member and port; target = factor · source + offset.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Wire {
    pub source: (usize, usize),
    pub target: (usize, usize),
    pub factor: f64,
    pub offset: f64,
}

/// All connections, checked.
pub(super) fn wires(members: &[Member], connections: &[Connection]) -> Result<Vec<Wire>, Error> {
    let mut wires: Vec<Wire> = Vec::new();
    for (n, connection) in connections.iter().enumerate() {
        let refuse = |expected, found: String| {
            Err(Error::Connection {
                connection: connection.to_string(),
                expected,
                found,
            })
        };
        let (source, from) = find(members, &connection.source)?;
        let (target, to) = find(members, &connection.target)?;
        if from.direction != Direction::Output {
            return refuse("an output as its source", what(from).to_owned());
        }
        if to.direction != Direction::Input {
            return refuse("an input as its target", what(to).to_owned());
        }
        if let Some(first) = wires.iter().position(|wire| wire.target == target) {
            return Err(Error::TwoSources {
                target: connection.target.to_string(),
                first: connections[first].source.to_string(),
                second: connections[n].source.to_string(),
            });
        }
        if !converts(from.kind, to.kind) {
            let found = format!("a {} to a {}", from.kind.name(), to.kind.name());
            return refuse("variables of one type", found);
        }
        let converted = match (&from.unit, &to.unit) {
            (Some(a), Some(b)) => {
                conversion(a, b).ok_or_else(|| format!("{} to {}", a.name, b.name))
            }
            _ => Ok((1.0, 0.0)),
        };
        let (factor, offset) = match converted {
            Ok(found) => found,
            Err(found) => return refuse("units that convert", found),
        };
        wires.push(Wire {
            source,
            target,
            factor,
            offset,
        });
    }
    Ok(wires)
}

/// The number of the member called `name`.
pub(super) fn member(members: &[Member], name: &str) -> Result<usize, Error> {
    let found = members.iter().position(|member| member.name == name);
    found.ok_or_else(|| Error::UnknownMember {
        name: name.to_owned(),
        nearest: nearest(name, members.iter().map(|member| member.name.as_str())),
    })
}

fn find<'m>(
    members: &'m [Member],
    terminal: &Terminal,
) -> Result<((usize, usize), &'m Port), Error> {
    let m = member(members, &terminal.participant)?;
    let ports = members[m].participant.ports();
    let p = port(&members[m].name, ports, &terminal.variable)?;
    Ok(((m, p), &ports[p]))
}

/// The number of the port of `model` called `name`.
pub(super) fn port(model: &str, ports: &[Port], name: &str) -> Result<usize, Error> {
    let found = ports.iter().position(|port| port.name == name);
    found.ok_or_else(|| {
        let known = ports.iter().map(|port| port.name.as_str());
        Error::unknown_variable(model, name, known)
    })
}

fn what(port: &Port) -> &'static str {
    match port.direction {
        Direction::Input => "an input",
        Direction::Output => "an output",
        Direction::Other => "a variable that is neither input nor output",
    }
}

/// Whether each value of the one type is one of the other.
fn converts(from: Kind, to: Kind) -> bool {
    from == to || from == Kind::Integer && to == Kind::Real
}

/// Factor and offset from values in `from` to values in `to`; of the same name they are the same
/// where not both say what they are (FMI 2.0 §2.2.2).
fn conversion(from: &Unit, to: &Unit) -> Option<(f64, f64)> {
    if from.name == to.name && (from.base.is_none() || to.base.is_none()) {
        return Some((1.0, 0.0));
    }
    from.base?.conversion(&to.base?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use model_description::BaseUnit;

    fn unit(name: &str, rad: i32, factor: f64, offset: f64) -> Unit {
        Unit {
            name: name.to_owned(),
            base: Some(BaseUnit {
                rad,
                factor,
                offset,
                ..BaseUnit::default()
            }),
            display_units: Vec::new(),
        }
    }

    #[test]
    fn units_of_one_dimension_convert() {
        let (deg, rad) = (
            unit("deg", 1, 1_f64.to_radians(), 0.0),
            unit("rad", 1, 1.0, 0.0),
        );
        assert_eq!(conversion(&deg, &rad), Some((1_f64.to_radians(), 0.0)));
        assert_eq!(conversion(&rad, &unit("1", 0, 1.0, 0.0)), None);
        // °C to K and back
        let (celsius, kelvin) = (unit("degC", 0, 1.0, 273.15), unit("K", 0, 1.0, 0.0));
        assert_eq!(conversion(&celsius, &kelvin), Some((1.0, 273.15)));
        assert_eq!(conversion(&kelvin, &celsius), Some((1.0, -273.15)));
        // of one name: the same, even where nobody says what it is
        let unknown = Unit {
            name: "furlong".to_owned(),
            ..Unit::default()
        };
        assert_eq!(conversion(&unknown, &unknown), Some((1.0, 0.0)));
        assert_eq!(conversion(&unknown, &rad), None);
    }
}
