//! What stays behind: nothing, whatever comes and goes. In a process of its own, so that no other
//! test's memory is counted; read from /proc, so on Linux only.
#![cfg(target_os = "linux")]

use fmi_import::Fmu;
use fmi2::fmi2OK;
use std::process::Command;
use std::sync::{Mutex, MutexGuard, PoisonError};
use tests::{Slave, State};

/// The tests of this file count the memory of the whole process: one at a time.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What the process holds.
#[derive(Debug)]
struct Holdings {
    /// Memory that is resident \[kB\].
    resident: u64,
    threads: usize,
    files: usize,
    /// Mapped libraries of FMUs.
    libraries: usize,
}

impl Holdings {
    fn now() -> Self {
        let count = |folder| std::fs::read_dir(folder).expect("Linux").count();
        let status = std::fs::read_to_string("/proc/self/status").expect("Linux");
        let resident = status
            .lines()
            .find_map(|line| line.strip_prefix("VmRSS:"))
            .and_then(|rest| rest.trim().strip_suffix(" kB"))
            .expect("VmRSS in kB");
        let maps = std::fs::read_to_string("/proc/self/maps").expect("Linux");
        Self {
            resident: resident.parse().expect("a number"),
            threads: count("/proc/self/task"),
            files: count("/proc/self/fd"),
            libraries: maps.matches("RearLoadBicycle").count(),
        }
    }
}

/// Runs `cycle` so many times, and a tenth as many before, until caches and the allocator's pools
/// are full. `bound` is in kB.
#[track_caller]
fn check(cycles: u32, bound: u64, mut cycle: impl FnMut()) {
    for _ in 0..cycles / 10 {
        cycle();
    }
    let before = Holdings::now();
    for _ in 0..cycles {
        cycle();
    }
    let after = Holdings::now();
    assert!(
        after.resident <= before.resident + bound,
        "{before:?} grew to {after:?}"
    );
    // The test harness may start a thread for another test of this file in between, which then
    // waits.
    assert!(
        after.threads <= before.threads.max(TESTS + 1),
        "{before:?} grew to {after:?}"
    );
    assert_eq!(after.files, before.files);
    assert_eq!((before.libraries, after.libraries), (0, 0));
}

/// Number of tests below.
const TESTS: usize = 3;

/// The smallest leak there can be, one block of the allocator (32 bytes) in each of 10 000 cycles,
/// makes 312 kB; what the allocator and the harness need by chance is less than this.
const LESS_THAN_ONE_BLOCK_EACH: u64 = 256;

#[test]
fn instances_come_and_go() {
    let _alone = alone();
    check(10_000, LESS_THAN_ONE_BLOCK_EACH, || {
        let slave = Slave::reach(State::StepComplete);
        let bytes = slave.bytes();
        // saved states that nobody frees go with the last instance
        slave.save();
        let mut read = std::ptr::null_mut();
        assert_eq!(slave.read(&bytes, &mut read), fmi2OK);
        // refused calls leave nothing
        slave.set("time", f64::NAN);
        slave.read(&bytes[1..], &mut std::ptr::null_mut());
        Slave::lines();
    });
}

#[test]
fn instances_come_and_go_while_another_stays() {
    let _alone = alone();
    let keeper = Slave::reach(State::StepComplete);
    check(10_000, LESS_THAN_ONE_BLOCK_EACH, || {
        let mut slave = Slave::reach(State::Initialization);
        slave.saved = slave.save();
        let other = slave.save();
        keeper.forget(other);
        Slave::lines();
    });
}

#[test]
fn libraries_come_and_go() {
    let _alone = alone();
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("RearLoadBicycle.fmu");
    let library = folder.path().join("library");
    let built = fmu::built_library().expect("cargo builds it as a dependency");
    // Without its line tables there is a tenth to unpack; where the tool is missing it takes longer.
    let stripped = Command::new("strip")
        .arg("-g")
        .arg("-o")
        .args([&library, &built])
        .status();
    if !stripped.is_ok_and(|status| status.success()) {
        std::fs::copy(built, &library).expect("copied");
    }
    fmu::pack(&library, &path).expect("packed");
    // The smallest leak of a library is a page of its writable data: 4 kB in each of 1100 cycles.
    check(1_100, 4_000, || {
        let fmu = Fmu::open(&path).expect("loaded");
        let mut instance = fmu.instantiate("bicycle").expect("an instance");
        instance.setup_experiment(None, 0.0, None).expect("obeyed");
        instance.enter_initialization_mode().expect("obeyed");
        instance.exit_initialization_mode().expect("obeyed");
        instance.do_step(0.0, 0.005).expect("a step");
        let state = instance.get_fmu_state().expect("a state");
        instance.set_fmu_state(&state).expect("set");
    });
}
