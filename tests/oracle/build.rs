//! Sets the path at which the test finds libpython: that of the interpreter of its virtual environment.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    pyo3_build_config::add_libpython_rpath_link_args();
}
