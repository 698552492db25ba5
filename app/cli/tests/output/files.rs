//! Files of results and what is none.

use crate::command::{aghf, assert_bad_input, empty_folder, files};

const SWING: &str = "pendulum_1_swingup";

/// What is no file is neither replaced nor written through, whatever the command, and it is refused before the work.
#[cfg(unix)]
#[test]
fn devices_and_links_are_not_replaced() {
    use std::os::unix::{fs::symlink, net::UnixListener};
    let folder = empty_folder("special");
    let run = aghf(&folder, &["solve", SWING, "--out", "here"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    std::fs::create_dir(folder.join("folder")).expect("writable");
    let _socket = UnixListener::bind(folder.join("socket")).expect("writable");
    symlink("/dev/null", folder.join("device")).expect("writable");
    std::fs::write(folder.join("file"), "mine").expect("writable");
    symlink("file", folder.join("link")).expect("writable");
    let before = files(&folder);
    let commands = [
        &["certify", SWING, "here", "--out"][..],
        &["sample", "here", "--out"],
        &["export", "here", "--to", "trajectory", "--out"],
        &["export", "here", "--to", "mcap", "--out"],
        &["compare", "here", "here", "--out"],
        &["robots", "pendulum_2", "--urdf"],
        &["scenarios", SWING, "--out"],
    ];
    for command in commands {
        for (path, kind) in [
            ("folder", "it is a folder"),
            ("socket", "it is a device, a pipe or a socket"),
            ("/dev/null", "it is a device, a pipe or a socket"),
            ("device", "it is a symbolic link"),
            ("link", "it is a symbolic link"),
        ] {
            let arguments = [command, &[path, "--force"]].concat();
            assert_bad_input(&folder, &arguments, &format!("{path}: output: {kind}"));
        }
    }
    assert_eq!(files(&folder), before);
    assert_eq!(std::fs::read_to_string(folder.join("link")).expect("it is there"), "mine");
    assert!(folder.join("link").is_symlink());
}
