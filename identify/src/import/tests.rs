#![expect(clippy::unwrap_used, reason = "a failed import is a failed test")]
use super::*;
use std::fmt::Write as _;

fn read(text: &str) -> Result<Ride> {
    Import::default().parse("ride.csv", text.as_bytes())
}

fn message(text: &str) -> String {
    read(text).unwrap_err().to_string()
}

/// A ride of 20 samples at 200 Hz, with `edit` made to its lines (line 1 is the header).
fn edited(edit: impl Fn(usize, String) -> String) -> String {
    let lines = (1..=21).map(|row| {
        let t = (f64::from(row) - 2.0) * 0.005;
        let line = if row == 1 {
            "time[s],steer[rad]".into()
        } else {
            format!("{t:.3},{}", t * t)
        };
        edit(row as usize, line)
    });
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn a_written_ride_is_read_back_to_the_last_bit() {
    let mut ride = Ride::new(3.0, 0.005, 500);
    let wild = |i: usize| ((i * i) as f64).sin() * [1.0, 1e-7, 1e-14][i % 3];
    ride.insert("steer", (0..500).map(wild).collect()).unwrap();
    ride.insert("speed", (0..500).map(|i| 2.0 + wild(i)).collect())
        .unwrap();
    let mut signed = vec![0.0; 500];
    signed[3] = -0.0;
    signed[4] = f64::MIN_POSITIVE;
    ride.insert("steer_torque", signed).unwrap();
    for law in [None, Some(true), Some(false)] {
        ride.law_in_loop = law;
        let back = read(&ride.to_csv()).unwrap();
        assert_eq!(
            (back.step(), back.time(0), back.law_in_loop),
            (0.005, 3.0, law)
        );
        assert_eq!(back.notes, Vec::<String>::new());
        for ((a, x), (b, y)) in ride.channels().zip(back.channels()) {
            assert_eq!(a.name, b.name);
            assert!(
                x.iter().zip(y).all(|(x, y)| x.to_bits() == y.to_bits()),
                "{}",
                a.name
            );
        }
    }
}

#[test]
fn a_file_from_a_spreadsheet_is_understood() {
    let text = "\u{feff}# logged on Tuesday\r\n\r\ntime[ms];steer[deg];\"speed[km/h]\";;\r\n\
                100;1,5;8;;\r\n% a pause\r\n110;-2,5;8,0;;\r\n120;1e1;7.9;;\r\n;;;;\r\n\r\n";
    let ride = read(text).unwrap();
    assert_eq!((ride.step(), ride.time(0), ride.len()), (0.01, 0.1, 3));
    assert_eq!(
        ride.channel("steer").unwrap(),
        [1.5, -2.5, 10.0].map(f64::to_radians)
    );
    assert_eq!(ride.channel("speed").unwrap()[0], 8.0 / 3.6);
    assert_eq!(ride.origin.unwrap().rows, [4, 6, 7]);
    assert_eq!(ride.notes, Vec::<String>::new());
}

#[test]
fn latin_1_and_tabs_are_understood_and_utf_16_is_named() {
    let bytes = b"time\tsteer[\xb0]\n0\t1\n0.1\t2\n";
    let ride = Import::default().parse("ride.csv", bytes).unwrap();
    assert_eq!(ride.channel("steer").unwrap()[0], 1.0_f64.to_radians());
    assert_eq!(ride.notes, ["read as Latin-1: the file is not UTF-8"]);
    assert_eq!(
        Import::default()
            .parse("ride.csv", b"t\0i\0")
            .unwrap_err()
            .to_string(),
        "ride.csv: expected text, found a zero byte at offset 1 (UTF-16 or binary?)"
    );
}

#[test]
fn without_a_time_column_the_rate_must_be_given() {
    let text = "steer\n0.1\n0.2\n0.3\n";
    assert_eq!(
        message(text),
        "ride.csv: expected a time column or a sampling rate (--rate), found neither"
    );
    let at = |rate| {
        Import {
            rate: Some(rate),
            ..Import::default()
        }
        .parse("ride.csv", text.as_bytes())
    };
    let ride = at(200.0).unwrap();
    assert_eq!((ride.step(), ride.time(0)), (0.005, 0.0));
    assert_eq!(ride.notes, ["no time column: sampled at 200 Hz as given"]);
    assert_eq!(
        at(0.0).unwrap_err().to_string(),
        "rate: expected 0 to 1000000 Hz, found 0 Hz"
    );
}

#[test]
fn a_rate_that_contradicts_the_time_column_is_refused() {
    let import = |rate| Import {
        rate: Some(rate),
        ..Import::default()
    };
    let text = edited(|_, line| line);
    assert_eq!(
        import(100.0)
            .parse("ride.csv", text.as_bytes())
            .unwrap_err()
            .to_string(),
        "ride.csv: expected 100 Hz as given, found 200 Hz in the time column"
    );
    assert_eq!(
        import(200.0)
            .parse("ride.csv", text.as_bytes())
            .unwrap()
            .step(),
        0.005
    );
}

#[test]
fn what_is_no_number_is_named_with_its_row() {
    let at_812 = |cell: &str| {
        let mut text = String::from("# a comment\n\ntime[s],steer[rad]\n");
        for row in 4..=900 {
            let steer = if row == 812 { cell } else { "0.1" };
            writeln!(text, "{:.3},{steer}", f64::from(row) * 0.005).unwrap();
        }
        message(&text)
    };
    for (cell, found) in [
        ("NaN", "`NaN`"),
        ("inf", "`inf`"),
        ("left", "`left`"),
        ("", "an empty cell"),
        ("\"1.234,5\"", "`1.234,5`"),
    ] {
        assert_eq!(
            at_812(cell),
            format!("ride.csv, row 812: expected a number in column `steer[rad]`, found {found}")
        );
    }
    assert_eq!(
        at_812("1,2"),
        "ride.csv, row 812: expected 2 cells, found 3"
    );
    assert_eq!(
        message(&edited(|row, line| if row == 7 {
            "0.03".into()
        } else {
            line
        })),
        "ride.csv, row 7: expected 2 cells, found 1"
    );
}

#[test]
fn time_must_run() {
    let with = |row: usize, t: &str| {
        message(&edited(
            |r, line| if r == row { format!("{t},0") } else { line },
        ))
    };
    assert_eq!(
        with(9, "0.03"),
        "ride.csv, row 9: expected a time after 0.03 s, found 0.03 s"
    );
    assert_eq!(
        with(9, "0.001"),
        "ride.csv, row 9: expected a time after 0.03 s, found 0.001 s"
    );
}

#[test]
fn gaps_are_refused_or_bridged_and_told() {
    // rows 10 and 11 are lost
    let gap = edited(|row, line| {
        if [10, 11].contains(&row) {
            String::new()
        } else {
            line
        }
    });
    assert_eq!(
        message(&gap),
        "ride.csv, row 12: time step 0.015 s, expected 0.005 s; \
         --resample bridges gaps of up to 10 steps by straight lines"
    );
    let ride = Import {
        resample: true,
        ..Import::default()
    }
    .parse("ride.csv", gap.as_bytes())
    .unwrap();
    assert_eq!((ride.len(), ride.step()), (20, 0.005));
    assert_eq!(
        ride.notes,
        [
            "time steps of 0.005 to 0.005 s: resampled to 200 Hz by linear interpolation",
            "1 gap bridged by straight lines, the longest of 0.015 s before row 12",
        ]
    );
    // a clock set forward in the middle of the record
    let jump = edited(|row, line| {
        if row > 10 {
            format!("1700000{line}")
        } else {
            line
        }
    });
    for resample in [false, true] {
        let import = Import {
            resample,
            ..Import::default()
        };
        assert_eq!(
            import
                .parse("ride.csv", jump.as_bytes())
                .unwrap_err()
                .to_string(),
            "ride.csv, row 11: time step 17000000.005 s, expected 0.005 s; \
             too long to bridge: cut the record there"
        );
    }
    let steer = ride.channel("steer").unwrap();
    let (before, after) = (0.035 * 0.035, 0.05 * 0.05);
    // two thirds of the way, to the rounding of printed times
    assert!((steer[9] - (before + 2.0 * after) / 3.0).abs() < 1e-12);
    assert_eq!(ride.origin.unwrap().rows[7..11], [9, 9, 9, 12]);
}

#[test]
fn jitter_is_resampled_and_told() {
    // a logger at 60 Hz with stamps in whole milliseconds
    let mut text = String::from("time[ms],roll[rad]\n");
    for i in 0..600 {
        let t = f64::from(i) / 60.0;
        let stamp = (t * 1000.0).round();
        writeln!(text, "{stamp},{}", stamp * 2e-3).unwrap();
    }
    let ride = read(&text).unwrap();
    // the last stamp is rounded down, so that the last point of the grid lies behind it
    assert_eq!((ride.step(), ride.len()), (1.0 / 60.0, 599));
    assert_eq!(
        ride.notes,
        ["time steps of 0.016 to 0.017 s: resampled to 60 Hz by linear interpolation"]
    );
    // linear in the stamps, so linear interpolation is exact but for round-off
    for (i, roll) in ride.channel("roll").unwrap().iter().enumerate() {
        assert!((roll - i as f64 / 30.0).abs() < 1e-12, "sample {i}: {roll}");
    }
}

#[test]
fn headers_are_checked() {
    for (header, expected) in [
        (
            "time,ster[rad]",
            "ride.csv, row 1: unknown column `ster`; nearest: steer; \
             a file with other columns needs a map (--map)",
        ),
        (
            "tme,steer",
            "ride.csv, row 1: unknown column `tme`; nearest: time; \
             a file with other columns needs a map (--map)",
        ),
        (
            "time,steer[m]",
            "ride.csv, row 1: steer: expected a unit of the dimension of rad, found `m`",
        ),
        (
            "time,steer[grad]",
            "ride.csv, row 1: steer: expected a unit such as rad, found `grad`",
        ),
        (
            "time,steer[deg",
            "ride.csv, row 1: expected a column as name[unit], found `steer[deg`",
        ),
        (
            "time,steer,steer[deg]",
            "ride.csv, row 1: column `steer` appears twice",
        ),
        (
            "0.0,0.1",
            "ride.csv, row 1: expected a header with names such as steer[deg], found `0.0`",
        ),
    ] {
        let row = header.replace(|c| c != ',', "").replace(',', "0,") + "0";
        assert_eq!(
            message(&format!("{header}\n{row}\n{row}")),
            expected,
            "{header}"
        );
    }
}

#[test]
fn nothing_and_next_to_nothing_are_named() {
    for (text, found) in [
        ("", "an empty file"),
        ("# only a comment\n\n", "an empty file"),
        ("time,steer\n", "a header only"),
        ("time,steer\n0,0\n\n", "1 row"),
    ] {
        assert_eq!(
            message(text),
            format!("ride.csv: expected a header and at least 2 rows of numbers, found {found}")
        );
    }
    assert_eq!(
        Import::default()
            .read(Path::new("nowhere.csv"))
            .unwrap_err()
            .to_string(),
        "nowhere.csv: cannot be read: No such file or directory (os error 2)"
    );
}

#[test]
fn a_map_opens_a_foreign_file() {
    let text = "time_s,steer_angle_rad,steer_rate_rad_s,roll_angle_rad,roll_rate_rad_s,speed_m_s,\
                motor_steer_torque_Nm,hand_steer_torque_Nm\n\
                0,0.03145,0,0.01822,-0.06314,4.1828,-0.2926,-0.01946\n\
                0.01,0.03145,0.07667,0.0176,-0.06107,4.1828,-0.28302,-0.02375\n";
    let import = Import {
        map: Some(Map::open("sbw-delft").unwrap()),
        ..Import::default()
    };
    let ride = import.parse("bode.csv", text.as_bytes()).unwrap();
    assert_eq!(ride.step(), 0.01);
    assert_eq!(ride.law_in_loop, Some(true));
    assert_eq!(ride.channel("steer").unwrap(), [-0.03145, -0.03145]);
    assert_eq!(ride.channel("roll").unwrap(), [0.01822, 0.0176]);
    assert_eq!(ride.channel("steer_torque").unwrap(), [-0.01946, -0.02375]);
    assert!((ride.channel("speed").unwrap()[0] - (4.1828 + 0.128) / 1.066).abs() < 1e-14);
    assert_eq!(
        ride.notes,
        [
            "signs turned to ISO 8855: steer, steer_rate, steer_torque",
            "columns not used: motor_steer_torque_Nm",
        ]
    );
    let misspelt = text.replace("speed_m_s", "speed_mps");
    assert_eq!(
        import
            .parse("bode.csv", misspelt.as_bytes())
            .unwrap_err()
            .to_string(),
        "bode.csv, row 1: unknown column `speed_m_s`; nearest: speed_mps"
    );
}
