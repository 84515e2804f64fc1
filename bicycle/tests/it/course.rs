//! Courses as geometry.

use bicycle::course::{Circle, LaneChange, Layout, Slalom};
use std::f64::consts::{PI, TAU};

#[test]
fn a_circle_closes_and_a_clothoid_turns_as_fresnel_has_it() {
    let circle = Circle::default();
    let course = circle.course();
    let onto = circle.run_in + circle.transition;
    assert!((course.length() - onto - TAU * circle.radius).abs() < 1e-12);
    let (start, end) = (course.at(onto), course.at(course.length()));
    // heading: half the curvature over the clothoid, then once round; Simpson's rule at a
    // centimetre and the cubic between stations leave less than a nanometre
    assert!((start.heading - 0.5 * circle.transition / circle.radius).abs() < 1e-9);
    assert!((end.heading - start.heading - TAU).abs() < 1e-9);
    assert!((end.x - start.x).hypot(end.y - start.y) < 1e-9);
    // the lateral shift of a clothoid: l²/6R − l⁴/336R³ + l⁶/42240R⁵ − …, next term 1e-6
    let (l, r) = (circle.transition, circle.radius);
    let aside =
        l * l / (6.0 * r) - l.powi(4) / (336.0 * r.powi(3)) + l.powi(6) / (42240.0 * r.powi(5));
    assert!((start.y - aside).abs() < 2e-6, "{} {aside}", start.y);
}

#[test]
fn a_point_beside_a_course_is_found() {
    let slalom = Slalom {
        cone_spacing: 3.0,
        amplitude: 0.4,
        ..Slalom::default()
    };
    let circle = Circle {
        rounds: 2.0,
        ..Circle::default()
    };
    for course in [
        slalom.course(),
        circle.course(),
        LaneChange::default().course(),
    ] {
        for n in 0..200 {
            let s = course.length() * f64::from(n) / 180.0;
            let station = course.at(s);
            for offset in [-0.3, 0.0, 0.2] {
                let (sin, cos) = station.heading.sin_cos();
                let (x, y) = (station.x - offset * sin, station.y + offset * cos);
                let place = course.locate(x, y, s - 0.05);
                // the cubics' directions are their stations' to 1e-8 rad; on the second round of
                // the circle it is the second round that is found
                assert!((place.arc_length - s).abs() < 1e-7, "{s}: {place:?}");
                assert!((place.offset - offset).abs() < 1e-7, "{s}: {place:?}");
                assert_eq!(place.heading, course.at(place.arc_length).heading);
            }
        }
    }
}

#[test]
fn a_lane_change_arrives_one_lane_to_the_left() {
    let lane = LaneChange::default();
    let course = lane.course();
    let end = course.at(course.length());
    assert!((end.x - (lane.run_in + lane.transition + lane.run_out)).abs() < 1e-9);
    assert_eq!(
        (end.y, end.heading, end.curvature),
        (lane.lane_offset, 0.0, 0.0)
    );
    // the steepest slope of 10 t³ − 15 t⁴ + 6 t⁵ is 15/8, half way
    let middle = course.locate(
        lane.run_in + 0.5 * lane.transition,
        0.5 * lane.lane_offset,
        7.0,
    );
    let slope = 15.0 / 8.0 * lane.lane_offset / lane.transition;
    assert!((middle.heading - slope.atan()).abs() < 1e-9);
}

#[test]
fn layouts_are_told_by_the_rows_of_their_tables() {
    for mut layout in Layout::all() {
        let before = layout.course();
        for (index, row) in layout.table().iter().enumerate() {
            assert!(row.admits(row.nominal), "{}", row.name);
            layout.set(index, row.nominal);
        }
        assert_eq!(layout.course(), before);
        layout.set(0, 1.5 * layout.table()[0].nominal);
        assert_ne!(layout.course(), before, "{}", layout.name());
    }
    // no room between the run-ins: no cones, no swing
    let short = Slalom {
        length: 5.0,
        ..Slalom::default()
    };
    let course = short.course();
    assert!(course.cones().is_empty());
    assert_eq!(course.at(2.5).y, 0.0);
}

#[test]
fn lead_shares_the_room_between_the_wheels() {
    // nearer than a wheelbase or further: the front wheel, √(1 + k²L²) cos(kL − atan kL − ζ) times
    // as far out as the rear one, clears the cone by as much as that or by more
    for tenths in 5..60 {
        let slalom = Slalom {
            cone_spacing: 0.1 * f64::from(tenths),
            ..Slalom::default()
        };
        let k = PI / slalom.cone_spacing;
        let kl = k * slalom.wheelbase;
        let zeta = k * slalom.lead();
        let front = kl.hypot(1.0) * (kl - kl.atan() - zeta).cos();
        assert!(front > zeta.cos() - 1e-12, "{slalom:?}: {front}");
    }
    // on the course itself, with a swing so small that slopes are: both clear by A cos ζ
    let slalom = Slalom {
        amplitude: 1e-4,
        ..Slalom::default()
    };
    let course = slalom.course();
    let cone = course.cones()[8];
    let y = |x: f64| course.at(course.locate(x, 0.0, x).arc_length);
    let rear = y(cone.x).y;
    let back = y(cone.x - slalom.wheelbase);
    let front = back.y + slalom.wheelbase * back.heading;
    let share = 1e-4 * (PI * slalom.lead()).cos();
    // squares of the slope: 1e-7 of the swing
    assert!((cone.side * rear - share).abs() < 1e-9, "{rear} {share}");
    assert!((cone.side * front - share).abs() < 1e-9, "{front} {share}");
    assert!((share / 1e-4 - 0.825).abs() < 1e-3);
}
