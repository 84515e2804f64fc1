#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
use super::words::{Reading, scatter};
use super::*;
use crate::effort::Effort;
use crate::figure::tests::check_well_formed;
use crate::fit::fit;
use crate::free::ALL;
use crate::plan::Plan;
use crate::problem::Spent;
use crate::progress::Watch;
use crate::run::{Recorded, Source};
use crate::spectrum::{Line, Recipe};
use crate::synthesis::Synthesis;
use crate::verdict::Verdict::{self, Determined, NotDetermined, Nuisance, Weak};

/// A ride of the nominal bicycle and a fit of `plan` to it.
fn ridden(synthesis: &Synthesis, plan: &Plan) -> (Run, Ride) {
    let ride = synthesis.ride().unwrap();
    let source = Source {
        file: "rides/monday <1>.csv".into(),
        sha256: "9f86d081".into(),
        map: Some("lab map.toml".into()),
        map_sha256: None,
        rate: None,
        resample: true,
        times: Some((2.0, 26.0)),
        notes: vec!["resampled to 200 Hz".into()],
    };
    let rides = [plan.ridden(&ride)];
    let effort = Effort {
        seed: 7,
        ..Effort::default()
    };
    let (problem, fit) = fit(&rides, plan, &effort, &Watch::default()).unwrap();
    let recorded = Recorded::new(source, "nominal", &rides[0], plan);
    (Run::new(vec![recorded], plan, &problem, &effort, fit), ride)
}

fn check_page(run: &Run, ride: &Ride) -> String {
    let page = html(run, std::slice::from_ref(ride)).unwrap();
    // nothing is fetched: the script is in the page, and names the SVG standard only
    let own = include_str!("plot.js");
    assert_eq!(page.matches(own).count(), 1);
    check_well_formed(&page.replace(own, ""));
    for absent in ["http", "src=", "url(", "@import", "<link", "NaN", "inf"] {
        let text = page.replace(own, "").replace("infinite", "");
        assert!(!text.contains(absent), "{absent}");
    }
    for p in &run.fit.parameters {
        assert!(
            page.contains(&format!("<th>{}<small>", words(&p.name))),
            "{}",
            p.name
        );
        assert!(
            page.contains(&format!(">{}</span>", p.verdict.name())),
            "{}",
            p.verdict.name()
        );
    }
    let titles = [
        "Parameters",
        "Does the",
        "Signals",
        "Correlations",
        "Assumptions",
        "Work",
        "Provenance",
    ];
    let at: Vec<usize> = titles
        .iter()
        .map(|t| page.find(&format!("<h2>{t}")).unwrap())
        .collect();
    assert!(at.is_sorted(), "{at:?}");
    assert_eq!(
        page,
        html(run, std::slice::from_ref(ride)).unwrap(),
        "same input, same bytes"
    );
    page
}

#[test]
fn a_report_of_steering_alone() {
    let plan = Plan {
        objective: Some(Objective::Amplitude),
        free: Some(ALL.iter().map(|name| Free::new(name).unwrap()).collect()),
        recipe: Recipe {
            lines: vec![Line { frequency: 1.11 }],
            ..Recipe::default()
        },
        ..Plan::default()
    };
    let (mut run, ride) = ridden(&Synthesis::default(), &plan);
    let page = check_page(&run, &ride);
    for said in [
        "<h1>monday &lt;1&gt;.csv</h1>",
        "class=\"advice\">Steer alone does not determine",
        "<h2>Spectrum",
        "a seeded ride of the fitted bicycle",
        "The lines left out of the spectrum are in the measured curve only.",
        "over 5\u{a0}s, rectangular window, bins from 0.3 to 3\u{a0}Hz",
        "Torque not measured",
        "a corner of 2 Hz",
        "Noise of steer: 0.10° (estimated above 10 Hz).",
        "Ride: resampled to 200 Hz.",
        "9f86d081",
        "wobble fit 'rides/monday &lt;1&gt;.csv' --bicycle nominal",
        "--map 'lab map.toml' --times 2:26 --resample --objective amplitude --channels steer --free \
         cornering_stiffness,camber_stiffness,viscous_friction,coulomb_friction,remnant_intensity",
        "--line 1.11 --max-iterations 100 --seed 7</pre>",
    ] {
        assert!(page.contains(said), "{said}");
    }
    assert!(table(&run.fit).starts_with("Steer alone does not determine"));

    // with a remnant that drives it past its steer limit there is no ride to show: it is said
    run.rides[0]
        .start
        .rows
        .insert("steer_limit".into(), 10f64.to_radians());
    run.fit.parameters.last_mut().unwrap().value = 20.0;
    let page = html(&run, std::slice::from_ref(&ride)).unwrap();
    assert!(page.contains(FALLEN) && page.contains("<h2>Spectrum"));
}

#[test]
fn a_report_of_three_channels() {
    let (run, ride) = ridden(&Synthesis::default(), &Plan::default());
    let page = check_page(&run, &ride);
    for said in [
        "objective whittle on steer, roll rate and yaw rate",
        "Hann window",
        "85 to 88 of 100",
    ] {
        assert!(page.contains(said), "{said}");
    }
    // spectrum and signals as still pictures
    assert_eq!(page.matches("<svg").count(), 2);
}

#[test]
fn a_report_of_a_replay() {
    let synthesis = Synthesis {
        torque_recorded: true,
        duration: 8.0,
        ..Synthesis::default()
    };
    let (run, ride) = ridden(&synthesis, &Plan::default());
    let page = check_page(&run, &ride);
    for said in [
        "variance accounted for",
        "whole torque on the handlebar",
        "replayed in windows",
        "--objective time",
        "<h2>Residuals",
        "steer, autocorrelation",
    ] {
        assert!(page.contains(said), "{said}");
    }
    assert!(!page.contains("<h2>Spectrum") && !page.contains("--band"));
}

#[test]
fn a_report_of_frequency_responses_has_no_noise_of_channels() {
    let synthesis = Synthesis {
        torque_recorded: true,
        ..Synthesis::default()
    };
    let plan = Plan {
        objective: Some(Objective::Frf),
        free: Some(vec![Free::new("cornering_stiffness").unwrap()]),
        ..Plan::default()
    };
    let (run, ride) = ridden(&synthesis, &plan);
    let page = html(&run, std::slice::from_ref(&ride)).unwrap();
    assert!(page.contains("<h2>Frequency response") && page.contains("[random errors]"));
    assert!(!page.contains("Noise of steer"));
}

/// What is done to a fit on record.
type Change = fn(&mut Run);

#[test]
fn a_record_whose_parts_do_not_go_together_is_refused() {
    let (run, _) = ridden(&Synthesis::default(), &Plan::default());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fit.json");
    let read = |change: &dyn Fn(&mut Run)| {
        let mut run = run.clone();
        change(&mut run);
        std::fs::write(&path, run.to_json()).unwrap();
        Run::read(&path).map_err(|e| e.to_string())
    };
    assert_eq!(read(&|_| {}).unwrap(), run);
    let cases: [(Change, &str); 4] = [
        (
            |run| run.fit.explained.clear(),
            "explained: expected 1 entries, found 0",
        ),
        (
            |run| drop(run.fit.parameters.pop()),
            "parameters: expected 4 entries, found 3",
        ),
        (
            |run| run.fit.correlation[1].truncate(3),
            "correlation: expected 4 entries, found 3",
        ),
        (|run| run.rides.clear(), "expected a ride, found none"),
    ];
    for (change, message) in cases {
        let refused = read(&change).unwrap_err();
        assert!(
            refused.contains("fit.json: ") && refused.ends_with(message),
            "{refused}"
        );
    }
}

/// The command of a report makes the fit again: all that was asked is in it.
#[test]
fn the_command_on_record_holds_all_that_was_asked() {
    let (mut run, ride) = ridden(&Synthesis::default(), &Plan::default());
    run.asked.effort = Effort {
        starts: 20,
        population: 300,
        profiles: true,
        bootstrap: 5000,
        reduce: true,
        seed: 7,
        resume: Some("half".into()),
    };
    run.asked.windows = Some("pulses.csv".into());
    let page = html(&run, std::slice::from_ref(&ride)).unwrap();
    for said in [
        "--windows pulses.csv",
        "--seed 7 --starts 20 --population 300 --bootstrap 5000 --profile --reduce</pre>",
        "Stopped before all that was asked was made: starts, profiles, bootstrap and reduction.",
    ] {
        assert!(page.contains(said), "{said}");
    }
    assert!(
        summary(&run)
            .replace('\n', " ")
            .contains("starts, profiles, bootstrap and reduction.")
    );
    run.asked.study = Some("three riders.toml".into());
    let page = html(&run, std::slice::from_ref(&ride)).unwrap();
    assert!(page.contains("wobble fit --study 'three riders.toml' --windows"));
    assert!(!page.contains("--bicycle"));
}

#[test]
fn what_many_rides_have_of_their_own_is_named_once() {
    let mut rows = vec![("cornering_stiffness", Determined)];
    rows.extend([("effective_damping", NotDetermined); 18]);
    let fit = judged(Objective::Whittle, &THREE, &rows);
    let text = headline(&fit) + &advice(&fit).unwrap();
    assert!(
        text.contains("not determined: effective damping (18 of them)"),
        "{text}"
    );
    assert!(
        text.contains("do not determine effective_damping (18 of them)."),
        "{text}"
    );
    let alone = judged(Objective::Whittle, &THREE, &[("effective_damping", Weak)]);
    assert!(headline(&alone).starts_with("The one parameter is weakly determined; "));
}

fn estimate(name: &str, verdict: Verdict) -> Estimate {
    let free = Free::new(name).unwrap();
    Estimate {
        name: name.into(),
        of: None,
        unit: free.row.unit.symbol.into(),
        value: free.row.nominal,
        std_error: Some(0.1),
        interval: Some((free.row.nominal - 0.2, free.row.nominal + 0.2)),
        lower: free.lower,
        upper: free.upper,
        at_bound: false,
        verdict,
        trades_against: Vec::new(),
    }
}

/// A converged fit with a misfit of 1.
fn judged(objective: Objective, channels: &[&str], rows: &[(&str, Verdict)]) -> Fit {
    Fit {
        objective,
        channels: channels.iter().map(|c| (*c).into()).collect(),
        parameters: rows
            .iter()
            .map(|(name, verdict)| estimate(name, *verdict))
            .collect(),
        correlation: vec![vec![1.0; rows.len()]; rows.len()],
        cost: 0.0,
        misfit: 1.0,
        observations: 200,
        explained: Vec::new(),
        termination: "stopped after 3 iterations".into(),
        converged: true,
        work: Spent::default(),
        notes: Vec::new(),
        further: crate::effort::Further::default(),
    }
}

const THREE: [&str; 3] = ["steer", "roll_rate", "yaw_rate"];

#[test]
fn advice_names_the_channel_that_is_missing() {
    let all = ALL.map(|name| (name, NotDetermined));
    let said = |fit: &Fit| advice(fit).unwrap();

    let steer = said(&judged(Objective::Amplitude, &["steer"], &all));
    assert!(steer.contains("Roll rate and yaw rate recorded besides would determine the tyres"));
    assert!(steer.contains("measured steer torque would determine all four"));
    assert!(steer.contains("several rides at clearly different intensities"));

    let rows = [
        ("camber_stiffness", NotDetermined),
        ("effective_damping", Weak),
    ];
    let no_yaw = said(&judged(Objective::Whittle, &["steer", "roll_rate"], &rows));
    assert!(no_yaw.contains("Yaw rate recorded besides"), "{no_yaw}");
    assert!(no_yaw.contains("measured steer torque would determine camber_stiffness."));
    assert!(!no_yaw.contains("intensities") && !no_yaw.contains("effective_damping"));

    let crossless = said(&judged(Objective::Amplitude, &THREE, &rows));
    assert!(crossless.contains("objective whittle") && !crossless.contains("recorded besides"));

    let rows = [
        ("cornering_stiffness", Determined),
        ("effective_damping", NotDetermined),
    ];
    let damping = said(&judged(Objective::Whittle, &THREE, &rows));
    assert!(damping.contains(
        "would determine viscous and Coulomb friction, which effective_damping stands for"
    ));
    assert!(!damping.contains("cornering_stiffness") && !damping.contains("tyres"));

    let torque = said(&judged(Objective::Time, &THREE, &all));
    assert!(torque.contains("although its steer torque was measured"));
    assert!(
        !torque.contains("would determine"),
        "there is no further channel"
    );

    let mut far = judged(Objective::Time, &["steer", "roll_rate"], &all);
    far.misfit = 50.0;
    assert!(said(&far).contains("look at signs, speed, bicycle and formulation first"));
    assert!(said(&far).contains("Yaw rate recorded besides, a longer or livelier ride"));

    let mut bound = judged(Objective::Whittle, &THREE, &[("trail", NotDetermined)]);
    bound.parameters[0].at_bound = true;
    assert!(said(&bound).contains("ended at a bound of trail"));
    assert!(said(&bound).contains("Where trail can be measured directly"));
}

#[test]
fn where_nothing_is_lost_there_is_no_advice() {
    let rows = [
        ("cornering_stiffness", Determined),
        ("camber_stiffness", Weak),
        ("remnant_intensity", Nuisance),
    ];
    let fit = judged(Objective::Whittle, &THREE, &rows);
    assert_eq!(advice(&fit), None);
    assert!(table(&fit).starts_with("parameter "));
    assert_eq!(
        headline(&fit),
        "1 of 2 parameters determined: cornering stiffness 14.00 ± 0.10\u{a0}1/rad; weak: camber stiffness; the \
         model explains the spectra and cross-spectra (misfit 1.00)."
    );
}

#[test]
fn the_misfit_is_read_against_its_own_scatter() {
    let mut fit = judged(
        Objective::Amplitude,
        &["steer"],
        &[("effective_damping", NotDetermined)],
    );
    // 2 √(2/200) = .2
    assert!((scatter(200) - 0.2).abs() < 1e-12);
    for (misfit, reading) in [
        (0.1, Reading::Small),
        (0.79, Reading::Small),
        (0.81, Reading::Explained),
        (1.19, Reading::Explained),
        (1.21, Reading::Slight),
        (1.49, Reading::Slight),
        (1.51, Reading::Unexplained),
        (f64::INFINITY, Reading::Unexplained),
        (f64::NAN, Reading::Unexplained),
    ] {
        fit.misfit = misfit;
        assert_eq!(Reading::of(&fit), reading, "{misfit}");
    }
    // eight bins scatter by 1: what is far off for many is chance for few
    (fit.misfit, fit.observations) = (1.9, 8);
    assert_eq!(Reading::of(&fit), Reading::Explained);
}

#[test]
fn a_model_that_does_not_fit_is_not_praised() {
    let mut fit = judged(
        Objective::Time,
        &THREE,
        &[("cornering_stiffness", Determined)],
    );
    (fit.misfit, fit.converged) = (12.3, false);
    let headline = headline(&fit);
    assert!(
        headline.contains(
            "the model does not explain the recorded motion (misfit 12.3), so the numbers"
        )
    );
    assert!(headline.ends_with("The search did not converge: stopped after 3 iterations."));
    assert!(misfit(&fit).contains("between 0.80 and 1.20") && misfit(&fit).contains("well above"));
}

#[test]
fn columns_of_the_table_stand_below_each_other() {
    let mut fit = judged(
        Objective::Amplitude,
        &["steer"],
        &[("viscous_friction", Weak), ("trail", Determined)],
    );
    fit.parameters[0].std_error = None;
    fit.parameters[0].interval = None;
    fit.parameters[0].trades_against = vec!["coulomb_friction".into()];
    let text = table(&fit);
    let rows: Vec<Vec<char>> = text.lines().map(|line| line.chars().collect()).collect();
    assert_eq!(rows.len(), 3);
    let start = |head: &str| text.lines().next().unwrap().find(head).unwrap();
    for head in ["symbol", "estimate", "bounds", "verdict"] {
        let at = start(head);
        assert!(
            rows.iter().all(|row| row[at] != ' ' && row[at - 1] == ' '),
            "{head}\n{text}"
        );
    }
    assert!(
        text.contains("0.300 N m s/rad")
            && text.contains("weak")
            && text.contains("coulomb_friction")
    );
    assert!(text.lines().all(|line| line.trim_end() == line));
}
