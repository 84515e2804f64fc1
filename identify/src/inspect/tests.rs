#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
use super::*;
use std::f64::consts::TAU;

/// A steer of 1 Hz and .1 rad at 100 Hz, 10 s, through `f`.
fn steer(f: impl Fn(usize, f64) -> f64) -> Vec<f64> {
    (0..1000)
        .map(|i| f(i, 0.1 * (TAU * i as f64 / 100.0).sin()))
        .collect()
}

fn findings(channel: &str, samples: Vec<f64>) -> Vec<String> {
    let mut ride = Ride::new(0.0, 0.01, samples.len());
    ride.insert(channel, samples).unwrap();
    inspect(&ride)
        .findings
        .iter()
        // the sine all these signals are made of
        .filter(|finding| !matches!(finding, Finding::Line { .. }))
        .map(Finding::to_string)
        .collect()
}

#[test]
fn a_clean_ride_has_its_line_and_the_right_numbers() {
    let mut ride = Ride::new(2.0, 0.01, 1000);
    ride.insert("steer", steer(|_, x| x + 0.02)).unwrap();
    let inspection = inspect(&ride);
    let [
        Finding::Line {
            channel: "steer",
            frequency,
            amplitude,
            ..
        },
    ] = inspection.findings[..]
    else {
        panic!("{:?}", inspection.findings);
    };
    assert_eq!(frequency, 1.0);
    // the moving average shrinks at the ends: its gain is not quite that within
    assert!((amplitude - 0.1).abs() < 0.02, "{amplitude}");
    assert_eq!(
        (inspection.samples, inspection.rate, inspection.start),
        (1000, 100.0, 2.0)
    );
    let Summary {
        name,
        unit,
        min,
        max,
        mean,
        rms,
    } = inspection.channels[0];
    assert_eq!((name, unit), ("steer", "rad"));
    // whole periods with a sample at each crest: sums to round-off
    for (value, expected) in [
        (min, -0.08),
        (max, 0.12),
        (mean, 0.02),
        (rms, 0.1 / 2.0_f64.sqrt()),
    ] {
        assert!((value - expected).abs() < 1e-12, "{value} {expected}");
    }
}

#[test]
fn a_glitch_is_found_at_either_end_and_within() {
    for (at, text) in [
        (0, "steer_rate: a glitch, -22 rad/s in 0 s"),
        (500, "steer_rate: a glitch, -22 rad/s in 5 s"),
        (999, "steer_rate: a glitch, -22 rad/s in 9.99 s"),
    ] {
        assert_eq!(
            findings("steer_rate", steer(|i, x| if i == at { -22.0 } else { x })),
            [text]
        );
    }
    let two = steer(|i, x| if [300, 600].contains(&i) { i as f64 } else { x });
    assert_eq!(
        findings("steer", two),
        ["steer: 2 glitches, the farthest 600 rad in 6 s"]
    );
}

#[test]
fn an_encoder_is_found_and_the_rounding_of_print_is_not() {
    let encoder = steer(|_, x| (x / 7.7e-4).round() * 7.7e-4);
    assert_eq!(
        findings("steer", encoder),
        ["steer: in steps of 7.700e-4 rad, which makes noise of 2.2e-4 rad rms"]
    );
    assert_eq!(
        findings("steer", steer(|_, x| (x * 1e5).round() / 1e5)),
        [""; 0]
    );
}

#[test]
fn clipping_is_found_on_either_side() {
    assert_eq!(
        findings("steer", steer(|_, x| x.clamp(-0.09, 0.2))),
        ["steer: stays at its extreme -0.09 rad in 0.68 to 0.82 s: clipped?"]
    );
    // an encoder dwells at its crest as well
    let encoder = steer(|_, x| (x / 0.01).round() * 0.01);
    assert_eq!(
        findings("steer", encoder),
        ["steer: in steps of 1.000e-2 rad, which makes noise of 2.9e-3 rad rms"]
    );
}

#[test]
fn silence_and_standstill_are_found() {
    assert_eq!(
        findings("steer_torque", vec![0.0; 9]),
        ["steer_torque: 0 N.m throughout"]
    );
    let speed: Vec<f64> = (0..1000).map(|i| f64::from(i / 10 % 20)).collect();
    let found = findings("speed", speed);
    assert_eq!(
        found[0],
        "speed: standstill in 0 to 0.09 s; 2 to 2.09 s; 4 to 4.09 s; and 2 more"
    );
}

#[test]
fn it_becomes_json() {
    let mut ride = Ride::new(0.0, 0.01, 4);
    ride.insert("steer", vec![0.0; 4]).unwrap();
    let json = serde_json::to_value(inspect(&ride)).unwrap();
    assert_eq!(json["channels"][0]["name"], "steer");
    assert_eq!(json["findings"][0]["kind"], "constant");
    assert_eq!(json["law_in_loop"], serde_json::Value::Null);
}

#[test]
fn dropouts_are_found_in_one_channel_and_in_all() {
    assert_eq!(
        findings(
            "steer",
            steer(|i, x| if (300..=305).contains(&i) { 0.5 } else { x })
        ),
        ["steer: a dropout in 3 to 3.05 s"]
    );
    // held, then back: the last value for a quarter of a second from a zero crossing
    let hold = |i: usize, x: f64| if (400..425).contains(&i) { 0.0 } else { x };
    assert_eq!(
        findings("steer", steer(hold)),
        ["steer: a dropout in 4 to 4.24 s"]
    );
    let mut ride = Ride::new(0.0, 0.01, 1000);
    let frozen = |x: Vec<f64>| {
        (0..1000)
            .map(|i| x[if (70..76).contains(&i) { 70 } else { i }])
            .collect()
    };
    for name in ["steer", "roll_rate"] {
        ride.insert(name, frozen(steer(|_, x| x))).unwrap();
    }
    let found: Vec<String> = inspect(&ride)
        .findings
        .iter()
        .map(Finding::to_string)
        .collect();
    assert_eq!(found[0], "steer, roll_rate: a dropout in 0.7 to 0.75 s");
}

#[test]
fn a_mean_that_wanders_is_a_drift() {
    let mut ride = Ride::new(0.0, 0.01, 1000);
    let samples = steer(|i, x| x + 2e-4 * i as f64);
    ride.insert("roll_rate", samples).unwrap();
    let all = inspect(&ride).findings;
    let change = all.iter().find_map(|finding| match finding {
        Finding::Drift { change, .. } => Some(*change),
        _ => None,
    });
    // .2 rad/s; the eighths of the ride hold no whole periods of the sine
    assert!((change.unwrap() - 0.2).abs() < 0.03, "{all:?}");
    // heading may
    assert_eq!(
        findings("heading", steer(|i, x| x + 2e-4 * i as f64)),
        [""; 0]
    );
}

#[test]
fn a_line_is_read_as_pedalling_or_as_a_slalom() {
    let mut ride = Ride::new(0.0, 0.01, 2000);
    // an irregular signal below a sine of 1.1 Hz
    let noise = |i: usize| 0.002 * ((i * i * 7919) as f64 % 1000.0 / 500.0 - 1.0);
    let sine = |i: usize| 0.1 * (TAU * 1.1 * i as f64 / 100.0).sin();
    ride.insert("steer", (0..2000).map(|i| noise(i) + sine(i)).collect())
        .unwrap();
    ride.insert("speed", vec![2.2; 2000]).unwrap();
    let found: Vec<String> = inspect(&ride)
        .findings
        .iter()
        .map(Finding::to_string)
        .collect();
    let line = found.last().unwrap();
    assert!(
        line.starts_with("steer: a line at 1.100 Hz, a sine of 5."),
        "{line}"
    );
    assert!(
        line.ends_with("pedalling at 66 rpm, or a slalom about cones 1.00 m apart"),
        "{line}"
    );
}

#[test]
fn degrees_under_the_name_of_radians_and_a_speed_of_the_wrong_sign_are_found() {
    let found = findings("steer", steer(|_, x| 30.0 * x));
    assert_eq!(
        found,
        [
            "steer: 2.121 rad rms, where a ridden bicycle stays below 0.7 rad: degrees under another \
          name?"
        ]
    );
    let found = findings("speed", vec![-2.2; 1000]);
    assert_eq!(
        found,
        [
            "speed: down to -2.200 m/s, backwards: is the sign of the column right?",
            "speed: -2.2 m/s throughout"
        ]
    );
}
