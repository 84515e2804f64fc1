#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
use super::*;

/// A folder with two rides of 2 s, one of them without a clock.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut ride = Ride::new(0.0, 0.01, 200);
    ride.insert("steer", (0..200).map(f64::from).collect())
        .unwrap();
    ride.insert("speed", vec![2.5; 200]).unwrap();
    ride.write(&folder.path().join("a.csv")).unwrap();
    std::fs::write(folder.path().join("b.csv"), "winkel\n1\n2\n3\n4\n").unwrap();
    let map = "name = 'm'\nsigns = 'literature'\n[channels.steer]\ncolumn = 'winkel'";
    std::fs::write(folder.path().join("m.toml"), map).unwrap();
    folder
}

#[test]
fn what_stands_at_the_top_holds_where_a_ride_says_nothing() {
    let folder = folder();
    let text = "load = '10 kg'\nset = ['wheelbase=1.1']\nspeed = '9 km/h'\n\
        [[ride]]\nfile = 'a.csv'\nrider = '53kg,1.68m'\ntimes = '0.5s:1s'\ntrail = '130 mm'\n\
        [[ride]]\nfile = 'b.csv'\nmap = 'm.toml'\nrate = '2 Hz'\nload = 0\n\
        set = ['wheelbase=1.2']\ncondition = 'gravel'";
    let study = Study::parse("s.toml", text, folder.path()).unwrap();
    assert_eq!((study.name.as_str(), study.rides.len()), ("s.toml", 2));
    let [a, b] = [&study.rides[0], &study.rides[1]];
    let labels = |rider: &str, load, trail, condition: &str| Labels {
        rider: rider.into(),
        load,
        trail,
        speed: 2.5,
        condition: condition.into(),
    };
    assert_eq!(a.labels, labels("53kg,1.68m", 10.0, 0.13, ""));
    assert_eq!(b.labels, labels("", 0.0, 0.085, "gravel"));
    assert_eq!((a.ride.len(), a.ride.time(0)), (50, 0.5));
    assert_eq!(a.source.times, Some((0.5, 1.0)));
    // a light rider weighs less than the nominal one
    assert!(a.bicycle.parameters.total_mass < b.bicycle.parameters.total_mass);
    assert_eq!(a.bicycle.parameters.wheelbase, 1.1);
    assert_eq!(b.bicycle.parameters.wheelbase, 1.2);
    assert_eq!(b.ride.channel("steer").unwrap(), [-1.0, -2.0, -3.0, -4.0]);
    assert_eq!(
        [a, b].map(|entry| entry.ridden().condition),
        [
            "rider 53kg,1.68m, load 10 kg, trail 0.13 m",
            "load 0 kg, trail 0.085 m, gravel"
        ]
    );
    assert!(b.source.map.as_ref().unwrap().ends_with("m.toml"));
}

#[test]
fn mistakes_are_named() {
    let folder = folder();
    for (text, expected) in [
        (
            "name = 'x'",
            "s.toml: study: expected `[[ride]]`, found none",
        ),
        (
            "file = 'a.csv'\n[[ride]]",
            "s.toml: [[ride]]: expected `file`, found none",
        ),
        (
            "[[ride]]\nfile = 'a.csv'\n[[ride]]\nload = 3",
            "s.toml, ride 2: [[ride]]: expected `file`, found none",
        ),
        ("[[ride]]\nfile = 'none.csv'", "none.csv: cannot be read"),
        (
            "[[ride]]\nfle = 'a.csv'",
            "s.toml, row 2: unknown field `fle`, expected one of `name`, `ride`, `file`",
        ),
        (
            "bicycle = 'nominl'\n[[ride]]\nfile = 'a.csv'",
            "s.toml, ride 1: unknown bicycle `nominl`; nearest: nominal",
        ),
        (
            "[[ride]]\nfile = 'a.csv'\nset = ['trial=3']",
            "unknown parameter `trial`; nearest: trail",
        ),
        (
            "[[ride]]\nfile = 'a.csv'\ntrail = '85 kg'",
            "trail: expected a unit of the dimension of m",
        ),
        (
            "[[ride]]\nfile = 'a.csv'\ntimes = '3s'",
            "expected times as START:STOP, found `3s`",
        ),
        (
            "[[ride]]\nfile = 'a.csv'\ntimes = '3s:4s'",
            "expected a window of at least 2 samples",
        ),
        ("[[ride]]\nfile = 'b.csv'", "unknown column `winkel`"),
        (
            "[[ride]]\nfile = 'a.csv'\nname = 'x'",
            "expected keys of a ride, found `name`",
        ),
    ] {
        let error = Study::parse("s.toml", text, folder.path()).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
}
