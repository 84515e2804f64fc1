//! Sensors that count.

/// `value` as a sensor of that resolution gives it, both in the same unit; 0 is a perfect sensor.
pub fn quantised(value: f64, resolution: f64) -> f64 {
    if resolution > 0.0 {
        (value / resolution).round() * resolution
    } else {
        value
    }
}

#[test]
fn a_sensor_errs_by_half_a_count_at_most() {
    for i in -1000..1000 {
        let angle = f64::from(i) * 1.7e-3;
        let found = quantised(angle, 0.01);
        assert!((found - angle).abs() <= 0.005 + 1e-15, "{angle}");
        assert_eq!(quantised(found, 0.01), found, "a count is a count");
        assert_eq!(quantised(-angle, 0.01), -found, "left as right");
        assert_eq!(quantised(angle, 0.0), angle);
    }
}
