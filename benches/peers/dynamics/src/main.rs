//! The share of the Rust libraries in the comparison: values and times of `aghf` and `dynibo` on one robot.
//!
//! ```text
//! aghf-peers-dynamics ROBOT values    results of aghf at the first states, one line each
//! aghf-peers-dynamics ROBOT times S [FUNCTION]    microseconds per state, the least of several blocks of S seconds
//! aghf-peers-dynamics ROBOT dynibo S  the same of dynibo, once it agrees with aghf
//! ```
//!
//! `ROBOT.urdf` holds the robot, and `ROBOT.txt`, which `robots.py` wrote, the states.

mod ours;
mod peer;

use aghf::model::Model;
use std::error::Error;
use std::path::Path;
use std::time::Instant;

/// Anything that goes wrong ends the program.
type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Positions, velocities, accelerations and forces.
type State = [Vec<f64>; 4];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    if let Err(error) = run(&arguments) {
        eprintln!("aghf-peers-dynamics: {error}");
        std::process::exit(1);
    }
}

/// Does what the arguments say.
fn run(arguments: &[&str]) -> Result<()> {
    let [robot, what, rest @ ..] = arguments else {
        return Err("usage: ROBOT values | times SECONDS [FUNCTION] | dynibo SECONDS".into());
    };
    let urdf = Path::new(robot).with_extension("urdf");
    let (model, _) = aghf::urdf::load_urdf(&urdf)?;
    let states = read_states(&Path::new(robot).with_extension("txt"), model.dof())?;
    match (*what, rest) {
        ("values", []) => ours::values(&model, &states),
        ("times", [seconds, function @ ..]) if function.len() <= 1 => {
            ours::times(&model, &states, seconds.parse()?, function.first().copied())
        }
        ("dynibo", [seconds]) => peer::times(&urdf, model, &states, seconds.parse()?),
        _ => Err(format!("{what} is not known").into()),
    }
}

/// The states at the end of the file of a robot.
fn read_states(path: &Path, dof: usize) -> Result<Vec<State>> {
    /// Axis, placement and inertia, after the parent and the kind.
    const NUMBERS_OF_A_JOINT: usize = 3 + 12 + 13;
    let text = std::fs::read_to_string(path)?;
    let words: Vec<&str> = text.split_whitespace().collect();
    let found: usize = words.first().ok_or("the file is empty")?.parse()?;
    if found != dof {
        return Err(format!("{found} joints in {}, {dof} in the URDF", path.display()).into());
    }
    let numbers = words[2 + dof * (2 + NUMBERS_OF_A_JOINT)..].iter();
    let numbers: Vec<f64> = numbers.map(|word| word.parse()).collect::<std::result::Result<_, _>>()?;
    let states = numbers.chunks_exact(4 * dof);
    Ok(states.map(|state| std::array::from_fn(|k| state[k * dof..][..dof].to_vec())).collect())
}

/// The least time per state, in microseconds, of several blocks.
fn time<T>(states: &[T], lanes: usize, seconds: f64, mut call: impl FnMut(&T) -> Result<()>) -> Result<f64> {
    let mut least = f64::INFINITY;
    for _ in 0..6 {
        let (mut calls, mut elapsed) = (0, 0.0);
        let start = Instant::now();
        while elapsed < seconds {
            for state in states {
                call(state)?;
            }
            calls += states.len() * lanes;
            elapsed = start.elapsed().as_secs_f64();
        }
        least = least.min(1e6 * elapsed / calls as f64);
    }
    Ok(least)
}

/// The model under another gravity along its own.
fn under_gravity(model: Model, size: f64) -> Model {
    let gravity = model.gravity().normalize() * size;
    model.with_gravity(gravity)
}
