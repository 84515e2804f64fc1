//! What a sweep of 1000 speeds costs, eigenvalues named and carried:
//! `cargo bench -p tests --bench modes --no-default-features --features benchmarks`.

use bicycle::modes::{crossings, over_speeds};
use bicycle::{Bicycle, Formulation, Parameters};
use divan::{Bencher, black_box};

fn main() {
    divan::main();
}

fn riderless(formulation: Formulation) -> Bicycle {
    Bicycle::new(&Parameters::default().riderless(), formulation)
}

#[divan::bench(args = [Formulation::Repaired, Formulation::Whipple, Formulation::WhippleSlip])]
fn sweep(bencher: Bencher, formulation: Formulation) {
    let b = riderless(formulation);
    let speeds: Vec<f64> = (1..=1000).map(|i| 0.01 * f64::from(i)).collect();
    bencher.bench_local(|| over_speeds(black_box(&b), &speeds));
}

#[divan::bench]
fn weave_and_capsize_speed(bencher: Bencher) {
    let b = riderless(Formulation::Whipple);
    bencher.bench_local(|| crossings(black_box(&b), 0.01, 10.0));
}
