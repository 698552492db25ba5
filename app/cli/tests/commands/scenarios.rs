//! Lists, help and standard output of the `aghf` binary.

use crate::command::{aghf, assert_bad_input, empty_folder, files, parsed};
use aghf_cli::sweep::builtin_sweeps;
use aghf_scenario::{builtin_scenarios, generated_scenarios};
use std::process::{Command, Stdio};

#[test]
fn scenarios_lists_all_of_them() {
    let folder = empty_folder("scenarios");
    let run = aghf(&folder, &["scenarios"]);
    assert_eq!(run.code, Some(0));
    let first_words = run.stdout.lines().filter_map(|line| line.split_whitespace().next());
    let listed: Vec<&str> = first_words.take_while(|word| !word.ends_with(':')).collect();
    let known = builtin_scenarios().map(str::to_owned);
    let known: Vec<String> = known.chain(generated_scenarios()).collect();
    assert_eq!(listed, known);
}

#[test]
fn a_scenario_that_is_printed_is_a_scenario_file() {
    let folder = empty_folder("scenario_file");
    let run = aghf(&folder, &["scenarios", "digit_box_03"]);
    assert_eq!(run.code, Some(0));
    std::fs::write(folder.join("digit_box_03.json"), &run.stdout).expect("the folder is writable");
    let again = aghf(&folder, &["scenarios", "digit_box_03.json"]);
    assert_eq!(again.stdout, run.stdout);
    assert_eq!(aghf(&folder, &["scenarios", "digit_box_x"]).code, Some(2));
}

#[test]
fn the_help_is_plain_text() {
    for arguments in [
        &["--help"][..],
        &["solve", "--help"],
        &["sweep", "--help"],
        &["robots", "--help"],
        &["scenarios", "--help"],
        &["eval", "--help"],
    ] {
        let run = aghf(&empty_folder("plain"), arguments);
        assert!(!run.stdout.contains("[`"), "a link of rustdoc in {arguments:?}: {}", run.stdout);
    }
}

#[test]
fn the_help_names_all_sweeps() {
    let help = aghf(&empty_folder("sweeps"), &["sweep", "--help"]).stdout;
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    let list = help.split("Built in: ").nth(1).expect("it lists them");
    let list = list.split('.').next().expect("it ends");
    assert!(list.split(", ").eq(builtin_sweeps()), "{list}");
}

/// Runs with its standard output somewhere else, and returns its exit code and what it says on standard error.
fn with_stdout(stdout: Stdio, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_aghf"));
    command.current_dir(empty_folder("stdout")).args(arguments).stdout(stdout).stderr(Stdio::piped());
    let output = command.spawn().expect("it runs").wait_with_output().expect("it ends");
    (output.status.code(), String::from_utf8(output.stderr).expect("it prints text"))
}

#[test]
fn a_reader_that_went_away_is_no_error_and_a_full_disk_is_one() {
    for arguments in [&["robots"][..], &["robots", "--json"], &["solve", "pendulum_1_swingup"]] {
        let (reader, writer) = std::io::pipe().expect("pipes are to be had");
        drop(reader);
        assert_eq!(with_stdout(writer.into(), arguments), (Some(0), String::new()));
    }
    #[cfg(target_os = "linux")]
    {
        let full = std::fs::File::options().write(true).open("/dev/full");
        let full = full.expect("Linux has it");
        let (code, message) = with_stdout(full.into(), &["robots"]);
        assert_eq!(code, Some(2));
        assert!(message.starts_with("aghf: standard output: "), "{message}");
    }
}

#[test]
fn a_robot_is_chosen_for_generated_scenarios_alone() {
    let folder = empty_folder("chosen_robot");
    let run = aghf(&folder, &["scenarios", "limits_02", "--robot", "pendulum_3"]);
    assert_eq!(parsed(&run)["robot"], "pendulum_3");
    std::fs::write(folder.join("some.json"), run.stdout).expect("writable");
    for command in ["solve", "scenarios"] {
        for (scenario, words) in [
            ("some.json", "some.json: robot: ; names its robot"),
            ("kinova_free_01", "kinova_free_01: robot: ; names its robot"),
            ("kinova_gap_01", "kinova_gap_01: robot: ; kinova_gen3 alone"),
        ] {
            let arguments = [command, scenario, "--robot", "pendulum_2"];
            assert_bad_input(&folder, &arguments, words);
        }
        let arguments = [command, "limits_01", "--mimic", "maybe"];
        assert_bad_input(&folder, &arguments, "--mimic; 'maybe'; independent");
    }
    assert_bad_input(&folder, &["scenarios", "--robot", "pendulum_2"], "SCENARIO");
    assert_eq!(files(&folder).len(), 1, "nothing is written");
}
