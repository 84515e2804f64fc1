//! Algebraic loops, found from what outputs depend on at a communication point.

use super::Member;
use super::resolve::Wire;
use std::fmt;

/// Terminals around a loop, output, input, output, …, each depending on the one before it, the
/// first on the last.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loop(pub Vec<String>);

impl fmt::Display for Loop {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} → {}", self.0.join(" → "), self.0[0])
    }
}

/// A wire and, from its target, the wires that the outputs depending on it feed.
struct Graph {
    next: Vec<Vec<usize>>,
}

/// One loop for each set of connections that depend on each other in a ring.
pub(super) fn loops(members: &[Member], wires: &[Wire]) -> Vec<Loop> {
    let feeds = |wire: &Wire| {
        let (member, input) = wire.target;
        let ports = members[member].participant.ports();
        let depends = |other: &&(usize, &Wire)| {
            let (source, output) = other.1.source;
            source == member && {
                let known = ports[output].depends_on.as_ref();
                known.is_none_or(|known| known.contains(&input))
            }
        };
        wires
            .iter()
            .enumerate()
            .filter(|other| depends(&other))
            .map(|(n, _)| n)
            .collect()
    };
    let graph = Graph {
        next: wires.iter().map(feeds).collect(),
    };
    let name = |(member, port): (usize, usize)| {
        let member = &members[member];
        format!("{}.{}", member.name, member.participant.ports()[port].name)
    };
    let mut told = vec![false; wires.len()];
    let mut found = Vec::new();
    for first in 0..wires.len() {
        if told[first] {
            continue;
        }
        let Some(ring) = graph.shortest_ring(first) else {
            continue;
        };
        // every wire that is in a ring with this one belongs to what was told
        for (wire, told) in told.iter_mut().enumerate() {
            *told |= graph.reaches(first, wire) && graph.reaches(wire, first);
        }
        let terminals = ring
            .iter()
            .flat_map(|&wire| [name(wires[wire].source), name(wires[wire].target)])
            .collect();
        found.push(Loop(terminals));
    }
    found
}

impl Graph {
    /// For each wire the one before it on a shortest way from `first`, which is its own start.
    fn ways(&self, first: usize) -> Vec<Option<usize>> {
        let mut before = vec![None; self.next.len()];
        let mut queue = std::collections::VecDeque::from([first]);
        while let Some(wire) = queue.pop_front() {
            for &next in &self.next[wire] {
                if before[next].is_none() {
                    before[next] = Some(wire);
                    queue.push_back(next);
                }
            }
        }
        before
    }

    fn reaches(&self, from: usize, to: usize) -> bool {
        self.ways(from)[to].is_some()
    }

    fn shortest_ring(&self, first: usize) -> Option<Vec<usize>> {
        let before = self.ways(first);
        let mut ring = vec![first];
        let mut wire = before[first]?;
        while wire != first {
            ring.push(wire);
            wire = before[wire]?;
        }
        ring[1..].reverse();
        Some(ring)
    }
}
