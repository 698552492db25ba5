//! Bad input: exit code 2, a message that names file and element, and no files.

use crate::command::{assert_bad_input, empty_folder, files};
use crate::import::{IMPORT, folder, import_of};
use serde::Deserialize;
use std::collections::BTreeMap;

/// Files, commands and problems of MoveIt, each with words of the condition once per kind of message.
const CASES: &str = include_str!("refused.json");

#[derive(Deserialize)]
struct Cases {
    files: BTreeMap<String, String>,
    /// The arguments, the place that the error names, and words.
    commands: Vec<Vec<String>>,
    /// A file, a part that it has once or all of it, what stands there instead, the element, and words.
    import: Vec<Vec<Option<String>>>,
}

fn cases() -> Cases {
    serde_json::from_str(CASES).expect("it has these keys")
}

#[test]
fn commands_are_refused_by_the_place_of_the_error() {
    let (cases, folder) = (cases(), empty_folder("refused"));
    for (name, text) in &cases.files {
        std::fs::write(folder.join(name), text).expect("writable");
    }
    for case in &cases.commands {
        let arguments: Vec<&str> = case[0].split(' ').collect();
        let place =
            if case[1].is_empty() || case[1].starts_with('-') { case[1].clone() } else { format!("{}: ", case[1]) };
        let words = case.get(2).map_or("", String::as_str);
        assert_bad_input(&folder, &arguments, &format!("{place}; {words}"));
    }
    let left = files(&folder);
    let of_sweeps = |file: &&String| file.starts_with("out/sweeps");
    let written = left.iter().filter(|file| !of_sweeps(file)).count();
    assert_eq!(written, cases.files.len(), "{left:?}");
}

#[test]
fn problems_of_moveit_are_refused_by_file_and_element() {
    for case in &cases().import {
        let part = |i: usize| case.get(i).and_then(Option::as_deref);
        let [file, bad, element] = [0, 2, 3].map(|i| part(i).expect("it is given"));
        let folder = folder("import_refused", file, part(1), bad);
        let words = format!("{file}: {element}: ; {}", part(4).unwrap_or(""));
        let request = if file == "pose.yaml" { file } else { "request.yaml" };
        assert_bad_input(&folder, &import_of(request), &words);
        assert_eq!(files(&folder).len(), 5, "{element}: something was written");
    }
}

/// Options of an import that its scenario refuses.
#[test]
fn bad_options_of_an_import_leave_no_file() {
    let folder = folder("import_options", "", None, "");
    for (more, words) in [
        (&["--horizon", "-1"][..], "made.json: horizon_s"),
        (&["--horizon-bounds", "3", "2"], "made.json: free_horizon"),
        (&["--excess", "0"], "excess: it is 0 and must be a positive number"),
    ] {
        assert_bad_input(&folder, &[&IMPORT, more].concat(), words);
    }
    assert!(!folder.join("made.json").exists());
}

/// No text takes the program down.
#[test]
fn deep_nesting_is_refused() {
    for open in ["[", "{a: ", "- "] {
        let folder = folder("import_deep", "scene.yaml", None, &open.repeat(100_000));
        assert_bad_input(&folder, &IMPORT, "scene.yaml: scene: ");
    }
}

#[test]
fn lists_of_a_sweep_have_bounds() {
    let folder = empty_folder("sweep_bounds");
    let list = |count: usize| {
        let values: Vec<_> = (1..=count).map(|i| format!("{i}.0")).collect();
        values.join(", ")
    };
    let (long, longer) = (list(2000), list(10_001));
    let costs = format!("[objective]\neffort = [{long}]\nvelocity = [{long}]\nacceleration = [{long}]");
    for (keys, words) in [
        ("starts = [100001]".to_owned(), "starts[0]: it is 100001 and must be at least 1 and at most 100000"),
        (format!("tolerance = [{longer}]"), "tolerance: it has 10001 values, at most 10000"),
        (costs, "sweep: the grid has more than 1000000 sets"),
        ("objective = [[1.0], [0.1], [0.2]]".to_owned(), "objective[0]: ; the name of an objective, or an object"),
    ] {
        let text = format!("method = 'direct'\nscenarios = ['pendulum_*']\ntime_limit_s = 1\n{keys}\n");
        std::fs::write(folder.join("s.toml"), text).expect("writable");
        assert_bad_input(&folder, &["sweep", "s.toml"], &format!("s.toml: {words}"));
    }
    let text = "method = 'flow'\nscenarios = ['pendulum_*']\ntime_limit_s = 1e300\ndegree = [4]\nk = [1e5]\n\
        s_max = [1]\n";
    std::fs::write(folder.join("s.toml"), text).expect("writable");
    let words = "s.toml: time_limit_s: it is 1e300 and must be ; at most 31536000 s";
    assert_bad_input(&folder, &["sweep", "s.toml"], words);
}

/// A file that has no end is not read to its end.
#[test]
#[cfg(unix)]
fn texts_without_end_are_refused() {
    let folder = empty_folder("endless");
    for arguments in [
        &["solve", "/dev/zero"][..],
        &["robots", "/dev/zero"],
        &["sweep", "/dev/zero"],
        &["eval", "pendulum_1", "/dev/zero"],
    ] {
        assert_bad_input(&folder, arguments, "aghf: /dev/zero: ; more than 64 MiB");
    }
}
