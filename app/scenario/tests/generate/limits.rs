//! The generated family for any robot: each scenario is close to the velocity limits and has a solution, found here by
//! other means.

use super::seeds::LISTED;
use aghf::dynamics::{Data, bias, crba};
use aghf::model::Model;
use aghf::urdf::Mimic;
use aghf_scenario::{
    EnforcedLimits, LoadOptions, Objective, ObjectiveWeights, PerJoint, Scenario, Units, generate, generate_for,
};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::Path;

/// The number of scenarios of each kind.
const SEEDS: u64 = 20;
/// At how many times a motion is.
const SAMPLES: usize = 301;

/// Position, velocity and acceleration of all joints at a time.
type State = [Vec<f64>; 3];

/// The motion `start + (goal - start) s + bend h` at all times, with s = 5 t^2 - 10 t^3 + 10 t^4 - 4 t^5 and
/// h = 16 (t^2 - 2 t^3 + t^4) of the part t of the horizon.
fn motion(scenario: &Scenario, bend: &[f64]) -> Vec<State> {
    let file = &scenario.file;
    let derivatives = |c: [f64; 6], t: f64| {
        let sum = |f: &dyn Fn(f64, i32) -> f64| -> f64 {
            let terms = c.iter().zip(0..).map(|(c, k)| c * f(t, k));
            terms.sum()
        };
        let real = f64::from;
        [
            sum(&|t, k| t.powi(k)),
            sum(&|t, k| if k > 0 { real(k) * t.powi(k - 1) } else { 0.0 }),
            sum(&|t, k| {
                if k > 1 { real(k * (k - 1)) * t.powi(k - 2) } else { 0.0 }
            }),
        ]
    };
    let state = |n: usize| {
        let t = n as f64 / (SAMPLES - 1) as f64;
        let s = derivatives([0.0, 0.0, 5.0, -10.0, 10.0, -4.0], t);
        let h = derivatives([0.0, 0.0, 16.0, -32.0, 16.0, 0.0], t);
        [0, 1, 2].map(|k| {
            let joints = file.q_start.iter().zip(&file.q_goal).zip(bend);
            let entry = |((start, goal), bend): ((&f64, &f64), &f64)| {
                let constant = if k == 0 { *start } else { 0.0 };
                constant + ((goal - start) * s[k] + bend * h[k]) / file.horizon_s.powi(k as i32)
            };
            joints.map(entry).collect()
        })
    };
    (0..SAMPLES).map(state).collect()
}

/// The largest part of a limit of velocity, and of torque, that a motion takes; infinite if it leaves the range of a
/// joint.
fn shares(model: &Model, motion: &[State]) -> [f64; 2] {
    let n = model.dof();
    let mut data = Data::new(model);
    let (mut mass, mut rest) = (DMatrix::zeros(n, n), vec![0.0; n]);
    let mut shares = [0.0_f64; 2];
    for [q, v, a] in motion {
        crba(model, &mut data, q, &mut mass).expect("it fits");
        bias(model, &mut data, q, v, &mut rest).expect("it fits");
        for (i, joint) in model.joints().iter().enumerate() {
            let limits = joint.limits();
            let inertial: f64 = (0..n).map(|j| mass[(i, j)] * a[j]).sum();
            let torque = (inertial + rest[i]).abs() / limits.effort;
            let inside = (limits.lower..=limits.upper).contains(&q[i]);
            let speed = if inside { v[i].abs() } else { f64::INFINITY };
            shares = [shares[0].max(speed / limits.velocity), shares[1].max(torque)];
        }
    }
    shares
}

/// The ends at rest.
fn ends(scenario: &Scenario) -> [State; 2] {
    let file = &scenario.file;
    [&file.q_start, &file.q_goal].map(|q| [q.clone(), file.v_start.clone(), file.v_goal.clone()])
}

fn load(family: &str, seed: u64) -> Scenario {
    Scenario::load(&format!("{family}_{seed:02}")).expect("it can be generated")
}

#[test]
fn every_horizon_is_the_least_and_some_more() {
    for family in ["limits", "limits_obstacle"] {
        for seed in 1..=SEEDS {
            let Scenario { file, model, .. } = load(family, seed);
            let ways = file.q_start.iter().zip(&file.q_goal).zip(model.joints());
            let least =
                ways.map(|((start, goal), joint)| (goal - start).abs() / joint.limits().velocity).fold(0.0, f64::max);
            let longer = file.horizon_s - (1.3 * least).max(0.5);
            assert!((-1e-12..=1e-3).contains(&longer), "{family} {seed}");
            let rest = vec![0.0; model.dof()];
            assert_eq!([&file.v_start, &file.v_goal], [&rest; 2]);
            assert_eq!(file.enforced_limits, EnforcedLimits::default());
            let weights =
                ObjectiveWeights { units: Units::Si, acceleration: PerJoint::Same(0.1), ..ObjectiveWeights::default() };
            assert_eq!(file.objective, Objective::Weights(weights));
        }
    }
}

#[test]
fn without_an_obstacle_the_line_keeps_all_limits() {
    for seed in 1..=SEEDS {
        let scenario = load("limits", seed);
        assert!(scenario.scene.is_empty());
        let line = motion(&scenario, &vec![0.0; scenario.model.dof()]);
        let [velocity, torque] = shares(&scenario.model, &line);
        // Close to the limits, else the scenario is none of this family; between the generator's times there may be a
        // little more.
        assert!((0.95..0.98).contains(&velocity), "{seed}: {velocity}");
        assert!(torque < 0.901, "{seed}: {torque}");
        let [_, held] = shares(&scenario.model, &ends(&scenario));
        assert!(held < 0.901, "{seed}: {held}");
    }
}

#[test]
fn around_an_obstacle_there_is_a_motion_within_all_limits() {
    for seed in 1..=SEEDS {
        let scenario = load("limits_obstacle", seed);
        let clearance = |motion: &[State]| {
            let configurations = motion.iter().map(|[q, ..]| q.as_slice());
            let smallest = scenario.smallest_clearance(configurations);
            let smallest = smallest.expect("it is the robot's");
            smallest.expect("there is an obstacle")
        };
        let n = scenario.model.dof();
        let line = motion(&scenario, &vec![0.0; n]);
        assert!(clearance(&line) < -0.02, "{seed}: the line hits nothing");
        assert!(clearance(&ends(&scenario)) > 0.03 - 1e-9, "{seed}");
        // A bend of the line, found anew.
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        let found = (0..20_000).any(|_| {
            let bend: Vec<f64> =
                (0..n).map(|_| rng.random_range(-0.9..0.9) * f64::from(rng.random_range(0..4)) / 3.0).collect();
            let bent = motion(&scenario, &bend);
            let coarse: Vec<State> = bent.iter().step_by(20).cloned().collect();
            let good = |motion: &[State]| {
                let [velocity, torque] = shares(&scenario.model, motion);
                velocity < 1.0 && torque < 1.0 && clearance(motion) > 0.0
            };
            good(&coarse) && good(&bent)
        });
        assert!(found, "{seed}: no motion was found");
    }
}

/// The paths beside the lines of the older families are motions within the limits as well: so the line is, where it is
/// hardest.
#[test]
fn the_families_of_kinova_leave_time_for_the_velocity_limits() {
    let families = ["kinova_cross_", "kinova_gap_", "kinova_floor_"];
    let of_kinova = |name: &str| families.iter().any(|family| name.starts_with(family));
    let mut compared = 0;
    for (name, scenario) in LISTED.iter().filter(|(name, _)| of_kinova(name)) {
        let line = motion(scenario, &vec![0.0; scenario.model.dof()]);
        let [velocity, _] = shares(&scenario.model, &line);
        assert!(velocity < 0.97, "{name}: {velocity}");
        let [_, held] = shares(&scenario.model, &ends(scenario));
        assert!(held < 0.9, "{name}: {held}");
        assert!(scenario.file.enforced_limits.any());
        compared += 1;
    }
    assert_eq!(compared, 30);
}

#[test]
fn a_seed_and_a_robot_decide() {
    let robot = |name: &str, robot: &str| {
        generate_for(name, Some(robot), Mimic::Refuse).expect("there is such a family").expect("it can be generated")
    };
    let json = |name: &str| {
        let file = generate(name).expect("there is such a family");
        serde_json::to_string(&file.expect("it can be generated")).expect("it is JSON")
    };
    for family in ["limits", "limits_obstacle"] {
        assert_eq!(json(&format!("{family}_3")), json(&format!("{family}_03")));
        assert_ne!(json(&format!("{family}_03")), json(&format!("{family}_04")));
    }
    assert_eq!(Some(robot("limits_03", "kinova_gen3")), generate("limits_03").and_then(Result::ok));
    let pendulum = robot("limits_obstacle_01", "pendulum_3");
    assert_eq!((&*pendulum.robot, pendulum.q_start.len()), ("pendulum_3", 3));
    assert_eq!(pendulum.obstacles.len(), 1);
    // Without velocity limits, joints are taken to do 3 rad/s.
    let ways = pendulum.q_start.iter().zip(&pendulum.q_goal);
    let farthest = ways.map(|(a, b)| (b - a).abs()).fold(0.0, f64::max);
    let longer = pendulum.horizon_s - (1.3 * farthest / 3.0).max(0.5);
    assert!((-1e-12..=1e-3).contains(&longer), "{longer}");
}

/// The scenarios of several arms are of this family.
#[test]
fn scenarios_of_several_arms_are_what_is_generated() {
    for (name, of) in [("two_arms", "2arms"), ("three_arms", "3arms")] {
        for seed in ["01", "02"] {
            let built_in = Scenario::load(&format!("{name}_{seed}")).expect("it is good");
            let robot = format!("kinova_gen3_{of}");
            let made = generate_for(&format!("limits_{seed}"), Some(&robot), Mimic::Refuse);
            let made = made.expect("there is such a family").expect("it can be");
            assert_eq!(built_in.file, made);
        }
    }
}

/// A lever that its torque holds in a part of its range alone, and hardly swings.
const LEVER: &str = r#"<robot name="lever"><link name="base"/>
    <link name="a"><inertial><mass value="1"/><origin xyz="0.5 0 0"/>
        <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="swing" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 1 0"/>
        <limit lower="-3" upper="3" velocity="2" effort="4.5"/></joint></robot>"#;

/// For the robot at this path.
fn for_robot(path: &Path) -> LoadOptions {
    LoadOptions { robot: Some(path.display().to_string()), ..LoadOptions::default() }
}

#[test]
fn scarce_torques_suffice_on_the_line_and_at_its_ends() {
    let urdf = Path::new(env!("CARGO_TARGET_TMPDIR")).join("lever.urdf");
    std::fs::write(&urdf, LEVER).expect("the folder is writable");
    let mut most = 0.0_f64;
    for seed in 1..=50 {
        let scenario = Scenario::load_for(&format!("limits_{seed}"), &for_robot(&urdf));
        let scenario = scenario.expect("it can be generated");
        let [_, torque] = shares(&scenario.model, &motion(&scenario, &[0.0]));
        let [_, held] = shares(&scenario.model, &ends(&scenario));
        assert!(torque.max(held) < 0.901, "{seed}: {torque} {held}");
        most = most.max(torque.min(held));
    }
    // It has no frame but that of its joint.
    let short = generate_for("limits_obstacle_01", urdf.to_str(), Mimic::Refuse);
    let short = short.expect("there is such a family").expect_err("it has no link");
    assert!(short.to_string().contains("no link reach"), "{short}");
    assert!(most > 0.8, "the torques are not scarce: {most}");
}

/// A crank and a rocker that mimics it.
const MIMIC: &str = r#"<robot name="crank"><link name="base"/>
    <link name="a"><inertial><mass value="1"/><origin xyz="0.1 0 0"/>
        <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <link name="b"><inertial><mass value="1"/><origin xyz="0.1 0 0"/>
        <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="crank" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>
        <limit lower="-1" upper="1" velocity="2" effort="50"/></joint>
    <joint name="rocker" type="revolute"><parent link="base"/><child link="b"/><axis xyz="0 0 1"/>
        <limit lower="4" upper="11" velocity="3" effort="50"/><mimic joint="crank"/></joint></robot>"#;

#[test]
fn mimic_joints_move_by_themselves_where_a_scenario_says_so() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
    let urdf = folder.join("crank.urdf");
    std::fs::write(&urdf, MIMIC).expect("the folder is writable");
    let urdf = urdf.to_str().expect("it is text");
    let made = |mimic| generate_for("limits_02", Some(urdf), mimic).expect("there is such a family");
    let refused = made(Mimic::Refuse).expect_err("a joint mimics another");
    assert!(refused.to_string().contains("mimics joint 'crank'"));
    let file = made(Mimic::Independent).expect("it can be generated");
    // Ranges beyond half a turn are used as well, but for one turn alone.
    let [start, goal] = [file.q_start[1], file.q_goal[1]];
    assert!((4.0..4.0 + 6.3).contains(&start) && (4.0..4.0 + 6.3).contains(&goal));

    let path = folder.join("crank.json");
    let path = path.to_str().expect("it is text");
    let write = |value: &serde_json::Value| {
        std::fs::write(path, value.to_string()).expect("the folder is writable");
    };
    let mut json = serde_json::to_value(&file).expect("it is JSON");
    assert_eq!(json["mimic"], "independent");
    write(&json);
    assert_eq!(Scenario::load(path).expect("it is good").file, file);
    json["mimic"] = "refuse".into();
    write(&json);
    let error = Scenario::load(path).expect_err("it is refused");
    assert!(error.to_string().contains("mimics joint 'crank'"));
    let independent = LoadOptions { mimic: Some(Mimic::Independent), ..LoadOptions::default() };
    let forced = Scenario::load_for(path, &independent);
    assert_eq!(forced.expect("it is asked for").file, file);
    json["mimic"] = "sometimes".into();
    write(&json);
    let error = Scenario::load(path).expect_err("there is no such choice");
    assert!(error.to_string().contains("mimic"), "{error}");
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let error = |name: &str, robot: &str| {
        let made = generate_for(name, Some(robot), Mimic::Refuse).expect("there is such a family");
        made.expect_err("it cannot be").to_string()
    };
    let own = error("kinova_gap_01", "pendulum_3");
    assert!(own.contains("kinova_gap") && own.contains("kinova_gen3 alone"), "{own}");
    let missing = error("limits_01", "nowhere.urdf");
    assert!(missing.contains("limits_01") && missing.contains("nowhere.urdf"), "{missing}");
    // The torques of Digit's file do not hold it.
    let weak = error("limits_07", "digit_v3_pinned");
    assert!(weak.contains("seed 7") && weak.contains("hold it at rest"), "{weak}");
    let named = Scenario::load_for("kinova_free_01", &for_robot(Path::new("pendulum_3")));
    let named = named.expect_err("it names its robot").to_string();
    assert!(named.contains("names its robot"), "{named}");
}
