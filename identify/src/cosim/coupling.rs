//! What was typed, loaded and understood; runs of it.

use super::opening::{self, Opened, not_ours};
use super::record::{self, Column};
use super::rider::Rider;
use super::setup::Setup;
use super::{PLANT, RIDER, plant, wires};
use crate::bicycles::Bicycle;
use crate::course;
use crate::error::{Error, Result};
use crate::ride::TIME;

use bicycle::course::{LATERAL_OFFSET, Layout};
use bicycle::rider::{Manner, Preview, Schedule};
use bicycle::{Input, Parameters};
use fmi_import::master::{
    Connection, Foreign, Master, Member, Participant, Plan, Run, Terminal, Watch, by_name,
};
use fmi_import::{Value, VariableRow};
use std::sync::Arc;

/// How long a run is where nothing else says so [s].
const DURATION: f64 = 20.0;

/// Loaded and understood.
pub struct Coupling {
    fmus: Vec<Opened>,
    /// The plant, where it is one of ours.
    pub bicycle: Option<Bicycle>,
    course: Option<(Layout, Manner)>,
    connections: Vec<Connection>,
    seed: u64,
    plan: Plan,
}

/// How a run differs from what was typed.
#[derive(Debug, Clone, Copy)]
pub struct Variation<'a> {
    /// The plant's parameters, where it is one of ours.
    pub parameters: Option<&'a Parameters>,
    /// Seed of the remnant.
    pub seed: u64,
    /// The participant that is left out.
    pub without: Option<&'a str>,
    /// For small motions: without quantisers of controllers (rows called `…_resolution`), and with
    /// no input of the plant but its speed.
    pub smooth: bool,
}

impl Variation<'_> {
    pub(super) fn of(&self, bicycle: &Bicycle) -> Parameters {
        self.parameters.copied().unwrap_or(bicycle.parameters)
    }
}

/// A run under way and what its columns are.
#[derive(Debug, Clone)]
pub struct Begun {
    /// For looking at it.
    pub watch: Arc<Watch>,
    /// The name of each column.
    pub names: Vec<String>,
    /// The unit of each column.
    pub units: Vec<Option<String>>,
}

/// A run and what its columns are.
#[derive(Debug)]
pub struct Ran {
    /// What the master left; names are those of the columns.
    pub run: Run,
    /// Where it was to stop [s].
    pub stop: f64,
    /// The unit of each column.
    pub units: Vec<Option<String>>,
    /// What was connected.
    pub connections: Vec<Connection>,
    /// Algebraic loops, in words.
    pub loops: Vec<String>,
}

impl Ran {
    /// What is connected between FMUs, the rider left out.
    pub fn between_fmus(&self) -> impl Iterator<Item = &Connection> {
        let has_rider = |c: &Connection| {
            [&c.source, &c.target]
                .iter()
                .any(|t| t.participant == RIDER)
        };
        self.connections.iter().filter(move |c| !has_rider(c))
    }
}

impl Coupling {
    /// Loads what was typed. What was done besides is told through `note`.
    pub fn open(setup: &Setup, note: &mut dyn FnMut(&str)) -> Result<Self> {
        opening::check(setup)?;
        let mut fmus = Vec::new();
        let mut bicycle = None;
        for typed in &setup.fmus {
            let (opened, ridden) = opening::open(typed, setup)?;
            fmus.push(opened);
            bicycle = bicycle.or(ridden);
        }
        if let Some(bicycle) = &mut bicycle {
            bicycle.notes.drain(..).for_each(|words| note(&words));
        }
        let course = match (&setup.course, &bicycle) {
            (Some(name), Some(bicycle)) => {
                let wheelbase = bicycle.parameters.wheelbase;
                Some(course::plan(name, &setup.course_set, wheelbase)?)
            }
            (Some(name), None) => {
                return Err(not_ours("none").typed(format!("--course {name}")));
            }
            _ => None,
        };
        let stop = setup.stop.unwrap_or_else(|| match (&course, &bicycle) {
            (Some((layout, _)), Some(bicycle)) => layout.course().length() / bicycle.input.speed,
            _ => DURATION,
        });
        let mut coupling = Self {
            fmus,
            bicycle,
            course,
            connections: Vec::new(),
            seed: setup.seed,
            plan: Plan {
                start_time: 0.0,
                stop_time: stop,
                step: setup.step,
                algorithm: setup.algorithm,
                tolerance: setup.tolerance,
                initial_exchange: setup.initial_exchange,
                record: Vec::new(),
            },
        };
        coupling.connections = coupling.connect(&setup.connect)?;
        coupling.tell_open(note);
        Ok(coupling)
    }

    /// What was typed, without a difference.
    pub fn as_typed(&self) -> Variation<'_> {
        Variation {
            parameters: None,
            seed: self.seed,
            without: None,
            smooth: false,
        }
    }

    /// Where runs stop [s].
    pub fn stop(&self) -> f64 {
        self.plan.stop_time
    }

    /// Seed of the remnant.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Names of the FMUs.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.fmus.iter().map(|fmu| fmu.name.as_str())
    }

    /// Name of the model of the FMU called `name`; that name if there is none.
    pub fn model_name<'a>(&'a self, name: &'a str) -> &'a str {
        let found = self.fmus.iter().find(|fmu| fmu.name == name);
        found.map_or(name, |opened| &opened.fmu.description().model_name)
    }

    /// Whether a course is followed.
    pub fn has_course(&self) -> bool {
        self.course.is_some()
    }

    /// Frequency at which a slalom swings [Hz], where one is ridden: cones are passed alternately.
    pub fn slalom(&self) -> Option<f64> {
        match (&self.course, &self.bicycle) {
            (Some((Layout::Slalom(slalom), _)), Some(bicycle)) => {
                Some(bicycle.input.speed / (2.0 * slalom.cone_spacing))
            }
            _ => None,
        }
    }

    /// Runs; `begun` is told before the start.
    pub fn run(&self, variation: &Variation, begun: &mut dyn FnMut(Begun)) -> Result<Ran> {
        let mut master = self.master(variation)?;
        let others = self.names().filter(|name| *name != PLANT);
        let columns = record::columns(&mut master, others);
        let name = |column: &Column| column.name.clone();
        let names: Vec<String> = [TIME.to_owned()]
            .into_iter()
            .chain(columns.iter().map(name))
            .collect();
        let unit = |column: &Column| column.unit.clone();
        let mut units: Vec<_> = [Some("s".to_owned())]
            .into_iter()
            .chain(columns.iter().map(unit))
            .collect();
        let record = columns.into_iter().map(|column| column.terminal).collect();
        begun(Begun {
            watch: master.watch(),
            names: names.clone(),
            units: units.clone(),
        });
        let mut run = master.run(&Plan {
            record,
            ..self.plan.clone()
        })?;
        run.names = names;
        self.add_offset(&mut run, &mut units);
        Ok(Ran {
            run,
            stop: self.plan.stop_time,
            units,
            connections: master.connections().to_vec(),
            loops: master.loops().iter().map(ToString::to_string).collect(),
        })
    }

    /// Where the bicycle was beside its course, row by row.
    fn add_offset(&self, run: &mut Run, units: &mut Vec<Option<String>>) {
        let column = |name: &str| {
            let index = run.names.iter().position(|known| known == name)?;
            Some(&run.columns[index])
        };
        let (Some((layout, _)), Some(x), Some(y)) = (&self.course, column("x"), column("y")) else {
            return;
        };
        let course = layout.course();
        let mut near = 0.0;
        let offsets = x.iter().zip(y).map(|(x, y)| {
            let place = course.locate(*x, *y, near);
            near = place.arc_length;
            place.offset
        });
        run.columns.push(offsets.collect());
        run.names.push(LATERAL_OFFSET.name.to_owned());
        units.push(Some(LATERAL_OFFSET.unit.symbol.to_owned()));
    }

    /// The participants, connected.
    pub fn master(&self, variation: &Variation) -> Result<Master<'_>> {
        let rider = self.in_the_saddle(variation)?;
        self.master_with(variation, rider)
    }

    /// The participants, connected, with this one in the rider's place.
    pub(super) fn master_with<'a>(
        &'a self,
        variation: &Variation,
        rider: Option<Box<dyn Participant + 'a>>,
    ) -> Result<Master<'a>> {
        let members = self.members(variation, rider)?;
        let is_here = |name: &str| members.iter().any(|member| member.name == name);
        let both_here =
            |c: &&Connection| is_here(&c.source.participant) && is_here(&c.target.participant);
        let mut connections: Vec<_> = self.connections.iter().filter(both_here).cloned().collect();
        // one in the rider's place may give more
        let more = by_name(&members, &connections);
        connections.extend(more.into_iter().filter(|c| c.source.participant == RIDER));
        Ok(Master::new(members, connections)?)
    }

    fn members<'a>(
        &'a self,
        variation: &Variation,
        rider: Option<Box<dyn Participant + 'a>>,
    ) -> Result<Vec<Member<'a>>> {
        let rider = rider.map(|participant| Member {
            name: RIDER.to_owned(),
            participant,
            step: None,
        });
        let mut members: Vec<Member> = rider.into_iter().collect();
        for fmu in self.present(variation) {
            let starts = self.starts_of(fmu, variation);
            members.push(Member {
                name: fmu.name.clone(),
                participant: Box::new(
                    Foreign::new(&fmu.fmu, &fmu.name, &starts)
                        .map_err(|cause| Error::from(cause).in_file(fmu.name.clone()))?,
                ),
                step: fmu.step,
            });
        }
        Ok(members)
    }

    /// What is connected where all take part: what was typed, and equal names.
    fn connect(&self, typed: &[String]) -> Result<Vec<Connection>> {
        let variation = self.as_typed();
        let members = self.members(&variation, self.in_the_saddle(&variation)?)?;
        let mut connections = typed
            .iter()
            .map(|text| wires::connection(text, &members))
            .collect::<Result<Vec<_>>>()?;
        self.check_seat(&connections)?;
        connections.extend(by_name(&members, &connections));
        Ok(Master::new(members, connections)?.connections().to_vec())
    }

    /// A course and a remnant are ridden by steer torque: another source of it leaves them without.
    fn check_seat(&self, typed: &[Connection]) -> Result<()> {
        let remnant = |b: &Bicycle| b.excitation.remnant_intensity > 0.0;
        let rides = self.has_course() || self.bicycle.as_ref().is_some_and(remnant);
        let takes =
            |c: &&Connection| c.target.participant == PLANT && c.target.variable == "steer_torque";
        match typed.iter().find(takes) {
            Some(connection) if rides => Err(Error::Form {
                expected: "the rider as the source of plant.steer_torque, with a course or a remnant",
                found: connection.source.to_string(),
            }
            .typed("--connect")),
            _ => Ok(()),
        }
    }

    /// Says which inputs of controllers are left open, and whose outputs nobody takes.
    fn tell_open(&self, note: &mut dyn FnMut(&str)) {
        for fmu in self.fmus.iter().filter(|fmu| fmu.name != PLANT) {
            let ends = |row: &VariableRow, end: fn(&Connection) -> &Terminal| {
                let is_it = |t: &Terminal| t.participant == fmu.name && t.variable == row.name;
                self.connections
                    .iter()
                    .any(|connection| is_it(end(connection)))
            };
            let mut acts = false;
            for row in &fmu.rows {
                match row.causality {
                    "input" if !ends(row, |c| &c.target) => {
                        note(&format!("{}.{} is not connected", fmu.name, row.name));
                    }
                    "output" => acts |= ends(row, |c| &c.source),
                    _ => {}
                }
            }
            if !acts {
                note(&format!(
                    "no output of {} is connected: it acts on nothing",
                    fmu.name
                ));
            }
        }
    }

    /// The rider, where the plant is one of ours.
    fn in_the_saddle<'a>(
        &self,
        variation: &Variation,
    ) -> Result<Option<Box<dyn Participant + 'a>>> {
        Ok(match &self.bicycle {
            Some(bicycle) => Some(Box::new(self.rider(bicycle, variation)?)),
            None => None,
        })
    }

    /// The FMUs that take part.
    pub(super) fn present(&self, variation: &Variation) -> impl Iterator<Item = &Opened> {
        let without = variation.without.map(str::to_owned);
        let is_present = move |fmu: &&Opened| without.as_deref() != Some(fmu.name.as_str());
        self.fmus.iter().filter(is_present)
    }

    /// What an FMU starts with.
    pub(super) fn starts_of(&self, opened: &Opened, variation: &Variation) -> Vec<(String, Value)> {
        if let Some(bicycle) = self.bicycle.as_ref().filter(|_| opened.name == PLANT) {
            return self.plant_starts(bicycle, &opened.rows, variation);
        }
        let mut starts = opened.starts.clone();
        if variation.smooth {
            let is_step = |row: &&VariableRow| {
                let is_real = row.causality == "parameter" && row.type_name == "Real";
                is_real && row.name.ends_with("_resolution")
            };
            let steps = opened.rows.iter().filter(is_step);
            starts.extend(steps.map(|row| (row.name.clone(), Value::Real(0.0))));
        }
        starts
    }

    /// What a rider gives who does nothing but hold the start value of the plant's input `name`.
    pub(super) fn held(&self, name: &str) -> f64 {
        let input = self.bicycle.as_ref().map_or(Input::default(), |b| b.input);
        Input::index(name).map_or(0.0, |index| input.get(index))
    }

    /// The plan, without anything to record.
    pub(super) fn plan(&self) -> &Plan {
        &self.plan
    }

    /// After how long all that samples does so together again [s]: a common multiple of the steps
    /// that participants take and of those that their FMUs suggest. None below 1000 steps.
    pub(super) fn period(&self) -> Option<f64> {
        let own = |fmu: &Opened| [fmu.step, fmu.suggested];
        let steps: Vec<f64> = self.fmus.iter().flat_map(own).flatten().collect();
        let multiple = |n: &u32| {
            let time = f64::from(*n) * self.plan.step;
            let whole = |step: &f64| (time / step - (time / step).round()).abs() < 1e-6;
            steps.iter().all(whole)
        };
        let n = (1..1000).find(multiple)?;
        Some(f64::from(n) * self.plan.step)
    }

    fn rider(&self, bicycle: &Bicycle, variation: &Variation) -> Result<Rider> {
        let course = match &self.course {
            Some((layout, manner)) => {
                let parameters = variation.of(bicycle);
                let speed = bicycle.input.speed;
                let schedule = Schedule::at(&parameters, bicycle.formulation, *manner, speed)?;
                Some(Preview::new(layout.course(), schedule))
            }
            None => None,
        };
        Ok(Rider::new(
            bicycle.input,
            course,
            &bicycle.excitation,
            variation.seed,
            self.plan.stop_time,
        ))
    }

    fn plant_starts(
        &self,
        bicycle: &Bicycle,
        rows: &[VariableRow],
        variation: &Variation,
    ) -> Vec<(String, Value)> {
        let parameters = variation.of(bicycle);
        // one who follows a course takes the place of the law
        let parameters = if self.course.is_some() {
            parameters.riderless()
        } else {
            parameters
        };
        let input = if variation.smooth {
            Input {
                speed: bicycle.input.speed,
                ..Input::ZERO
            }
        } else {
            bicycle.input
        };
        plant::starts(rows, &parameters, &input, bicycle.formulation)
    }
}
