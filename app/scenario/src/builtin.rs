//! The scenarios in `robots/`, built into the library.

/// Names and texts of the scenarios that are built in.
macro_rules! scenarios {
    ($($robot:literal / $name:literal),*) => {
        [$(($name, include_str!(concat!("../robots/", $robot, "/", $name, ".json")))),*]
    };
}

/// The scenarios, in the order in which they are listed.
const SCENARIOS: [(&str, &str); 31] = scenarios!(
    "pendulum_1" / "pendulum_1_swingup",
    "pendulum_2" / "pendulum_2_swingup",
    "pendulum_3" / "pendulum_3_swingup",
    "pendulum_4" / "pendulum_4_swingup",
    "pendulum_5" / "pendulum_5_swingup",
    "kinova_gen3" / "kinova_free_01",
    "kinova_gen3" / "kinova_free_02",
    "kinova_gen3" / "kinova_free_03",
    "kinova_gen3" / "kinova_free_04",
    "kinova_gen3" / "kinova_free_05",
    "digit_v3_pinned" / "digit_free_stretch",
    "digit_v3_pinned" / "digit_free_step",
    "kinova_gen3" / "kinova_obstacles_01",
    "kinova_gen3" / "kinova_obstacles_02",
    "kinova_gen3" / "kinova_obstacles_03",
    "kinova_gen3" / "kinova_obstacles_04",
    "kinova_gen3" / "kinova_obstacles_05",
    "kinova_gen3" / "kinova_table_01",
    "digit_v3_pinned" / "digit_obstacles_2",
    "digit_v3_pinned" / "digit_obstacles_4",
    "kinova_gen3_2arms" / "two_arms_01",
    "kinova_gen3_2arms" / "two_arms_02",
    "kinova_gen3_2arms" / "two_arms_bar_01",
    "kinova_gen3_3arms" / "three_arms_01",
    "kinova_gen3_3arms" / "three_arms_02",
    "acrobot" / "acrobot_swingup",
    "pendubot" / "pendubot_swingup",
    "cart_pole" / "cart_pole_swingup",
    "planar_rotorcraft" / "rotorcraft_shift_01",
    "planar_rotorcraft" / "rotorcraft_flip_01",
    "kinova_gen3" / "kinova_dead_wrist_01"
);

/// The names of the scenarios that are built in.
pub fn builtin_scenarios() -> impl Iterator<Item = &'static str> {
    SCENARIOS.iter().map(|(name, _)| *name)
}

/// The text of the scenario called `name`, if it is built in.
pub(crate) fn builtin_scenario(name: &str) -> Option<&'static str> {
    let (_, text) = SCENARIOS.iter().find(|(scenario, _)| *scenario == name)?;
    Some(text)
}
