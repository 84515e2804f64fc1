//! What is recorded of a coupled run, and under which names.

use super::PLANT;
use fmi_import::master::{Direction, Master, Port, Terminal};

/// A column: its name, its unit, what is recorded in it.
pub struct Column {
    pub name: String,
    pub unit: Option<String>,
    pub terminal: Terminal,
}

/// Of the plant its outputs and its speed under their plain names, so that the file is a ride; then
/// the plant's other inputs that are connected, each as it was over the step that ends with the row,
/// and the outputs of the others, as `participant.variable`.
pub fn columns<'a>(master: &mut Master, others: impl Iterator<Item = &'a str>) -> Vec<Column> {
    let connections = master.connections().iter();
    let targets: Vec<Terminal> = connections.map(|c| c.target.clone()).collect();
    let (mut ride, mut rest) = (Vec::new(), Vec::new());
    for member in [PLANT].into_iter().chain(others) {
        let Some(participant) = master.participant(member) else {
            continue;
        };
        for Port {
            name,
            direction,
            unit,
            ..
        } in participant.ports()
        {
            let terminal = Terminal {
                participant: member.to_owned(),
                variable: name.clone(),
            };
            let is_of_ride = match (member, *direction) {
                (PLANT, Direction::Output) => true,
                (PLANT, Direction::Input) if targets.contains(&terminal) => name == "speed",
                (PLANT, _) | (_, Direction::Input | Direction::Other) => continue,
                (_, Direction::Output) => false,
            };
            let (columns, name) = if is_of_ride {
                (&mut ride, name.clone())
            } else {
                (&mut rest, terminal.to_string())
            };
            columns.push(Column {
                name,
                unit: unit.as_ref().map(|unit| unit.name.clone()),
                terminal,
            });
        }
    }
    ride.append(&mut rest);
    ride
}
