//! What a controller is worth: the same rides without and with it, over trails and loads.

use super::PLANT;
use super::coupling::{Begun, Coupling, Ran, Variation};
use super::opening::not_ours;
use crate::assist::{self, Case, Fall, Pair, Ridden, Study};
use crate::error::{Error, Result};
use crate::ride::Ride;
use crate::spectrum::Recipe;
use bicycle::cases::TRAILS;
use bicycle::course::LATERAL_OFFSET;
use bicycle::{Parameters, simulate};
use fmi_import::master::End;

/// Which cases, how many rides each.
#[derive(Debug, Clone, PartialEq)]
pub struct Cases {
    /// Trails [m].
    pub trails: Vec<f64>,
    /// Loads on the carrier [kg].
    pub loads: Vec<f64>,
    /// Rides of each, with seeds of the remnant from the setup's on.
    pub rides: u64,
    /// The participant that is left out.
    pub controller: String,
    /// How spectra are taken.
    pub recipe: Recipe,
}

impl Default for Cases {
    /// The paper's trails, from a child's seat empty to 30 kg in it.
    fn default() -> Self {
        Self {
            trails: TRAILS.to_vec(),
            loads: vec![0.0, 10.0, 20.0, 30.0],
            rides: 4,
            controller: "controller".to_owned(),
            recipe: Recipe::default(),
        }
    }
}

impl Cases {
    /// How many runs a study of them takes at most: each ride without and with the controller, and
    /// for the eigenvalues of either the answers to four pulses.
    pub fn runs(&self) -> u64 {
        (2 * self.rides + 8) * (self.trails.len() * self.loads.len()) as u64
    }
}

/// Rides every case without and with the controller.
pub fn study(coupling: &Coupling, cases: &Cases, begun: &mut dyn FnMut(Begun)) -> Result<Study> {
    let bicycle = coupling.bicycle.as_ref().ok_or_else(|| not_ours("none"))?;
    if coupling.names().all(|name| name != cases.controller) {
        let known = coupling.names();
        return Err(Error::unknown("participant", &cases.controller, known));
    }
    let row = |name| &Parameters::TABLE[Parameters::index(name).expect("a row")];
    let mut rows = Vec::new();
    let mut found_by = Vec::new();
    for &trail in &cases.trails {
        for &rear_load in &cases.loads {
            let case = Case(vec![(row("trail"), trail), (row("rear_load"), rear_load)]);
            let parameters = Parameters {
                trail,
                rear_load,
                ..bicycle.parameters
            };
            let model = bicycle::Bicycle::new(&parameters, bicycle.formulation);
            let name = case.to_string();
            let here = |cause: Error| cause.in_file(name.clone());
            simulate::check(&model, bicycle.input.speed).map_err(|cause| here(cause.into()))?;
            let variation = |seed, without| Variation {
                parameters: Some(&parameters),
                seed,
                without,
                smooth: false,
            };
            let alone = Some(cases.controller.as_str());
            let mut pairs = Vec::new();
            for seed in (0..cases.rides).map(|n| coupling.seed().wrapping_add(n)) {
                let mut ride = |without| {
                    let ran = coupling.run(&variation(seed, without), begun)?;
                    ridden(ran, coupling.plan().step)
                };
                pairs.push(Pair {
                    without: ride(alone).map_err(here)?,
                    with: ride(None).map_err(here)?,
                });
            }
            let mut modes = |without| {
                let found = coupling
                    .modes(&variation(coupling.seed(), without), begun)
                    .map_err(here)?;
                Ok::<_, Error>(found.map(|(values, method)| {
                    if !found_by.contains(&method) {
                        found_by.push(method);
                    }
                    values
                }))
            };
            let modes = Pair {
                without: modes(alone)?,
                with: modes(None)?,
            };
            let worth = assist::worth(case, &pairs, &cases.recipe, &modes);
            rows.push(worth.map_err(here)?);
        }
    }
    let mut notes = vec![format!(
        "{} ride{} of {:.4} s in each case, formulation {}, at {:.2} m/s",
        cases.rides,
        if cases.rides == 1 { "" } else { "s" },
        coupling.stop(),
        bicycle.formulation.name(),
        bicycle.input.speed
    )];
    if !found_by.is_empty() {
        notes.push(format!(
            "eigenvalues by {}, about standing upright, without Coulomb friction and quantisers",
            found_by.join(" and ")
        ));
    }
    Ok(Study {
        controller: coupling.model_name(&cases.controller).to_owned(),
        recipe: cases.recipe.clone(),
        rows,
        notes,
    })
}

/// A run as a ride. One that the plant ended is a fall; any other end but the stop is an error.
fn ridden(ran: Ran, step: f64) -> Result<Ridden> {
    let Ran { run, .. } = ran;
    let fell = match run.end {
        End::Complete | End::Stopped => None,
        End::Early { member, time, log } if member == PLANT => Some(Fall {
            time,
            why: log
                .last()
                .map_or_else(String::new, |line| line.message.clone()),
        }),
        End::Early { member, time, .. } => return Err(Error::EndedEarly { member, time }),
        End::Failed(error) => return Err(error.into()),
    };
    // the row at the time of a fall lies between the others
    let rows = run.columns[0].len() - usize::from(fell.is_some());
    let mut ride = Ride::new(0.0, step, rows);
    let wanted = [
        ("steer", "steer"),
        ("assist_torque", "plant.assist_torque"),
        (LATERAL_OFFSET.name, LATERAL_OFFSET.name),
    ];
    for (channel, column) in wanted {
        if let Some(index) = run.names.iter().position(|name| name == column) {
            ride.insert(channel, run.columns[index][..rows].to_vec())?;
        }
    }
    // a row's torque acted over the step before it: so its work is exact
    let steer = ride.channel("steer")?;
    let turned = steer.windows(2).map(|pair| (pair[1] - pair[0]) / step);
    let mean_rate = [0.0].into_iter().chain(turned).take(rows).collect();
    ride.insert("steer_rate", mean_rate)?;
    Ok(Ridden { ride, fell })
}
