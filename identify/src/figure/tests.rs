#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
use super::*;
use bicycle::cases::Case;

/// Panics unless every tag of `markup` is closed, in the right order.
pub(crate) fn check_well_formed(markup: &str) {
    let mut open = Vec::new();
    let mut rest = markup.strip_prefix("<!DOCTYPE html>").unwrap_or(markup);
    while let Some(start) = rest.find('<') {
        assert!(
            !rest[..start].contains('>'),
            "stray > in {}",
            &rest[..start]
        );
        let end = start + rest[start..].find('>').unwrap();
        let tag = &rest[start + 1..end];
        assert_eq!(tag.matches('"').count() % 2, 0, "quotes of <{tag}>");
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "</{name}>");
        } else if !tag.ends_with('/') {
            open.push(tag.split_whitespace().next().unwrap());
        }
        rest = &rest[end + 1..];
    }
    assert_eq!(open, [""; 0]);
}

/// A course that ends after `steer` [rad], sampled every .1 s.
fn course(nth: usize, steer: Vec<f64>, stop: Option<Stop>) -> Course {
    let case: Case = bicycle::cases::all()[nth];
    let time = (0..steer.len()).map(|i| 0.1 * i as f64).collect();
    Course {
        case,
        time,
        steer,
        stop,
    }
}

fn curve(frequency: Vec<f64>) -> Curve {
    let n = frequency.len();
    let level = |y: f64| vec![y; n];
    Curve {
        channel: "roll_rate".into(),
        unit: "rad/s".into(),
        frequency,
        measured: level(0.02),
        expected: level(0.02),
        low: level(0.01),
        high: level(0.04),
    }
}

/// Twelve bins .1 Hz apart, three of them left out about .8 Hz.
fn masked() -> Vec<f64> {
    (3..15)
        .filter(|k| !(7..10).contains(k))
        .map(|k| 0.1 * f64::from(k))
        .collect()
}

#[test]
fn the_cases_tell_how_each_went() {
    let courses = [
        course(
            0,
            (0..51).map(|i| if i < 20 { 0.5 } else { 0.05 }).collect(),
            None,
        ),
        course(
            6,
            vec![0.0, 0.7, 85f64.to_radians()],
            Some(Stop::SteerLimit { t: 0.2004 }),
        ),
        course(8, vec![0.0, 0.1], Some(Stop::Diverged { t: 0.1 })),
    ];
    let svg = cases(&courses);
    check_well_formed(&svg);
    // .5 rad after the first second
    for said in [
        "up to 28.65° after 1 s",
        "steer limit at 0.200 s",
        "fell at 0.100 s",
    ] {
        assert!(svg.contains(said), "{said}");
    }
    for trail in ["trail 0.130 m", "trail 0.085 m", "trail −0.035 m"] {
        assert!(svg.contains(trail), "{trail}");
    }
    // blue and vermillion of two centres of mass; circles where two ended, and in words
    assert!(svg.contains("#0072B2") && svg.contains("#D55E00") && !svg.contains("#E69F00"));
    assert_eq!(svg.matches("<circle").count(), 4);
    assert_eq!(svg, cases(&courses));
}

#[test]
fn loads_have_a_colour_each_and_room_for_their_names() {
    let loads: Vec<f64> = (0..6).map(|k| 5.0 * f64::from(k)).collect();
    let courses: Vec<Course> = bicycle::cases::loaded(&loads)
        .into_iter()
        .map(|case| Course {
            case,
            ..course(0, vec![0.01; 51], None)
        })
        .collect();
    let svg = cases(&courses);
    check_well_formed(&svg);
    assert_eq!(svg.matches("25 kg of load").count(), 3);
    let height = |svg: &str| -> f64 {
        let from = svg.find("height=\"").unwrap() + 8;
        svg[from..].split('"').next().unwrap().parse().unwrap()
    };
    // four loads fit no more into the panels of three centres of mass
    assert!(height(&svg) > height(&cases(&courses[..3])) + 3.0 * 100.0);
}

#[test]
fn nothing_is_drawn_across_bins_that_were_left_out() {
    let svg = spectrum(&[curve(masked())], &[0.8]);
    check_well_formed(&svg);
    assert_eq!(svg.matches("<polygon").count(), 2);
    assert!(svg.contains("line left out") && svg.contains("roll rate [°/s]"));
    let whole = spectrum(&[curve((3..15).map(|k| 0.1 * f64::from(k)).collect())], &[]);
    assert_eq!(whole.matches("<polygon").count(), 1);
    assert!(!whole.contains("line left out"));
}

#[test]
fn stretches_and_gaps_follow_the_bins() {
    let f = masked();
    assert_eq!(stretches(&f), [0..4, 4..9]);
    let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
    assert!(near(gap(&f, 0.8).start, 0.6) && near(gap(&f, 0.8).end, 1.0));
    assert_eq!(gap(&f, 2.0).end, 2.0, "a line beyond the band");
    assert_eq!(stretches(&[]), [0..0; 0]);
    assert_eq!(stretches(&[1.0]).len(), 1);
}

#[test]
fn a_thinned_signal_keeps_its_extremes_in_order() {
    let mut y: Vec<f64> = (0..10_000).map(|i| (f64::from(i) * 0.01).sin()).collect();
    y[5_003] = 7.0;
    y[5_004] = -7.0;
    let x: Vec<f64> = (0..10_000).map(f64::from).collect();
    let thin = decimated(&points(&x, y.iter().copied()), &(0.0..9_999.0), 100);
    assert!(thin.len() <= 2 * 101, "{}", thin.len());
    assert!(thin.is_sorted_by(|a, b| a.0 < b.0));
    assert!(thin.contains(&(5_003.0, 7.0)) && thin.contains(&(5_004.0, -7.0)));
    let short = points(&x[..150], y.iter().copied());
    assert_eq!(
        decimated(&short, &(0.0..149.0), 100),
        short,
        "what fits stays"
    );
}

#[test]
fn traces_of_a_long_ride_stay_small() {
    let n = 10_000;
    let noise = |seed: usize| {
        (0..n)
            .map(|i| ((i * i + seed) as f64 * 0.37).sin())
            .collect()
    };
    let trace = |channel: &str| Trace {
        windows: Vec::new(),
        channel: channel.into(),
        unit: "rad".into(),
        time: (0..n).map(|i| i as f64 * 0.01).collect(),
        measured: noise(1),
        model: noise(2),
    };
    let svg = traces(&[trace("steer"), trace("roll"), trace("steer")]);
    check_well_formed(&svg);
    // three panels, two signals, two points of at most ten letters in each of 720 columns
    assert!(svg.len() < 3 * 2 * 2 * 720 * 10 + 20_000, "{}", svg.len());
    assert!(svg.contains("steer [°]") && svg.contains("roll [°]"));
}

#[test]
fn a_comparison_names_every_spectrum() {
    let f = masked();
    let a = vec![0.01; f.len()];
    let spectra = [
        ("a <b> & c.csv".to_owned(), &f[..], &a[..]),
        ("d.csv".into(), &f, &a),
    ];
    let svg = comparison(&spectra, "rad");
    check_well_formed(&svg);
    assert!(svg.contains("a &lt;b&gt; &amp; c.csv") && svg.contains("d.csv"));
    assert!(svg.contains("amplitude [°]"));
}

#[test]
fn what_is_empty_or_not_finite_is_still_a_figure() {
    let mut odd = curve(vec![1.0]);
    odd.measured = vec![f64::NAN];
    odd.high = vec![f64::INFINITY];
    let flat = Trace {
        windows: Vec::new(),
        channel: "steer".into(),
        unit: "rad".into(),
        time: vec![0.0],
        measured: vec![0.0],
        model: vec![f64::NAN],
    };
    for svg in [
        cases(&[]),
        spectrum(&[], &[]),
        spectrum(&[odd], &[1.0]),
        traces(&[]),
        traces(&[flat]),
        comparison(&[], "rad"),
    ] {
        check_well_formed(&svg);
        assert!(svg.starts_with("<svg") && !svg.contains("NaN"));
    }
}
