//! Loaded and unloaded many times: alone in its process, for it looks at the whole of it.
#![cfg(target_os = "linux")]

#[path = "foreign/build.rs"]
mod build;

use build::Variant;

/// Memory in use, in pages.
fn resident() -> u64 {
    let statm = std::fs::read_to_string("/proc/self/statm").expect("readable");
    let pages = statm.split(' ').nth(1).expect("the second number");
    pages.parse().expect("a number")
}

/// Open files, and mappings of our library.
fn held() -> (usize, usize) {
    let files = std::fs::read_dir("/proc/self/fd")
        .expect("readable")
        .count();
    let maps = std::fs::read_to_string("/proc/self/maps").expect("readable");
    (files, maps.matches("foreign.so").count())
}

#[test]
fn nothing_grows() {
    let cycle = || {
        let fmu = Variant::default().load();
        let mass = build::reference(&fmu, "mass");
        let mut instances = [(); 10].map(|()| fmu.instantiate("swing").expect("an instance"));
        for instance in &mut instances {
            instance.enter_initialization_mode().expect("entered");
            let saved = instance.get_fmu_state().expect("saved");
            instance.set_real(&[mass], &[1.0]).expect("set");
            instance.set_fmu_state(&saved).expect("restored");
            instance.serialize_fmu_state(&saved).expect("written");
        }
    };
    // the allocator and the loader fill their caches first
    (0..100).for_each(|_| cycle());
    let (before, had) = (resident(), held());
    (0..1100).for_each(|_| cycle());
    assert_eq!(held(), had);
    assert_eq!(had.1, 0, "unloaded");
    // A page for every tenth instance would be 1100; what the allocator keeps is less.
    let after = resident();
    assert!(after < before + 256, "{before} to {after} pages");
}
