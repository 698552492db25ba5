//! The files and the standard input that `aghf` reads, and what it notes of robots.

use crate::command::{Run, aghf, aghf_reading, assert_bad_input, empty_folder};
use std::fs::File;
use std::path::Path;

const SCENARIO: &str = r#"{"robot": "pendulum_1", "horizon_s": 2, "q_start": [0], "v_start": [0], "q_goal": [1],
    "v_goal": [0]}"#;
const SWEEP: &str = "method = 'flow'\nscenarios = ['s.json']\ntime_limit_s = 60\ndegree = [4]\nk = [1e5]\n\
    s_max = [0.1]\n";

/// Three sliders, the first of which has damping and all of which have friction, none with an effort limit; the last
/// one carries a body that is none.
fn odd_robot() -> String {
    let mut text = "<robot name='odd'><link name='l0'/>".to_owned();
    for i in 1..=3 {
        let (mass, damping) = (if i == 3 { -1 } else { 1 }, if i == 1 { "0.5" } else { "0" });
        text += &format!(
            "<link name='l{i}'><inertial><mass value='1'/>
               <inertia ixx='{mass}' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial></link>
             <joint name='j{i}' type='prismatic'><parent link='l{}'/><child link='l{i}'/><axis xyz='{} {} {}'/>
               <limit lower='-2' upper='2' velocity='5' effort='0'/>\
               <dynamics damping='{damping}' friction='0.1'/></joint>",
            i - 1,
            i32::from(i == 1),
            i32::from(i == 2),
            i32::from(i == 3),
        );
    }
    text + "</robot>"
}

fn write(folder: &Path, files: &[(&str, &str)]) {
    for (name, text) in files {
        std::fs::write(folder.join(name), text).expect("writable");
    }
}

/// Runs `aghf` with the file `name` as the standard input.
fn reading(folder: &Path, arguments: &[&str], name: &str) -> Run {
    let file = File::open(folder.join(name)).expect("it is there");
    aghf_reading(folder, arguments, file)
}

#[test]
fn the_standard_input_stands_for_any_file() {
    let folder = empty_folder("standard_input");
    let robot = concat!(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."), "/robots/pendulum_2/pendulum_2.urdf");
    std::fs::copy(robot, folder.join("r.urdf")).expect("writable");
    let state = r#"{"q": [0, 1], "v": [2, 3], "a": [4, 5]}"#;
    write(&folder, &[("s.json", SCENARIO), ("s.toml", SWEEP), ("state.json", state)]);
    for (before, after, name) in [
        (&["scenarios"][..], &[][..], "s.json"),
        (&["robots"], &["--json"], "r.urdf"),
        (&["check"], &["--samples", "1"], "r.urdf"),
        (&["eval"], &["state.json"], "r.urdf"),
        (&["eval", "pendulum_2"], &[], "state.json"),
        (&["scenarios", "limits_01", "--robot"], &[], "r.urdf"),
    ] {
        let [read, named] = ["-", name].map(|file| reading(&folder, &[before, &[file], after].concat(), name));
        assert_eq!((read.code, read.stderr.as_str()), (Some(0), ""), "{before:?}");
        let of_file = named.stdout.replace(&format!("\"{name}\""), "\"-\"");
        assert_eq!(read.stdout, of_file, "{before:?}");
    }
    for (arguments, name, written) in [
        (&["solve", "-", "--degree", "6"][..], "s.json", "out/stdin/summary.json"),
        (&["sweep", "-"], "s.toml", "out/sweeps/stdin/results.csv"),
    ] {
        let run = reading(&folder, arguments, name);
        assert_eq!(run.code, Some(0), "{arguments:?}: {}", run.stderr);
        assert!(folder.join(written).exists(), "{written}");
    }
}

#[test]
fn byte_order_marks_are_no_part_of_a_text() {
    let folder = empty_folder("marks");
    let robot = std::fs::read_to_string(concat!(
        concat!(env!("CARGO_MANIFEST_DIR"), "/../.."),
        "/robots/pendulum_1/pendulum_1.urdf"
    ));
    let mark = |text: &str| format!("\u{feff}{text}");
    let texts =
        [mark(SCENARIO), mark(SWEEP), mark(&robot.expect("it is there")), mark(r#"{"q": [0], "v": [0], "a": [0]}"#)];
    write(&folder, &[("s.json", &texts[0]), ("s.toml", &texts[1]), ("r.urdf", &texts[2]), ("e.json", &texts[3])]);
    for arguments in [&["scenarios", "s.json"][..], &["sweep", "s.toml"], &["eval", "r.urdf", "e.json"]] {
        let run = aghf(&folder, arguments);
        assert_eq!(run.code, Some(0), "{arguments:?}: {}", run.stderr);
    }
    let wide: Vec<u8> = mark(SCENARIO).encode_utf16().flat_map(u16::to_le_bytes).collect();
    std::fs::write(folder.join("wide.json"), wide).expect("writable");
    assert_bad_input(&folder, &["solve", "wide.json"], "wide.json: ; UTF-16");
    std::fs::write(folder.join("latin.json"), b"{\n\"robot\": \"\xe9\"}").expect("writable");
    assert_bad_input(&folder, &["solve", "latin.json"], "latin.json: ; UTF-8; line 2");
}

/// All that bears on a motion is told wherever a robot is loaded, on the standard error, one line a kind.
#[test]
fn notes_on_a_robot_are_told_wherever_it_is_loaded() {
    let folder = empty_folder("notes");
    let zeros = |key: &str| format!("\"{key}\": [0, 0, 0]");
    let keys = ["q_start", "v_start", "v_goal"].map(zeros).join(", ");
    let scenario = format!(r#"{{"robot": "r.urdf", "horizon_s": 2, "q_goal": [0.1, 0, 0], {keys}}}"#);
    let state = r#"{"q": [0, 0, 0], "v": [0, 0, 0], "a": [0, 0, 0]}"#;
    write(&folder, &[("r.urdf", &odd_robot()), ("s.json", &scenario), ("s.toml", SWEEP), ("state.json", state)]);
    let notes = "note: r.urdf: joint 'j1': damping is not counted, as losses are not asked for
note: r.urdf: joints 'j1', 'j2', 'j3': friction is not counted, as losses are not asked for
note: r.urdf: joints 'j1', 'j2', 'j3': effort limit of 0 counts as unknown, no limit
note: r.urdf: link 'l3': its principal moment of inertia -1e0 is negative
";
    let sorted = |text: &str| {
        let mut lines: Vec<_> = text.lines().map(str::to_owned).collect();
        lines.sort();
        lines
    };
    for arguments in [
        &["solve", "s.json", "--json"][..],
        &["scenarios", "s.json"],
        &["sweep", "s.toml"],
        &["check", "r.urdf", "--samples", "1", "--json"],
        &["eval", "r.urdf", "state.json"],
    ] {
        let run = aghf(&folder, arguments);
        assert_eq!(run.code, Some(0), "{arguments:?}: {}", run.stderr);
        assert_eq!(sorted(&run.stderr), sorted(notes), "{arguments:?}");
        assert!(!run.stdout.contains("note: "), "{arguments:?}: {}", run.stdout);
    }
    // Losses that count are no note.
    let of_losses = |flags: &[&str]| {
        let command = [&["eval", "r.urdf", "state.json"], flags].concat();
        let run = aghf(&folder, &command);
        assert_eq!(run.code, Some(0), "{flags:?}: {}", run.stderr);
        run.stderr.contains("not counted")
    };
    assert!(of_losses(&[]) && !of_losses(&["--losses"]));
    // All is in the list that is asked for, and of what is built in nothing is told.
    let run = aghf(&folder, &["robots", "r.urdf"]);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    assert!(run.stdout.contains("link 'l0': massless") && run.stdout.contains("joint 'j3': friction"));
    assert_eq!(aghf(&folder, &["solve", "digit_free_step", "--degree", "4", "--starts", "1"]).stderr, "");
}
