//! Who sits where, and the board on which outputs are published.

use super::resolve::{self, Wire};
use super::{Member, Participant, Terminal};
use crate::Error;

/// A member with what goes in and out of it.
pub(super) struct Seat<'a> {
    pub name: String,
    pub participant: Box<dyn Participant + 'a>,
    /// Its own communication step [s], where it has one.
    pub step: Option<f64>,
    /// Ports that are set, where each value comes from, and the values last set.
    inputs: Vec<usize>,
    sources: Vec<Source>,
    set: Vec<f64>,
    /// Ports that are read, those exchanged first, and where they stand on the board.
    seen: Vec<usize>,
    exchanged: usize,
    first: usize,
}

/// An output that others use.
pub(super) struct Exchanged {
    /// Its place on the board.
    pub slot: usize,
    /// Its typical size.
    pub nominal: f64,
    /// It says that it depends on an input at once, so it is as late as that.
    pub lags: bool,
}

/// Where an input comes from: value = factor · output + offset.
struct Source {
    seat: usize,
    port: usize,
    slot: usize,
    factor: f64,
    offset: f64,
    /// In words.
    name: String,
}

impl<'a> Seat<'a> {
    pub fn new(member: Member<'a>) -> Self {
        Self {
            name: member.name,
            participant: member.participant,
            step: member.step,
            inputs: Vec::new(),
            sources: Vec::new(),
            set: Vec::new(),
            seen: Vec::new(),
            exchanged: 0,
            first: 0,
        }
    }

    /// What is being set, in words.
    pub fn inputs_set(&self) -> String {
        let ports = self.participant.ports();
        let names: Vec<&str> = self
            .inputs
            .iter()
            .map(|&i| ports[i].name.as_str())
            .collect();
        format!("setting {}", names.join(", "))
    }

    /// Sets the inputs from the board; whether one changed.
    pub fn set_inputs(&mut self, board: &[f64]) -> Result<bool, Error> {
        let mut changed = false;
        for (set, source) in self.set.iter_mut().zip(&self.sources) {
            let value = source.factor * board[source.slot] + source.offset;
            changed |= set.to_bits() != value.to_bits();
            *set = value;
        }
        if let Some(n) = self.set.iter().position(|value| !value.is_finite()) {
            return Err(Error::NotFinite {
                variable: self.participant.ports()[self.inputs[n]].name.clone(),
                found: self.set[n],
                from: self.sources[n].name.clone(),
            });
        }
        self.participant.write(&self.inputs, &self.set)?;
        Ok(changed)
    }

    /// Publishes what others use of it: all that may be read before initialization is over.
    pub fn publish_exchanged(&mut self, board: &mut [f64]) -> Result<(), Error> {
        let slots = self.first..self.first + self.exchanged;
        self.participant
            .read(&self.seen[..self.exchanged], &mut board[slots])
    }

    /// Its places on the board.
    pub fn slots(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.seen.len()
    }

    /// Publishes what is seen of it.
    pub fn publish(&mut self, board: &mut [f64]) -> Result<(), Error> {
        let slots = self.slots();
        self.participant.read(&self.seen, &mut board[slots])
    }

    /// The outputs that others use.
    pub fn exchanged(&self) -> impl Iterator<Item = Exchanged> {
        let ports = self.participant.ports();
        let is_set = |port: &usize| self.inputs.contains(port);
        let seen = (self.first..).zip(&self.seen[..self.exchanged]);
        seen.map(move |(slot, &port)| Exchanged {
            slot,
            nominal: ports[port].nominal,
            lags: (ports[port].depends_on.as_ref()).is_some_and(|known| known.iter().any(is_set)),
        })
    }

    fn place_of(&mut self, port: usize) -> usize {
        let found = self.seen.iter().position(|&seen| seen == port);
        found.unwrap_or_else(|| {
            self.seen.push(port);
            self.seen.len() - 1
        })
    }
}

/// Puts a wire between its seats.
pub(super) fn connect(seats: &mut [Seat], wire: &Wire) {
    let (from, output) = wire.source;
    seats[from].place_of(output);
    seats[from].exchanged = seats[from].seen.len();
    let name = &seats[from].participant.ports()[output].name;
    let name = format!("{}.{name}", seats[from].name);
    let (to, input) = wire.target;
    let seat = &mut seats[to];
    seat.inputs.push(input);
    seat.sources.push(Source {
        seat: from,
        port: output,
        slot: 0,
        factor: wire.factor,
        offset: wire.offset,
        name,
    });
    seat.set.push(f64::NAN);
}

/// Lays the board out for a run that records `record`; the slots of these, and how many there
/// are in all.
pub(super) fn lay_out(
    seats: &mut [Seat],
    record: &[Terminal],
) -> Result<(Vec<usize>, usize), Error> {
    for seat in seats.iter_mut() {
        seat.seen.truncate(seat.exchanged);
        seat.set.fill(f64::NAN);
    }
    let mut places = Vec::with_capacity(record.len());
    for terminal in record {
        let found = seats
            .iter()
            .position(|seat| seat.name == terminal.participant);
        let at = found.ok_or_else(|| Error::UnknownMember {
            name: terminal.participant.clone(),
            nearest: crate::error::nearest(
                &terminal.participant,
                seats.iter().map(|seat| seat.name.as_str()),
            ),
        })?;
        let seat = &mut seats[at];
        let port = resolve::port(&seat.name, seat.participant.ports(), &terminal.variable)?;
        places.push((at, seat.place_of(port)));
    }
    let mut slots = 0;
    for seat in seats.iter_mut() {
        seat.first = slots;
        slots += seat.seen.len();
    }
    for i in 0..seats.len() {
        for j in 0..seats[i].sources.len() {
            let Source { seat, port, .. } = seats[i].sources[j];
            seats[i].sources[j].slot = seats[seat].first + seats[seat].place_of(port);
        }
    }
    let recorded = places
        .iter()
        .map(|&(seat, place)| seats[seat].first + place);
    Ok((recorded.collect(), slots))
}
