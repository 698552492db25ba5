//! Lets the oracle's test find libpython where the interpreter of its virtual environment has it; otherwise it does nothing.

fn main() {
    println!("cargo::rerun-if-changed=tests/oracle/build.rs");
    #[cfg(feature = "oracle")]
    pyo3_build_config::add_libpython_rpath_link_args();
}
