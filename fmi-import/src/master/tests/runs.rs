use super::lag::{Lag, connection, coupled, exact, master, member, pair};
use crate::Error;
use crate::master::{Algorithm, End, Master, Plan, Run};

fn plan(step: f64) -> Plan {
    Plan {
        start_time: 0.0,
        stop_time: 2.0,
        step,
        algorithm: Algorithm::Jacobi,
        tolerance: None,
        initial_exchange: true,
        record: ["x.x", "y.x"]
            .map(|t| t.parse().expect("a terminal"))
            .into(),
    }
}

fn last(run: &Run) -> [f64; 3] {
    [0, 1, 2].map(|c: usize| *run.columns[c].last().expect("a row"))
}

/// The largest error over the record.
fn error(run: &Run) -> f64 {
    let rows = run.columns[0].iter().enumerate().map(|(n, &t)| {
        let [x, y] = exact(t);
        (run.columns[1][n] - x)
            .abs()
            .max((run.columns[2][n] - y).abs())
    });
    rows.fold(0.0, f64::max)
}

#[test]
fn both_algorithms_converge_with_the_first_power_of_the_step() {
    for algorithm in [Algorithm::Jacobi, Algorithm::GaussSeidel] {
        let errors = [0.02, 0.01, 0.005, 0.0025].map(|step| {
            let plan = Plan {
                algorithm,
                ..plan(step)
            };
            error(&master().run(&plan).expect("ran"))
        });
        for pair in errors.windows(2) {
            // 2 but for the second power of the step
            let order = (pair[0] / pair[1]).log2();
            assert!((order - 1.0).abs() < 0.05, "{algorithm:?}: {errors:?}");
        }
    }
}

#[test]
fn the_order_of_the_members_does_not_matter_to_jacobi_and_does_to_gauss_seidel() {
    let run = |members, algorithm| {
        let mut master = Master::new(members, coupled()).expect("connected");
        let plan = Plan {
            algorithm,
            ..plan(0.1)
        };
        master.run(&plan).expect("ran").columns
    };
    let turned = || pair().into_iter().rev().collect();
    let algorithm = Algorithm::Jacobi;
    assert_eq!(run(pair(), algorithm), run(turned(), algorithm));
    let algorithm = Algorithm::GaussSeidel;
    assert_ne!(run(pair(), algorithm), run(turned(), algorithm));
}

#[test]
fn a_step_of_jacobi_and_one_of_gauss_seidel_by_hand() {
    let h = 0.5_f64;
    let lag = |rate: f64, gain: f64, x: f64, input: f64| {
        x * (-rate * h).exp() + gain * input / rate * (1.0 - (-rate * h).exp())
    };
    let x = lag(1.0, 2.0, 1.0, 0.5);
    for (algorithm, seen) in [(Algorithm::Jacobi, 1.0), (Algorithm::GaussSeidel, x)] {
        let plan = Plan {
            algorithm,
            stop_time: h,
            ..plan(h)
        };
        let run = master().run(&plan).expect("ran");
        assert_eq!(last(&run), [h, x, lag(3.0, -1.0, 0.5, seen)]);
        assert_eq!(run.names, ["time", "x.x", "y.x"]);
    }
}

#[test]
fn without_the_initial_exchange_the_first_step_has_the_inputs_own_start_values() {
    let plan = Plan {
        initial_exchange: false,
        stop_time: 0.5,
        ..plan(0.5)
    };
    let run = master().run(&plan).expect("ran");
    assert_eq!(last(&run), [0.5, (-0.5_f64).exp(), 0.5 * (-1.5_f64).exp()]);
}

#[test]
fn with_a_tolerance_the_error_stays_within_it_and_the_work_grows_as_its_inverse() {
    for algorithm in [Algorithm::Jacobi, Algorithm::GaussSeidel] {
        let run = |tolerance| {
            let plan = Plan {
                algorithm,
                tolerance: Some(tolerance),
                ..plan(0.25)
            };
            let run = master().run(&plan).expect("ran");
            assert!(matches!(run.end, End::Complete));
            assert_eq!(run.columns[0].len(), 9);
            assert!(
                error(&run) < tolerance,
                "{algorithm:?} {tolerance}: {}",
                error(&run)
            );
            // and is not far below it
            assert!(
                error(&run) > 0.02 * tolerance,
                "{algorithm:?} {tolerance}: {}",
                error(&run)
            );
            run.steps as f64
        };
        let steps = [1e-2, 1e-3, 1e-4].map(run);
        for pair in steps.windows(2) {
            let growth = pair[1] / pair[0];
            assert!((5.0..15.0).contains(&growth), "{algorithm:?}: {steps:?}");
        }
    }
}

#[test]
fn a_step_that_cannot_be_computed_is_cut_where_there_is_a_tolerance() {
    let members = || {
        let mut members = pair();
        let lag = Lag {
            longest: 0.01,
            ..Lag::new(1.0, 2.0, 1.0)
        };
        members[0] = member("x", lag);
        members
    };
    let plan = Plan {
        tolerance: Some(1e-2),
        ..plan(0.25)
    };
    let mut master = Master::new(members(), coupled()).expect("connected");
    let run = master.run(&plan).expect("ran");
    assert!(matches!(run.end, End::Complete), "{:?}", run.end);
    assert!(run.taken_back > 0 && error(&run) < 1e-2);

    // without one the run ends there
    let plan = Plan {
        tolerance: None,
        ..plan
    };
    let run = master.run(&plan).expect("ran");
    assert!(
        matches!(&run.end, End::Early { member, time: 0.0, .. } if member == "x"),
        "{:?}",
        run.end
    );
}

#[test]
fn a_member_with_a_longer_step_is_seen_when_it_has_arrived() {
    let mut members = pair();
    members[1].step = Some(0.5);
    let mut master = Master::new(members, coupled()).expect("connected");
    let plan = Plan {
        stop_time: 1.0,
        ..plan(0.25)
    };
    let run = master.run(&plan).expect("ran");
    let y = |x: f64, y: f64| y * (-1.5_f64).exp() - x / 3.0 * (1.0 - (-1.5_f64).exp());
    let at_half = y(1.0, 0.5);
    assert_eq!(
        run.columns[2],
        [0.5, 0.5, at_half, at_half, y(run.columns[1][2], at_half)]
    );
}

#[test]
fn a_stop_that_is_no_multiple_of_the_step_is_reached() {
    let run = master().run(&plan(0.3)).expect("ran");
    assert_eq!(run.columns[0].len(), 8);
    assert_eq!(last(&run)[0], 2.0);
    // and one that is but for round-off has no step of 1e-16 s
    let plan = Plan {
        stop_time: 0.3,
        ..plan(0.1)
    };
    let run = master().run(&plan).expect("ran");
    assert_eq!(run.columns[0].len(), 4);
    assert_eq!(last(&run)[0], 0.3);
}

#[test]
fn one_that_ends_early_ends_the_run_with_what_was_reached() {
    let lag = Lag {
        end: 0.6,
        ..Lag::new(1.0, 2.0, 1.0)
    };
    for tolerance in [None, Some(1e-3)] {
        let members = vec![
            member("x", lag.clone()),
            member("y", Lag::new(3.0, -1.0, 0.5)),
        ];
        let mut master = Master::new(members, coupled()).expect("connected");
        let plan = Plan {
            tolerance,
            ..plan(0.25)
        };
        let run = master.run(&plan).expect("ran");
        assert!(
            matches!(&run.end, End::Early { member, time, .. } if member == "x" && *time == 0.6),
            "{:?}",
            run.end
        );
        assert_eq!(run.columns[0], [0.0, 0.25, 0.5, 0.6]);
        assert!(run.columns.iter().all(|column| column.len() == 4));
    }
}

#[test]
fn a_value_that_is_none_is_refused_by_name_and_time() {
    let members = vec![
        member("source", Lag::new(-2000.0, 0.0, 1.0)),
        member("sink", Lag::new(1.0, 1.0, 0.0)),
    ];
    let wires = vec![connection("source.x", "sink.input")];
    let mut master = Master::new(members, wires).expect("connected");
    let run = master
        .run(&Plan {
            record: vec![],
            ..plan(0.5)
        })
        .expect("ran");
    let End::Failed(error) = run.end else {
        panic!("{:?}", run.end)
    };
    assert_eq!(
        error.to_string(),
        "sink at 0.5 s: input: expected a finite value, found NaN from source.x"
    );
    assert_eq!(run.columns[0], [0.0, 0.5]);
}

#[test]
fn a_run_can_be_stopped_and_the_next_one_goes_on() {
    let mut master = master();
    let watch = master.watch();
    watch.stop();
    let run = master.run(&plan(0.1)).expect("ran");
    assert!(matches!(run.end, End::Stopped));
    assert_eq!(run.columns[0], [0.0]);
    // nothing is being called any more
    assert_eq!(watch.call(), None);
    let run = master.run(&plan(0.1)).expect("ran");
    assert!(matches!(run.end, End::Complete));
    assert_eq!(run.columns[0].len(), 21);
}

#[test]
fn under_gauss_seidel_too_a_slow_member_is_recorded_when_it_has_arrived() {
    let mut members = pair();
    members[1].step = Some(0.5);
    let mut master = Master::new(members, coupled()).expect("connected");
    let plan = Plan {
        stop_time: 1.0,
        algorithm: Algorithm::GaussSeidel,
        ..plan(0.25)
    };
    let y = master.run(&plan).expect("ran").columns[2].clone();
    assert_eq!((y[0], y[1]), (0.5, 0.5));
    assert!(y[2] != y[1] && y[2] == y[3] && y[4] != y[3], "{y:?}");
}

#[test]
fn one_that_takes_steps_of_one_length_only_begins_none_that_it_cannot_finish() {
    let mut members = pair();
    members[1] = member(
        "y",
        Lag {
            only: Some(0.5),
            ..Lag::new(3.0, -1.0, 0.5)
        },
    );
    members[1].step = Some(0.5);
    let mut master = Master::new(members, coupled()).expect("connected");
    let plan = Plan {
        stop_time: 1.2,
        ..plan(0.1)
    };
    let run = master.run(&plan).expect("ran");
    assert!(matches!(run.end, End::Complete), "{:?}", run.end);
    assert_eq!(last(&run)[0], 1.2);
    assert_eq!(run.columns[2][10], run.columns[2][12]);
}

#[test]
fn an_fmu_that_says_nothing_of_dependencies_is_held_to_the_tolerance_all_the_same() {
    let silent = |mut lag: Lag| {
        lag.ports[1].depends_on = None;
        lag
    };
    let members = vec![
        member("x", silent(Lag::new(1.0, 2.0, 1.0))),
        member("y", silent(Lag::new(3.0, -1.0, 0.5))),
    ];
    let mut master = Master::new(members, coupled()).expect("connected");
    // it may depend on its input at once, so there may be a loop
    assert_eq!(master.loops().len(), 1);
    for tolerance in [1e-2, 1e-3] {
        let plan = Plan {
            tolerance: Some(tolerance),
            ..plan(0.25)
        };
        let run = master.run(&plan).expect("ran");
        assert!(error(&run) < tolerance, "{tolerance}: {}", error(&run));
        assert_eq!(run.forced, 0);
    }
}

#[test]
fn plans_that_cannot_be_carried_out_are_refused() {
    let refused = |plan: Plan, expected: &str| {
        let mut members = pair();
        members[1].step = Some(0.05);
        let mut master = Master::new(members, coupled()).expect("connected");
        let error = master.run(&plan).expect_err("refused").to_string();
        assert!(error.contains(expected), "{error}");
    };
    refused(
        plan(0.0),
        "communication step: expected a positive time, found 0",
    );
    refused(
        plan(0.03),
        "y: expected a step that is a multiple of the communication step of 0.03 s, found 0.05 s",
    );
    let tolerance = |tolerance| Plan {
        tolerance: Some(tolerance),
        ..plan(0.01)
    };
    refused(
        tolerance(-1.0),
        "tolerance: expected a positive number, found -1",
    );
    refused(
        tolerance(1e-3),
        "y: expected a participant that has no step of its own",
    );
    let record = Plan {
        record: vec!["x.xx".parse().expect("a terminal")],
        ..plan(0.01)
    };
    refused(
        record,
        "expected a variable of x, found \"xx\"; the nearest: x",
    );
    let members = vec![member(
        "x",
        Lag {
            can_keep: false,
            ..Lag::new(1.0, 1.0, 1.0)
        },
    )];
    let error = Master::new(members, vec![])
        .expect("nothing to connect")
        .run(&Plan {
            record: vec![],
            ..tolerance(1e-3)
        })
        .expect_err("refused");
    assert!(matches!(error, Error::Untolerant { member, .. } if member == "x"));
}
