use super::lag::{Lag, connection, member, port};
use crate::Error;
use crate::Step;
use crate::master::{Connection, Direction, Kind, Master, Member, Participant, Port, by_name};
use expect_test::{Expect, expect};
use model_description::{BaseUnit, Unit};

/// Has ports, and nothing else.
struct Sketch(Vec<Port>);

impl Participant for Sketch {
    fn ports(&self) -> &[Port] {
        &self.0
    }
    fn enter_initialization(&mut self, _: f64, _: f64) -> Result<(), Error> {
        Ok(())
    }
    fn exit_initialization(&mut self) -> Result<(), Error> {
        Ok(())
    }
    fn read(&mut self, _: &[usize], values: &mut [f64]) -> Result<(), Error> {
        values.fill(1.0);
        Ok(())
    }
    fn write(&mut self, _: &[usize], _: &[f64]) -> Result<(), Error> {
        Ok(())
    }
    fn step(&mut self, _: f64, _: f64) -> Result<Step, Error> {
        Ok(Step::Complete)
    }
    fn can_vary_step(&self) -> bool {
        true
    }
    fn can_keep(&self) -> bool {
        false
    }
    fn keep(&mut self) -> Result<(), Error> {
        Err(Error::NothingKept)
    }
    fn go_back(&mut self) -> Result<(), Error> {
        Err(Error::NothingKept)
    }
    fn terminate(&mut self) -> Result<(), Error> {
        Ok(())
    }
}

fn unit(name: &str, m: i32) -> Unit {
    Unit {
        name: name.to_owned(),
        base: Some(BaseUnit {
            m,
            ..BaseUnit::default()
        }),
        display_units: Vec::new(),
    }
}

/// `out` depends on `in` at once, if `through`; there is a switch, and something local.
fn sketch(name: &str, through: bool) -> Member<'static> {
    let mut out = port("out", Direction::Output);
    out.depends_on = Some(if through { vec![0] } else { vec![] });
    out.unit = Some(unit("m", 1));
    let mut switch = port("switch", Direction::Output);
    switch.kind = Kind::Boolean;
    let mut area = port("area", Direction::Input);
    area.unit = Some(unit("m2", 2));
    Member {
        name: name.to_owned(),
        participant: Box::new(Sketch(vec![
            port("in", Direction::Input),
            out,
            switch,
            area,
            port("inside", Direction::Other),
        ])),
        step: None,
    }
}

fn refused(connections: &[(&str, &str)], expected: &Expect) {
    let connections = connections.iter().map(|(a, b)| connection(a, b)).collect();
    let members = vec![sketch("a", true), sketch("b", false)];
    let Err(error) = Master::new(members, connections) else {
        panic!("connected")
    };
    expected.assert_eq(&error.to_string());
}

#[test]
fn what_does_not_go_together_is_refused() {
    refused(
        &[("a.out", "b.out")],
        &expect!["a.out → b.out: expected an input as its target, found an output"],
    );
    refused(
        &[("a.in", "b.in")],
        &expect!["a.in → b.in: expected an output as its source, found an input"],
    );
    refused(
        &[("a.inside", "b.in")],
        &expect![
            "a.inside → b.in: expected an output as its source, found a variable that is neither input nor output"
        ],
    );
    refused(
        &[("a.out", "b.in"), ("b.out", "b.in")],
        &expect!["b.in: expected one source, found two, a.out and b.out"],
    );
    refused(
        &[("a.out", "b.area")],
        &expect!["a.out → b.area: expected units that convert, found m to m2"],
    );
    refused(
        &[("a.switch", "b.in")],
        &expect!["a.switch → b.in: expected variables of one type, found a Boolean to a Real"],
    );
    refused(
        &[("a.output", "b.in")],
        &expect![[r#"expected a variable of a, found "output"; the nearest: out"#]],
    );
    refused(
        &[("c.out", "b.in")],
        &expect![[r#"expected a participant, found "c"; the nearest: a"#]],
    );
    let members = vec![sketch("a", true), sketch("a", true)];
    assert!(matches!(
        Master::new(members, vec![]),
        Err(Error::TwoMembers { name }) if name == "a"
    ));
    assert!("nowhere".parse::<crate::master::Terminal>().is_err());
}

fn loops(connections: &[(&str, &str)], through: [bool; 3]) -> Vec<String> {
    let members = ["a", "b", "c"]
        .iter()
        .zip(through)
        .map(|(name, through)| sketch(name, through))
        .collect();
    let connections = connections.iter().map(|(a, b)| connection(a, b)).collect();
    let master = Master::new(members, connections).expect("connected");
    master.loops().iter().map(ToString::to_string).collect()
}

#[test]
fn algebraic_loops_are_found_once_each() {
    let ring = [("a.out", "b.in"), ("b.out", "c.in"), ("c.out", "a.in")];
    assert_eq!(
        loops(&ring, [true; 3]),
        ["a.out → b.in → b.out → c.in → c.out → a.in → a.out"]
    );
    // time in one of them opens the loop
    assert!(loops(&ring, [true, false, true]).is_empty());
    assert_eq!(
        loops(&[("a.out", "a.in")], [true; 3]),
        ["a.out → a.in → a.out"]
    );
}

#[test]
fn equal_names_are_connected_where_there_is_one_source() {
    let members = vec![
        member("a", Lag::new(1.0, 1.0, 0.0)),
        sketch("b", false),
        sketch("c", false),
    ];
    assert!(by_name(&members, &[]).is_empty());
    let mut input = port("x", Direction::Input);
    input.unit = Some(unit("m", 1));
    let wanting = |name: &str| Member {
        name: name.to_owned(),
        participant: Box::new(Sketch(vec![input.clone()])),
        step: None,
    };
    let mut members = vec![
        member("lag", Lag::new(1.0, 1.0, 0.0)),
        wanting("d"),
        wanting("e"),
    ];
    let to_d = connection("lag.x", "d.x");
    let to_e = connection("lag.x", "e.x");
    assert_eq!(by_name(&members, &[]), [to_d.clone(), to_e.clone()]);
    let taken: [Connection; 1] = [to_d];
    assert_eq!(by_name(&members, &taken), [to_e]);
    members.push(member("another", Lag::new(1.0, 1.0, 0.0)));
    assert!(by_name(&members, &[]).is_empty());
}
