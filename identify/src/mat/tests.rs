#![expect(clippy::unwrap_used, reason = "a failed import is a failed test")]
use crate::error::Result;
use crate::import::Import;
use crate::map::Map;
use crate::ride::Ride;

/// Files of SciPy's and h5py's making, see `tests/data/rides/write.py`.
macro_rules! file {
    ($name:literal) => {
        (
            $name,
            include_bytes!(concat!("../../../tests/data/rides/", $name)).as_slice(),
        )
    };
}

fn read((name, bytes): (&str, &[u8])) -> Result<Ride> {
    Import::default().parse(name, bytes)
}

/// Whether `ride` is the one in all those files, up to `tolerance` (relative).
#[track_caller]
fn is_the_ride(ride: &Ride, tolerance: f64) {
    assert_eq!((ride.len(), ride.step(), ride.time(0)), (40, 0.005, 0.0));
    for i in 0..40 {
        let sample = i as f64;
        for (name, value) in [
            ("steer", (sample / 5.0).sin() / 10.0),
            ("roll_rate", (sample / 7.0).cos() / 4.0),
            ("speed", 2.5),
        ] {
            let x = ride.channel(name).unwrap()[i];
            assert!(
                (x - value).abs() <= tolerance,
                "{name}[{i}]: {x} for {value}"
            );
        }
    }
}

/// One unit in the last place: another library's sine.
const ROUND_OFF: f64 = 1e-16;

#[test]
fn vectors_and_structs_are_read_compressed_or_not() {
    let ride = read(file!("vectors.mat")).unwrap();
    is_the_ride(&ride, ROUND_OFF);
    assert_eq!(ride.law_in_loop, Some(false));
    assert_eq!(
        ride.notes,
        ["columns not used: rider (text), fs (1 of 40 numbers)"]
    );
    assert_eq!(ride.origin.unwrap().rows, (1..=40).collect::<Vec<_>>());
    is_the_ride(&read(file!("struct.mat")).unwrap(), ROUND_OFF);
}

#[test]
fn integers_and_singles_come_through_a_map() {
    let map = "name = 'x'\n[time]\ncolumn = 't'\nunit = 'ms'\n\
        [channels.steer]\ncolumn = 'steer_counts'\nscale = 1e-4\n\
        [channels.roll_rate]\ncolumn = 'w'\n[channels.speed]\ncolumn = 'v'";
    let import = |map: &str| {
        let (name, bytes) = file!("integers.mat");
        Import {
            map: Some(Map::parse("x.toml", map).unwrap()),
            ..Import::default()
        }
        .parse(name, bytes)
    };
    // steer in counts of 1e-4 rad
    is_the_ride(&import(map).unwrap(), 0.5001e-4);
    assert_eq!(
        import(&map.replace("'w'", "'calibration'"))
            .unwrap_err()
            .to_string(),
        "integers.mat: expected a number a row in column `calibration`, found a matrix of 3 × 3"
    );
    assert_eq!(
        import(&map.replace("'w'", "'ww'")).unwrap_err().to_string(),
        "integers.mat: unknown column `ww`; nearest: w"
    );
}

#[test]
fn a_struct_beside_others_is_named_with_its_fields() {
    let (name, bytes) = file!("structs.mat");
    let error = read((name, bytes)).unwrap_err().to_string();
    assert!(
        error.starts_with("structs.mat: unknown column `t2`; nearest: time"),
        "{error}"
    );
    let map = "name = 'x'\nsigns = 'literature'\n[time]\ncolumn = 'ride.time'\n\
        [channels.steer]\ncolumn = 'ride.steer'";
    let import = |map: &str| {
        Import {
            map: Some(Map::parse("x.toml", map).unwrap()),
            ..Import::default()
        }
        .parse(name, bytes)
    };
    let ride = import(map).unwrap();
    assert!((ride.channel("steer").unwrap()[5] + 1f64.sin() / 10.0).abs() < ROUND_OFF);
    let error = import(&map.replace("ride.steer", "z"))
        .unwrap_err()
        .to_string();
    assert!(error.ends_with("found complex numbers"), "{error}");
}

/// A file is damaged at every byte and cut at every length in turn: an error or a ride, no panic.
#[test]
fn damaged_files_are_errors() {
    for (name, bytes) in [
        file!("vectors.mat"),
        file!("struct.mat"),
        file!("structs.mat"),
        file!("integers.mat"),
    ] {
        let (mut refused, mut whole) = (0, 0);
        for at in 0..bytes.len() {
            let mut damaged = bytes.to_vec();
            damaged[at] ^= 0xff;
            refused += usize::from(read((name, &damaged)).is_err());
            whole += usize::from(read((name, &bytes[..at])).is_ok());
        }
        // cut between two variables, or in the filling behind the last number, it is a file with
        // fewer of them
        assert!(whole <= 12, "{name}: {whole} cuts");
        // of the text of the header nothing depends
        assert!(refused > (bytes.len() - 128) / 4, "{name}: {refused}");
    }
}

#[test]
fn a_compressed_variable_with_another_checksum_is_refused() {
    let (name, bytes) = file!("vectors.mat");
    // the first element ends with its checksum
    let length = u32::from_le_bytes(bytes[132..136].try_into().unwrap()) as usize;
    let mut damaged = bytes.to_vec();
    damaged[136 + length - 1] ^= 1;
    assert_eq!(
        read((name, &damaged)).unwrap_err().to_string(),
        "vectors.mat: expected a MAT-file of version 5, found a compressed variable damaged; save \
         vectors, or a struct of them, with `save -v7`"
    );
}

#[test]
fn other_files_called_mat_say_how_to_save() {
    let error = read(("old.mat", b"\0\0\0\0\x01\0\0\0"))
        .unwrap_err()
        .to_string();
    assert_eq!(
        error,
        "old.mat: expected a MAT-file of version 5, found another file; save with `save -v7`"
    );
}

#[cfg(not(feature = "mat73"))]
#[test]
fn version_7_3_says_how_to_save() {
    let error = read(file!("vectors73.mat")).unwrap_err().to_string();
    assert!(error.contains("found version 7.3 (HDF5)"), "{error}");
    assert!(error.ends_with("`save -v7`"), "{error}");
}

#[cfg(feature = "mat73")]
#[test]
fn version_7_3_is_read() {
    // roll rate in single precision
    is_the_ride(&read(file!("vectors73.mat")).unwrap(), 1e-8);
    is_the_ride(&read(file!("struct73.mat")).unwrap(), ROUND_OFF);
}
