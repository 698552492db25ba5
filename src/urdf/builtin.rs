//! The built-in robots, from `robots/`.

use super::parse_urdf;
use crate::error::{Error, Result};
use crate::model::Model;

/// Names and URDF texts of the built-in robots.
macro_rules! robots {
    ($($name:literal),*) => {
        [$(($name, include_str!(concat!("../../robots/", $name, "/", $name, ".urdf")))),*]
    };
}

/// The robots, in the order of the listing.
const ROBOTS: [(&str, &str); 15] = robots!(
    "pendulum_1",
    "pendulum_2",
    "pendulum_3",
    "pendulum_4",
    "pendulum_5",
    "pendulum_6",
    "kinova_gen3",
    "kinova_gen3_2arms",
    "kinova_gen3_3arms",
    "digit_v3_pinned",
    "acrobot",
    "pendubot",
    "cart_pole",
    "planar_rotorcraft",
    "panda"
);

/// The names of the built-in robots.
pub fn builtin_robots() -> impl Iterator<Item = &'static str> {
    ROBOTS.iter().map(|(name, _)| *name)
}

/// The built-in robot of this name; [`load_robot`](super::load_robot) returns its notes too.
///
/// # Errors
/// There is no such robot; the message lists the names.
pub fn builtin_robot(name: &str) -> Result<Model> {
    let text = builtin_robot_text(name).ok_or_else(|| {
        let all: Vec<_> = builtin_robots().collect();
        let condition = format!("no built-in robot is called so, but {}", all.join(", "));
        Error::input(name, "robot", condition)
    })?;
    let (model, _) = parse_urdf(text, name)?;
    Ok(model)
}

/// The URDF text of the robot called `name`, if it is built in.
pub fn builtin_robot_text(name: &str) -> Option<&'static str> {
    let (_, text) = ROBOTS.iter().find(|(robot, _)| *robot == name)?;
    Some(text)
}
