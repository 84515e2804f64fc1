//! scratch
use bicycle::simulate::{Simulation, Stop};
use bicycle::{Formulation, Input, Parameters, cases};

pub fn oscillator(internal_step: f64) -> Parameters {
    Parameters {
        internal_step,
        cog_height: 0.0, cross_inertia: 0.0, caster_angle: 0.0, trail: 0.0,
        front_wheel_inertia: 0.0, rear_wheel_inertia: 0.0, viscous_friction: 0.0,
        steer_inertia: 0.14, coulomb_friction: 0.35, rider_steer_gain: 7.0,
        steer_smoothing: 1e-3, steer_rate_smoothing: 0.0,
        steer_start: 0.53,
        ..Parameters::default().riderless()
    }
}

fn closed(t: f64, mut a: f64, offset: f64, omega: f64) -> f64 {
    let mut t = omega * t;
    let pi = std::f64::consts::PI;
    loop {
        if a.abs() <= offset { return a }
        let c = offset * a.signum();
        if t <= pi { return c + (a - c) * t.cos() }
        a = 2.0 * c - a;
        t -= pi;
    }
}

#[test]
fn scratch_order() {
    let mut last = 0.0;
    for n in 0..12 {
        let h = 0.032 * 0.5f64.powf(n as f64 * 0.5);
        let p = Parameters { rider_steer_gain: 7.0, ..oscillator(h) };
        let mut r = Simulation::new(&p, Formulation::Repaired, Input::default(), 0.0).unwrap();
        let omega = (7.0f64 / 0.14).sqrt();
        let mut e = 0.0f64; let mut k=0;
        while r.time() < 3.0 { k+=1; r.advance(k as f64 * 0.01).unwrap();
            e = e.max((r.state().steer - closed(r.time(), 0.53, 0.35/7.0, omega)).abs()); }
        println!("{h:.5} {e:.3e} order {:.2} work {} final {:?} {}", 2.0*(last/e).log2(), r.derivatives() as f64/3.0*h, r.state(), closed(3.0,0.53,0.05,omega));
        last = e;
    }
}

pub fn section3() -> Parameters {
    let mut p = Parameters {
        wheelbase: 1.015, caster_angle: 20f64.to_radians(), trail: 0.13,
        front_wheel_radius: 0.308, rear_wheel_radius: 0.308, front_wheel_mass: 3.12065,
        steer_inertia: 0.15142, front_wheel_inertia: 0.0827, rear_wheel_inertia: 0.14297,
        cornering_stiffness: 6.47596, camber_stiffness: 0.96524, viscous_friction: 0.48866, coulomb_friction: 0.17037,
        gravity: 9.81, steer_smoothing: 0.0, steer_rate_smoothing: 0.0,
        ..Parameters::default().riderless()
    };
    p.rider_roll_gain = 190.81949; p.rider_roll_rate_gain = 117.89524;
    let (m, l, h) = (73.2169, 0.68, 0.96028);
    p.total_mass = m; p.cog_to_rear = l; p.cog_height = h;
    p.roll_inertia = 14.52883 + m*h*h; p.yaw_inertia = 8.8278 + m*l*l; p.cross_inertia = -3.027 + m*l*h;
    p
}

#[test]
fn scratch_cases() {
    for (st, rt) in [(0.0,0.0),(1e-3,1e-2),(0.0,1e-2),(1e-3,0.0)] {
    for h in [1e-3, 1e-4] {
        for case in cases::all() {
            let p = Parameters { internal_step: h, steer_smoothing: st, steer_rate_smoothing: rt, ..section3() };
            let c = case.run(&p, Formulation::Repaired, Input::default(), 1e-3).unwrap();
            let mut r = Simulation::new(&case.parameters(&p), Formulation::Repaired, Input::default(), 0.0).unwrap();
            let mut alt=0; let mut prev=0.0; let mut pp=0.0; let mut held=0; let mut k=0;
            while r.time()<5.0 && r.stop().is_none() { k+=1; let _=r.advance(k as f64*h); let s=r.state().steer_rate; if s==0.0 {held+=1}
               if s*prev<0.0 && prev*pp<0.0 {alt+=1;} pp=prev; prev=s; }
            println!("{st} {rt} {h} case {} amp {:?} end {:.5} extra work {:.1}/s alt {alt} held {held}", case.number, c.amplitude().map(f64::to_degrees), c.end_time(), (r.derivatives() as f64 - 4.0*k as f64)/r.time());
        }
    }}
}

#[test]
fn scratch_90() {
    for deg in [85.0f64, 89.0, 90.0, 90.001, 90.5] {
    for case in &cases::all()[6..] {
        print!("{deg} case {}:", case.number);
        for h in [2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5] {
            let p = Parameters { internal_step: h, steer_limit: deg.to_radians(), ..section3() };
            let c = case.run(&p, Formulation::Repaired, Input::default(), 0.1).unwrap();
            print!(" {:.6}{}", c.end_time(), c.stop.map_or("-", Stop::name).chars().next().unwrap());
        }
        println!();
    }}
}
