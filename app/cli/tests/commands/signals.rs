//! Searches that are asked to end, and files that cannot be completed.
#![cfg(unix)]

use crate::command::{empty_folder, files};
use std::collections::BTreeSet;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

/// Runs a search that would go on for minutes until it tells of a stage, and then asks it to end.
fn interrupted(folder: &Path, signal: &str, stage: &str) -> (Option<i32>, String) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_aghf"))
        .current_dir(folder)
        .args(["solve", "pendulum_2_swingup", "--time-limit-s", "600", "-v", "--starts", "100000"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it runs");
    let mut lines = BufReader::new(child.stderr.take().expect("it is piped")).lines();
    lines
        .by_ref()
        .map(|line| line.expect("it prints text"))
        .find(|line| line.starts_with(stage))
        .expect("it comes to this stage");
    let id = child.id().to_string();
    let sent = Command::new("kill").args([signal, &id]).status();
    assert!(sent.expect("there is such a command").success());
    // Read to its end, so that it can go on telling.
    lines.for_each(drop);
    let output = child.wait_with_output().expect("it ends");
    let stdout = String::from_utf8(output.stdout).expect("it prints text");
    (output.status.code(), stdout)
}

/// Tells whether this process, and so its children, ignore a signal.
fn is_ignored(signal: u32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask & (1 << (signal - 1)) != 0)
}

#[test]
fn ctrl_c_keeps_the_best_motion_and_says_so() {
    // Whoever runs the tests may have the others ignored, as `nohup` does, and what is ignored stays so.
    let signals = [("-INT", 2), ("-HUP", 1)].into_iter().filter(|(_, number)| !is_ignored(*number));
    for (signal, _) in signals.chain([("-TERM", 15)]) {
        let folder = empty_folder(&format!("signal{signal}"));
        // The first batch has ended by then, and something was found.
        let (code, stdout) = interrupted(&folder, signal, "start 9");
        assert_eq!(code, Some(0), "{signal}: {stdout}");
        assert!(stdout.contains("interrupted: the motion is the best minimum"), "{stdout}");
        let out = "out/pendulum_2_swingup";
        let expected = ["report.html", "summary.json", "trajectory.csv"].map(|f| format!("{out}/{f}"));
        assert_eq!(files(&folder), expected.into());
    }
}

/// The exit code of a command of the shell, and what it said on the standard error.
fn shell(folder: &Path, command: &str) -> (Option<i32>, String) {
    let mut shell = Command::new("sh");
    let output = shell.current_dir(folder).args(["-c", command]).output();
    let output = output.expect("it runs");
    let stderr = String::from_utf8(output.stderr).expect("it prints text");
    (output.status.code(), stderr)
}

/// A file that the system does not let grow to its size.
#[test]
fn a_file_that_cannot_be_completed_leaves_nothing() {
    let folder = empty_folder("too_large");
    let command = format!("ulimit -f 8; exec {} solve pendulum_1_swingup --samples 20000", env!("CARGO_BIN_EXE_aghf"));
    let (code, stderr) = shell(&folder, &command);
    assert_eq!(code, Some(2), "{stderr}");
    assert!(stderr.contains("trajectory.csv"), "{stderr}");
    assert_eq!(files(&folder), BTreeSet::new());
}

/// Whoever reads what is told may go away: the motion is written all the same.
#[test]
fn nobody_who_listens_is_no_reason_to_stop() {
    let folder = empty_folder("nobody");
    let binary = env!("CARGO_BIN_EXE_aghf");
    let command = format!(
        "{binary} solve pendulum_1_swingup -v 2>/dev/full && {binary} sample out/*/summary.json --rate 1e5 | head -1"
    );
    let (code, stderr) = shell(&folder, &command);
    assert_eq!((code, stderr.as_str()), (Some(0), ""));
    assert_eq!(files(&folder).len(), 3);
}

/// Of two solves for the same folder one has it, and the other writes to a new private folder and names it. A file or a
/// link of any name in the folder of temporary files, made by whomever, does not matter.
#[test]
#[cfg(unix)]
fn two_solves_for_one_folder_lose_none() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = empty_folder("two");
    let (spare, elsewhere) = (folder.join("spare"), folder.join("elsewhere"));
    for folder in [&spare, &elsewhere] {
        std::fs::create_dir(folder).expect("writable");
    }
    std::fs::write(spare.join("aghf"), "").expect("writable");
    symlink(&elsewhere, spare.join("aghf-pendulum_3_swingup")).expect("writable");
    let solve = || {
        Command::new(env!("CARGO_BIN_EXE_aghf"))
            .current_dir(&folder)
            .env("TMPDIR", &spare)
            .args(["solve", "pendulum_3_swingup", "--out", "same", "--time-limit-s", "1", "--starts", "100000"])
            .output()
            .expect("it runs")
    };
    let runs = std::thread::scope(|scope| {
        let both = [scope.spawn(solve), scope.spawn(solve)];
        both.map(|run| run.join().expect("it ends"))
    });
    assert!(runs.iter().all(|run| run.status.success()));
    let told: String = runs.iter().map(|run| String::from_utf8_lossy(&run.stderr)).collect();
    assert!(told.contains("same/") && told.contains("the files are in "), "{told}");
    let own = std::fs::read_dir(&spare).expect("readable").filter_map(|entry| {
        let entry = entry.expect("readable");
        entry.file_type().expect("readable").is_dir().then(|| entry.path())
    });
    let own: Vec<_> = own.collect();
    let [own] = own.as_slice() else { panic!("one private folder: {own:?}") };
    let mode = std::fs::metadata(own).expect("it is there").permissions().mode();
    assert_eq!((files(own).len(), mode & 0o777), (3, 0o700));
    assert_eq!((files(&folder.join("same")).len(), files(&elsewhere).len()), (3, 0));
}
