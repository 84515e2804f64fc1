//! Whether a rider gets round the courses.

use crate::published;
use bicycle::course::{Circle, Course, Layout, Slalom, Straight};
use bicycle::rider::{Followed, Manner, Preview, Sample, Schedule, follow};
use bicycle::simulate::{Simulation, Stop};
use bicycle::{Formulation, Input, Output, Parameters};

/// The paper's speed [m/s].
const SPEED: f64 = 8.0 / 3.6;

/// The formulations that keep to mechanics, as far as they go.
const RIDDEN: [Formulation; 3] = [
    Formulation::Repaired,
    Formulation::Whipple,
    Formulation::WhippleSlip,
];

/// Each of them with the nominal and the benchmark bicycle, without a load and with 20 kg.
fn all_ridden() -> impl Iterator<Item = (Formulation, Parameters)> {
    let bicycles = [Parameters::default(), published::benchmark_bicycle()];
    RIDDEN.into_iter().flat_map(move |formulation| {
        bicycles.into_iter().flat_map(move |bicycle| {
            [0.0, 20.0].map(|rear_load| {
                let loaded = Parameters {
                    rear_load,
                    ..bicycle
                };
                (formulation, loaded)
            })
        })
    })
}

fn loaded(rear_load: f64) -> Parameters {
    Parameters {
        rear_load,
        ..Parameters::default()
    }
}

fn rider(
    parameters: &Parameters,
    formulation: Formulation,
    course: Course,
    manner: Manner,
) -> Preview {
    let schedule = Schedule::at(parameters, formulation, manner, SPEED);
    Preview::new(course, schedule.expect("rideable"))
}

fn ridden(parameters: &Parameters, formulation: Formulation, course: Course) -> Followed {
    let rider = rider(parameters, formulation, course, Manner::default());
    follow(parameters, formulation, Input::default(), rider).expect("steps small enough")
}

fn largest(ride: &Followed, of: impl Fn(&Sample) -> f64) -> f64 {
    ride.samples.iter().map(|s| of(s).abs()).fold(0.0, f64::max)
}

/// Largest offset [m] and steer torque [N m] of a ride over each layout, whatever the formulation,
/// bicycle and load: a few per cent above what the rides show, so that a rider who follows worse or
/// works harder fails.
///
/// Straight, thrown off at the start: centimetres out before it is caught. Slalom: a third of its
/// swing, phase mostly. Lane change: next to nothing. Circle: the tangent of the steer angle, which
/// the linear design does not know.
const HELD: [(&str, f64, f64); 4] = [
    ("straight", 0.075, 65.0),
    ("slalom", 0.016, 9.0),
    ("lane-change", 0.001, 1.8),
    ("circle", 0.008, 4.5),
];

#[test]
fn the_rider_follows_every_course_with_and_without_a_load() {
    for (formulation, p) in all_ridden() {
        for (layout, (name, offset, torque)) in Layout::all().into_iter().zip(HELD) {
            assert_eq!(layout.name(), name);
            let mut p = p;
            if name == "straight" {
                p.roll_start = 0.03;
                p.steer_start = -0.02;
                p.yaw_rate_start = 0.1;
            }
            let ride = ridden(&p, formulation, layout.course());
            let what = format!("{name}, {formulation:?} with {} kg", p.rear_load);
            assert_eq!(ride.stop, None, "{what}");
            let last = ride.samples.last().expect("a sample");
            assert!(last.place.arc_length >= layout.course().length());
            let out = largest(&ride, |s| s.place.offset);
            let by = largest(&ride, |s| s.torque);
            assert!(out < offset, "{what}: {out} m");
            assert!(by < torque, "{what}: {by} N m");
            if name == "straight" {
                assert!(out > 0.01, "thrown off to begin with: {out}");
                // dry friction lets the steering hunt within a millimetre
                assert!(last.place.offset.abs() < 1e-3, "{:?}", last.place);
            }
        }
    }
}

/// Ten to 113 kg, wheelbases of .99 to 1.12 m, trails of 4 to 19 cm: one procedure for all.
#[test]
fn measured_bicycles_are_ridden_round_the_cones_and_the_circle() {
    let bicycles = published::measured();
    assert_eq!(bicycles.len(), 9);
    for (name, bicycle) in bicycles {
        for formulation in [Formulation::Whipple, Formulation::WhippleSlip] {
            for rear_load in [0.0, 20.0] {
                let p = Parameters {
                    rear_load,
                    ..bicycle
                };
                let slalom = Slalom {
                    wheelbase: p.wheelbase,
                    ..Slalom::default()
                };
                for course in [slalom.course(), Circle::default().course()] {
                    let length = course.length();
                    let ride = ridden(&p, formulation, course);
                    let what = format!("{name}, {formulation:?} with {rear_load} kg");
                    assert_eq!(ride.stop, None, "{what}");
                    let last = ride.samples.last().expect("a sample");
                    assert!(last.place.arc_length >= length, "{what}");
                    // half of the slalom's swing
                    let out = largest(&ride, |s| s.place.offset);
                    assert!(out < 0.02, "{what}: {out} m");
                }
            }
        }
    }
}

/// Where the point `ahead` [m] of the rear contact on the bicycle's axis passes `x` [m].
fn passes(ride: &Followed, x: f64, ahead: f64) -> f64 {
    let point = |s: &Sample| {
        let (sin, cos) = s.output.heading.sin_cos();
        (s.output.x + ahead * cos, s.output.y + ahead * sin)
    };
    let pair = ride
        .samples
        .windows(2)
        .map(|w| (point(&w[0]), point(&w[1])))
        .find(|(a, b)| a.0 <= x && x < b.0)
        .expect("the bicycle gets there");
    let ((x0, y0), (x1, y1)) = pair;
    y0 + (x - x0) / (x1 - x0) * (y1 - y0)
}

#[test]
fn both_wheels_pass_every_cone_on_its_side() {
    // the paper's cones: the wheels' tracks swing by centimetres, and stay on their sides by half
    // of one; cones between which a bicycle has room: by nearly the amplitude
    let wide = Slalom {
        cone_spacing: 2.5,
        amplitude: 0.3,
        ..Slalom::default()
    };
    for (slalom, cones, clear) in [(Slalom::default(), 17, 0.005), (wide, 7, 0.27)] {
        assert_eq!(slalom.course().cones().len(), cones);
        for (formulation, p) in all_ridden() {
            let ride = ridden(&p, formulation, slalom.course());
            for cone in slalom.course().cones() {
                for wheel in [0.0, p.wheelbase] {
                    let by = cone.side * (passes(&ride, cone.x, wheel) - cone.y);
                    assert!(
                        by > clear,
                        "{formulation:?}, {cone:?}, wheel at {wheel} m: {by} m"
                    );
                }
            }
        }
    }
}

#[test]
fn a_mirrored_course_is_ridden_in_the_mirror() {
    for formulation in RIDDEN {
        for layout in Layout::all() {
            let p = loaded(20.0);
            let ride = ridden(&p, formulation, layout.course());
            let mirrored = ridden(&p, formulation, layout.course().mirrored());
            assert_eq!(ride.samples.len(), mirrored.samples.len());
            for (a, b) in ride.samples.iter().zip(&mirrored.samples) {
                assert_eq!((a.output.x, a.output.y), (b.output.x, -b.output.y));
                assert_eq!(a.output.roll, -b.output.roll);
                assert_eq!((a.torque, a.place.offset), (-b.torque, -b.place.offset));
            }
        }
    }
}

#[test]
fn a_rider_outside_of_the_stepper_rides_the_same() {
    let p = Parameters::default();
    let formulation = Formulation::WhippleSlip;
    let course = Circle::default().course();
    let ride = ridden(&p, formulation, course.clone());
    let mut rider = rider(&p, formulation, course, Manner::default());
    let input = Input::default();
    let mut bicycle = Simulation::new(&p.riderless(), formulation, input, 0.0).expect("nominal");
    // asked every millisecond, the rider looks every five
    for n in 0..2000_u32 {
        let time = f64::from(n) * 1e-3;
        bicycle.advance(time).expect("upright");
        let seen = bicycle.output();
        let steer_torque = rider.torque(time, &seen);
        let sample = &ride.samples[n as usize / 5];
        assert_eq!(steer_torque, sample.torque, "at {time} s");
        if n % 5 == 0 {
            assert_eq!(seen, sample.output);
        }
        let input = Input {
            steer_torque,
            ..input
        };
        bicycle.set_input(input).expect("the same speed");
    }
    let lost = Output {
        x: f64::NAN,
        ..bicycle.output()
    };
    assert_eq!(rider.torque(3.0, &lost), ride.samples[399].torque);
}

#[test]
fn a_scheduled_rider_keeps_up_with_a_changing_speed() {
    let p = loaded(20.0);
    let slowest = 1.5;
    let schedule = Schedule::over(&p, Formulation::Repaired, Manner::default(), slowest, 5.0);
    let mut rider = Preview::new(
        Slalom {
            cone_spacing: 6.0,
            amplitude: 0.3,
            length: 100.0,
            ..Slalom::default()
        }
        .course(),
        schedule.expect("rideable"),
    );
    let mut input = Input {
        speed: slowest,
        ..Input::default()
    };
    let mut bicycle =
        Simulation::new(&p.riderless(), Formulation::Repaired, input, 0.0).expect("nominal");
    let mut n = 0_u32;
    while rider.place().arc_length < rider.course().length() {
        let time = f64::from(n) * 5e-3;
        bicycle.advance(time).expect("upright");
        input.steer_torque = rider.torque(time, &bicycle.output());
        // from the slowest to the fastest speed in 14 s
        input.speed = (slowest + 0.25 * time).min(5.0);
        bicycle
            .set_input(input)
            .expect("speeds that can be stepped");
        // at 5 m/s cones 6 m apart swing the bicycle at 0.42 Hz; a twentieth of the swing is lost
        assert!(
            rider.place().offset.abs() < 0.02,
            "{:?} at {time} s",
            rider.place()
        );
        n += 1;
    }
    assert_eq!(input.speed, 5.0);
}

#[test]
fn a_weak_rider_falls() {
    let p = Parameters::default();
    let formulation = Formulation::Repaired;
    let weak = Manner {
        torque_limit: 1.0,
        ..Manner::default()
    };
    let course = Circle::default().course();
    let rider = rider(&p, formulation, course.clone(), weak);
    let ride = follow(&p, formulation, Input::default(), rider).expect("nominal");
    assert!(ride.stop.is_some());
    assert_eq!(largest(&ride, |s| s.torque), 1.0);
    let ride = ridden(&p, formulation, course);
    assert!(largest(&ride, |s| s.torque) > 1.0);
}

#[test]
fn a_fall_at_walking_pace_is_said() {
    let f = Formulation::Repaired;
    // at a tenth of a metre a second the lean outruns the steering: a design, and a fall
    let slow = Input {
        speed: 0.1,
        ..Input::default()
    };
    let tipped = Parameters {
        roll_start: 0.02,
        ..loaded(20.0)
    };
    let schedule = Schedule::at(&tipped, f, Manner::default(), slow.speed).expect("a design");
    let rider = Preview::new(Straight::default().course(), schedule);
    let ride = follow(&tipped, f, slow, rider).expect("steps small enough");
    assert!(
        matches!(ride.stop, Some(Stop::SteerLimit { t }) if t < 1.0),
        "{:?}",
        ride.stop
    );
}

#[test]
fn a_rider_who_reacts_late_still_gets_round() {
    // the linear bicycle is as its rider predicts it, friction apart. The paper's has a jump in its
    // trail, r_f sin φ sign θ, half the trail itself on this circle, which the prediction does not
    // know: 0.1 s late its rider falls there
    for (formulation, reaction_delay) in RIDDEN.into_iter().zip([0.05, 0.2, 0.2]) {
        let p = loaded(20.0);
        let late = Manner {
            reaction_delay,
            ..Manner::default()
        };
        for layout in Layout::all() {
            let rider = rider(&p, formulation, layout.course(), late);
            let ride = follow(&p, formulation, Input::default(), rider).expect("nominal");
            assert_eq!(ride.stop, None, "{}, {formulation:?}", layout.name());
            // hardly more than the prompt rider's on the slalom
            let out = largest(&ride, |s| s.place.offset);
            assert!(out < 0.016, "{}, {formulation:?}: {out} m", layout.name());
            // nothing acts before the delay is over
            let samples = (reaction_delay / 0.005) as usize;
            assert!(ride.samples[..samples].iter().all(|s| s.torque == 0.0));
        }
    }
}

#[test]
fn exact_jumps_are_ridden_as_well_as_smoothed_ones() {
    for formulation in RIDDEN {
        let p = Parameters {
            steer_smoothing: 0.0,
            steer_rate_smoothing: 0.0,
            ..loaded(20.0)
        };
        for (layout, (name, offset, _)) in Layout::all().into_iter().zip(HELD) {
            let ride = ridden(&p, formulation, layout.course());
            assert_eq!(ride.stop, None, "{name}, {formulation:?}");
            let out = largest(&ride, |s| s.place.offset);
            assert!(out < offset, "{name}, {formulation:?}: {out} m");
        }
    }
}
