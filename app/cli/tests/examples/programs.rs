//! Every example as `cargo test` has built it, in an empty folder.

use crate::command::{empty_folder, files};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The examples, by their files.
fn sources() -> Vec<PathBuf> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("examples");
    let files = std::fs::read_dir(folder).expect("it is there");
    let files = files.map(|file| file.expect("it can be read").path());
    files.filter(|path| path.extension().is_some_and(|e| e == "rs")).collect()
}

/// The name of an example.
fn name_of(source: &Path) -> &str {
    let stem = source.file_stem().and_then(|name| name.to_str());
    stem.expect("names are text")
}

/// The program, beside the folder of this test.
fn program(name: &str) -> PathBuf {
    let this = std::env::current_exe().expect("it runs");
    let built = this.parent().and_then(Path::parent).expect("target/debug");
    built.join("examples").join(format!("{name}{}", std::env::consts::EXE_SUFFIX))
}

/// The output of an example; it has to end well and say nothing else.
fn run(name: &str, folder: &Path, arguments: &[&str]) -> String {
    let program = program(name);
    let time_of = |path: &Path| path.metadata().and_then(|of| of.modified()).ok();
    let source = format!("{}/examples/{name}.rs", concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    assert!(
        time_of(&program) >= time_of(Path::new(&source)),
        "{} is older than its source, or not there: cargo build --examples, or cargo test without --test, builds it",
        program.display()
    );
    let mut command = Command::new(program);
    let output = command.current_dir(folder).args(arguments).output();
    let output = output.expect("it runs");
    let [stdout, stderr] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).expect("it is text"));
    assert!(output.status.success(), "{name}: {stdout}{stderr}");
    assert_eq!(stderr, "", "{name}");
    stdout
}

/// The numbers in column `i` of the lines that have one there.
fn column(text: &str, i: usize) -> Vec<f64> {
    let cells = text.lines().map(|line| line.split_whitespace().nth(i));
    cells.filter_map(|cell| cell.and_then(|cell| cell.parse().ok())).collect()
}

#[test]
fn all_are_short() {
    let sources = sources();
    let names: BTreeSet<&str> = sources.iter().map(|source| name_of(source)).collect();
    let tried = [
        "another_robot",
        "code_to_file",
        "own_constraint",
        "own_jacobian",
        "own_lagrangian",
        "own_program",
        "own_scalar",
        "tracker",
    ];
    // Whoever adds one adds its test below.
    assert_eq!(names, BTreeSet::from(tried));
    for source in &sources {
        let text = std::fs::read_to_string(source).expect("it can be read");
        let lines = text.lines().count();
        assert!(lines < 60, "{}: {lines} lines", name_of(source));
    }
}

/// The heavier the potential the nearer the motion stays to rest, and the more effort it takes.
#[test]
fn own_lagrangian() {
    let shown = run("own_lagrangian", &empty_folder("own_lagrangian"), &[]);
    let (distances, efforts) = (column(&shown, 1), column(&shown, 2));
    assert_eq!((distances.len(), efforts.len()), (3, 3), "{shown}");
    assert!(distances.windows(2).all(|d| d[1] < d[0]), "{shown}");
    assert!(efforts.windows(2).all(|e| e[1] > e[0]), "{shown}");
}

/// Both methods keep every row, and the constraint of one's own is among those that matter.
#[test]
fn own_constraint() {
    let shown = run("own_constraint", &empty_folder("own_constraint"), &[]);
    let left = column(&shown, 0);
    assert_eq!(left.len(), 8, "{shown}");
    assert!(left.iter().all(|left| *left > -1e-6), "{shown}");
    assert_eq!(shown.matches("height of the tool").count(), 2, "{shown}");
}

/// The checker tells good blocks from rough ones; the flow comes to the same curve by both.
#[test]
fn own_jacobian() {
    let shown = run("own_jacobian", &empty_folder("own_jacobian"), &[]);
    let blocks = shown.lines().filter(|line| line.contains("fourth-order"));
    let blocks: Vec<_> = blocks.collect();
    assert_eq!(blocks.len(), 6, "{shown}");
    let verdict = |line: &&str| line.trim_end().ends_with("ok");
    let good = blocks.iter().filter(|line| verdict(line)).count();
    assert!((3..6).contains(&good), "{shown}");
    let (_, difference) = shown.trim_end().rsplit_once("curves: ").expect("it tells the difference");
    let difference: f64 = difference.parse().expect("a number");
    assert!((0.0..1e-6).contains(&difference), "{shown}");
}

/// The solution of the literature, to all of its digits that are shown.
#[test]
fn own_program() {
    let shown = run("own_program", &empty_folder("own_program"), &[]);
    assert!(shown.starts_with("Converged") && shown.contains("f = 17.014017"), "{shown}");
}

/// As many operations as there are, the same on every machine, and about as many for each further joint of a chain.
#[test]
fn own_scalar() {
    let shown = run("own_scalar", &empty_folder("own_scalar"), &[]);
    let (joints, alone) = (column(&shown, 1), column(&shown, 2));
    let derivatives = column(&shown, 3);
    assert_eq!(alone.len(), aghf::urdf::builtin_robots().count(), "{shown}");
    assert!(alone.iter().zip(&derivatives).all(|(a, d)| a < d));
    // The pendulums.
    let further: Vec<f64> = alone[..6].windows(2).map(|a| a[1] - a[0]).collect();
    assert!(further.iter().all(|f| *f == further[0]), "{shown}");
    assert_eq!(joints[..6], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
}

/// The motion keeps its rows at every step, and ends at the goal where that has stopped.
#[test]
fn tracker() {
    let shown = run("tracker", &empty_folder("tracker"), &[]);
    assert!(shown.contains("Finished Kept"), "{shown}");
    assert!(!shown.contains("Violated") && !shown.contains("Left"), "{shown}");
    let last = shown.lines().last().and_then(|line| line.split(' ').next());
    let error: f64 = last.and_then(|x| x.parse().ok()).expect("a number");
    assert!(error < 0.01, "{shown}");
}

/// A second run takes another folder and leaves the first as it was.
#[test]
fn code_to_file() {
    let folder = empty_folder("code_to_file");
    let shown = run("code_to_file", &folder, &[]);
    assert!(shown.starts_with("success: true"), "{shown}");
    let names = ["q.svg", "report.html", "summary.json", "trajectory.csv", "u.svg"];
    let of = |i: usize| {
        let folder = if i == 1 { "code_to_file" } else { "code_to_file-2" };
        names.map(|name| format!("out/{folder}/{name}"))
    };
    assert_eq!(files(&folder), BTreeSet::from(of(1)));
    let read = |file: &str| std::fs::read_to_string(folder.join(file)).expect("it is there");
    let before = of(1).map(|file| read(&file));
    for (name, text) in names.iter().zip(&before) {
        assert!(shown.contains(name), "{shown}");
        // Seven joints: a line each, and one in the legend.
        let lines = text.matches("<polyline").count();
        assert!(!name.ends_with("svg") || (text.contains("joint_7") && lines >= 7), "{name}");
    }
    run("code_to_file", &folder, &[]);
    assert_eq!(files(&folder), of(1).into_iter().chain(of(2)).collect());
    assert_eq!(of(1).map(|file| read(&file)), before);
}

#[test]
fn another_robot() {
    let folder = empty_folder("another_robot");
    let path = format!("{}/robots/kinova_gen3/kinova_gen3.urdf", concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let arguments: [&[&str]; 2] = [&[], &[&path]];
    for (arguments, joints) in arguments.into_iter().zip([22, 7]) {
        let shown = run("another_robot", &folder, arguments);
        assert!(shown.contains(&format!(": {joints} joints")), "{shown}");
        let differences = column(&shown, 1);
        let small = differences.iter().filter(|d| (0.0..1e-12).contains(*d));
        assert_eq!(small.count(), 5, "{shown}");
    }
}
