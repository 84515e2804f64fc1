//! Jumps taken exactly, against motions solved by hand: the bicycle made a mass on a spring.

use bicycle::sensitivity::{Direction, output_along};
use bicycle::simulate::Simulation;
use bicycle::{Bicycle, Formulation, Input, Parameters};

const INERTIA: f64 = 0.14;
const STIFFNESS: f64 = 7.0;
const LEAN: f64 = 0.05;
const START: f64 = 0.53;

/// A bicycle whose fork is a mass on a spring between two jumps,
/// `I θ̈ = −k θ − B sign θ − d sign θ̇ + τ`: no trail, no caster, no gyroscopes, no tyre forces, and a
/// body too heavy to roll, leant so that its front load on r_f sin φ makes B.
fn spring(coulomb_friction: f64, internal_step: f64) -> Parameters {
    Parameters {
        internal_step,
        coulomb_friction,
        steer_smoothing: 0.0,
        steer_rate_smoothing: 0.0,
        steer_inertia: INERTIA,
        rider_steer_gain: STIFFNESS,
        roll_start: LEAN,
        steer_start: START,
        caster_angle: 0.0,
        trail: 0.0,
        front_wheel_inertia: 0.0,
        rear_wheel_inertia: 0.0,
        viscous_friction: 0.0,
        cornering_stiffness: 0.0,
        camber_stiffness: 0.0,
        cog_height: 0.0,
        cross_inertia: 0.0,
        roll_inertia: 1e300,
        ..Parameters::default().riderless()
    }
}

fn ride(p: &Parameters) -> Simulation {
    Simulation::new(p, Formulation::Repaired, Input::default(), 0.0).expect("a stable step")
}

/// B of [`spring`] [N m]: F_z r_f sin² φ, by (2) and (9).
fn contact_moment(p: &Parameters) -> f64 {
    Bicycle::new(p, Formulation::Repaired).front_load * p.front_wheel_radius * LEAN.sin().powi(2)
}

/// θ(t) of [`spring`] let go at [`START`], arc by arc; then where and when it comes to rest.
struct Arcs {
    /// Begin [s], sense of turning, angle × sense at the centre, radius, phase at the begin.
    pieces: Vec<[f64; 5]>,
    rest: f64,
    rest_time: f64,
}

const OMEGA_2: f64 = STIFFNESS / INERTIA;

impl Arcs {
    fn of(p: &Parameters) -> Self {
        let (b, d) = (
            contact_moment(p) / STIFFNESS,
            p.coulomb_friction / STIFFNESS,
        );
        let omega = OMEGA_2.sqrt();
        let mut pieces = Vec::new();
        let (mut time, mut sense, mut y, mut rate) = (0.0, -1.0, -START, 0.0f64);
        // y = sense · θ rises towards its turning point: y'' = −ω² (y + b sign y + d)
        loop {
            let at_rest = rate == 0.0;
            if at_rest && (y.abs() + b <= d || y.abs() < 1e-13) {
                return Self {
                    pieces,
                    rest: sense * y,
                    rest_time: time,
                };
            }
            let centre = -(b * if y < 0.0 { -1.0 } else { 1.0 } + d);
            let radius = (y - centre).hypot(rate / omega);
            let phase = ((y - centre) / radius).clamp(-1.0, 1.0).acos();
            pieces.push([time, sense, centre, radius, phase]);
            let crossing = -centre / radius;
            if y < 0.0 && crossing <= 1.0 {
                let turned = phase - crossing.acos();
                (time, y) = (time + turned / omega, 0.0);
                rate = omega * radius * (1.0 - crossing * crossing).sqrt();
            } else {
                time += phase / omega;
                (sense, y, rate) = (-sense, -(centre + radius), 0.0);
            }
        }
    }

    fn steer(&self, t: f64) -> f64 {
        if t >= self.rest_time {
            return self.rest;
        }
        let last = self.pieces.iter().rfind(|arc| arc[0] <= t);
        let [begin, sense, centre, radius, phase] = *last.expect("an arc from 0 on");
        sense * (centre + radius * (OMEGA_2.sqrt() * (t - begin) - phase).cos())
    }
}

/// Largest error of θ [rad] in `seconds`, looked at every 10 ms, and the ride.
fn error(p: &Parameters, seconds: u32) -> (f64, Simulation) {
    let (arcs, mut ride) = (Arcs::of(p), ride(p));
    let mut largest = 0.0f64;
    for k in 1..=100 * seconds {
        ride.advance(f64::from(k) * 0.01).expect("no stop");
        largest = largest.max((ride.state().steer - arcs.steer(ride.time())).abs());
    }
    (largest, ride)
}

/// Friction stronger than the jump of sign θ, which brings the fork to rest away from the centre
/// after thirteen arcs, and weaker.
#[test]
fn order_is_four_across_events() {
    for friction in [0.35, 0.15] {
        let steps = [16e-3, 8e-3, 4e-3, 2e-3, 1e-3];
        let errors = steps.map(|step| error(&spring(friction, step), 3).0);
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            // 3.96 to 4.00 are seen: the next order's term
            assert!((3.9..4.1).contains(&order), "{order} from {errors:?}");
        }
        assert!(errors[4] < 2e-10, "{errors:?}");
    }
}

#[test]
fn a_fork_sticks_where_friction_holds_it() {
    let p = spring(0.35, 1e-3);
    let arcs = Arcs::of(&p);
    let (_, ride) = error(&p, 3);
    assert!(arcs.rest_time < 3.0 && arcs.rest > 5e-3);
    assert_eq!(ride.state().steer_rate, 0.0);
    // the error of RK4 over 2.9 s, as above
    assert!((ride.state().steer - arcs.rest).abs() < 1e-10);
}

/// Where friction is the weaker jump the arcs shrink by a constant factor, endlessly many of them
/// in finite time: the fork comes to rest all the same, straight, and the work is bounded.
#[test]
fn a_fork_that_swings_between_jumps_comes_to_rest() {
    let p = spring(0.15, 1e-3);
    let arcs = Arcs::of(&p);
    let (largest, mut ride) = error(&p, 7);
    assert!(arcs.rest_time < 6.3, "{}", arcs.rest_time);
    assert_eq!((ride.state().steer, ride.state().steer_rate), (0.0, 0.0));
    // what was left of the swing when the pieces of a step were used up: B/I (h/16)²/8 = 1e-9 rad
    assert!(largest < 2e-9, "{largest}");
    // 4 a step without events; 8 more in each of 712 steps at rest; some 70 events, of ten pieces as
    // a rule and of 46 at the end
    let work = ride.derivatives();
    assert!(work < 28_000 + 8 * 712 + 70 * 4 * 25, "{work}");
    // and at rest it stays
    ride.advance(9.0).expect("no stop");
    assert_eq!((ride.state().steer, ride.state().steer_rate), (0.0, 0.0));
    assert!(ride.derivatives() - work <= 2000 * 12);
}

/// The nominal bicycle, nobody steering.
fn riderless() -> Parameters {
    Parameters {
        steer_smoothing: 0.0,
        steer_rate_smoothing: 0.0,
        ..Parameters::default().riderless()
    }
}

fn torque(steer_torque: f64) -> Input {
    Input {
        steer_torque,
        ..Input::default()
    }
}

/// A torque that changes, nothing else.
fn per_second(steer_torque: f64) -> Input {
    Input {
        steer_torque,
        ..Input::ZERO
    }
}

#[test]
fn less_than_friction_moves_nothing() {
    let p = riderless();
    let d = p.coulomb_friction;
    for (share, moves) in [
        (0.999, false),
        (-0.999, false),
        (1.001, true),
        (-1.001, true),
    ] {
        let mut ride = ride(&p);
        ride.set_input(torque(share * d)).expect("the same speed");
        ride.advance(0.5).expect("no fall");
        let x = ride.state();
        if moves {
            assert!(x.steer * share > 0.0 && x.steer_rate * share > 0.0);
        } else {
            let still = [x.steer, x.steer_rate, x.roll, x.yaw_rate].map(f64::to_bits);
            assert_eq!(still, [0; 4]);
        }
    }
}

/// A bicycle leans over while friction holds its fork, until the fork breaks away to the side of
/// the lean.
#[test]
fn a_held_fork_breaks_away() {
    let p = Parameters {
        roll_start: 1e-3,
        steer_start: 0.3e-3,
        ..riderless()
    };
    let d = p.coulomb_friction;
    let mut ride = ride(&p);
    let mut held = 0;
    let mut last = (0.0, ride.state().roll);
    for k in 1..=1000 {
        let b = *ride.bicycle();
        let free = Parameters {
            coulomb_friction: 0.0,
            ..p
        };
        let x = *ride.state();
        let seen = bicycle::simulate::output(
            &Bicycle::new(&free, Formulation::Repaired),
            &x,
            ride.path(),
            &ride.input(),
        );
        // θ̈ without friction; steer_rate is 0 as long as it holds
        let net = seen.steer_acceleration * b.steering_inertia;
        if x.steer_rate == 0.0 {
            assert!(net.abs() <= d, "{net} N m at {} s", ride.time());
            assert_eq!(x.steer.to_bits(), p.steer_start.to_bits());
            assert_eq!(ride.output().steer_acceleration, 0.0);
            assert!(x.roll.abs() >= last.1.abs());
            held = k;
        }
        last = (net, x.roll);
        if x.steer_rate != 0.0 {
            break;
        }
        ride.advance(f64::from(k) * 1e-3).expect("no fall");
    }
    assert!((100..900).contains(&held), "{held} ms");
    // it has moved for less than a step
    assert!(last.0.abs() > d && ride.state().steer_rate.abs() < 1e-3);
    assert!(ride.state().steer_rate < 0.0 && ride.state().roll > 0.0);
}

/// Break-away on a slow ramp of the torque, at the instant when it exceeds d.
#[test]
fn a_ramp_breaks_away_in_time() {
    let p = Parameters {
        rider_steer_gain: 0.0,
        steer_start: 0.0,
        roll_start: 0.0,
        ..spring(0.15, 1e-3)
    };
    for slope in [0.1234, -0.4321] {
        let mut ride = ride(&p);
        ride.set(&p, torque(0.0), per_second(slope))
            .expect("the same speed");
        let breaks_away = p.coulomb_friction / slope.abs();
        ride.advance(breaks_away - 1e-9).expect("no stop");
        assert_eq!(ride.state().steer_rate, 0.0);
        // I θ̈ = slope (t − t_b) from there, which RK4 integrates without error: the instant is in θ
        ride.advance(breaks_away + 0.1).expect("no stop");
        let moving = (6.0 * INERTIA * ride.state().steer / slope).cbrt();
        // a tenth of what is asked for: t_b itself rounds by 2e-16 s
        assert!((moving - 0.1).abs() < 1e-10, "{moving} s");
    }
}

/// What is seen of a held fork, and how that changes: nothing turns it, whichever way one looks.
#[test]
fn a_held_fork_is_seen_at_rest() {
    let p = Parameters {
        steer_start: 1e-4,
        roll_start: 5e-4,
        roll_rate_start: 1e-2,
        ..riderless()
    };
    let mut ride = ride(&p);
    ride.advance(0.0105).expect("no fall");
    let along = |ride: &Simulation| {
        let push = Direction {
            input: per_second(1.0),
            ..Direction::ZERO
        };
        let (b, u) = (ride.bicycle(), ride.input());
        output_along(b, ride.state(), ride.path(), &u, &push)
    };
    let (seen, rate) = (ride.output(), ride.output_rate());
    assert_eq!((seen.steer, seen.steer_rate), (p.steer_start, 0.0));
    assert_eq!(
        (seen.steer_acceleration, rate.steer_acceleration),
        (0.0, 0.0)
    );
    assert_eq!((rate.steer, rate.steer_rate), (0.0, 0.0));
    assert_eq!(along(&ride).steer_acceleration, 0.0);
    // everything else goes on
    assert_eq!(rate.roll_rate, seen.roll_acceleration);
    assert!(seen.roll_acceleration != 0.0 && seen.yaw_acceleration != 0.0);
    // pushed, it gives way at once, and by what the push has too much
    ride.set_input(torque(1.0)).expect("the same speed");
    let inertia = ride.bicycle().steering_inertia;
    assert!(ride.output().steer_acceleration > 0.0);
    assert!((along(&ride).steer_acceleration * inertia - 1.0).abs() < 1e-14);
}

/// The stiffest tyre at walking pace, pushed to and fro, at the default step: stable, as precise as
/// steps of a tenth, and not by stealth.
#[test]
fn stiff_tyres_at_walking_pace_are_stable() {
    for cornering_stiffness in [10.0, 20.0, 30.0, 40.0] {
        let [whole, tenth] = [1e-3, 1e-4].map(|internal_step| {
            let p = Parameters {
                cornering_stiffness,
                internal_step,
                steer_smoothing: 0.0,
                steer_rate_smoothing: 0.0,
                ..Parameters::default()
            };
            let mut input = Input {
                speed: 1.0,
                ..torque(4.0)
            };
            let mut ride =
                Simulation::new(&p, Formulation::Repaired, input, 0.0).expect("a stable step");
            for k in 1..=10 {
                ride.advance(0.5 * f64::from(k)).expect("no fall");
                input.steer_torque = -input.steer_torque;
                ride.set_input(input).expect("the same speed");
            }
            ride
        });
        let moved = (whole.state().steer - tenth.state().steer).abs();
        // 3e-10 rad of .85 are seen; an unstable step would leave nothing of it
        assert!(moved < 1e-9, "{moved} rad at {cornering_stiffness} 1/rad");
        // four derivatives a step, or 4000 per second, and less than a fifth more for the events
        for (ride, steps) in [(whole, 5_000), (tenth, 50_000)] {
            let work = ride.derivatives();
            assert!((4 * steps..4 * steps * 6 / 5).contains(&work), "{work}");
        }
    }
}

fn seen(ride: &Simulation) -> [u64; 18] {
    let output = ride.output().to_array();
    std::array::from_fn(|i| output[i].to_bits())
}

/// Two rides to the same bits: one looked at, saved and cloned all the time, on the grid
/// and off it, moving and held; the other not.
#[test]
fn looking_changes_nothing() {
    let p = Parameters {
        steer_smoothing: 0.0,
        steer_rate_smoothing: 0.0,
        roll_start: -0.02,
        ..Parameters::default()
    };
    let (mut one, mut other) = (ride(&p), ride(&p));
    let mut held = 0;
    for k in 1..=2000 {
        let t = f64::from(k) * 1.7e-3;
        let text = serde_json::to_string(&other).expect("numbers");
        other = serde_json::from_str(&text).expect("what was saved");
        let mut ahead = other.clone();
        ahead.advance(t + 0.3e-3).expect("no fall");
        other.advance(t).expect("no fall");
        held += u32::from(other.state().steer_rate == 0.0);
        if k % 500 == 0 {
            one.advance(t).expect("no fall");
            assert_eq!(seen(&one), seen(&other), "{t} s");
        }
    }
    assert!((200..1800).contains(&held), "{held} of 2000");
    // and what changes at the same instants
    for ride in [&mut one, &mut other] {
        ride.set_input(torque(0.8)).expect("the same speed");
    }
    other.advance(3.41234).expect("no fall");
    for ride in [&mut one, &mut other] {
        ride.advance(4.0).expect("no fall");
    }
    assert_eq!(seen(&one), seen(&other));
}
