//! A course in place of the rider law: `wobble simulate --course`.

use crate::model::outputs;
use crate::output::{Output, Progress};
use anyhow::Result;
use bicycle::Input;
use bicycle::course::{LATERAL_OFFSET, Layout};
use bicycle::rider::{Followed, Preview, Sample, Schedule, follow};
use clap::Args;
use clap::builder::PossibleValuesParser;
use identify::bicycles::Bicycle;
use identify::course;
use identify::trajectory::Trajectory;
use serde_json::json;
use std::fmt::Write as _;

/// Looks of a rider at most: hours of riding.
const MOST_LOOKS: f64 = 5e6;

/// Which course, and how it is ridden.
#[derive(Args)]
pub struct CourseArguments {
    /// Follow a course in place of the rider law
    #[arg(
        long,
        value_name = "NAME",
        value_parser = PossibleValuesParser::new(Layout::all().map(|layout| layout.name())),
        conflicts_with_all = ["fmu", "ride", "at", "duration", "step"]
    )]
    course: Option<String>,
    /// Set a row of the course, e.g. cone_spacing=2.5m or radius=5m, or of the rider's manner, e.g.
    /// offset_scale=5cm
    #[arg(long, value_name = "NAME=VALUE", requires = "course")]
    course_set: Vec<String>,
}

impl CourseArguments {
    /// The name behind `--course`.
    pub fn name(&self) -> Option<&str> {
        self.course.as_deref()
    }

    /// Rides the course called `name` and writes what was seen, with steer torque and offset.
    pub fn run(&self, name: &str, bicycle: &Bicycle, output: &Output) -> Result<()> {
        let wheelbase = bicycle.parameters.wheelbase;
        let (layout, manner) = course::plan(name, &self.course_set, wheelbase)?;
        let progress = Progress::new();
        progress.say("riding");
        let Bicycle {
            parameters,
            formulation,
            input,
            ..
        } = bicycle;
        let sample_time = manner.sample_time;
        let schedule = Schedule::at(parameters, *formulation, manner, input.speed)?;
        let course = layout.course();
        let length = course.length();
        let looks = 2.0 * length / (input.speed * sample_time);
        if looks > MOST_LOOKS {
            let expected = 2.0 * length / (MOST_LOOKS * sample_time);
            let speed = input.speed;
            anyhow::bail!(
                "speed: expected at least {expected:.1e} m/s on a course of {length:.1} m, found {speed} m/s"
            );
        }
        let ridden = follow(
            parameters,
            *formulation,
            *input,
            Preview::new(course, schedule),
        )?;
        drop(progress);
        tell(&ridden, length);
        write(&layout, &ridden, input, output)
    }
}

/// Says how the ride went.
fn tell(ridden: &Followed, length: f64) {
    let offset = |s: &Sample| s.place.offset.abs();
    let largest = ridden.samples.iter().map(offset).fold(0.0, f64::max);
    eprintln!("note: largest lateral offset from the course {largest:.3} m");
    if let Some(stop) = ridden.stop {
        eprintln!("note: {stop}");
    } else if let Some(last) = ridden.samples.last()
        && last.place.arc_length < length
    {
        eprintln!(
            "note: after {} s the bicycle had come {:.2} m of {length:.2} m",
            last.time, last.place.arc_length
        );
    }
}

fn write(layout: &Layout, ridden: &Followed, input: &Input, output: &Output) -> Result<()> {
    let column = |of: fn(&Sample) -> f64| ridden.samples.iter().map(of).collect::<Vec<f64>>();
    let steer_torque: Vec<_> = column(|s| s.torque)
        .into_iter()
        .map(|torque| torque + input.steer_torque)
        .collect();
    let offset = column(|s| s.place.offset);
    let trajectory = Trajectory {
        time: column(|s| s.time),
        output: ridden.samples.iter().map(|s| s.output).collect(),
        stop: ridden.stop,
    };
    let json = json!({
        "course": layout.name(),
        "stop": trajectory.stop.map_or("end", |stop| stop.name()),
        "time": trajectory.time,
        "outputs": outputs(&trajectory),
        "steer_torque": steer_torque,
        "lateral_offset": offset,
    });
    output.json_or(&json, || {
        let csv = trajectory.to_csv();
        let mut lines = csv.lines();
        let header = lines.next().unwrap_or_default();
        let mut text = format!("{header},steer_torque[N.m],{}[m]\n", LATERAL_OFFSET.name);
        for ((line, torque), offset) in lines.zip(&steer_torque).zip(&offset) {
            writeln!(text, "{line},{torque},{offset}").expect("a string takes all");
        }
        text
    })
}
