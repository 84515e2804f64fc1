//! What the assists are worth: the residual steering spectrum with and without them, paired over the
//! same remnants, as tables in their documentation.

use super::{Assist, DisturbanceObserver, RollAssist, started};
use crate::marked;
use bicycle::cases::{TABLE_2, TRAILS};
use bicycle::simulate::{Simulation, Stop};
use bicycle::{Formulation, Input, Parameters};
use fmi_export::model_description::{Causality, VariableType};
use identify::bicycles::{Bicycle, Changes};
use identify::compare::{BANDS, bands};
use identify::ride::Ride;
use identify::spectrum::Recipe;
use std::f64::consts::TAU;
use std::fmt::Write;

/// Both sides see each other so often [s]: 200 Hz, the assist's own sampling.
const STEP: f64 = 0.005;
/// Samples of a ride: 24 s.
const SAMPLES: usize = 4800;
/// Samples before it, in which an upright start is forgotten: 6 s.
const WARM_UP: usize = 1200;
/// Remnant of the rider: rms [N m] and corner [Hz] of its first-order noise.
const REMNANT: (f64, f64) = (1.2, 2.0);
/// Pairs of rides, each with a remnant of its own.
const SEEDS: u64 = 4;
/// The band that has to fall: the oscillation.
const OSCILLATION: usize = 1;
const LOADS: [f64; 4] = [0.0, 10.0, 20.0, 30.0];

#[derive(Clone, Copy)]
struct Case {
    bicycle: &'static str,
    trail: f64,
    load: f64,
    /// [km/h]
    speed: f64,
    formulation: Formulation,
    /// From Table 2's start instead of upright and straight.
    thrown: bool,
}

impl Case {
    /// Trails, then loads, with each of the paper's two bicycles, `repaired`, at 8 km/h.
    fn ridden() -> Vec<Self> {
        let mut cases = Vec::new();
        for bicycle in ["section3", "nominal"] {
            for trail in TRAILS {
                cases.extend(LOADS.map(|load| Self {
                    bicycle,
                    trail,
                    load,
                    speed: 8.0,
                    formulation: Formulation::Repaired,
                    thrown: false,
                }));
            }
        }
        cases
    }

    /// What was ridden besides: Table 2's start, higher speeds, the four-body bicycle.
    fn elsewhere() -> Vec<Self> {
        let with = |bicycle, trail, load| {
            let all = Self::ridden().into_iter();
            all.filter(move |case| (case.bicycle, case.trail, case.load) == (bicycle, trail, load))
        };
        let mut cases = Vec::new();
        for trail in TRAILS {
            for case in with("section3", trail, 0.0).chain(with("nominal", trail, 20.0)) {
                cases.push(Self {
                    thrown: true,
                    ..case
                });
            }
        }
        for trail in TRAILS {
            for case in with("nominal", trail, 20.0) {
                cases.extend([14.0, 18.0].map(|speed| Self { speed, ..case }));
            }
        }
        for trail in TRAILS {
            for case in with("nominal", trail, 20.0) {
                cases.push(Self {
                    formulation: Formulation::WhippleSlip,
                    ..case
                });
            }
        }
        cases
    }

    /// Whether the documentation claims that the assist lowers the oscillation: wherever the paper's
    /// bicycles stay up at 8 km/h.
    fn claimed(&self) -> bool {
        let falls = self.bicycle == "section3" && self.trail < 0.0;
        !falls && self.speed == 8.0 && self.formulation == Formulation::Repaired && !self.thrown
    }

    fn parameters(&self) -> Parameters {
        let bicycle = Bicycle::open(self.bicycle, &Changes::default()).expect("a named bicycle");
        let mut p = Parameters {
            trail: self.trail,
            rear_load: self.load,
            ..bicycle.parameters
        };
        if self.thrown {
            let [roll_rate, steer_rate, roll, steer, yaw_rate] = TABLE_2;
            p.roll_rate_start = roll_rate;
            p.steer_rate_start = steer_rate;
            p.roll_start = roll.to_radians();
            p.steer_start = steer.to_radians();
            p.yaw_rate_start = yaw_rate;
        }
        p
    }

    /// A ride, and the largest torque of the assist [N m]; or why it ended early. Both sides exchange
    /// at each step what they had at its beginning (Jacobi).
    fn ride<A: Assist>(&self, mut assist: Option<A>, seed: u64) -> Result<(Ride, f64), Stop> {
        let warm_up = if self.thrown { 0 } else { WARM_UP };
        let speed = self.speed / 3.6;
        let mut input = Input {
            speed,
            ..Input::ZERO
        };
        let mut simulation = Simulation::new(&self.parameters(), self.formulation, input, 0.0)
            .expect("a stable step");
        let mut steer = Vec::with_capacity(SAMPLES);
        let mut peak: f64 = 0.0;
        for (i, torque) in remnant(seed).take(warm_up + SAMPLES).enumerate() {
            let t = i as f64 * STEP;
            let x = *simulation.state();
            if i >= warm_up {
                steer.push(x.steer);
            }
            input.steer_torque = torque;
            if let Some(assist) = &mut assist {
                input.assist_torque = assist.torque();
                peak = peak.max(input.assist_torque.abs());
                assist.see(&x, speed);
                super::step(assist, t, STEP);
            }
            simulation.set_input(input).expect("the same speed");
            simulation.advance((i + 1) as f64 * STEP)?;
        }
        let mut ride = Ride::new(0.0, STEP, SAMPLES);
        ride.insert("steer", steer).expect("as many samples");
        Ok((ride, peak))
    }
}

/// First-order noise at the samples, held between them.
fn remnant(seed: u64) -> impl Iterator<Item = f64> {
    let (intensity, corner) = REMNANT;
    let keep = (-TAU * corner * STEP).exp();
    let renew = (1.0 - keep * keep).sqrt();
    let mut normal = normal(seed);
    let mut value = normal();
    std::iter::repeat_with(move || {
        value = keep * value + renew * normal();
        intensity * value
    })
}

/// Numbers of mean 0 and variance 1: SplitMix64, twelve of which make a normal one.
fn normal(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    let mut uniform = move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    move || (0..12).map(|_| uniform()).sum::<f64>() - 6.0
}

/// What became of a case over all seeds.
enum Outcome {
    /// Residual with over without, rms of all rides, in each of [`BANDS`]; the largest of them for
    /// one pair in the oscillation's; the largest torque [N m].
    Ridden {
        ratios: [f64; 3],
        worst: f64,
        peak: f64,
    },
    /// Mean time from the start to the end [s], without and with.
    Fallen { without: f64, with: f64 },
}

fn outcome<A: Assist>(case: &Case) -> Outcome {
    let (mut squares, mut worst, mut peak) = ([[0.0; 2]; 3], 0.0_f64, 0.0_f64);
    let mut falls = [0.0; 2];
    for seed in 1..=SEEDS {
        let without = case.ride::<A>(None, seed);
        let with = case.ride(Some(started::<A>()), seed);
        match (without, with) {
            (Ok((without, _)), Ok((with, torque))) => {
                let rows = bands(&[without, with], "steer", &Recipe::default()).expect("two rides");
                for (sums, pair) in squares.iter_mut().zip(rows.chunks(2)) {
                    for (sum, row) in sums.iter_mut().zip(pair) {
                        *sum += row.rms * row.rms;
                    }
                }
                worst = worst.max(rows[2 * OSCILLATION + 1].ratio);
                peak = peak.max(torque);
            }
            (Err(without), Err(with)) => {
                for (sum, stop) in falls.iter_mut().zip([without, with]) {
                    *sum += stop.time() / SEEDS as f64;
                }
            }
            (without, with) => {
                let [without, with] = [without.err(), with.err()];
                panic!("seed {seed}: without {without:?}, with {with:?}")
            }
        }
    }
    if falls[0] > 0.0 {
        let [without, with] = falls;
        return Outcome::Fallen { without, with };
    }
    let ratios = squares.map(|[without, with]| (with / without).sqrt());
    Outcome::Ridden {
        ratios,
        worst,
        peak,
    }
}

/// The rows of a table of HTML; claims are checked on the way.
fn table<A: Assist>(cases: &[Case], describe: impl Fn(&Case) -> String) -> String {
    let mut table = String::new();
    for case in cases {
        let what = describe(case);
        write!(table, "<tr><td>{what}</td>").expect("a string grows");
        match outcome::<A>(case) {
            Outcome::Ridden {
                ratios: [slow, oscillation, fast],
                worst,
                peak,
            } => {
                assert!(
                    !case.claimed() || worst < 1.0,
                    "{what}: claimed to fall, a ride has {worst}"
                );
                let claimed = if case.claimed() { "claimed" } else { "" };
                let class = if oscillation < 1.0 { "less" } else { "more" };
                write!(
                    table,
                    "<td>{slow:.2}</td><td class=\"{class}\">{oscillation:.2}</td>\
                     <td>{fast:.2}</td><td>{worst:.2}</td><td>{peak:.1}</td><td>{claimed}</td>"
                )
                .expect("a string grows");
            }
            Outcome::Fallen { without, with } => {
                assert!(!case.claimed(), "{what}: claimed to fall, the bicycle does");
                write!(
                    table,
                    "<td colspan=\"6\" class=\"more\">the bicycle falls after {without:.2} s, with \
                     the assist after {with:.2} s</td>"
                )
                .expect("a string grows");
            }
        }
        table += "</tr>\n";
    }
    table
}

/// What can be set and read, from the description.
fn variables<A: Assist>() -> String {
    let mut table = String::new();
    for variable in A::description().variables {
        let VariableType::Real(real) = &variable.variable_type else {
            continue;
        };
        if variable.causality == Causality::Independent {
            continue;
        }
        let start = real
            .start
            .map(|start| format!("{start:.4e}").parse::<f64>());
        let range = match (real.min, real.max) {
            (Some(min), Some(max)) => format!("{min} to {max}"),
            _ => String::new(),
        };
        writeln!(
            table,
            "<tr><td><code>{}</code></td><td>{}</td><td>{}</td><td>{range}</td><td>{}</td></tr>",
            variable.name,
            start.map_or(String::new(), |start| start.expect("a number").to_string()),
            real.unit.as_deref().unwrap_or("1"),
            variable.description.as_deref().unwrap_or_default(),
        )
        .expect("a string grows");
    }
    table
}

fn documented<A: Assist>(example: &str) {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../fmi-export/examples/");
    let file = format!("{folder}{example}/documentation/index.html");
    marked::assert_block(&file, "variables", &variables::<A>());
    let sign = |trail: f64| format!("{trail:.3}").replace('-', "−");
    let ridden = table::<A>(&Case::ridden(), |case| {
        format!(
            "<code>{}</code></td><td>{}</td><td>{}",
            case.bicycle,
            sign(case.trail),
            case.load
        )
    });
    marked::assert_block(&file, "ridden", &ridden);
    let elsewhere = table::<A>(&Case::elsewhere(), |case| {
        let start = if case.thrown {
            ", Table 2’s start"
        } else {
            ""
        };
        format!(
            "<code>{}</code>, {} m, {} kg, {} km/h, <code>{}</code>{start}",
            case.bicycle,
            sign(case.trail),
            case.load,
            case.speed,
            case.formulation.name()
        )
    });
    marked::assert_block(&file, "elsewhere", &elsewhere);
}

#[test]
fn the_disturbance_observer_is_worth_what_its_documentation_says() {
    documented::<DisturbanceObserver>("disturbance_observer");
}

#[test]
fn the_roll_assist_is_worth_what_its_documentation_says() {
    documented::<RollAssist>("roll_assist");
}

/// The bands of the tables' heads.
#[test]
fn the_tables_have_the_bands_of_the_program() {
    assert_eq!(BANDS, [(0.3, 0.8), (0.8, 1.6), (1.6, 3.0)]);
}
