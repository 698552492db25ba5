//! Obstacles of every shape, the collision shapes of the robot, and links that keep clear of each other.

use aghf::constraint::{AnyConstraint, Constraint};
use aghf::dynamics::forward_kinematics;
use aghf::geometry::Shape;
use aghf::scenario::{IgnoredPairs, LinkBall, Scenario};
use aghf::spatial::Placement;
use aghf::urdf::{Srdf, builtin_robot};
use nalgebra::Vector3;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("surroundings")
        .join(test);
    std::fs::create_dir_all(&folder).expect("the folder is writable");
    folder
}

/// The start of every problem of MotionBenchMaker.
const READY: [f64; 7] = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785];

fn panda() -> Value {
    json!({
        "robot": "panda", "horizon_s": 2.0,
        "q_start": READY, "v_start": [0, 0, 0, 0, 0, 0, 0],
        "q_goal": [0.5, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785], "v_goal": [0, 0, 0, 0, 0, 0, 0],
        "robot_shape": { "collision": {} },
        "box_obstacles": [
            { "center_m": [0.0, 0.0, 2.0], "size_m": [0.2, 0.4, 0.6] },
            { "name": "lid", "center_m": [0.0, 2.0, 0.0], "size_m": [1, 1, 0.1], "orientation_xyzw": [0.0, 0.0, 0.6, 0.8] }
        ],
        "cylinder_obstacles": [{ "name": "post", "center_m": [2.0, 0.0, 0.0], "radius_m": 0.1, "length_m": 3.0 }],
        "capsule_obstacles": [{ "ends_m": [[0.0, -2.0, 0.0], [0.0, -2.0, -1.0]], "radius_m": 0.2 }],
        "self_collision": { "ignored_pairs": [["panda_link0", "panda_link1"], ["panda_hand", "panda_link6"]] }
    })
}

fn with(mut scenario: Value, keys: Value) -> Value {
    for (key, value) in keys.as_object().expect("an object") {
        scenario[key] = value.clone();
    }
    scenario
}

fn load(test: &str, scenario: &Value) -> Result<Scenario, String> {
    let path = folder(test).join("scenario.json");
    std::fs::write(&path, scenario.to_string()).expect("the folder is writable");
    Scenario::load(path.to_str().expect("it is text")).map_err(|e| e.to_string())
}

#[test]
fn obstacles_are_placed_as_the_keys_say() {
    let scenario = load("placed", &panda()).expect("it is good");
    let solids: Vec<_> = scenario.environment.solids().copied().collect();
    let half_extents = Vector3::new(0.1, 0.2, 0.3);
    assert_eq!(solids[0].shape, Shape::Cuboid { half_extents });
    assert_eq!(solids[0].placement.translation, Vector3::new(0.0, 0.0, 2.0));
    // A turn about z by the angle whose half has the sine 0.6.
    let [sin, cos] = [2.0 * 0.6 * 0.8, 0.8 * 0.8 - 0.6 * 0.6];
    let x = solids[1].placement.rotation.column(0).into_owned();
    assert!((x - Vector3::new(cos, sin, 0.0)).norm() < 1e-15);
    let (radius, half_length) = (0.1, 1.5);
    let post = Shape::Cylinder {
        radius,
        half_length,
    };
    assert_eq!(solids[2].shape, post);
    // The ends of the segment are on the surface of a capsule moved in by its radius, those beyond are outside.
    for (z, distance) in [(0.0, -0.2), (-1.0, -0.2), (0.3, 0.1), (-1.3, 0.1)] {
        let found: f64 = solids[3].distance(&Vector3::new(0.0, -2.0, z));
        assert!((found - distance).abs() < 1e-15, "{found}, {distance}");
    }
    assert_eq!(scenario.file.box_obstacles[1].name.as_deref(), Some("lid"));
}

/// The clearance is that of the nearest ball, and a ball that touches an obstacle is told by link and obstacle.
#[test]
fn clearances_and_overlaps_are_those_of_the_balls_of_the_links() {
    let model = builtin_robot("panda").expect("built in");
    let balls = LinkBall::of_model(&model, Path::new(""), 0.05).expect("spheres");
    assert_eq!(balls.len(), 59);
    let mut placements = vec![Placement::identity(); 7];
    forward_kinematics(&model, &READY, &mut placements).expect("lengths agree");
    // A box below the lowest ball of the hand.
    let centre = |b: &LinkBall| {
        let placement = b.ball.body.map_or(Placement::identity(), |i| placements[i]);
        placement.rotation * b.ball.centre + placement.translation
    };
    let bottom = |b: &LinkBall| centre(b).z - b.ball.radius;
    let in_front = balls.iter().filter(|b| centre(b).x > 0.3);
    let lowest = in_front.min_by(|a, b| bottom(a).total_cmp(&bottom(b)));
    let lowest = lowest.expect("there is one");
    let table = |gap: f64| {
        let [x, y, _]: [f64; 3] = centre(lowest).into();
        let center = [x, y, bottom(lowest) - gap - 0.05];
        json!([{ "name": "table", "center_m": center, "size_m": [0.2, 0.2, 0.1] }])
    };
    let scenario = |gap: f64| {
        let alone = with(
            panda(),
            json!({ "box_obstacles": table(gap), "cylinder_obstacles": [] }),
        );
        load("clearance", &with(alone, json!({ "self_collision": null }))).expect("it is good")
    };
    let clear = scenario(0.02);
    let found = clear
        .environment
        .clearance(&placements)
        .expect("lengths agree");
    assert!((found - 0.02).abs() < 1e-12, "{found}");
    clear.check_feasible().expect("it is clear of the table");
    let error = scenario(-0.01)
        .check_feasible()
        .expect_err("it is in the table")
        .to_string();
    let words = format!(
        "q_start: link '{}' is 1.000e-2 m inside box_obstacles[0] 'table'",
        lowest.link
    );
    assert!(error.contains(&words), "{error}; {words}");
    let rows = clear.environment.constraints().expect("good balls");
    // The ball of the base is none.
    assert_eq!(rows.iter().map(Constraint::dim).sum::<usize>(), 58 * 2);
}

#[test]
fn links_keep_clear_of_each_other_but_for_those_that_may_overlap() {
    let scenario = load("own", &panda()).expect("it is good");
    let balls = scenario.environment.balls().expect("good balls");
    let pairs = scenario.environment.self_pairs();
    let model = builtin_robot("panda").expect("built in");
    let links = LinkBall::of_model(&model, Path::new(""), 0.05).expect("spheres");
    let ignored = [
        ("panda_link0", "panda_link1"),
        ("panda_link6", "panda_hand"),
    ];
    let mut expected = 0;
    for (i, a) in links.iter().enumerate() {
        for b in &links[i + 1..] {
            let names = (a.link.as_str(), b.link.as_str());
            let ignore = ignored.contains(&names) || ignored.contains(&(names.1, names.0));
            expected += usize::from(a.ball.body != b.ball.body && !ignore);
        }
    }
    assert_eq!(pairs.len(), expected);
    assert!(pairs.iter().all(|[i, j]| balls[*i].body != balls[*j].body));
    let rows = scenario.environment.constraints().expect("good balls");
    assert!(
        matches!(rows.last(), Some(AnyConstraint::SelfCollision(own)) if own.dim() == expected)
    );
    // Neighbours overlap, as not all of them are ignored.
    let error = scenario
        .check_feasible()
        .expect_err("neighbours overlap")
        .to_string();
    assert!(error.contains("inside link 'panda_link"), "{error}");
}

/// With a joint locked, and with the joints between the base and it, the shapes stay where they were.
#[test]
fn a_robot_with_locked_joints_keeps_its_shapes() {
    let clearance = |scenario: &Scenario| {
        let mut placements = vec![Placement::identity(); scenario.model.dof()];
        forward_kinematics(&scenario.model, &scenario.file.q_start, &mut placements)
            .expect("lengths agree");
        let found = scenario.environment.clearance(&placements);
        found.expect("lengths agree")
    };
    let near = json!({ "center_m": [0.3, 0.1, 0.3], "radius_m": 0.05 });
    let near = with(
        panda(),
        json!({ "sphere_obstacles": [near], "self_collision": null }),
    );
    let whole = clearance(&load("locked", &near).expect("it is good"));
    for locked in [&[3][..], &[0, 1], &[1, 4, 6]] {
        let left = |q: &[f64]| {
            let kept = q.iter().enumerate().filter(|(i, _)| !locked.contains(i));
            json!(kept.map(|(_, q)| *q).collect::<Vec<_>>())
        };
        let joints: serde_json::Map<_, _> = locked
            .iter()
            .map(|i| (format!("panda_joint{}", i + 1), json!(READY[*i])))
            .collect();
        let (q, zeros) = (left(&READY), left(&[0.0; 7]));
        let keys = json!({ "locked_joints": joints, "q_start": q, "q_goal": q, "v_start": zeros, "v_goal": zeros });
        let reduced = load("locked", &with(near.clone(), keys)).expect("it is good");
        let found = clearance(&reduced);
        assert!(
            (found - whole).abs() < 1e-12,
            "{locked:?}: {found}, {whole}"
        );
    }
}

#[test]
fn pairs_that_a_file_names_are_part_of_the_scenario() {
    let model = builtin_robot("panda").expect("built in");
    let balls = LinkBall::of_model(&model, Path::new(""), 0.05).expect("spheres");
    let pairs = IgnoredPairs::by_sampling(&model, &balls).expect("its own balls");
    assert_eq!(
        pairs,
        IgnoredPairs::by_sampling(&model, &balls).expect("its own balls")
    );
    let text = pairs.to_json();
    assert_eq!(
        IgnoredPairs::parse(&text, "pairs.json").expect("as written"),
        pairs
    );
    assert_eq!(
        text.lines().filter(|l| l.contains("\"links\"")).count(),
        pairs.ignored_pairs.len()
    );
    std::fs::write(folder("file").join("panda.pairs.json"), text).expect("writable");
    let keys = json!({ "self_collision": { "ignored_pairs_file": "panda.pairs.json" } });
    let scenario = load("file", &with(panda(), keys)).expect("it is good");
    let written = serde_json::to_value(&scenario.file).expect("numbers");
    let links: Vec<_> = pairs
        .ignored_pairs
        .iter()
        .map(|pair| json!(pair.links))
        .collect();
    assert_eq!(written["self_collision"], json!({ "ignored_pairs": links }));
    scenario
        .check_feasible()
        .expect("the start is clear of itself");
    for (text, words) in [
        ("{\"robot\": \"panda\"}", "missing field `ignored_pairs`"),
        (
            "{\"robot\": \"panda\", \"ignored_pairs\": [{\"links\": [\"a\"], \"reason\": \"\"}]}",
            "ignored_pairs[0].links",
        ),
    ] {
        let error = IgnoredPairs::parse(text, "pairs.json")
            .expect_err("it is bad")
            .to_string();
        assert!(
            error.starts_with("pairs.json: ") && error.contains(words),
            "{error}"
        );
    }
}

/// `a` is always in `c` and in `d`; `b` is in `d` at six of seven configurations.
#[test]
fn neighbours_and_links_that_always_overlap_may() {
    let link = |name: &str, x: f64, radius: f64| {
        format!(
            r#"<link name="{name}"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
            <collision><origin xyz="{x} 0 0"/><geometry><sphere radius="{radius}"/></geometry></collision></link>"#
        )
    };
    let joint = |name: &str, parent: &str, child: &str| {
        format!(
            r#"<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/><axis xyz="0 0 1"/></joint>"#
        )
    };
    let links =
        link("a", 0.0, 0.1) + &link("b", 1.0, 0.1) + &link("c", 0.15, 0.1) + &link("d", 1.0, 1.85);
    let joints = joint("ab", "a", "b") + &joint("bc", "b", "c") + &joint("cd", "c", "d");
    let text = format!(r#"<robot name="four">{links}{joints}</robot>"#);
    let (model, _) = aghf::urdf::parse_urdf(&text, "four.urdf").expect("it is good");
    let balls = LinkBall::of_model(&model, Path::new(""), 0.05).expect("spheres");
    let found = IgnoredPairs::by_sampling(&model, &balls).expect("its own balls");
    let found: Vec<_> = found
        .ignored_pairs
        .iter()
        .map(|p| (p.links.join(" "), p.reason.as_str()))
        .collect();
    let often = "overlap at each of 10000 random configurations";
    let expected = [
        ("a b", "neighbours"),
        ("a c", often),
        ("a d", often),
        ("b c", "neighbours"),
        ("c d", "neighbours"),
    ];
    assert_eq!(
        found,
        expected.map(|(links, reason)| (links.to_owned(), reason))
    );
    let srdf =
        r#"<robot name="four"><disable_collisions link1="d" link2="a" reason="Never"/></robot>"#;
    let srdf = Srdf::parse(srdf, "four.srdf", &model).expect("it is good");
    let pair = &IgnoredPairs::of_srdf(&model, &srdf).ignored_pairs[0];
    assert_eq!(
        (pair.links.join(" "), pair.reason.as_str()),
        ("d a".to_owned(), "disabled in the SRDF: Never")
    );
}

#[test]
fn bad_surroundings_are_refused_by_key() {
    let one = |key: &str, keys: Value| {
        let mut obstacle = panda()[key][0].clone();
        for (key, value) in keys.as_object().expect("an object") {
            obstacle[key] = value.clone();
        }
        with(panda(), json!({ key: [obstacle] }))
    };
    let own = |pairs: Value| with(panda(), json!({ "self_collision": pairs }));
    let shape = |shape: Value| with(panda(), json!({ "robot_shape": shape }));
    for (scenario, words) in [
        (
            one("box_obstacles", json!({ "size_m": [1, 1, 0] })),
            "box_obstacles[0]: size_m has 0",
        ),
        (
            one("box_obstacles", json!({ "size_m": [1, 1] })),
            "box_obstacles[0].size_m: ;length 2",
        ),
        (
            one("box_obstacles", json!({ "center_m": [1e9, 0, 0] })),
            "box_obstacles[0]: center_m",
        ),
        (
            one("box_obstacles", json!({ "orientation_xyzw": [0, 0, 0, 2] })),
            "box_obstacles[0]: ;has length 2",
        ),
        (
            one("box_obstacles", json!({ "colour": "red" })),
            "box_obstacles[0].colour: ",
        ),
        (
            one("cylinder_obstacles", json!({ "radius_m": -1 })),
            "cylinder_obstacles[0]: radius_m has -1",
        ),
        (
            one("cylinder_obstacles", json!({ "length_m": 0 })),
            "cylinder_obstacles[0]: length_m has 0",
        ),
        (
            one(
                "capsule_obstacles",
                json!({ "ends_m": [[1, 0, 0], [1, 0, 0]] }),
            ),
            "capsule_obstacles[0]: ends_m",
        ),
        (
            one("capsule_obstacles", json!({ "radius_m": 0 })),
            "capsule_obstacles[0]: radius_m has 0",
        ),
        (
            own(json!({ "ignored_pairs": [["panda_link0", "panda_leg"]] })),
            "self_collision.ignored_pairs[0]: ;'panda_leg'",
        ),
        (
            own(json!({ "ignored_pairs_file": "nowhere.json" })),
            "self_collision: ;nowhere.json",
        ),
        (
            own(json!({ "pairs": [] })),
            "self_collision.pairs: ;unknown field `pairs`",
        ),
        (
            own(json!({})),
            "self_collision: one of the keys ignored_pairs and ignored_pairs_file",
        ),
        (
            own(json!(true)),
            "self_collision: ;the key ignored_pairs or",
        ),
        (
            shape(json!("collision")),
            "robot_shape.collision: ;{\"collision\": {...}} is needed",
        ),
        (
            shape(json!("joint-frames")),
            "self_collision: ;'collision' only",
        ),
        (
            shape(json!({ "collision": { "spacing_m": 0 } })),
            "robot_shape: ;positive spacing",
        ),
        (
            with(
                shape(json!({ "collision": {} })),
                json!({ "robot": "pendulum_1" }),
            ),
            "robot_shape: ;no;collision element",
        ),
    ] {
        let error = load("bad", &scenario).expect_err(words);
        assert!(
            error.contains("scenario.json: ") && words.split(';').all(|w| error.contains(w)),
            "{error}; {words}"
        );
    }
}

/// Those that are in the repository can be begun and ended, and name the robot that is built in.
#[test]
fn problems_of_motion_bench_maker_are_scenarios() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/panda/scenarios");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).expect("it is there") {
        let path = entry.expect("readable").path();
        let scenario = Scenario::load(path.to_str().expect("it is text")).expect("it is good");
        assert_eq!(scenario.file.robot, "panda");
        assert!(
            scenario.environment.solids().count() > 2,
            "{}",
            path.display()
        );
        scenario
            .check_feasible()
            .unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        count += 1;
    }
    assert_eq!(count, 35);
}
