//! Scenarios that have no solution for a plain reason are refused before any search, with the reason.

use crate::generate::seeds::LISTED;
use crate::written::{folder, load, with};
use aghf::dynamics::forward_kinematics;
use aghf::model::{Model, pendulum};
use aghf::spatial::Placement;
use aghf::urdf::builtin_robot;
use aghf_scenario::{FlowOptions, Quantity, Scenario, Solve, SolveOptions, builtin_scenarios, least_horizon};
use serde_json::{Value, json};

/// A motion of Kinova that has a solution.
pub fn kinova() -> Value {
    json!({
        "robot": "kinova_gen3", "robot_shape": "joint_frames", "horizon_s": 2.0,
        "q_start": [0.0, 0.5, 0.0, 1.0, 0.0, 0.5, 0.0], "v_start": [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        "q_goal": [1.0, 0.5, 0.0, 1.0, 0.0, 0.5, 0.0], "v_goal": [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    })
}

/// Seven zeros but for one entry.
pub fn entry(i: usize, x: f64) -> Value {
    let mut entries = [0.0; 7];
    entries[i] = x;
    json!(entries)
}

/// The reason for which a scenario is refused, if any.
pub fn refusal(scenario: &Value) -> Option<String> {
    let scenario = load("preflight", scenario).unwrap_or_else(|e| panic!("{e}"));
    let error = scenario.check_feasible().err()?.to_string();
    let rest = error.strip_prefix("preflight: ");
    Some(rest.unwrap_or_else(|| panic!("{error}")).to_owned())
}

fn assert_refused(scenario: &Value, words: &str) {
    let error = refusal(scenario).unwrap_or_else(|| panic!("accepted; want {words}"));
    assert!(error.starts_with(words), "{error}; want {words}");
}

#[test]
fn nothing_is_wrong_with_our_own_scenarios() {
    let built_in = builtin_scenarios().map(|name| Scenario::load(name).expect("it is ours"));
    let built_in: Vec<Scenario> = built_in.collect();
    for scenario in built_in.iter().chain(LISTED.iter().map(|(_, of)| of)) {
        scenario.check_feasible().unwrap_or_else(|e| panic!("{e}"));
    }
    assert_eq!(refusal(&kinova()), None);
}

#[test]
fn ends_beyond_a_limit_are_refused_where_it_is_enforced() {
    let bent = |key: &str, q: f64| with(kinova(), json!({ key: entry(1, q) }));
    let words = "joint 'joint_2' has 2.3 rad, its enforced position limits are [-2.25, 2.25] rad";
    assert_refused(&bent("q_goal", 2.3), &format!("q_goal: {words}"));
    assert_refused(&bent("q_start", 2.3), &format!("q_start: {words}"));
    assert!(refusal(&bent("q_goal", -2.3)).is_some(), "the other side");
    let degrees = refusal(&bent("q_goal", 90.0)).expect("it is beyond");
    assert!(degrees.ends_with(" rad; angles are in radians, are these degrees?"), "{degrees}");
    // As the search, which keeps limits to 1e-6.
    assert_eq!(refusal(&bent("q_goal", 2.25 + 5e-7)), None);
    assert!(refusal(&bent("q_goal", 2.25 + 5e-6)).is_some());

    let fast = |key: &str| with(kinova(), json!({ key: entry(4, -1.23) }));
    let words = "joint 'joint_5' has -1.23 rad/s, its enforced velocity limits are [-1.2218, 1.2218] rad/s";
    assert_refused(&fast("v_start"), &format!("v_start: {words}"));
    assert_refused(&fast("v_goal"), &format!("v_goal: {words}"));
    let free = with(fast("v_goal"), json!({ "free_final_velocity": true }));
    assert_eq!(refusal(&free), None, "it is a guess");

    // The way out, and a share.
    for (scenario, enforced) in [
        (bent("q_goal", 2.3), json!({ "position": false })),
        (bent("q_goal", 2.3), json!({ "position": { "joints": ["joint_4"] } })),
        (fast("v_start"), json!({ "velocity": { "joints": ["joint_4"] } })),
    ] {
        let scenario = with(scenario, json!({ "enforced_limits": enforced, "horizon_s": 3.0 }));
        assert_eq!(refusal(&scenario), None, "{enforced}");
    }
    let share = with(bent("q_goal", 1.9), json!({ "enforced_limits": { "position": 0.8 } }));
    assert_refused(&share, "q_goal: joint 'joint_2' has 1.9 rad, its enforced");
    assert_eq!(refusal(&bent("q_goal", 1.9)), None);
}

#[test]
fn horizons_that_are_too_short_are_refused_with_the_least() {
    let far = |keys: Value| {
        let goal = [1.0, 0.5, 0.0, 1.0, 5.6, 0.5, -5.5];
        with(with(kinova(), json!({ "q_goal": goal })), keys)
    };
    let words = "it is 2 s, but joint 'joint_5' needs at least 4.59 s at its velocity limit of 1.22 rad/s";
    assert_refused(&far(json!({})), &format!("horizon_s: {words}"));
    let least = 5.6 / 1.2218;
    let scenario = load("least", &far(json!({}))).expect("it is good");
    assert_eq!(scenario.least_horizon(), Some((4, Quantity::Velocity, least)));
    assert_eq!(refusal(&far(json!({ "horizon_s": least }))), None);
    assert_eq!(refusal(&far(json!({ "horizon_s": 4.59 }))), None, "as the message says");
    assert!(refusal(&far(json!({ "horizon_s": 0.9999 * least }))).is_some());

    // A horizon that is free may be as long as its bound.
    let free = |longest: f64| {
        let bounds = json!({ "shortest_s": 1.0, "longest_s": longest });
        far(json!({ "free_horizon": bounds }))
    };
    assert_refused(&free(3.0), "free_horizon.longest_s: it is 3 s, but joint 'joint_5'");
    assert_eq!(refusal(&free(5.0)), None);

    // Half the velocity, twice the time; without the limit of that joint, the next.
    let enforced = |velocity: Value| far(json!({ "enforced_limits": { "velocity": velocity } }));
    assert_refused(&enforced(json!(0.5)), "horizon_s: it is 2 s, but joint 'joint_5' needs at least 9.17 s");
    let others = json!({ "joints": ["joint_1", "joint_7"] });
    assert_refused(&enforced(others), "horizon_s: it is 2 s, but joint 'joint_7' needs at least 4.51 s");
    assert_eq!(refusal(&enforced(json!({ "joints": ["joint_1"] }))), None);
    assert_eq!(refusal(&enforced(json!(false))), None);

    // From rest to rest within accelerations and jerks, up to a velocity or not.
    let within = |limits: Value| far(json!({ "enforced_limits": limits }));
    assert_refused(
        &within(json!({ "acceleration": 2, "velocity": false })),
        "horizon_s: it is 2 s, but joint 'joint_5' needs at least 3.35 s at its acceleration limit of 2.00 rad/s^2",
    );
    assert_refused(
        &within(json!({ "acceleration": 2, "velocity": { "joints": ["joint_5"] } })),
        "horizon_s: it is 2 s, but joint 'joint_5' needs at least 5.20 s at its acceleration limit of 2.00 rad/s^2",
    );
    let jerk = json!({ "jerk": 10, "velocity": false });
    assert_refused(
        &within(jerk.clone()),
        "horizon_s: it is 2 s, but joint 'joint_5' needs at least 2.62 s at its jerk limit of 10.0 rad/s^3",
    );
    let jumping = json!({ "continuity": "velocity", "enforced_limits": jerk });
    let jumping = load("jumping", &far(jumping)).expect_err("a jump has no jerk");
    let words = "enforced_limits.jerk: the continuity is 'velocity'";
    assert!(jumping.to_string().contains(words), "{jumping}");
}

/// An end may be outside by rounding, and not by as much as the search accepts for a whole motion.
#[test]
fn an_end_beyond_a_limit_leaves_something_to_move_with() {
    let strict = json!({ "position": 0.0 });
    let keys = |by: f64| json!({ "q_start": entry(1, 2.25 + by), "start_tolerance": strict });
    let bent = |by: f64| refusal(&with(kinova(), keys(by)));
    assert_eq!(bent(1e-7), None);
    for by in [1e-6, 2e-6] {
        assert!(bent(by).expect("refused").contains("enforced position limits"), "{by}");
    }
}

#[test]
fn the_least_horizon_of_a_robot() {
    let kinova = builtin_robot("kinova_gen3").expect("built in");
    let (start, mut goal) = ([0.5; 7], [0.5; 7]);
    assert_eq!(least_horizon(&kinova, &start, &goal).expect("lengths agree"), None);
    goal[2] -= 1.3963;
    // Less far, but slower.
    goal[5] += 1.3;
    let (joint, seconds) = least_horizon(&kinova, &start, &goal).expect("lengths agree").expect("two joints move");
    assert!(joint == 5 && (seconds - 1.3 / 1.2218).abs() < 1e-15, "{seconds}");
    let free = pendulum(2).expect("two links");
    let least = least_horizon(&free, &[0.0; 2], &[9.0; 2]).expect("lengths agree");
    assert_eq!(least, None, "nothing is limited");
    for (start, goal) in [(&[0.0; 6][..], &[0.0; 7][..]), (&[0.0; 7], &[0.0; 8])] {
        least_horizon(&kinova, start, goal).expect_err("a length is wrong");
    }
}

/// The positions of the joints in the base frame.
fn origins(model: &Model, q: &[f64]) -> Vec<[f64; 3]> {
    let mut placements = vec![Placement::identity(); model.dof()];
    forward_kinematics(model, q, &mut placements).expect("lengths agree");
    placements.iter().map(|p| p.translation.into()).collect()
}

#[test]
fn ends_in_collision_are_refused_with_link_obstacle_and_depth() {
    let good = load("clear", &kinova()).expect("it is good");
    let wrist = origins(&good.model, &good.file.q_goal)[5];
    let sphere = |off: f64, radius: f64| {
        let [x, y, z] = wrist;
        json!({ "shape": { "sphere": { "radius_m": radius } }, "pose": { "position_m": [x, y, z + off] } })
    };
    let far = json!({ "shape": { "sphere": { "radius_m": 0.1 } }, "pose": { "position_m": [0.0, 0.0, 9.0] } });
    let among = |spheres: [Value; 2]| with(kinova(), json!({ "obstacles": spheres }));
    // The ball of the paper's measure is a point.
    let hit = among([far.clone(), sphere(0.02, 0.03)]);
    let words = "q_goal: link 'spherical_wrist_2_link' is 1.000e-2 m inside 'obstacles[1]'";
    assert_refused(&hit, words);
    assert_eq!(refusal(&among([far.clone(), sphere(0.02, 0.02 + 5e-7)])), None);
    assert!(refusal(&among([far.clone(), sphere(0.02, 0.02 + 5e-6)])).is_some());
    let back = with(hit, json!({ "q_start": good.file.q_goal, "q_goal": good.file.q_start }));
    assert_refused(&back, "q_start: link 'spherical_wrist_2_link'");

    // The deepest ball is told, and of links the balls that cover them count, as in the search.
    let shape = |spacing: f64| {
        let shape = json!({ "swept_links": { "radius_m": 0.01, "spacing_m": spacing } });
        let [_, _, z] = wrist;
        let floor = json!([{
            "shape": { "half_space": {} },
            "pose": { "position_m": [0.0, 0.0, z + 0.02], "orientation_xyzw": [1.0, 0.0, 0.0, 0.0] }
        }]);
        with(kinova(), json!({ "robot_shape": shape, "obstacles": floor }))
    };
    let error = refusal(&shape(0.2)).expect("links are above the ceiling");
    assert!(error.contains("inside 'obstacles[0]'"), "{error}");
    let beside = |spacing: f64| {
        let [x, y, z] = origins(&good.model, &good.file.q_start)[5];
        let obstacle = json!([{ "shape": { "sphere": { "radius_m": 0.08 } },
            "pose": { "position_m": [x, y, z + 0.1] } }]);
        let shape = json!({ "swept_links": { "radius_m": 0.01, "spacing_m": spacing } });
        with(kinova(), json!({ "robot_shape": shape, "obstacles": obstacle }))
    };
    let coarse = refusal(&beside(0.5)).expect("its balls are large");
    assert!(coarse.starts_with("q_start: link '") && coarse.contains("by the balls that cover it"));
    assert_eq!(refusal(&beside(0.02)), None);
}

/// A robot of one joint of this type, whose axis is vertical or level, with a limit of its effort.
fn one_joint(name: &str, kind: &str, axis: &str, effort: f64) -> Value {
    let urdf = format!(
        r#"<robot name="one"><link name="base"/><link name="body"><inertial><origin xyz="-0.5 0 0"/><mass value="1"/>
        <inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
        <joint name="only" type="{kind}"><parent link="base"/><child link="body"/><axis xyz="{axis}"/>
        <limit lower="-9" upper="9" velocity="0" effort="{effort}"/></joint></robot>"#
    );
    std::fs::write(folder().join(format!("{name}.urdf")), urdf).expect("the folder is writable");
    json!({
        "robot": format!("{name}.urdf"), "horizon_s": 2.0,
        "q_start": [0.5 * std::f64::consts::PI], "v_start": [0.0], "q_goal": [0.0], "v_goal": [0.0],
    })
}

#[test]
fn ends_at_rest_that_the_torques_cannot_hold_are_refused() {
    // Level, 1 kg at half a metre weighs 4.905 N m; upright, nothing.
    let weak = one_joint("weak", "revolute", "0 1 0", 4.9);
    let words = "joint 'only' needs 4.91 N m to hold the robot at rest, its enforced torque limit is 4.9 N m";
    assert_refused(&weak, &format!("q_goal: {words}"));
    let back = with(weak.clone(), json!({ "q_start": weak["q_goal"], "q_goal": weak["q_start"] }));
    assert_refused(&back, "q_start: joint 'only'");
    assert_eq!(refusal(&one_joint("strong", "revolute", "0 1 0", 4.906)), None);
    for keys in [
        json!({ "v_goal": [0.1] }),
        json!({ "free_final_velocity": true }),
        json!({ "enforced_limits": { "torque": false } }),
    ] {
        assert_eq!(refusal(&with(weak.clone(), keys.clone())), None, "{keys}");
    }
    let share = json!({ "enforced_limits": { "torque": 0.5 } });
    let strong = with(one_joint("half", "revolute", "0 1 0", 8.0), share);
    assert_refused(
        &strong,
        "q_goal: joint 'only' needs 4.91 N m to hold the robot at rest, its enforced torque limit is 4 N m",
    );
    let lift = one_joint("lift", "prismatic", "0 0 1", 9.8);
    assert_refused(&lift, "q_start: joint 'only' needs 9.81 N to hold");
    let lift = with(lift, json!({ "q_goal": [9.5] }));
    assert_refused(&lift, "q_goal: joint 'only' has 9.5 m, its enforced position limits are [-9, 9] m");
}

#[test]
fn no_method_searches_then() {
    let far = with(kinova(), json!({ "horizon_s": 0.5 }));
    let scenario = load("far", &far).expect("it is good");
    for options in [SolveOptions::default(), FlowOptions::default().into()] {
        let solve = Solve::new(&scenario).options(options);
        let error = solve.observe(|_| panic!("it searches")).run();
        let error = error.expect_err("too short");
        assert!(error.to_string().starts_with("far: horizon_s: it is 0.5 s"), "{error}");
    }
}
