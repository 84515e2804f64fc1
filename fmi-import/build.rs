//! Compiles the variadic logger, which Rust can call but not define.

fn main() {
    println!("cargo::rerun-if-changed=src/logger.c");
    cc::Build::new()
        .file("src/logger.c")
        // no library that this crate becomes a part of exports it
        .flag_if_supported("-fvisibility=hidden")
        .compile("fmi_import_logger");
}
