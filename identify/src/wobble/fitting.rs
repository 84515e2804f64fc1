//! `wobble fit`: parameters of rides.

use crate::arguments::{
    BicycleArguments, RideArguments, SpectrumArguments, assignment, pair, quantity,
};
use crate::modelling::ModelArguments;
use crate::output::{Output, Progress};
use anyhow::Result;
use bicycle::Formulation;
use bicycle::quantity::S;
use clap::Args;
use identify::bicycles::Bicycle;
use identify::effort::Effort;
use identify::error::{Error, Result as Typed};
use identify::fit;
use identify::free::{Free, Prior, Scale, Scope, Tie, all};
use identify::model::Model;
use identify::objective::{Objective, free_response};
use identify::plan::{self, Change, Plan, Ridden};
use identify::ride::{Ride, quantity as channel_row};
use identify::run::{Recorded, Run, Source};
use identify::study::{Entry, Study};
use identify::{file, report};
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct Fit {
    /// Ride files, all of the same bicycle
    #[arg(required_unless_present = "study")]
    rides: Vec<PathBuf>,
    /// Rides with their bicycles and conditions, TOML
    #[arg(long, value_name = "FILE", conflicts_with_all = [
        "rides", "map", "rate", "resample", "times", "bicycle", "set", "load", "rider", "formulation"
    ])]
    study: Option<PathBuf>,
    #[command(flatten)]
    reading: RideArguments,
    /// The stretch of each ride to use, on its own clock
    #[arg(long, value_name = "START:STOP")]
    times: Option<String>,
    #[command(flatten)]
    bicycle: BicycleArguments,
    /// amplitude, whittle, time, free-response or frf; else by what was recorded
    #[arg(long, value_name = "NAME")]
    objective: Option<String>,
    /// Channels to look at, comma-separated; else by what was recorded
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    channels: Vec<String>,
    /// Free parameters, comma-separated, or all; they start at the bicycle's values
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    free: Vec<String>,
    /// Bounds of a free parameter
    #[arg(long, value_name = "NAME=LOW:HIGH")]
    bounds: Vec<String>,
    /// Parameters that are one and the same of all rides, comma-separated
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    shared: Vec<String>,
    /// Parameters of which each condition has its own
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    per_condition: Vec<String>,
    /// Parameters of which each ride has its own
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    per_ride: Vec<String>,
    /// Parameters sought on a logarithmic scale
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    log: Vec<String>,
    /// What was known before of a parameter; without numbers what the literature measured
    #[arg(long, value_name = "NAME[=MEAN:DEVIATION]")]
    prior: Vec<String>,
    /// Let a parameter keep its ratio to a free one
    #[arg(long, value_name = "FOLLOWER=LEADER")]
    tie: Vec<String>,
    /// Standard deviation of a channel's noise, else estimated above 10 Hz; for all channels or none
    #[arg(long, value_name = "CHANNEL=VALUE")]
    noise: Vec<String>,
    #[command(flatten)]
    spectrum: SpectrumArguments,
    /// Length of a window: of time, else 0.5s, of frf, else 10s
    #[arg(long, value_name = "TIME")]
    window: Option<String>,
    /// Windows of free-response, and of time in place of the whole ride: CSV with columns start,
    /// stop (s) or start_sample, stop_sample, and where there are several rides, file
    #[arg(long, value_name = "FILE", conflicts_with = "window")]
    windows: Option<PathBuf>,
    /// Most iterations of a search
    #[arg(long, default_value_t = 100)]
    max_iterations: u64,
    #[command(flatten)]
    model: ModelArguments,
    #[command(flatten)]
    effort: EffortArguments,
    /// Seed of whatever is random, the simulated ride in the report too: another than that of any
    /// ride to be fitted
    #[arg(long, default_value_t = 1000)]
    seed: u64,
    /// Report to write besides, HTML
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

/// What is asked of a fit besides one search.
#[derive(Args)]
pub struct EffortArguments {
    /// Search from so many Sobol points besides
    #[arg(long, value_name = "N", default_value_t = 0)]
    starts: usize,
    /// Search the whole box first, with so many evaluations of the cost
    #[arg(long, value_name = "N", default_value_t = 0)]
    population: u64,
    /// Profile every parameter
    #[arg(long)]
    profile: bool,
    /// Fit data made again so many times
    #[arg(long, value_name = "N", default_value_t = 0)]
    bootstrap: u64,
    /// Leave out, one by one, parameters that the data can do without
    #[arg(long)]
    reduce: bool,
    /// Write down what is finished of starts, population and bootstrap in FILE.starts and so on,
    /// and go on from there if it was written before
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,
}

impl EffortArguments {
    fn effort(&self, seed: u64) -> Typed<Effort> {
        if self.bootstrap == 1 {
            let form = Error::Form {
                expected: "2 fits or more, which can scatter",
                found: "1".into(),
            };
            return Err(form.typed("--bootstrap 1"));
        }
        Ok(Effort {
            starts: self.starts,
            population: self.population,
            profiles: self.profile,
            bootstrap: self.bootstrap,
            reduce: self.reduce,
            seed,
            resume: self.resume.clone(),
        })
    }
}

/// A ride as it was asked for: on whose bicycle, from where, under which condition.
struct Asked {
    ride: Ride,
    bicycle: Bicycle,
    source: Source,
    condition: String,
}

impl Fit {
    pub fn run(&self) -> Result<()> {
        let effort = self.effort.effort(self.seed)?;
        let model = self.model.open(self.seed)?;
        let asked = self.asked(&model)?;
        let outputs = [&self.output.out, &self.report];
        let outputs = outputs.into_iter().flatten().map(PathBuf::as_path);
        // a study names its rides itself
        file::check_apart(outputs, asked.iter().map(|a| Path::new(&a.source.file)))?;
        let mut plan = self.plan(&asked[0].bicycle, model)?;
        check_formulation(&asked)?;
        let rides: Vec<Ride> = asked.iter().map(|a| a.ride.clone()).collect();
        let mut ridden: Vec<_> = asked.iter().map(Asked::ridden).collect();
        if let Some(path) = &self.windows {
            for ridden in &mut ridden {
                ridden.windows = free_response::read(path, ridden.ride)?;
            }
        }
        if !self.noise.is_empty() {
            let channels = plan::resolve(&ridden, &plan)?.channels;
            plan.noise = Some(noise_of(&self.noise, &channels)?);
        }
        if self.bicycle.sets("speed") && rides.iter().any(|ride| ride.has("speed")) {
            eprintln!("note: the ride records its speed; --set speed has no say in this fit");
        }
        let origins = asked
            .iter()
            .map(|a| (a.source.clone(), a.bicycle.name.as_str()));
        let mut run = run(&ridden, &plan, &effort, origins.collect())?;
        let named = |path: &Option<PathBuf>| path.as_ref().map(|path| path.display().to_string());
        run.asked.study = named(&self.study);
        run.asked.windows = named(&self.windows);
        if let Some(path) = &self.report {
            file::write(path, report::html(&run, &rides)?)?;
        }
        eprint!("{}", report::summary(&run));
        if self.output.json || self.output.out.is_some() {
            self.output.text(&(run.to_json() + "\n"))?;
        }
        Ok(())
    }

    /// The rides named, or those of the study.
    fn asked(&self, model: &Model) -> Result<Vec<Asked>> {
        if let Some(path) = &self.study {
            let study = Study::read(path)?;
            let asked = study.rides.into_iter().map(|entry| {
                let condition = entry.labels.to_string();
                let Entry {
                    mut ride,
                    bicycle,
                    source,
                    ..
                } = entry;
                ride.law_in_loop.get_or_insert(bicycle.law_in_loop);
                Asked {
                    ride,
                    bicycle,
                    source,
                    condition,
                }
            });
            return Ok(asked.collect());
        }
        let bicycle = match model.foreign() {
            Some(fmu) => self.bicycle.of_fmu(fmu)?,
            None => Bicycle {
                // on record is what opens it again
                name: self.bicycle.name().to_owned(),
                ..self.bicycle.open()?
            },
        };
        let times = self
            .times
            .as_deref()
            .map(|text| pair("--times", text, S))
            .transpose()?;
        let one = |path: &PathBuf| {
            let mut ride = self.reading.read(path)?;
            if let Some((start, stop)) = times {
                let typed = |cause: Error| {
                    cause.typed(format!(
                        "--times {}",
                        self.times.as_deref().unwrap_or_default()
                    ))
                };
                ride = ride.slice(start..stop).map_err(typed)?;
            }
            ride.law_in_loop.get_or_insert(bicycle.law_in_loop);
            Ok(Asked {
                source: self.reading.source(&ride, times)?,
                ride,
                bicycle: bicycle.clone(),
                condition: String::new(),
            })
        };
        self.rides.iter().map(one).collect()
    }

    fn plan(&self, bicycle: &Bicycle, model: Model) -> Result<Plan> {
        let defaults = Plan::default();
        let mut excitation = bicycle.excitation;
        if excitation.remnant_intensity == 0.0 {
            excitation.remnant_intensity = defaults.excitation.remnant_intensity;
        }
        let objective = self.objective.as_deref().map(|name| {
            name.parse::<Objective>()
                .map_err(|cause| cause.typed(format!("--objective {name}")))
        });
        let channels = names("--channels", &self.channels, |name| {
            Ok(channel_row(name)?.name)
        })?;
        Ok(Plan {
            parameters: bicycle.parameters,
            formulation: bicycle.formulation,
            speed: bicycle.input.speed,
            excitation,
            objective: objective.transpose()?,
            channels,
            free: self.free(bicycle.formulation)?,
            changes: self.changes()?,
            ties: self.ties()?,
            recipe: self.spectrum.recipe()?,
            window: self
                .window
                .as_deref()
                .map(|text| quantity("--window", text, S))
                .transpose()?,
            noise: None,
            max_iterations: self.max_iterations,
            model,
        })
    }

    fn free(&self, formulation: Formulation) -> Typed<Option<Vec<Free>>> {
        let all: Vec<_> = all(formulation).into_iter().map(str::to_owned).collect();
        let asked = if self.free == ["all"] {
            &all[..]
        } else {
            &self.free[..]
        };
        let twice = asked
            .iter()
            .enumerate()
            .find(|(i, name)| asked[..*i].contains(name));
        if let Some((_, name)) = twice {
            let form = Error::Form {
                expected: "each name once",
                found: name.clone(),
            };
            return Err(form.typed(format!("--free {}", asked.join(","))));
        }
        names("--free", asked, Free::new)
    }

    /// What is changed of how the free parameters are sought, in the order in which it acts: a
    /// scale before the bounds on it, bounds before a prior within them.
    fn changes(&self) -> Typed<Vec<(&'static str, Change)>> {
        let mut changes = Vec::new();
        let row = |flag: &str, name: &str| {
            let free = Free::new(name).map_err(|cause| cause.typed(format!("{flag} {name}")))?;
            Ok::<_, Error>(free.row)
        };
        let plain = [
            ("--log", &self.log, Change::Scale(Scale::Logarithmic)),
            ("--shared", &self.shared, Change::Scope(Scope::Shared)),
            (
                "--per-condition",
                &self.per_condition,
                Change::Scope(Scope::Condition),
            ),
            ("--per-ride", &self.per_ride, Change::Scope(Scope::Ride)),
        ];
        let scopes = || plain.iter().skip(1);
        for (flag, names, _) in scopes() {
            let elsewhere = |name: &&String| {
                scopes().any(|(other, names, _)| other != flag && names.contains(name))
            };
            if let Some(name) = names.iter().find(elsewhere) {
                let form = Error::Form {
                    expected: "one of --shared, --per-condition and --per-ride for a parameter",
                    found: name.clone(),
                };
                return Err(form.typed(*flag));
            }
        }
        for (flag, names, change) in plain {
            for name in names {
                changes.push((row(flag, name)?.name, change));
            }
        }
        for text in &self.bounds {
            let (name, ends) = assignment("--bounds", text)?;
            let row = row("--bounds", name)?;
            let (lower, upper) = pair("--bounds", ends, row.unit)?;
            changes.push((row.name, Change::Bounds(lower, upper)));
        }
        for text in &self.prior {
            let (name, numbers) = match text.split_once('=') {
                Some((name, numbers)) => (name, Some(numbers)),
                None => (text.as_str(), None),
            };
            let row = row("--prior", name)?;
            let prior = |text| {
                let (mean, deviation) = pair("--prior", text, row.unit)?;
                Ok::<_, Error>(Prior { mean, deviation })
            };
            changes.push((row.name, Change::Prior(numbers.map(prior).transpose()?)));
        }
        Ok(changes)
    }

    fn ties(&self) -> Typed<Vec<Tie>> {
        let tie = |text: &String| {
            let (follower, leader) = assignment("--tie", text)?;
            Tie::new(follower, leader).map_err(|cause| cause.typed(format!("--tie {text}")))
        };
        self.tie.iter().map(tie).collect()
    }
}

/// The noise of each of `channels`: of all of them, or it is no use to a spectrum of several.
fn noise_of(given: &[String], channels: &[&'static str]) -> Typed<Vec<f64>> {
    let typed = |cause: Error| cause.typed(format!("--noise {}", given.join(" --noise ")));
    let form = |expected| {
        typed(Error::Form {
            expected,
            found: given.join(" "),
        })
    };
    let of = |channel: &&str| {
        let named = |text: &&String| text.split('=').next() == Some(channel);
        let text = given
            .iter()
            .find(named)
            .ok_or_else(|| form("the noise of every channel"))?;
        let (name, value) = assignment("--noise", text)?;
        let noise = quantity("--noise", value, channel_row(name)?.unit)?;
        if noise > 0.0 {
            Ok(noise)
        } else {
            Err(form("a standard deviation above 0"))
        }
    };
    channels.iter().map(of).collect()
}

/// `given` names turned into what they mean; none where none were given.
fn names<T>(
    flag: &str,
    given: &[String],
    mean: impl Fn(&str) -> Typed<T>,
) -> Typed<Option<Vec<T>>> {
    if given.is_empty() {
        return Ok(None);
    }
    let one = |name: &String| {
        mean(name).map_err(|cause| cause.typed(format!("{flag} {}", given.join(","))))
    };
    given.iter().map(one).collect::<Typed<Vec<T>>>().map(Some)
}

impl Asked {
    fn ridden(&self) -> Ridden<'_> {
        Ridden {
            ride: &self.ride,
            parameters: self.bicycle.parameters,
            speed: self.bicycle.input.speed,
            condition: self.condition.clone(),
            windows: Vec::new(),
        }
    }
}

/// Rides of one fit are read by the same equations.
fn check_formulation(asked: &[Asked]) -> Typed<()> {
    let first = asked[0].bicycle.formulation;
    let other = asked.iter().find(|a| a.bicycle.formulation != first);
    other.map_or(Ok(()), |other| {
        Err(Error::Form {
            expected: "one formulation for all rides",
            found: format!(
                "{} for {}, {} for {}",
                first.name(),
                asked[0].ride.name(),
                other.bicycle.formulation.name(),
                other.ride.name()
            ),
        })
    })
}

/// Fits rides and puts the fit on record; of each ride where it came from and the name of its
/// bicycle.
pub fn run(
    rides: &[Ridden],
    plan: &Plan,
    effort: &Effort,
    origins: Vec<(Source, &str)>,
) -> Result<Run> {
    let progress = Progress::new();
    let names: Vec<String> = rides.iter().map(|ridden| ridden.ride.name()).collect();
    let (problem, fit) = fit::fit(rides, plan, effort, &progress.watch()).map_err(|cause| {
        let said = cause.to_string();
        if names.iter().any(|name| said.contains(name)) {
            return cause.into();
        }
        let of = match names.len() {
            1 => names[0].clone(),
            n => format!("{n} rides"),
        };
        anyhow::Error::new(cause).context(format!("fit of {of}"))
    })?;
    let recorded = origins.into_iter().zip(rides);
    let recorded =
        recorded.map(|((source, bicycle), ridden)| Recorded::new(source, bicycle, ridden, plan));
    Ok(Run::new(recorded.collect(), plan, &problem, effort, fit))
}
