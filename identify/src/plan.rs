//! What is asked of a fit, and what it means for a ride.

use crate::error::{Error, Result};
use crate::free::{ALL, Candidate, Free, all};
use crate::objective::{Objective, Unknowns};
use crate::ride::Ride;
use crate::spectrum::{Recipe, Taper};
use bicycle::simulate;
use bicycle::{Bicycle, Excitation, Formulation, Parameters, State};

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
    /// Bounds of free parameters, in place of their rows' ranges.
    pub bounds: Vec<Free>,
    /// How spectra are taken; the taper follows from the number of channels.
    pub recipe: Recipe,
    /// Length of a window of the `time` objective [s].
    pub window: f64,
    /// Standard deviation of the noise of each channel [SI]; else estimated above 10 Hz.
    pub noise: Option<Vec<f64>>,
    /// Most iterations of a search.
    pub max_iterations: u64,
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
            bounds: Vec::new(),
            recipe: Recipe::default(),
            window: 0.5,
            noise: None,
            max_iterations: 100,
        }
    }
}

/// The channels that spectra look at, in the order of the likelihood.
const SPECTRAL: [&str; 3] = ["steer", "roll_rate", "yaw_rate"];

/// What a plan means for a ride: every choice made.
pub struct Resolved {
    /// The objective.
    pub objective: Objective,
    /// The channels.
    pub channels: Vec<&'static str>,
    /// What is sought.
    pub unknowns: Unknowns,
    /// How spectra are taken.
    pub recipe: Recipe,
}

/// Makes the choices a plan leaves open. With the torque recorded: `time`, all four parameters
/// (without slip the two of friction).
/// Without: `whittle` where roll and yaw rate are recorded, else `amplitude` of the steering; of
/// the friction then only the effective damping is sought.
pub fn resolve(ride: &Ride, plan: &Plan) -> Result<Resolved> {
    let has = |name: &&&'static str| ride.has(name);
    let three = match &plan.channels {
        Some(channels) => channels.len() > 2,
        None => SPECTRAL.iter().all(|name| ride.has(name)),
    };
    let objective = plan
        .objective
        .unwrap_or(match (ride.has("steer_torque"), three) {
            (true, _) => Objective::Time,
            (false, true) => Objective::Whittle,
            (false, false) => Objective::Amplitude,
        });
    let channels = plan.channels.clone().unwrap_or_else(|| match objective {
        Objective::Amplitude => vec!["steer"],
        Objective::Whittle | Objective::Time => SPECTRAL.iter().filter(has).copied().collect(),
    });
    for (i, channel) in channels.iter().enumerate() {
        ride.channel(channel)?;
        if channels[..i].contains(channel) {
            return Err(Error::Form {
                expected: "each channel once",
                found: channels.join(","),
            });
        }
    }
    let bicycle = Bicycle::new(&plan.parameters, plan.formulation);
    ride.check_moving()?;
    simulate::check(&bicycle, ride.mean_speed(plan.speed))?;
    check_moved(&channels, &bicycle)?;
    let mut free = if let Some(free) = &plan.free {
        free.clone()
    } else {
        let names: &[&str] = match (objective, channels.len()) {
            (Objective::Time, _) => &ALL,
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
    if objective != Objective::Time && !free.iter().any(Free::nuisance) {
        free.push(Free::new("remnant_intensity")?);
    }
    for bounded in &plan.bounds {
        let known: Vec<_> = free.iter().map(|f| f.row.name).collect();
        let name = bounded.row.name;
        let place = free.iter_mut().find(|f| f.row.name == name);
        *place.ok_or_else(|| Error::unknown("free parameter", name, known))? = *bounded;
    }
    check_friction(&free, objective)?;
    let taper = Taper::of(channels.len());
    let start = Candidate {
        parameters: plan.parameters,
        excitation: plan.excitation,
    };
    Ok(Resolved {
        objective,
        channels,
        unknowns: Unknowns { free, start },
        recipe: Recipe {
            taper,
            ..plan.recipe.clone()
        },
    })
}

/// What a fit leaves as it is though its user may take it for sought.
pub fn left_alone(free: &[Free], plan: &Plan) -> Option<String> {
    let is_free = |name: &str| free.iter().any(|f| f.row.name == name);
    let slips = plan.formulation == Formulation::WhippleSlip;
    let p = &plan.parameters;
    (slips && is_free("cornering_stiffness") && !is_free("rear_cornering_stiffness")).then(|| {
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
