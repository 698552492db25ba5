//! Sweep files of tests.

use aghf_cli::sweep::Sweep;
use std::path::{Path, PathBuf};

/// A grid of the flow.
pub const GRID: &str = r#"
method = "flow"
scenarios = ["pendulum_2_swingup", "pendulum_3_swingup"]
time_limit_s = 600
degree = [5, 7]
k = [1e3, 1e5, 1e7]
s_max = [1, 10]
"#;

/// A list of everything that can be swept of the direct method.
pub const FULL: &str = r#"
method = "direct"
scenarios = ["kinova_obstacles_01"]
time_limit_s = 600
degree = [9, 16]
segments = [1, 2]
starts = [1, 3]
tolerance = [1e-6]
seed = [7, 8]
planned_starts = ["later"]
objective = { units = ["si"], effort = [0, 1], velocity = [0.5], acceleration = [0.1, 2] }
enforced_limits = { position = [true], velocity = [true, 0.5], torque = [false, 1.0] }
"#;

/// A folder for the files of one test.
pub fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sweep").join(test);
    std::fs::create_dir_all(&folder).expect("the folder is writable");
    folder
}

/// Writes a sweep file and loads it.
pub fn load(test: &str, text: &str) -> aghf::Result<Sweep> {
    let path = folder(test).join("grid.toml");
    std::fs::write(&path, text).expect("the folder is writable");
    Sweep::load(path.to_str().expect("it is text"))
}
