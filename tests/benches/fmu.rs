//! What the interface costs, as ratios in one run:
//! `cargo build --release -p fmi-export --examples`, then
//! `cargo bench -p tests --no-default-features --features benchmarks`.
//!
//! Libraries are loaded as an importer loads them, so that nothing is inlined that would not be.

mod library;

use bicycle::simulate::Simulation;
use bicycle::{Formulation, Input, Parameters};
use divan::{Bencher, black_box};
use library::{Instance, Library, c_library, rust_example};
use std::time::Instant;
use tests::Slave;

/// Communication step of a ride [s], and how many make one of 24 s.
const STEP: f64 = 0.005;
const STEPS: u32 = 4800;

/// A roll moment [N·m] under which the bicycle leans and turns for ever: at rest, sines are cheap.
const LEANING: f64 = 5.0;

fn main() {
    divan::main();
    if std::env::args().any(|argument| argument == "--bench") {
        ratios();
    }
}

fn native() -> Simulation {
    let parameters = Parameters {
        roll_start: 0.02,
        ..Parameters::default()
    };
    let input = Input {
        roll_moment: LEANING,
        ..Input::default()
    };
    Simulation::new(&parameters, Formulation::Repaired, input, 0.0).expect("started")
}

fn internal_step() -> f64 {
    Parameters::default().internal_step
}

/// A bicycle behind the C interface.
struct Behind<'a> {
    instance: Instance<'a>,
    steps: u32,
    torque: u32,
    seen: [u32; 5],
}

impl<'a> Behind<'a> {
    fn new(library: &'a Library) -> Self {
        let instance = library.instantiate(&tests::bicycle().guid);
        instance.set(Slave::reference("roll_start"), 0.02);
        instance.set(Slave::reference("roll_moment"), LEANING);
        instance.initialize();
        Self {
            instance,
            steps: 0,
            torque: Slave::reference("assist_torque"),
            seen: ["roll", "steer", "roll_rate", "steer_rate", "yaw_rate"].map(Slave::reference),
        }
    }

    fn step(&mut self, h: f64) {
        self.instance.step(f64::from(self.steps) * h, h);
        self.steps += 1;
    }

    fn set_step_get(&mut self, torque: f64, h: f64) -> f64 {
        self.instance.set(self.torque, torque);
        self.step(h);
        self.instance.get(self.seen[1])
    }

    /// One step of a ride under a changing torque; the sum of what was seen.
    fn ride_step(&self, n: u32) -> f64 {
        let mut values = [0.0; 5];
        self.instance.set(self.torque, torque(n));
        self.instance.step(f64::from(n) * STEP, STEP);
        self.instance.get_many(&self.seen, &mut values);
        values.iter().sum()
    }

    fn ride(&self) -> f64 {
        (0..STEPS).map(|n| self.ride_step(n)).sum()
    }
}

/// Another value each step, too small to upset anybody.
fn torque(n: u32) -> f64 {
    1e-3 * f64::from(n % 16)
}

/// The same without the interface.
fn native_step(simulation: &mut Simulation, n: u32) -> f64 {
    let input = Input {
        assist_torque: torque(n),
        roll_moment: LEANING,
        ..Input::default()
    };
    simulation.set_input(input).expect("accepted");
    let arrival = f64::from(n) * STEP + STEP;
    simulation.advance(arrival).expect("arrived");
    let x = simulation.state();
    x.roll + x.steer + x.roll_rate + x.steer_rate + x.yaw_rate
}

fn native_ride() -> f64 {
    let mut simulation = native();
    (0..STEPS).map(|n| native_step(&mut simulation, n)).sum()
}

/// Angles of a ride.
fn angles() -> impl Iterator<Item = f64> {
    (-64..64).map(|n| 0.01 * f64::from(n))
}

/// 128 sines and cosines as the equations take them, the same bits everywhere.
#[divan::bench]
fn sin_cos_ours() -> f64 {
    let both = angles().map(|x| bicycle::Real::sin_cos(black_box(x)));
    both.map(|(sin, cos)| sin + cos).sum()
}

/// 128 of the platform's.
#[divan::bench]
fn sin_cos_platform() -> f64 {
    let both = angles().map(|x| f64::sin_cos(black_box(x)));
    both.map(|(sin, cos)| sin + cos).sum()
}

/// 128 arctangents as the equations take them.
#[divan::bench]
fn atan_ours() -> f64 {
    angles().map(|x| bicycle::Real::atan(black_box(x))).sum()
}

/// 128 of the platform's.
#[divan::bench]
fn atan_platform() -> f64 {
    angles().map(|x| f64::atan(black_box(x))).sum()
}

/// Ten seconds of a bicycle on its own at 1 kHz.
#[divan::bench(args = ["repaired", "whipple", "whipple_slip"])]
fn ten_seconds(name: &str) -> f64 {
    let formulation: Formulation = name.parse().expect("a formulation");
    let parameters = Parameters {
        roll_start: 0.02,
        ..Parameters::default()
    };
    let mut ride =
        Simulation::new(&parameters, formulation, Input::default(), 0.0).expect("nominal");
    ride.advance(10.0).expect("the rider stands it up");
    ride.state().roll
}

#[divan::bench]
fn bare_step(bencher: Bencher) {
    let (mut simulation, h) = (native(), internal_step());
    let mut n = 0;
    bencher.bench_local(|| {
        n += 1;
        simulation.advance(f64::from(n) * h)
    });
}

#[divan::bench]
fn do_step(bencher: Bencher) {
    let library = Library::bicycle();
    let (mut behind, h) = (Behind::new(&library), internal_step());
    bencher.bench_local(|| behind.step(h));
}

#[divan::bench]
fn set_step_get(bencher: Bencher) {
    let library = Library::bicycle();
    let (mut behind, h) = (Behind::new(&library), internal_step());
    let mut n = 0;
    bencher.bench_local(|| {
        n += 1;
        behind.set_step_get(torque(n), h)
    });
}

#[divan::bench]
fn set_alone(bencher: Bencher) {
    let library = Library::bicycle();
    let behind = Behind::new(&library);
    let mut n = 0;
    bencher.bench_local(|| {
        n += 1;
        behind.instance.set(behind.torque, torque(n));
    });
}

#[divan::bench(args = ["steer", "roll_acceleration", "trail", "loaded_mass"])]
fn get_alone(bencher: Bencher, name: &str) {
    let library = Library::bicycle();
    let (behind, reference) = (Behind::new(&library), Slave::reference(name));
    bencher.bench_local(|| behind.instance.get(reference));
}

#[divan::bench]
fn get_state_in_place(bencher: Bencher) {
    let library = Library::bicycle();
    let mut behind = Behind::new(&library);
    bencher.bench_local(|| behind.instance.save());
}

#[divan::bench]
fn set_state(bencher: Bencher) {
    let library = Library::bicycle();
    let mut behind = Behind::new(&library);
    behind.instance.save();
    bencher.bench_local(|| behind.instance.restore());
}

#[divan::bench]
fn instantiate_and_free(bencher: Bencher) {
    let library = Library::bicycle();
    bencher.bench_local(|| drop(library.instantiate(&tests::bicycle().guid)));
}

#[divan::bench]
fn instantiate_and_free_beside_another(bencher: Bencher) {
    let library = Library::bicycle();
    let _other = Behind::new(&library);
    bencher.bench_local(|| drop(library.instantiate(&tests::bicycle().guid)));
}

/// Contenders and the best time of each for one call [ns]: in turns, so that what else the machine
/// does hits all of them, and the best, because it can only be disturbed upwards.
fn race<const N: usize>(calls: u32, mut contenders: [&mut dyn FnMut(); N]) -> [f64; N] {
    const ROUNDS: usize = 200;
    let mut best = [f64::INFINITY; N];
    for _ in 0..ROUNDS {
        for (best, contender) in best.iter_mut().zip(&mut contenders) {
            let start = Instant::now();
            for _ in 0..calls {
                contender();
            }
            *best = best.min(start.elapsed().as_secs_f64() * 1e9 / f64::from(calls));
        }
    }
    best
}

#[expect(clippy::print_stdout, reason = "what a benchmark is for")]
fn ratios() {
    let library = Library::bicycle();
    let h = internal_step();
    let (mut simulation, mut stepped, mut looked) =
        (native(), Behind::new(&library), Behind::new(&library));
    let (mut n, mut m) = (0, 0);
    let [bare, step, looked] = race(
        2000,
        [
            &mut || {
                n += 1;
                simulation.advance(f64::from(n) * h).expect("arrived");
            },
            &mut || stepped.step(h),
            &mut || {
                m += 1;
                black_box(looked.set_step_get(torque(m), h));
            },
        ],
    );
    println!("bare step {bare:.0} ns, fmi2DoStep {:+.1} ns", step - bare);
    println!("set + step + get {:+.1} ns", looked - bare);

    let behind = Behind::new(&library);
    assert_eq!(native_ride().to_bits(), behind.ride().to_bits());
    let (mut simulation, behind) = (native(), Behind::new(&library));
    let (mut n, mut m) = (0, 0);
    // Not the whole ride at once: shorter than what the machine grants at a time.
    let [native, through] = race(
        200,
        [
            &mut || {
                black_box(native_step(&mut simulation, n));
                n += 1;
            },
            &mut || {
                black_box(behind.ride_step(m));
                m += 1;
            },
        ],
    );
    println!(
        "a ride in steps of {STEP} s: native {:.2} µs a step, through the interface {:+.1} %",
        native * 1e-3,
        100.0 * (through / native - 1.0)
    );

    let (Some(c), Some(rust)) = (c_library(), rust_example("van_der_pol")) else {
        println!("Van der Pol: not compared, the C compiler or the built example is missing");
        return;
    };
    let guid = library::example_guid("van_der_pol");
    let (c, rust) = (c.instantiate_c(), rust.instantiate(&guid));
    rust.initialize();
    let look = |instance: &Instance| {
        let mut x = [0.0; 2];
        instance.get_many(&[1, 2], &mut x);
        black_box(x);
    };
    let go_on = |instance: &Instance, n: &mut u32| {
        instance.step(f64::from(*n) * 0.01, 0.01);
        *n += 1;
    };
    let [mut n, mut m] = [0; 2];
    let [c_step, rust_step] = race(
        2000,
        [&mut || go_on(&c, &mut n), &mut || go_on(&rust, &mut m)],
    );
    let [c_look, rust_look] = race(2000, [&mut || look(&c), &mut || look(&rust)]);
    let [c, rust] = [c_step + c_look, rust_step + rust_look];
    println!("fmi2DoStep: C {c_step:.1} ns, ours {rust_step:.1} ns");
    println!("fmi2GetReal of two: C {c_look:.1} ns, ours {rust_look:.1} ns");
    println!(
        "Van der Pol: C {c:.1} ns a step, ours {rust:.1} ns, ratio {:.2}",
        rust / c
    );
}
