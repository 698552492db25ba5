//! Bad problems of MoveIt: each is refused by an error that names the file and the element, and nothing is written.

use crate::command::assert_bad_input;
use crate::import::{IMPORT, REQUEST, SCENE, folder};

#[test]
fn bad_problems_are_refused_by_file_and_element_and_nothing_is_written() {
    let cut = |text: &'static str, at: &str| text.split_once(at).expect("it is there").1;
    for (file, good, bad, words) in [
        (
            "scene.yaml",
            "[1, 2, 0.1]",
            "[1, 2]",
            "scene.yaml: world.collision_objects[0] 'table'.primitives[0]: ; three lengths; 2 numbers",
        ),
        (
            "scene.yaml",
            "[1, 2, 0.1]",
            "[1, 2, -0.1]",
            "collision_objects[0] 'table'.primitives[0]: size_m has -0.1",
        ),
        (
            "scene.yaml",
            "[1, 2, 0.1]",
            "[1, two, 0.1]",
            "scene.yaml: world.collision_objects[0].primitives[0].dimensions[1]: ",
        ),
        (
            "scene.yaml",
            "[1, 2, 0.1]",
            "[1, .nan, 0.1]",
            "scene.yaml: scene: ; not finite, .nan, at line",
        ),
        (
            "scene.yaml",
            "[0.4, 0.03]",
            "[0.4]",
            "'shelf'.primitives[0]: ; length and radius",
        ),
        (
            "scene.yaml",
            "type: cylinder",
            "type: cone",
            "'shelf'.primitives[0]: type is 'cone'",
        ),
        (
            "scene.yaml",
            "type: 2",
            "type: 9",
            "'shelf'.primitives[1]: type is 'shape 9'",
        ),
        (
            "scene.yaml",
            "      primitives: [{type: box, dimensions: [1, 2, 0.1]}]",
            "",
            "'table': it has no primitives",
        ),
        (
            "scene.yaml",
            "      primitives: [{type: box, dimensions: [1, 2, 0.1]}]",
            "      meshes: [{}]",
            "'table': it has meshes",
        ),
        (
            "scene.yaml",
            "        - {position: [0, 0, 2], orientation: [0, 0, 0, 1]}",
            "",
            "'shelf': it has 2 primitives, but 1 primitive_poses",
        ),
        (
            "scene.yaml",
            "[1, 0, 0, 0]",
            "[2, 0, 0, 0]",
            "'shelf'.primitives[0]: ; has length 2",
        ),
        (
            "scene.yaml",
            "data: []",
            "data: [1]",
            "scene.yaml: world.octomap: ",
        ),
        (
            "scene.yaml",
            cut(SCENE, "dimensions: [0.4, "),
            "",
            "scene.yaml: scene: not valid YAML",
        ),
        (
            "scene.yaml",
            cut(SCENE, "world:\n  octomap"),
            "",
            "scene.yaml: world",
        ),
        (
            "scene.yaml",
            SCENE,
            "",
            "scene.yaml: scene: not valid YAML: it is empty",
        ),
        (
            "scene.yaml",
            SCENE,
            "- 1\n- 2\n",
            "scene.yaml: scene: it is no YAML with keys",
        ),
        (
            "scene.yaml",
            "- id: shelf",
            "- id: shelf\n      id: rack",
            "scene.yaml: scene: not valid YAML: the key 'id' for the second time",
        ),
        (
            "scene.yaml",
            "[0.25, 0.5, 7]",
            "[0.25, 0.5]",
            "scene.yaml: robot_state.joint_state: it has 3 names, but 2 positions",
        ),
        (
            "scene.yaml",
            "wrist, glue",
            "shoulder, glue",
            "scene.yaml: robot_state.joint_state.name[1]: joint 'shoulder' is named twice",
        ),
        (
            "scene.yaml",
            "wrist, glue",
            "glue, elbow",
            "scene.yaml: robot_state.joint_state.name[2]: the robot has no joint 'elbow'",
        ),
        (
            "scene.yaml",
            "shoulder, wrist, glue], position: [0.25, 0.5, 7]",
            "glue], position: [7]",
            "request.yaml: start_state.joint_state: joint 'wrist'",
        ),
        (
            "scene.yaml",
            "translation: [0, 0, 0]",
            "translation: [0, 0, 1]",
            "scene.yaml: robot_state.multi_dof_joint_state.transforms[0]: it moves the robot",
        ),
        (
            "request.yaml",
            "position: 1.0",
            "position: far",
            "request.yaml: goal_constraints[0].joint_constraints[0].position: ",
        ),
        (
            "request.yaml",
            "joint_name: shoulder",
            "joint_name: elbow",
            "request.yaml: goal_constraints[0].joint_constraints[0]: ; no joint 'elbow' that moves",
        ),
        (
            "request.yaml",
            "joint_name: shoulder",
            "joint_name: glue",
            "request.yaml: goal_constraints[0].joint_constraints[0]: ; no joint 'glue' that moves",
        ),
        (
            "request.yaml",
            "      - {joint_name: shoulder, position: 1.0, weight: 1}",
            "      []",
            "request.yaml: goal_constraints[0]: it has no joint_constraints",
        ),
        (
            "request.yaml",
            cut(REQUEST, "position: [-0.5]}\n"),
            "",
            "request.yaml: request: missing field `goal_constraints`",
        ),
        (
            "request.yaml",
            "joint_constraints: []",
            "joint_constraints: [{joint_name: wrist}]",
            "request.yaml: path_constraints: ",
        ),
        (
            "request.yaml",
            "position: 1.0",
            "position: 1e300",
            "request.yaml: goal_constraints: ; so far from the start that it would take up to ",
        ),
        (
            "request.yaml",
            "goal_constraints:\n",
            "goal_constraints:\n  - joint_constraints: []\n",
            "request.yaml: goal_constraints: it has 2 goals",
        ),
        (
            "robot.srdf",
            r#"link2="hand""#,
            r#"link2="foot""#,
            "robot.srdf: disable_collisions at line 1: ; no link 'foot'",
        ),
        (
            "robot.srdf",
            "</robot>",
            "",
            "robot.srdf: robot: not a valid SRDF",
        ),
        (
            "robot.urdf",
            r#"radius="0.05""#,
            r#"radius="-0.05""#,
            "robot.urdf: link 'hand': collision 1: radius of its sphere has -0.05",
        ),
    ] {
        let folder = folder("import_refused", file, good, bad);
        assert_bad_input(&folder, &IMPORT, words);
        let files = std::fs::read_dir(&folder).expect("it is there").count();
        assert_eq!(files, 4, "{words}: something was written");
    }
    let folder = folder("import_options", "", "", "");
    for (more, words) in [
        (&["--horizon", "-1"][..], "made.json: horizon_s"),
        (&["--horizon-bounds", "3", "2"], "made.json: free_horizon"),
        (&["--spacing", "0"], "made.json: robot_shape"),
    ] {
        assert_bad_input(&folder, &[&IMPORT, more].concat(), words);
    }
    assert!(!folder.join("made.json").exists());
}

/// No text takes the program down.
#[test]
fn deep_nesting_is_refused() {
    for open in ["[", "{a: ", "- "] {
        let folder = folder("import_deep", "scene.yaml", SCENE, &open.repeat(100_000));
        assert_bad_input(&folder, &IMPORT, "scene.yaml: scene: ");
    }
}
