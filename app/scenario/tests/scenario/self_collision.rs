//! Links that keep clear of each other, and pairs of them that may overlap.

use crate::surroundings::panda;
use crate::written::{folder, load, with};
use aghf::constraint::{AnyConstraint, Constraint};
use aghf::dynamics::forward_kinematics;
use aghf::spatial::Placement;
use aghf::urdf::{Srdf, builtin_robot};
use aghf_scenario::{IgnoredPair, IgnoredPairs, SelfCollision, always_overlapping, link_shapes};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::json;
use std::path::Path;

#[test]
fn links_keep_clear_of_each_other_but_for_those_that_may_overlap() {
    let scenario = load("own", &panda()).expect("it is good");
    let balls = &scenario.scene.robot().balls;
    let pairs = scenario.scene.pairs();
    let model = builtin_robot("panda").expect("built in");
    let robot = link_shapes(&model, Path::new(""), 0.05).expect("spheres");
    assert_eq!(balls, &robot.balls);
    let ignored = [("panda_link0", "panda_link1"), ("panda_link6", "panda_hand")];
    // Neighbours always overlap.
    let listed = ignored.map(|(a, b)| [a, b].map(str::to_owned));
    let always = always_overlapping(&model, &robot, &listed).expect("its own balls");
    assert_eq!(scenario.overlapping, always);
    let [a, b] = ["panda_link5", "panda_link6"].map(str::to_owned);
    assert!(always.iter().any(|pair| pair.links == [a.clone(), b.clone()]));
    let trees = scenario.scene.trees();
    let link = |tree: usize| robot.link_of(&trees[tree]).expect("each has balls");
    let kept = scenario.scene.tree_pairs().iter();
    let kept: Vec<_> = kept.map(|pair| pair.map(link)).collect();
    let is_kept = |a: &str, b: &str| kept.contains(&[a, b]) || kept.contains(&[b, a]);
    let may_overlap = |a: &str, b: &str| {
        let overlap = |p: &IgnoredPair| p.links == [a, b] || p.links == [b, a];
        ignored.contains(&(a, b)) || ignored.contains(&(b, a)) || always.iter().any(overlap)
    };
    let mut expected = 0;
    let mut apart = Vec::new();
    for i in 0..balls.len() {
        for j in i + 1..balls.len() {
            let [a, b] = [i, j].map(|i| robot.links[i].as_str());
            let other = balls[i].body != balls[j].body && !may_overlap(a, b);
            expected += usize::from(other && is_kept(a, b));
            if other && !is_kept(a, b) {
                apart.push([i, j]);
            }
        }
    }
    assert_eq!(pairs.len(), expected);
    // Pairs of links that never meet are left out.
    assert!(!apart.is_empty());
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut placements = vec![Placement::identity(); model.dof()];
    for _ in 0..2000 {
        let q = model.random_configuration(&mut rng);
        forward_kinematics(&model, &q, &mut placements).expect("lengths agree");
        let placed = robot.placed(&placements).expect("lengths agree");
        assert!(apart.iter().all(|[i, j]| placed[*i].gap(&placed[*j]) > 0.0));
    }
    assert!(pairs.iter().all(|[i, j]| balls[*i].body != balls[*j].body));
    let rows = AnyConstraint::of_scene(&scenario.scene);
    assert!(matches!(rows.last(), Some(AnyConstraint::SelfCollision(own)) if own.dim() == expected));
}

#[test]
fn pairs_that_a_file_names_are_part_of_the_scenario() {
    let model = builtin_robot("panda").expect("built in");
    let balls = link_shapes(&model, Path::new(""), 0.05).expect("spheres");
    let pairs = IgnoredPairs::by_sampling(&model, &balls).expect("its own balls");
    assert_eq!(pairs, IgnoredPairs::by_sampling(&model, &balls).expect("its own balls"));
    let text = pairs.to_json();
    assert_eq!(IgnoredPairs::parse(&text, "pairs.json").expect("as written"), pairs);
    assert_eq!(text.lines().filter(|l| l.contains("\"links\"")).count(), pairs.ignored_pairs.len());
    std::fs::write(folder().join("panda.pairs.json"), text).expect("writable");
    let keys = json!({ "self_collision": { "ignored_pairs_file": "panda.pairs.json" } });
    let scenario = load("file", &with(panda(), keys)).expect("it is good");
    let written = serde_json::to_value(&scenario.file).expect("numbers");
    let links: Vec<_> = pairs.ignored_pairs.iter().map(|pair| json!(pair.links)).collect();
    assert_eq!(written["self_collision"], json!({ "ignored_pairs": links }));
    scenario.check_feasible().expect("the start is clear of itself");
    for (text, words) in [
        ("{\"robot\": \"panda\"}", "missing field `ignored_pairs`"),
        (
            "{\"robot\": \"panda\", \"ignored_pairs\": [{\"links\": [\"a\"], \"reason\": \"\"}]}",
            "ignored_pairs[0].links",
        ),
    ] {
        let error = IgnoredPairs::parse(text, "pairs.json").expect_err("it is bad").to_string();
        assert!(error.starts_with("pairs.json: ") && error.contains(words), "{error}");
    }
}

/// `a` is always in `c` and in `d`; `b` is in `d` at six of seven configurations.
#[test]
fn neighbours_and_links_that_always_overlap_may() {
    let link = |name: &str, x: f64, radius: f64| {
        format!(
            r#"<link name="{name}"><inertial><mass value="1"/>
                <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
            <collision><origin xyz="{x} 0 0"/><geometry><sphere radius="{radius}"/></geometry></collision></link>"#
        )
    };
    let joint = |name: &str, parent: &str, child: &str| {
        format!(
            r#"<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>
                <axis xyz="0 0 1"/></joint>"#
        )
    };
    let links = link("a", 0.0, 0.1) + &link("b", 1.0, 0.1) + &link("c", 0.15, 0.1) + &link("d", 1.0, 1.85);
    let joints = joint("ab", "a", "b") + &joint("bc", "b", "c") + &joint("cd", "c", "d");
    let text = format!(r#"<robot name="four">{links}{joints}</robot>"#);
    let (model, _) = aghf::urdf::parse_urdf(&text, "four.urdf").expect("it is good");
    let balls = link_shapes(&model, Path::new(""), 0.05).expect("spheres");
    let found = IgnoredPairs::by_sampling(&model, &balls).expect("its own balls");
    let found: Vec<_> = found.ignored_pairs.iter().map(|p| (p.links.join(" "), p.reason.as_str())).collect();
    let often = "overlap at each of 10000 random configurations";
    let expected =
        [("a b", "neighbours"), ("a c", often), ("a d", often), ("b c", "neighbours"), ("c d", "neighbours")];
    assert_eq!(found, expected.map(|(links, reason)| (links.to_owned(), reason)));
    let srdf = r#"<robot name="four"><disable_collisions link1="d" link2="a" reason="Never"/></robot>"#;
    let srdf = Srdf::parse(srdf, "four.srdf", &model).expect("it is good");
    let of_srdf = IgnoredPairs::find(&model, Some(&srdf), &balls).expect("its own balls").ignored_pairs;
    assert_eq!(of_srdf.len(), 3, "{of_srdf:?}");
    // An SRDF that disables no pair is as none.
    let none = Srdf::parse(r#"<robot name="four"/>"#, "four.srdf", &model).expect("it is good");
    let without = IgnoredPairs::find(&model, Some(&none), &balls).expect("its own balls").ignored_pairs;
    assert_eq!((without.len(), without[0].reason.as_str()), (5, "neighbours"));
    let pair = &of_srdf[0];
    assert_eq!((pair.links.join(" "), pair.reason.as_str()), ("d a".to_owned(), "disabled in the SRDF: Never"));
}

/// Links that are apart by less than the distance that is asked for are not left out, and neither are those whose
/// joints may go beyond their limits.
#[test]
fn links_that_may_meet_are_not_left_out() {
    let count = |keys| {
        let scenario = load("apart", &with(panda(), keys)).expect("it is good");
        scenario.scene.tree_pairs().len()
    };
    let limited = count(json!({}));
    assert!(limited < count(json!({ "clearance_m": 1.0 })));
    assert!(limited < count(json!({ "enforced_limits": { "position": false } })));
}

/// The links that the SRDF disables may overlap, unless the scenario names pairs or lets all overlap.
#[test]
fn an_srdf_says_which_links_may_overlap() {
    let srdf = r#"<robot name="panda">
        <disable_collisions link1="panda_hand" link2="panda_link2" reason="Never"/></robot>"#;
    std::fs::write(folder().join("panda.srdf"), srdf).expect("it is writable");
    let disabled = [["panda_hand".to_owned(), "panda_link2".to_owned()]];
    for (keys, pairs) in [
        (json!(null), SelfCollision::IgnoredPairs(disabled.into())),
        (json!("off"), SelfCollision::Off),
        (json!({ "ignored_pairs": [] }), SelfCollision::IgnoredPairs(Vec::new())),
    ] {
        let keys = json!({ "srdf": "panda.srdf", "self_collision": keys });
        let file = load("srdf", &with(panda(), keys)).expect("it is good").file;
        assert_eq!(file.srdf, None);
        match (file.self_collision, pairs) {
            // Pairs that always overlap follow those that are named.
            (Some(SelfCollision::IgnoredPairs(found)), SelfCollision::IgnoredPairs(named)) => {
                assert!(found.starts_with(&named), "{found:?}");
            }
            (found, pairs) => assert_eq!(found, Some(pairs)),
        }
    }
    let keys = json!({
        "srdf": "panda.srdf", "self_collision": null, "robot_shape": { "swept_links": { "radius_m": 0.05 } },
    });
    let file = load("swept", &with(panda(), keys)).expect("it is good").file;
    assert_eq!(file.self_collision, None);
}

/// By default neighbours may overlap, and all other pairs but those that never meet keep clear.
#[test]
fn neighbours_may_overlap_by_default() {
    let keys = json!({ "self_collision": null, "obstacles": [] });
    let scenario = load("neighbours", &with(panda(), keys)).expect("it is good");
    let scene = &scenario.scene;
    let names = |pair: &[usize; 2]| pair.map(|i| scene.robot().link_of(&scene.trees()[i]).unwrap_or_default());
    let kept: Vec<_> = scene.tree_pairs().iter().map(names).collect();
    let keeps = |a: &str, b: &str| kept.contains(&[a, b]) || kept.contains(&[b, a]);
    assert!(!keeps("panda_link3", "panda_link4") && !keeps("panda_link0", "panda_link1"));
    assert!(keeps("panda_hand", "panda_link2") && keeps("panda_link0", "panda_link6"), "{kept:?}");
    scenario.check_feasible().expect("nothing overlaps");
}
