//! Helpers of the tests of the binary, which run it in a folder of its own.
#![allow(dead_code)] // every test file uses its own part of it

use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// An empty folder for one test.
pub fn empty_folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli").join(test);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).expect("it is ours");
    }
    std::fs::create_dir_all(&folder).expect("the folder is writable");
    folder
}

/// The outcome of a command.
pub struct Run {
    /// Its exit code.
    pub code: Option<i32>,
    /// Its standard output.
    pub stdout: String,
    /// Its standard error.
    pub stderr: String,
}

/// Runs `aghf` in a folder.
pub fn aghf(folder: &Path, arguments: &[&str]) -> Run {
    aghf_reading(folder, arguments, Stdio::null())
}

/// Runs `aghf` in a folder with a standard input.
pub fn aghf_reading(folder: &Path, arguments: &[&str], input: impl Into<Stdio>) -> Run {
    let mut command = Command::new(env!("CARGO_BIN_EXE_aghf"));
    let output = command.current_dir(folder).args(arguments).stdin(input).output().expect("it runs");
    Run {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).expect("it prints text"),
        stderr: String::from_utf8(output.stderr).expect("it prints text"),
    }
}

/// Asserts exit code 2, nothing on the standard output, and one message with all words (between semicolons).
pub fn assert_bad_input(folder: &Path, arguments: &[&str], words: &str) {
    let run = aghf(folder, arguments);
    let all = words.split("; ").all(|word| run.stderr.contains(word));
    let good = run.code == Some(2) && run.stdout.is_empty() && all && !run.stderr.contains("panicked");
    assert!(
        good,
        "{arguments:?}: {:?} {}{}\nwant {words}",
        run.code,
        run.stdout.chars().take(200).collect::<String>(),
        run.stderr
    );
}

/// The files below a folder, relative to it.
pub fn files(folder: &Path) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for entry in std::fs::read_dir(folder).expect("it is there") {
        let entry = entry.expect("it can be read");
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.path().is_dir() {
            found.extend(files(&entry.path()).iter().map(|f| format!("{name}/{f}")));
        } else {
            found.insert(name);
        }
    }
    found
}

/// The JSON that a successful run printed.
pub fn parsed(run: &Run) -> Value {
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    serde_json::from_str(&run.stdout).expect("it is JSON and nothing else")
}
