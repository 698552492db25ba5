//! Lets the test find libpython where the interpreter of its virtual environment has it.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    pyo3_build_config::add_libpython_rpath_link_args();
}
