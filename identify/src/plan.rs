//! What is asked of a fit, and what it means for rides.

use crate::error::{Error, Result};
use crate::free::{ALL, Candidate, Free, Prior, Scale, Scope, Tie, Variable, all};
use crate::model::Model;
use crate::objective::{Objective, Unknowns};
use crate::ride::Ride;
use crate::spectrum::{Recipe, Taper};
use bicycle::simulate;
use bicycle::{Bicycle, Excitation, Formulation, Instruments, Parameters, State};
use std::ops::Range;

/// A change of how a free parameter is sought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// Other bounds than its row's range [SI].
    Bounds(f64, f64),
    /// Of how many rides it is one and the same.
    Scope(Scope),
    /// The scale of the search.
    Scale(Scale),
    /// What was known before; none: what the literature measured.
    Prior(Option<Prior>),
}

impl Change {
    fn apply(self, free: Free) -> Result<Free> {
        match self {
            Self::Bounds(lower, upper) => free.within(lower, upper),
            Self::Scope(scope) => Ok(free.per(scope)),
            Self::Scale(scale) => free.on(scale),
            Self::Prior(prior) => free.with_prior(prior),
        }
    }
}

/// A ride to be fitted, and the bicycle that was ridden.
#[derive(Debug, Clone)]
pub struct Ridden<'a> {
    /// The recording.
    pub ride: &'a Ride,
    /// The bicycle; what is free of it is one with the other rides', or starts here.
    pub parameters: Parameters,
    /// Speed [m/s] where the ride does not record it.
    pub speed: f64,
    /// Rides of one condition share what is free per condition.
    pub condition: String,
    /// The windows of `free-response`, and of `time` where they are given [samples].
    pub windows: Vec<Range<usize>>,
}

/// What is asked of a fit. `None` leaves the choice to what the ride has recorded.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The bicycle; free parameters start at its values.
    pub parameters: Parameters,
    /// How the equations are read.
    pub formulation: Formulation,
    /// Speed [m/s] where the ride does not record it.
    pub speed: f64,
    /// What drives an unmeasured torque; intensity and effective damping are where they start.
    pub excitation: Excitation,
    /// The objective.
    pub objective: Option<Objective>,
    /// Names of the channels.
    pub channels: Option<Vec<&'static str>>,
    /// The free parameters.
    pub free: Option<Vec<Free>>,
    /// What is changed of the free parameters: bounds, scope, scale, prior.
    pub changes: Vec<(&'static str, Change)>,
    /// Rows that follow free ones.
    pub ties: Vec<Tie>,
    /// How spectra are taken; the taper follows from the number of channels.
    pub recipe: Recipe,
    /// Length of a window [s] of `time`, else .5, or of `frf`, else 10.
    pub window: Option<f64>,
    /// Standard deviation of the noise of each channel [SI]; else estimated above 10 Hz.
    pub noise: Option<Vec<f64>>,
    /// Most iterations of a search.
    pub max_iterations: u64,
    /// What stands for the bicycle.
    pub model: Model,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            parameters: Parameters::default(),
            formulation: Formulation::default(),
            speed: bicycle::Input::default().speed,
            excitation: Excitation {
                remnant_intensity: 1.0,
                ..Excitation::default()
            },
            objective: None,
            channels: None,
            free: None,
            changes: Vec::new(),
            ties: Vec::new(),
            recipe: Recipe::default(),
            window: None,
            noise: None,
            max_iterations: 100,
            model: Model::default(),
        }
    }
}

/// The channels that spectra look at, in the order of the likelihood.
const SPECTRAL: [&str; 3] = ["steer", "roll_rate", "yaw_rate"];

impl Plan {
    /// `ride`, ridden on the plan's own bicycle.
    pub fn ridden<'a>(&self, ride: &'a Ride) -> Ridden<'a> {
        Ridden {
            ride,
            parameters: self.parameters,
            speed: self.speed,
            condition: String::new(),
            windows: Vec::new(),
        }
    }
}

/// What a plan means for rides: every choice made.
pub struct Resolved {
    /// The objective.
    pub objective: Objective,
    /// The channels.
    pub channels: Vec<&'static str>,
    /// The free parameters, as each ride has them.
    pub free: Vec<Free>,
    /// How spectra are taken.
    pub recipe: Recipe,
    /// Length of a window [s].
    pub window: f64,
}

impl Resolved {
    /// What is sought in `ridden`.
    pub fn unknowns(&self, ridden: &Ridden, plan: &Plan) -> Unknowns {
        Unknowns {
            free: self.free.clone(),
            ties: plan.ties.clone(),
            start: started(ridden, plan),
        }
    }

    /// The variables of the search, and for each ride which of them are its free parameters.
    pub fn variables(&self, rides: &[Ridden]) -> (Vec<Variable>, Vec<Vec<usize>>) {
        let names = names(rides);
        let mut variables: Vec<Variable> = Vec::new();
        let mut indices = vec![Vec::new(); rides.len()];
        for free in &self.free {
            let first = variables.len();
            for ((ridden, name), own) in rides.iter().zip(&names).zip(&mut indices) {
                // one ride needs no name behind its parameters
                let of = match free.scope {
                    _ if rides.len() == 1 => None,
                    Scope::Shared => None,
                    Scope::Condition => Some(ridden.condition.clone()),
                    Scope::Ride => Some(name.clone()),
                };
                let variable = Variable { free: *free, of };
                let known = variables[first..].iter().position(|v| *v == variable);
                own.push(known.map_or(variables.len(), |k| first + k));
                if known.is_none() {
                    variables.push(variable);
                }
            }
        }
        (variables, indices)
    }
}

/// What the rides are called beside each other: those of one name, stretches of one file say, are
/// numbered.
pub fn names(rides: &[Ridden]) -> Vec<String> {
    let plain: Vec<String> = rides.iter().map(|ridden| ridden.ride.name()).collect();
    let number = |i: usize| plain[..=i].iter().filter(|name| **name == plain[i]).count();
    let several = |i: usize| plain.iter().filter(|name| **name == plain[i]).count() > 1;
    (0..plain.len())
        .map(|i| {
            if several(i) {
                format!("{} #{}", plain[i], number(i))
            } else {
                plain[i].clone()
            }
        })
        .collect()
}

/// Refuses a ride that lacks a channel, or that no bicycle of the plan could ride.
fn check_ridden(
    Ridden {
        ride,
        parameters,
        speed,
        ..
    }: &Ridden,
    plan: &Plan,
    objective: Objective,
    channels: &[&'static str],
) -> Result<()> {
    channels
        .iter()
        .try_for_each(|c| ride.channel(c).map(drop))?;
    // windows leave out where a ride stands; spectra cannot
    if !objective.is_replayed() {
        ride.check_moving()?;
    }
    if plan.model.foreign().is_some() {
        return Ok(());
    }
    let bicycle = Bicycle::new(parameters, plan.formulation);
    simulate::check(&bicycle, ride.mean_speed(*speed))?;
    check_moved(channels, &bicycle)
}

/// Makes the choices a plan leaves open. With the torque recorded in every ride: `time`, all four
/// parameters (without slip the two of friction).
/// Without: `whittle` where roll and yaw rate are recorded, else `amplitude` of the steering; of
/// the friction then only the effective damping is sought.
pub fn resolve(rides: &[Ridden], plan: &Plan) -> Result<Resolved> {
    check_distinct(rides)?;
    Ride::check_sampled_alike(rides.iter().map(|ridden| ridden.ride))?;
    let record = |name: &str| rides.iter().all(|ridden| ridden.ride.has(name));
    let three = match &plan.channels {
        Some(channels) => channels.len() > 2,
        None => SPECTRAL.into_iter().all(record),
    };
    let objective = plan
        .objective
        .unwrap_or(match (record("steer_torque"), three) {
            (true, _) => Objective::Time,
            (false, true) => Objective::Whittle,
            (false, false) => Objective::Amplitude,
        });
    check_windows(rides, plan, objective)?;
    let recorded = || SPECTRAL.into_iter().filter(|name| record(name)).collect();
    let channels = plan.channels.clone().unwrap_or_else(|| match objective {
        Objective::Amplitude => vec!["steer"],
        _ => recorded(),
    });
    for (i, channel) in channels.iter().enumerate() {
        if channels[..i].contains(channel) {
            return Err(Error::Form {
                expected: "each channel once",
                found: channels.join(","),
            });
        }
    }
    rides
        .iter()
        .try_for_each(|ridden| check_ridden(ridden, plan, objective, &channels))?;
    let mut free = if let Some(free) = &plan.free {
        free.clone()
    } else {
        let names: &[&str] = match (objective, channels.len()) {
            (Objective::Time | Objective::Frf, _) => &ALL,
            (Objective::FreeResponse, _) => &["viscous_friction"],
            (_, 3..) => &[
                "cornering_stiffness",
                "camber_stiffness",
                "effective_damping",
            ],
            _ => &["effective_damping"],
        };
        let known = all(plan.formulation);
        names
            .iter()
            .filter(|name| known.contains(name) || !ALL.contains(name))
            .map(|name| Free::new(name))
            .collect::<Result<_>>()?
    };
    let intensity = |free: &Free| free.row.name == "remnant_intensity";
    if objective.has_remnant() && !free.iter().any(intensity) {
        free.push(Free::new("remnant_intensity")?);
    }
    for (name, change) in &plan.changes {
        let known = || {
            free.iter()
                .map(|f| f.row.name)
                .collect::<Vec<_>>()
                .join(", ")
        };
        let place = free.iter().position(|f| f.row.name == *name);
        let place = place.ok_or_else(|| Error::NotFree {
            name,
            free: known(),
        })?;
        free[place] = change.apply(free[place])?;
        check_start(&free[place], *change, plan, rides)?;
    }
    plan.model.check(objective)?;
    if let Some(fmu) = plan.model.foreign() {
        fmu.check(&free, &plan.ties, &channels)?;
        free = free
            .into_iter()
            .map(|free| fmu.within(free))
            .collect::<Result<_>>()?;
    }
    check_friction(&free, objective)?;
    check_ties(&free, plan, rides)?;
    let taper = Taper::of(channels.len());
    Ok(Resolved {
        objective,
        channels,
        free,
        recipe: Recipe {
            taper,
            ..plan.recipe.clone()
        },
        window: plan.window.unwrap_or(match objective {
            Objective::Frf => 10.0,
            _ => 0.5,
        }),
    })
}

/// Refuses no ride at all and a ride that would be counted twice.
fn check_distinct(rides: &[Ridden]) -> Result<()> {
    if rides.is_empty() {
        return Err(Error::NoRides);
    }
    for (i, ridden) in rides.iter().enumerate() {
        if rides[..i].iter().any(|other| other.ride == ridden.ride) {
            return Err(Error::SameRide {
                ride: ridden.ride.name(),
            });
        }
    }
    Ok(())
}

/// Refuses windows that the objective has no use for, or none where it lives on them.
fn check_windows(rides: &[Ridden], plan: &Plan, objective: Objective) -> Result<()> {
    let given = rides.iter().any(|ridden| !ridden.windows.is_empty());
    if given {
        objective.check("--windows", &[Objective::Time, Objective::FreeResponse])?;
    } else if objective == Objective::FreeResponse {
        return Err(Error::NoWindows {
            objective: objective.name(),
        });
    }
    let Some(window) = plan.window else {
        return Ok(());
    };
    objective.check("--window", &[Objective::Time, Objective::Frf])?;
    if objective == Objective::Frf {
        for Ridden { ride, .. } in rides {
            let (least, most) = (4.0 * ride.step(), ride.duration() / 1.5);
            if !(least..=most).contains(&window) {
                return Err(Error::Averaging {
                    window,
                    least,
                    most,
                });
            }
        }
    }
    Ok(())
}

/// Refuses bounds that leave out where the search of `free` would start. Where a nuisance starts
/// nobody chose: it is moved within them.
fn check_start(free: &Free, change: Change, plan: &Plan, rides: &[Ridden]) -> Result<()> {
    if free.nuisance() || !matches!(change, Change::Bounds(..)) {
        return Ok(());
    }
    let outside = rides
        .iter()
        .map(|ridden| started(ridden, plan).get(free))
        .find(|start| !(free.lower..=free.upper).contains(start));
    outside.map_or(Ok(()), |value| {
        Err(Error::StartOutside {
            name: free.row.name,
            value,
            lower: free.lower,
            upper: free.upper,
            unit: free.row.unit.symbol,
        })
    })
}

/// What a search of `ridden` starts from.
fn started(ridden: &Ridden, plan: &Plan) -> Candidate {
    Candidate {
        parameters: ridden.parameters,
        excitation: plan.excitation,
        instruments: Instruments::default(),
    }
}

/// Refuses a tie to a row that is not free, of a row that is, or without a ratio to keep.
fn check_ties(free: &[Free], plan: &Plan, rides: &[Ridden]) -> Result<()> {
    let is_free = |name: &str| free.iter().any(|f| f.row.name == name);
    for tie in &plan.ties {
        let (follower, leader) = (tie.follower().name, tie.leader.name);
        let refuse = |why| {
            Err(Error::Tie {
                follower,
                leader,
                why,
            })
        };
        if !is_free(leader) {
            return refuse("the one it follows is not free");
        }
        if is_free(follower) {
            return refuse("it is free itself");
        }
        let leads = Free::new(leader)?;
        if (rides.iter()).any(|ridden| started(ridden, plan).get(&leads) == 0.0) {
            return refuse("the one it follows starts at 0, so that there is no ratio to keep");
        }
    }
    Ok(())
}

/// What a fit leaves as it is though its user may take it for sought.
pub fn left_alone(free: &[Free], plan: &Plan) -> Option<String> {
    let is_free = |name: &str| free.iter().any(|f| f.row.name == name);
    let slips = plan.formulation == Formulation::WhippleSlip;
    let p = &plan.parameters;
    let follows = |name: &str| plan.ties.iter().any(|tie| tie.follower().name == name);
    let rear = "rear_cornering_stiffness";
    let alone = is_free("cornering_stiffness") && !is_free(rear) && !follows(rear);
    (slips && alone).then(|| {
        format!(
            "only the front tyre is sought: rear_cornering_stiffness stays {} 1/rad, \
             rear_camber_stiffness {} 1/rad",
            p.rear_cornering_stiffness, p.rear_camber_stiffness
        )
    })
}

/// Refuses a channel in which the bicycle does not move.
fn check_moved(channels: &[&'static str], bicycle: &Bicycle) -> Result<()> {
    let moved = State::TABLE.iter().enumerate().filter_map(|(i, row)| {
        // without slip the yaw rate is no state but follows from the steering
        (i < bicycle.order() || row.name == "yaw_rate").then_some(row.name)
    });
    let still = channels.iter().find(|channel| {
        State::index(channel).is_some() && moved.clone().all(|name| name != **channel)
    });
    match still {
        Some(channel) => Err(Error::Unmoved {
            channel,
            formulation: bicycle.formulation.name(),
            moved: moved.collect::<Vec<_>>().join(", "),
        }),
        None => Ok(()),
    }
}

/// Effective damping stands for viscous and Coulomb friction together: never both.
fn check_friction(free: &[Free], objective: Objective) -> Result<()> {
    let has = |name: &str| free.iter().any(|f| f.row.name == name);
    for part in ["viscous_friction", "coulomb_friction"] {
        if has("effective_damping") && has(part) {
            return Err(Error::NoInfluence {
                name: part.into(),
                objective: objective.name(),
                why: "effective_damping stands for viscous and Coulomb friction together; free \
                      either it or them",
            });
        }
    }
    Ok(())
}
