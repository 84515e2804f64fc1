#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
use super::*;

fn ride() -> Ride {
    let mut ride = Ride::new(2.0, 0.005, 6);
    ride.insert("steer", vec![0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
        .unwrap();
    ride.insert("speed", vec![0.0, 0.1, 2.0, 2.0, 0.3, 2.0])
        .unwrap();
    ride.insert("roll", vec![0.0; 6]).unwrap();
    ride
}

#[test]
fn the_clock_of_the_recording_is_kept() {
    let ride = ride();
    assert_eq!((ride.step(), ride.len()), (0.005, 6));
    assert_eq!(ride.time(3), 2.015);
    assert!(
        (ride.duration() - 0.03).abs() < 1e-15,
        "six steps of .005 s, to round-off"
    );
    assert_eq!(ride.rate(), 200.0);
}

#[test]
fn a_slice_is_half_open_in_time() {
    let slice = ride().slice(2.005..2.015).unwrap();
    assert_eq!(slice.channel("steer").unwrap(), [0.2, 0.3]);
    assert_eq!(slice.time(0), 2.005);
    assert_eq!(slice.notes, ["cut to 2.005 to 2.01 s"]);
    for outside in [0.0..9.0, -5.0..2.01, f64::NAN..2.01] {
        let refused = ride().slice(outside).unwrap_err();
        assert!(matches!(refused, Error::Window { .. }), "{refused}");
    }
    assert_eq!(
        ride().slice(7.0..9.0).unwrap_err().to_string(),
        "ride: expected a window of at least 2 samples within 2 to 2.025 s, found 7 to 9 s"
    );
}

#[test]
fn errors_name_the_channel() {
    let message = |result: Result<&[f64]>| result.unwrap_err().to_string();
    let ride = ride();
    assert_eq!(
        message(ride.channel("steer_torque")),
        "ride: no channel `steer_torque`; it has steer, speed, roll"
    );
    assert_eq!(
        message(ride.channel("ster")),
        "unknown channel `ster`; nearest: steer"
    );
    assert_eq!(
        message(ride.signal("roll")),
        "ride: expected a signal in channel `roll`, found 0 rad throughout"
    );
    let mut ride = ride;
    assert_eq!(
        ride.insert("steer", vec![0.0; 5]).unwrap_err().to_string(),
        "channel `steer`: expected 6 samples, found 5"
    );
    assert_eq!(
        ride.insert("yaw_rate", vec![0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0])
            .unwrap_err()
            .to_string(),
        "channel `yaw_rate`: expected finite samples, found NaN at sample 1"
    );
    assert!(!ride.has("yaw_rate"));
}

#[test]
fn standstill_is_found() {
    let mut ride = ride();
    let spans: Vec<String> = ride.standstill().iter().map(Span::to_string).collect();
    assert_eq!(spans, ["2 to 2.005 s", "2.02 s"]);
    assert_eq!(
        ride.check_moving().unwrap_err().to_string(),
        "ride: expected a speed above 0.5 m/s, found standstill in 2 to 2.005 s"
    );
    ride.insert("speed", vec![2.0; 6]).unwrap();
    ride.check_moving().unwrap();
}
