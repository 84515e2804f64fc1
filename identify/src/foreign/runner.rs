//! The FMU at work, on a thread of its own: an instance can neither be shared between threads nor
//! sent to another, and one serves them all.

use super::described::{Counterpart, Described};
use crate::error::{Error, Result};
use bicycle::{Parameters, State, rider};
use fmi_import::{Error as Cause, Fmu, Instance, Step};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, mpsc};
use std::thread;

/// A ride of the FMU.
#[derive(Debug, Clone)]
pub(crate) struct Request {
    /// The bicycle: the rows that the FMU has are set.
    pub parameters: Parameters,
    /// Where it starts; none: where the FMU does.
    pub start: Option<State>,
    /// Torque besides the rider law [N m] at each sample; straight between them.
    pub torque: Vec<f64>,
    /// Speed [m/s] likewise.
    pub speed: Vec<f64>,
    /// Between samples [s].
    pub step: f64,
    /// How many are looked at.
    pub samples: usize,
}

/// What a ride shows: channel by channel [SI].
type Seen = Vec<Vec<f64>>;

/// Rides to be ridden, and where they go.
struct Order {
    channels: Vec<&'static str>,
    requests: Vec<Request>,
    ridden: mpsc::Sender<Vec<Result<Seen>>>,
}

/// The work an FMU has done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Spent {
    /// Instances that were made.
    pub instantiations: u64,
    /// Rides that were begun.
    pub rides: u64,
    /// Those of them that failed.
    pub failures: u64,
}

#[derive(Debug, Default)]
struct Counts {
    instantiations: AtomicU64,
    rides: AtomicU64,
    failures: AtomicU64,
}

/// The thread of an FMU.
pub(super) struct Runner {
    orders: mpsc::Sender<Order>,
    counts: Arc<Counts>,
}

impl Runner {
    /// A thread for `fmu`; it ends when nobody can give it orders any more.
    pub fn new(fmu: Fmu, described: Arc<Described>) -> Self {
        let (orders, incoming) = mpsc::channel::<Order>();
        let counts = Arc::new(Counts::default());
        let own = counts.clone();
        thread::spawn(move || {
            let mut at_work = AtWork {
                fmu: &fmu,
                described: &described,
                instance: None,
                counts: &own,
            };
            for order in incoming {
                let ride = |request: &Request| at_work.ride(&order.channels, request);
                let ridden = order.requests.iter().map(ride).collect();
                // whoever ordered may have gone
                let _ = order.ridden.send(ridden);
            }
        });
        Self { orders, counts }
    }

    /// Rides all of `requests`, one after the other.
    pub fn ride(&self, channels: &[&'static str], requests: Vec<Request>) -> Vec<Result<Seen>> {
        let count = requests.len();
        let (ridden, result) = mpsc::channel();
        let order = Order {
            channels: channels.to_vec(),
            requests,
            ridden,
        };
        let sent = self.orders.send(order).is_ok();
        let ridden = if sent { result.recv().ok() } else { None };
        let lost = || Err(Error::Search("the thread of the FMU has ended".into()));
        ridden.unwrap_or_else(|| (0..count).map(|_| lost()).collect())
    }

    /// The work so far.
    pub fn spent(&self) -> Spent {
        let of = |count: &AtomicU64| count.load(Ordering::Relaxed);
        Spent {
            instantiations: of(&self.counts.instantiations),
            rides: of(&self.counts.rides),
            failures: of(&self.counts.failures),
        }
    }
}

/// The FMU and its instance.
struct AtWork<'a> {
    fmu: &'a Fmu,
    described: &'a Described,
    instance: Option<Instance<'a>>,
    counts: &'a Counts,
}

impl<'a> AtWork<'a> {
    fn ride(&mut self, channels: &[&'static str], request: &Request) -> Result<Seen> {
        let one = |count: &AtomicU64| count.fetch_add(1, Ordering::Relaxed);
        one(&self.counts.rides);
        let ridden = self.fresh().and_then(|mut instance| {
            let ridden = ride(&mut instance, self.described, channels, request);
            self.instance = Some(instance);
            ridden
        });
        if ridden.is_err() {
            one(&self.counts.failures);
        }
        ridden
    }

    /// The instance as after instantiation; another where it cannot be brought back.
    fn fresh(&mut self) -> Result<Instance<'a>> {
        if let Some(mut used) = self.instance.take()
            && used.reset().is_ok()
        {
            return Ok(used);
        }
        self.counts.instantiations.fetch_add(1, Ordering::Relaxed);
        Ok(self.fmu.instantiate("model")?)
    }
}

/// One ride of a fresh instance.
fn ride(
    instance: &mut Instance,
    described: &Described,
    channels: &[&'static str],
    request: &Request,
) -> Result<Seen> {
    let pieces = described.pieces(request.step)?;
    let h = request.step / pieces as f64;
    let outputs = channels.iter().map(|channel| described.output(channel));
    let outputs = Outputs::new(outputs.collect::<Result<_>>()?);
    let law = described
        .rider
        .then(|| Law::new(described, &request.parameters))
        .transpose()?;
    let stop = request.samples.saturating_sub(1) as f64 * request.step;
    instance.setup_experiment(None, 0.0, Some(stop.max(h)))?;
    let at = |y: &[f64], sample: usize, part: f64| {
        let here = y[sample];
        here + part * (y.get(sample + 1).copied().unwrap_or(here) - here)
    };
    set(instance, described, request, false)?;
    instance.enter_initialization_mode()?;
    set(instance, described, request, true)?;
    instance.exit_initialization_mode()?;

    let inputs = [&described.torque, &described.speed];
    let inputs: Vec<&Counterpart> = inputs.into_iter().filter(|own| own.is_input).collect();
    let references: Vec<u32> = inputs.iter().map(|own| own.reference).collect();
    let mut seen = vec![Vec::with_capacity(request.samples); channels.len()];
    for sample in 0..request.samples {
        let time = sample as f64 * request.step;
        let values = outputs.read(instance)?;
        if values.iter().any(|value| !value.is_finite()) {
            return Err(failed(time, "an output is not finite".into()));
        }
        for (channel, value) in seen.iter_mut().zip(values) {
            channel.push(value);
        }
        if sample + 1 == request.samples {
            break;
        }
        for piece in 0..pieces {
            let middle = (piece as f64 + 0.5) / pieces as f64;
            let speed = at(&request.speed, sample, middle);
            let steered = match &law {
                Some(law) => law.torque(instance, speed)?,
                None => 0.0,
            };
            let torque = at(&request.torque, sample, middle) + steered;
            let values = [described.torque.own(torque), described.speed.own(speed)];
            instance.set_real(&references, &values[..references.len()])?;
            let point = (sample * pieces + piece) as f64 * h;
            match instance.do_step(point, h) {
                Ok(Step::Complete) => {}
                Ok(Step::Discarded { log, .. }) => {
                    let said = log.iter().map(ToString::to_string).collect::<Vec<_>>();
                    return Err(failed(point, said.join("; ")));
                }
                Err(cause @ Cause::Refused { .. }) => {
                    return Err(failed(point, cause.to_string()));
                }
                Err(cause) => return Err(cause.into()),
            }
        }
    }
    Ok(seen)
}

fn failed(time: f64, why: String) -> Error {
    Error::FailedStep { time, why }
}

/// Gives the instance what it starts with: its inputs, or all that is set before initialization.
fn set(
    instance: &mut Instance,
    described: &Described,
    request: &Request,
    inputs: bool,
) -> Result<()> {
    let first = |y: &[f64]| y.first().copied().unwrap_or(0.0);
    let parameters = described
        .parameters
        .iter()
        .map(|(row, own)| (own, request.parameters.get(*row)));
    let starts = described
        .starts
        .iter()
        .filter_map(|(row, own)| Some((own, request.start?.get(*row))));
    let outside = [
        (&described.torque, first(&request.torque)),
        (&described.speed, first(&request.speed)),
    ];
    let (references, values): (Vec<u32>, Vec<f64>) = parameters
        .chain(starts)
        .chain(outside)
        .filter(|(own, _)| own.is_input == inputs)
        .map(|(own, value)| (own.reference, own.own(value)))
        .unzip();
    instance.set_real(&references, &values)?;
    for (variable, value) in &described.set {
        let is_input = variable.causality == fmi_import::model_description::Causality::Input;
        if is_input == inputs {
            instance.set(variable, value)?;
        }
    }
    Ok(())
}

/// Variables that are read together.
struct Outputs<'a> {
    own: Vec<&'a Counterpart>,
    references: Vec<u32>,
}

impl<'a> Outputs<'a> {
    fn new(own: Vec<&'a Counterpart>) -> Self {
        let references = own.iter().map(|own| own.reference).collect();
        Self { own, references }
    }

    /// Their values [SI].
    fn read(&self, instance: &mut Instance) -> Result<Vec<f64>> {
        let mut values = vec![0.0; self.references.len()];
        instance.get_real(&self.references, &mut values)?;
        let si = self.own.iter().zip(values);
        Ok(si.map(|(own, value)| own.si(value)).collect())
    }
}

/// The rider law, closed on the FMU's outputs.
struct Law<'a> {
    parameters: &'a Parameters,
    outputs: Outputs<'a>,
}

impl<'a> Law<'a> {
    fn new(described: &'a Described, parameters: &'a Parameters) -> Result<Self> {
        let names = ["roll", "roll_rate", "steer", "steer_rate"];
        let outputs = names.map(|name| described.output(name));
        Ok(Self {
            parameters,
            outputs: Outputs::new(outputs.into_iter().collect::<Result<_>>()?),
        })
    }

    /// The torque that it wants now [N m].
    fn torque(&self, instance: &mut Instance, speed: f64) -> Result<f64> {
        let seen = self.outputs.read(instance)?;
        let state = State {
            roll: seen[0],
            roll_rate: seen[1],
            steer: seen[2],
            steer_rate: seen[3],
            ..State::ZERO
        };
        Ok(rider::torque(self.parameters, &state, speed))
    }
}
