//! `wobble cases`: the study of the paper's section 3, and the same with loads on the carrier.

use crate::arguments::{BicycleArguments, values};
use crate::output::Output;
use anyhow::{Context, Result};
use bicycle::cases::{self, Case, Course, Oscillation, Rearward};
use clap::Args;
use identify::bicycles::Bicycle;
use identify::error::Error;
use identify::{figure, file};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::PathBuf;

#[derive(Args)]
pub struct Cases {
    #[command(flatten)]
    bicycle: BicycleArguments,
    /// Loads on the carrier instead of shifted centres of mass, e.g. 0,10,20,30
    #[arg(
        long,
        value_name = "MASSES",
        value_delimiter = ',',
        conflicts_with = "load",
        allow_hyphen_values = true
    )]
    loads: Option<Vec<String>>,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
    /// Figure to write besides, SVG
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// A row of the figure every 5 ms.
const INTERVAL: f64 = 0.005;

/// The cases `of` a bicycle, one after the other.
pub fn courses(bicycle: &Bicycle, of: &[Case]) -> Result<Vec<Course>> {
    let run = |case: &Case| {
        let ran = case.run(
            &bicycle.parameters,
            bicycle.formulation,
            bicycle.input,
            INTERVAL,
        );
        ran.with_context(|| format!("case {}", case.number))
    };
    of.iter().map(run).collect()
}

impl Cases {
    pub fn run(&self) -> Result<()> {
        let of = match &self.loads {
            Some(loads) => cases::loaded(&values("--loads", loads, "rear_load")?),
            None => cases::all().to_vec(),
        };
        if let Some(path) = self
            .out
            .as_deref()
            .filter(|p| p.extension() != Some("svg".as_ref()))
        {
            let found = path.display().to_string();
            let expected = "a file .svg";
            let form = Error::Form {
                expected,
                found: found.clone(),
            };
            return Err(form.typed(format!("--out {found}")).into());
        }
        let bicycle = self.bicycle.open()?;
        for case in &of {
            check(&bicycle, *case)?;
        }
        let courses = courses(&bicycle, &of)?;
        if let Some(path) = &self.out {
            file::write(path, figure::cases(&courses))?;
        }
        let found: Vec<Found> = courses
            .iter()
            .map(|course| Found::of(course, &bicycle))
            .collect();
        let output = Output {
            json: self.json,
            out: None,
        };
        let rows: Vec<Value> = found.iter().map(Found::json).collect();
        let formulation = bicycle.formulation.name();
        output.json_or(
            &json!({ "bicycle": bicycle.name, "formulation": formulation, "cases": rows }),
            || table(&found),
        )
    }
}

/// Says what is odd about the loaded bicycle of a case, and refuses one that cannot be ridden.
fn check(bicycle: &Bicycle, case: Case) -> Result<()> {
    let mut loaded = Bicycle {
        parameters: case.parameters(&bicycle.parameters),
        notes: Vec::new(),
        ..bicycle.clone()
    };
    loaded
        .check()
        .with_context(|| format!("case {}", case.number))?;
    for note in loaded.notes {
        eprintln!("note: case {}: {note}", case.number);
    }
    Ok(())
}

/// What a case gave: its course, and the linear bicycle behind it.
struct Found<'a> {
    course: &'a Course,
    /// With the rider law in the loop.
    ridden: Option<Oscillation>,
    /// Without.
    riderless: Option<Oscillation>,
}

impl<'a> Found<'a> {
    fn of(course: &'a Course, bicycle: &Bicycle) -> Self {
        let p = course.case.parameters(&bicycle.parameters);
        let least_damped =
            |p| Oscillation::least_damped(p, bicycle.formulation, bicycle.input.speed);
        Self {
            course,
            ridden: least_damped(&p),
            riderless: least_damped(&p.riderless()),
        }
    }

    fn json(&self) -> Value {
        let course = self.course;
        let (what, value) = rearward(course.case);
        let mode = |mode: Option<Oscillation>| {
            mode.map(|m| {
                json!({
                    "mode": m.mode.name(), "frequency": m.frequency,
                    "damping_ratio": m.damping_ratio,
                })
            })
        };
        json!({
            "case": course.case.number,
            "trail": course.case.trail,
            what: value,
            "end_time": course.end_time(),
            "stop": course.stop.map_or("end", |stop| stop.name()),
            "amplitude_deg": course.amplitude().map(f64::to_degrees),
            "dominant_frequency": course.dominant_frequency(),
            "early_reversals": course.early_reversals(),
            "least_damped": mode(self.ridden),
            "least_damped_riderless": mode(self.riderless),
        })
    }
}

/// The row that changes from case to case, and its value [SI].
fn rearward(case: Case) -> (&'static str, f64) {
    match case.rearward {
        Rearward::CogToRear(x) => ("cog_to_rear", x),
        Rearward::RearLoad(mass) => ("rear_load", mass),
    }
}

fn table(found: &[Found]) -> String {
    let loads = found
        .iter()
        .any(|f| matches!(f.course.case.rearward, Rearward::RearLoad(_)));
    let what = if loads { "load [kg]" } else { "cog [m]" };
    let mut text = format!(
        "case  trail [m]  {what:>9}  ends [s]  why          amplitude [deg]  swings [Hz]  \
         reversals  least damped [Hz]  damping  riderless [Hz]   damping\n"
    );
    let number = |value: Option<f64>| value.map_or_else(|| "–".into(), |v| format!("{v:.3}"));
    for Found {
        course,
        ridden,
        riderless,
    } in found
    {
        let (_, value) = rearward(course.case);
        let frequency = |mode: &Option<Oscillation>| {
            mode.map_or_else(
                || "–".into(),
                |m| format!("{} {:.3}", m.mode.name(), m.frequency),
            )
        };
        let damping = |mode: &Option<Oscillation>| number(mode.map(|m| m.damping_ratio));
        let _ = writeln!(
            text,
            "{:4}  {:9.3}  {value:9.2}  {:8.3}  {:11}  {:>15}  {:>11}  {:9}  {:>17}  {:>7}  {:>14}  {:>8}",
            course.case.number,
            course.case.trail,
            course.end_time(),
            course.stop.map_or("end", |stop| stop.name()),
            number(course.amplitude().map(f64::to_degrees)),
            number(course.dominant_frequency()),
            course.early_reversals(),
            frequency(ridden),
            damping(ridden),
            frequency(riderless),
            damping(riderless),
        );
    }
    text + "swings: dominant frequency after 1 s; reversals: in the first second; least damped: \
            of the oscillating modes\nupright with the rider law in the loop, Coulomb friction left \
            out; riderless: without the law\n"
}
