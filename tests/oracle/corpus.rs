//! Every URDF of two public collections and of this project: either it agrees with Pinocchio, or it is refused for a
//! stated reason.

use crate::common::config;
use crate::compare::{Comparison, assert_same_names, compare_dynamics, compare_second_derivatives, state};
use crate::python::{Oracle, venv};
use aghf::model::Model;
use aghf::urdf::{Mimic, UrdfOptions, parse_urdf_with};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// The refused robots, and words of the reason.
const REFUSED: [(&str, &str); 5] = [
    ("hector_description/robots/quadrotor_base.urdf", "has no moving joint"),
    ("iris_description/robots/iris_simple.urdf", "has no moving joint"),
    // Massless fingers and grippers, the former with mimic joints.
    ("romeo_description/urdf/romeo.urdf", "the mass matrix is singular"),
    ("romeo_description/urdf/romeo_laas_small.urdf", "the mass matrix is singular"),
    // A file without a link.
    ("ur_description/urdf/ur3.urdf", "has no links"),
];

/// The robots with mimic joints, which are refused unless their independence is requested, the treatment of Pinocchio.
const MIMIC: [&str; 8] = [
    "alex_description/urdf/alex_psyonic_hands.urdf",
    "baxter_description/urdf/baxter.urdf",
    "panda_description/urdf/panda.urdf",
    "panda_description/urdf/panda_collision.urdf",
    "pr2_description/urdf/pr2.urdf",
    "talos_data/robots/talos_full_v2.urdf",
    "talos_data/robots/talos_full_v2_box.urdf",
    "tiago_pro_description/robots/tiago_pro.urdf",
];

/// The number of states at which a robot is compared: few suffice, because only reading is tested here.
const STATES: u32 = 3;

/// The columns of the table, each with prefixes of names of quantities.
const COLUMNS: [(&str, &[&str]); 10] = [
    ("kinematics", &["joint placements", "link placements"]),
    ("Jacobians", &["joint axes", "link Jacobians"]),
    ("ID, C, gravity", &["ID", "C", "gravity"]),
    ("H, Hdot", &["H", "Hdot", "dID/da"]),
    ("energy", &["kinetic energy", "potential energy"]),
    ("FD", &["FD", "dFD/dtau"]),
    ("dID", &["dID/dq", "dID/dv"]),
    ("dFD", &["dFD/dq", "dFD/dv"]),
    ("root wrench", &["root wrench", "droot/dq", "droot/dv", "droot/da"]),
    ("d2ID", &["d2ID/dqdq", "d2ID/dqdv", "d2ID/dvdv", "d2ID/dadq"]),
];

/// The outcome for a robot.
enum Outcome {
    Compared { joints: usize, mimic: bool, comparison: Comparison },
    Refused { reason: String, pinocchio: String },
}

#[test]
fn every_robot_agrees_or_is_refused_for_a_stated_reason() {
    let robots = robots();
    let mut table = header();
    let (mut agreed, mut refused, mut wrong) = (0, 0, Vec::new());
    for (name, path) in &robots {
        let expected = REFUSED.iter().find(|(robot, _)| robot == name);
        let outcome = outcome(path);
        table += &row(name, &outcome);
        let words = expected.map(|(_, words)| *words);
        match (outcome, words) {
            (Outcome::Compared { comparison, mimic, .. }, None) => {
                if mimic != MIMIC.contains(&name.as_str()) {
                    wrong.push(format!("{name}: mimic joints were {mimic}"));
                }
                agreed += usize::from(comparison.off.is_empty());
                wrong.extend(comparison.off.iter().map(|off| format!("{name}: {off}")));
            }
            (Outcome::Compared { .. }, Some(_)) => wrong.push(format!("{name}: no longer refused")),
            (Outcome::Refused { reason, .. }, Some(words)) if reason.contains(words) => refused += 1,
            (Outcome::Refused { reason, .. }, _) => wrong.push(format!("{name}: {reason}")),
        }
    }
    let summary = format!("\n{agreed} of {} robots agree, {refused} are refused.\n", robots.len());
    table += &summary;
    println!("{table}");
    let file = venv().with_file_name("corpus.md");
    std::fs::write(file, table).expect("the folder is there");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert_eq!(refused, REFUSED.len(), "a refused robot is not there");
    assert!(agreed >= 70, "{summary}");
}

/// Reads and compares a robot. Mimic joints are independent, as in Pinocchio.
fn outcome(path: &Path) -> Outcome {
    let file = path.display().to_string();
    let text = std::fs::read_to_string(path).expect("it can be read");
    let read = |mimic| parse_urdf_with(&text, &file, UrdfOptions { mimic, ..UrdfOptions::default() });
    let strict = read(Mimic::Refuse);
    let mimic = strict.as_ref().is_err_and(|e| e.to_string().contains("mimic"));
    let loaded = if mimic { read(Mimic::Independent) } else { strict };
    let oracle = Oracle::load(&text);
    match loaded {
        Ok((model, _)) => Outcome::Compared {
            joints: model.dof(),
            mimic,
            comparison: compare(&model, &oracle.expect("Pinocchio reads it")),
        },
        Err(error) => Outcome::Refused {
            reason: error.to_string().replace(&format!("{file}: "), ""),
            pinocchio: match oracle {
                Ok(oracle) => oracle.summary(),
                Err(error) => format!("refuses: {error}"),
            },
        },
    }
}

/// Compares at a few random states, the second derivatives only at the first.
fn compare(model: &Model, oracle: &Oracle) -> Comparison {
    assert_same_names(model, oracle);
    let mut comparison = Comparison::default();
    let mut runner = TestRunner::new(config(STATES));
    for case in 0..STATES {
        let state = state(model).new_tree(&mut runner).expect("no filter").current();
        comparison.merge(compare_dynamics(model, oracle, &state));
        if case == 0 {
            comparison.merge(compare_second_derivatives(model, oracle, &state));
        }
    }
    comparison
}

/// All robots with their names: the path below the folder of their collection.
fn robots() -> Vec<(String, PathBuf)> {
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    let mut found = Vec::new();
    let mut of_collection = |folder: &Path, count: usize| {
        let mut files = Vec::new();
        collect(folder, &mut files);
        assert_eq!(files.len(), count, "robots in {}", folder.display());
        files.sort();
        let name = |p: &PathBuf| p.strip_prefix(folder).map(|p| p.display().to_string());
        found.extend(files.into_iter().map(|p| (name(&p).expect("it is below"), p)));
    };
    of_collection(&crate::python::share("example-robot-data/robots"), 69);
    of_collection(&venv().join("share/iCub/robots"), 16);
    of_collection(&project, 16);
    found
}

/// The URDF files below a folder.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    for entry in entries {
        let path = entry.expect("it can be listed").path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|e| e == "urdf") {
            files.push(path);
        }
    }
}

fn header() -> String {
    let names: Vec<_> = COLUMNS.iter().map(|(name, _)| *name).collect();
    let rule = "| --- ".repeat(COLUMNS.len() + 2);
    format!("| robot | joints | {} |\n{rule}|\n", names.join(" | "))
}

fn row(name: &str, outcome: &Outcome) -> String {
    let mut row = format!("| {name} |");
    let written = match outcome {
        Outcome::Compared { joints, mimic, comparison } => {
            let note = if *mimic { ", mimic joints independent" } else { "" };
            let worst = COLUMNS.map(|(_, of)| of.iter().map(|q| comparison.worst[*q]).fold(0.0, f64::max));
            let worst = worst.map(|e| format!("{e:.0e}")).join(" | ");
            writeln!(row, " {joints}{note} | {worst} |")
        }
        Outcome::Refused { reason, pinocchio } => {
            writeln!(row, " refused: {reason} (Pinocchio: {pinocchio}) |")
        }
    };
    written.expect("a text takes everything");
    row
}
