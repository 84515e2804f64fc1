//! Several participants coupled: FMUs of any maker and what takes part natively.
//!
//! [`Master::new`] takes [`Member`]s and [`Connection`]s and checks them; [`Master::run`] goes from
//! start to stop. Values travel at communication points and are held in between, so a coupled
//! trajectory converges to the monolithic one with the first power of the step.

mod algebraic;
mod exchange;
mod fmu;
mod participant;
mod resolve;
mod run;
mod step;
mod toleranced;
mod watch;
mod wiring;

#[cfg(test)]
mod tests;

pub use algebraic::Loop;
pub use fmu::Foreign;
pub use participant::{Direction, Kind, Participant, Port};
pub use run::{Algorithm, End, Plan, Run};
pub use watch::{Call, Watch};
pub use wiring::{Connection, Terminal, by_name};

use crate::Error;
use exchange::Seat;
use std::sync::Arc;

/// A participant at the table.
pub struct Member<'a> {
    /// Its name, unlike that of any other.
    pub name: String,
    /// What it is.
    pub participant: Box<dyn Participant + 'a>,
    /// Its own communication step \[s\], a multiple of the plan's; that one if there is none.
    pub step: Option<f64>,
}

/// Participants, connected.
pub struct Master<'a> {
    seats: Vec<Seat<'a>>,
    connections: Vec<Connection>,
    factors: Vec<f64>,
    loops: Vec<Loop>,
    watch: Arc<Watch>,
}

impl<'a> Master<'a> {
    /// Checks the connections: terminals that are there, from an output to an input, one source
    /// for an input, of one type and of units that convert; looks for algebraic loops.
    pub fn new(members: Vec<Member<'a>>, connections: Vec<Connection>) -> Result<Self, Error> {
        for (i, member) in members.iter().enumerate() {
            if members[..i].iter().any(|other| other.name == member.name) {
                return Err(Error::TwoMembers {
                    name: member.name.clone(),
                });
            }
        }
        let wires = resolve::wires(&members, &connections)?;
        let loops = algebraic::loops(&members, &wires);
        let mut seats: Vec<Seat> = members.into_iter().map(Seat::new).collect();
        for wire in &wires {
            exchange::connect(&mut seats, wire);
        }
        let names = seats.iter().map(|seat| seat.name.clone()).collect();
        Ok(Self {
            seats,
            connections,
            factors: wires.iter().map(|wire| wire.factor).collect(),
            loops,
            watch: Arc::new(Watch::new(names)),
        })
    }

    /// What is connected to what.
    pub fn connections(&self) -> &[Connection] {
        &self.connections
    }

    /// For each connection the factor from the unit of its output to that of its input.
    pub fn factors(&self) -> &[f64] {
        &self.factors
    }

    /// Outputs that depend on themselves through inputs, without time between. Their values lag
    /// by one communication step.
    pub fn loops(&self) -> &[Loop] {
        &self.loops
    }

    /// For another thread, to look at a run or to stop it.
    pub fn watch(&self) -> Arc<Watch> {
        Arc::clone(&self.watch)
    }

    /// The participant called `name`, for instance to set parameters of it.
    pub fn participant(&mut self, name: &str) -> Option<&mut (dyn Participant + 'a)> {
        let seat = self.seats.iter_mut().find(|seat| seat.name == name)?;
        Some(seat.participant.as_mut())
    }
}
