//! A bicycle file as written, and what it determines.

use crate::error::{Error, Result};
use crate::unit::Value;
use bicycle::Parameters;
use bicycle::mass::{self, Body, Literature, Lumps};
use bicycle::quantity::{KG, KG_M2, M, RAD, Unit};
use serde::Deserialize;
use std::collections::BTreeMap;

/// A bicycle file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Written {
    pub(super) name: String,
    #[serde(default)]
    pub(super) description: String,
    #[serde(default)]
    pub(super) source: String,
    #[serde(default)]
    pub(super) law_in_loop: bool,
    pub(super) formulation: Option<String>,
    bodies: Option<Bodies>,
    lumps: Option<WrittenLumps>,
    #[serde(default)]
    pub(super) parameters: BTreeMap<String, Value>,
    #[serde(default)]
    pub(super) inputs: BTreeMap<String, Value>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Bodies {
    bicycle: Option<BTreeMap<String, Value>>,
    literature: Option<WrittenLiterature>,
    rider: Option<BTreeMap<String, Value>>,
}

#[derive(Deserialize)]
struct WrittenLumps {
    about: About,
    #[serde(flatten)]
    values: BTreeMap<String, Value>,
}

#[derive(Deserialize)]
struct WrittenLiterature {
    rider_included: bool,
    #[serde(flatten)]
    values: BTreeMap<String, Value>,
}

/// What inertias are about.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum About {
    Cog,
    RearContact,
}

/// The masses of a bicycle, as far as the file takes them apart.
pub(super) enum Masses {
    /// Bicycle and rider in one.
    Lumps(Lumps),
    /// The bicycle alone, and perhaps a rider.
    Bodies { bicycle: Body, rider: Option<Body> },
    /// The literature's bodies, and perhaps a rider besides.
    Literature {
        bicycle: Box<Literature>,
        rider_included: bool,
        rider: Option<Body>,
    },
}

impl Written {
    /// The masses.
    pub(super) fn masses(&mut self) -> Result<Masses> {
        const EXPECTED: &str = "[lumps], [bodies.bicycle] and [bodies.literature]";
        let Bodies {
            bicycle,
            literature,
            rider,
        } = self.bodies.take().unwrap_or(Bodies {
            bicycle: None,
            literature: None,
            rider: None,
        });
        let rider = rider.map(read_rider).transpose()?;
        match (self.lumps.take(), bicycle, literature) {
            (Some(lumps), None, None) if rider.is_none() => Ok(Masses::Lumps(lumps.read()?)),
            (None, Some(bicycle), None) => Ok(Masses::Bodies {
                bicycle: read_body(bicycle)?,
                rider,
            }),
            (None, None, Some(literature)) => {
                let rider_included = literature.rider_included;
                let bicycle = Box::new(literature.read()?);
                let mut masses = Masses::Literature {
                    bicycle,
                    rider_included,
                    rider: None,
                };
                if let Some(rider) = rider {
                    masses.put_on(rider).map_err(|why| Error::Rider {
                        bicycle: self.name.clone(),
                        why,
                    })?;
                }
                Ok(masses)
            }
            (Some(_), None, None) => Err(Error::Rider {
                bicycle: self.name.clone(),
                why: IN_LUMPS,
            }),
            (lumps, bicycle, literature) => {
                let found = [lumps.is_some(), bicycle.is_some(), literature.is_some()];
                let found = found.into_iter().filter(|&there| there).count();
                Err(Error::Masses {
                    expected: EXPECTED,
                    found,
                })
            }
        }
    }
}

const IN_LUMPS: &str = "its masses are given as [lumps], with the rider in them";
const INCLUDED: &str = "its 25 parameters include one (rider_included = true)";

impl Masses {
    /// Puts `rider` on, in place of another; why not, where that cannot be.
    pub(super) fn put_on(&mut self, new: Body) -> std::result::Result<(), &'static str> {
        match self {
            Self::Lumps(_) => Err(IN_LUMPS),
            Self::Literature {
                rider_included: true,
                ..
            } => Err(INCLUDED),
            Self::Bodies { rider, .. } | Self::Literature { rider, .. } => {
                *rider = Some(new);
                Ok(())
            }
        }
    }

    /// Writes the rows the masses determine into `p`.
    pub(super) fn write(&self, p: &mut Parameters) {
        match self {
            Self::Lumps(lumps) => p.set_lumps(*lumps),
            Self::Bodies { bicycle, rider } => {
                let bodies: Vec<Body> = [Some(*bicycle), *rider].into_iter().flatten().collect();
                p.set_lumps(mass::compose(&bodies));
            }
            Self::Literature { bicycle, rider, .. } => bicycle.write(p, rider.as_slice()),
        }
    }

    /// The section they come from.
    pub(super) fn section(&self) -> &'static str {
        match self {
            Self::Lumps(_) => "[lumps]",
            Self::Bodies { .. } => "[bodies]",
            Self::Literature { .. } => "[bodies.literature]",
        }
    }
}

impl WrittenLumps {
    fn read(self) -> Result<Lumps> {
        let mut section = Section::new("[lumps]", self.values);
        let lumps = Lumps {
            total_mass: section.take("total_mass", KG),
            cog_to_rear: section.take("cog_to_rear", M),
            cog_height: section.take("cog_height", M),
            roll_inertia: section.take("roll_inertia", KG_M2),
            yaw_inertia: section.take("yaw_inertia", KG_M2),
            cross_inertia: section.take("cross_inertia", KG_M2),
        };
        section.end()?;
        Ok(match self.about {
            About::RearContact => lumps,
            About::Cog => mass::compose(&[Body {
                mass: lumps.total_mass,
                x: lumps.cog_to_rear,
                h: lumps.cog_height,
                roll_inertia: lumps.roll_inertia,
                yaw_inertia: lumps.yaw_inertia,
                cross_inertia: lumps.cross_inertia,
            }]),
        })
    }
}

fn read_body(values: BTreeMap<String, Value>) -> Result<Body> {
    let mut section = Section::new("[bodies.bicycle]", values);
    let body = Body {
        mass: section.take("mass", KG),
        x: section.take("x", M),
        h: section.take("h", M),
        roll_inertia: section.take("roll_inertia", KG_M2),
        yaw_inertia: section.take("yaw_inertia", KG_M2),
        cross_inertia: section.take("cross_inertia", KG_M2),
    };
    section.end()?;
    Ok(body)
}

fn read_rider(values: BTreeMap<String, Value>) -> Result<Body> {
    let mut section = Section::new("[bodies.rider]", values);
    let (mass, height) = (section.take("mass", KG), section.take("height", M));
    section.end()?;
    rider(mass, height)
}

/// A rider of `mass` [kg] and `height` [m], if such people ride.
pub(super) fn rider(mass: f64, height: f64) -> Result<Body> {
    let person = |name: &str, value: f64, min: f64, max: f64, unit: Unit| {
        if (min..=max).contains(&value) {
            return Ok(value);
        }
        Err(Error::OutOfRange {
            name: name.into(),
            value,
            min,
            max,
            unit: unit.symbol,
        })
    };
    Ok(mass::rider(
        person("mass of the rider", mass, 10.0, 200.0, KG)?,
        person("height of the rider", height, 0.8, 2.5, M)?,
    ))
}

impl WrittenLiterature {
    fn read(self) -> Result<Literature> {
        let mut section = Section::new("[bodies.literature]", self.values);
        let literature = Literature {
            w: section.take("w", M),
            c: section.take("c", M),
            lam: section.take("lam", RAD),
            rR: section.take("rR", M),
            mR: section.take("mR", KG),
            IRxx: section.take("IRxx", KG_M2),
            IRyy: section.take("IRyy", KG_M2),
            xB: section.take("xB", M),
            zB: section.take("zB", M),
            mB: section.take("mB", KG),
            IBxx: section.take("IBxx", KG_M2),
            IBzz: section.take("IBzz", KG_M2),
            IBxz: section.take("IBxz", KG_M2),
            xH: section.take("xH", M),
            zH: section.take("zH", M),
            mH: section.take("mH", KG),
            IHxx: section.take("IHxx", KG_M2),
            IHzz: section.take("IHzz", KG_M2),
            IHxz: section.take("IHxz", KG_M2),
            rF: section.take("rF", M),
            mF: section.take("mF", KG),
            IFxx: section.take("IFxx", KG_M2),
            IFyy: section.take("IFyy", KG_M2),
        };
        // printed with the others, but symmetric bodies in a plane have no use for them
        for unused in ["IByy", "IHyy"] {
            section.values.remove(unused);
        }
        section.end()?;
        let names = [
            "a rear wheel",
            "a rear frame",
            "a front frame",
            "a front wheel",
        ];
        let mut bodies = names.into_iter().zip(literature.bodies());
        match bodies.find(|(_, found)| !found.is_possible()) {
            Some((body, found)) => Err(Error::Body { body, found }.in_file("[bodies.literature]")),
            None => Ok(literature),
        }
    }
}

/// A section of quantities: each is taken once, and none may be left over.
struct Section {
    name: &'static str,
    values: BTreeMap<String, Value>,
    taken: Vec<&'static str>,
    error: Option<Error>,
}

impl Section {
    fn new(name: &'static str, values: BTreeMap<String, Value>) -> Self {
        Self {
            name,
            values,
            taken: Vec::new(),
            error: None,
        }
    }

    /// The value of `key`; NaN where there is none, which [`Section::end`] reports.
    fn take(&mut self, key: &'static str, unit: Unit) -> f64 {
        self.taken.push(key);
        let value = match self.values.remove(key) {
            Some(value) => value.si(unit, key).map_err(|e| e.in_file(self.name)),
            None => Err(Error::Missing {
                section: self.name,
                key,
            }),
        };
        value.unwrap_or_else(|error| {
            self.error.get_or_insert(error);
            f64::NAN
        })
    }

    /// What was wrong: first a key that nobody took, for a misspelt key is missed as well.
    fn end(self) -> Result<()> {
        if let Some(key) = self.values.keys().next() {
            return Err(Error::unknown("key", key, self.taken).in_file(self.name));
        }
        self.error.map_or(Ok(()), Err)
    }
}
