//! Programs of ROS: `xacro`, and `rospack` for packages, replaced by scripts in a separate process.

use aghf::urdf::{builtin_robot, load_mesh, load_robot, load_urdf};
use nalgebra::Vector3;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// A new folder with these scripts.
fn folder(name: &str, scripts: &[(&str, &str)]) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).expect("it is writable");
    for (name, script) in scripts {
        let path = folder.join(name);
        fs::write(&path, format!("#!/bin/sh\n{script}\n")).expect("it is writable");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("it is ours");
    }
    folder
}

/// Runs the `#[test]` of this name again with `folder` as the only path of programs; returns true in that run.
fn run_again(test: &str, folder: &Path) -> bool {
    if env::var_os("AGHF_TEST_ROS").is_some() {
        return true;
    }
    let output = Command::new(env::current_exe().expect("it runs"))
        .args(["--exact", test])
        .env("PATH", folder)
        .env("AGHF_TEST_ROS", "1")
        .env("ROS_PACKAGE_PATH", folder.join("ros_1"))
        .env("AMENT_PREFIX_PATH", folder.join("ros_2"))
        .output()
        .expect("it starts");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && text.contains("1 passed"), "{text}");
    false
}

#[test]
fn xacro_files_are_expanded() {
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots");
    let urdf = robots.join("pendulum_2/pendulum_2.urdf");
    let script = format!("while read -r line; do echo \"$line\"; done < {urdf:?}");
    let folder = folder("ros_xacro", &[("xacro", &script)]);
    let path = folder.join("arm.urdf.xacro");
    fs::write(&path, "<robot/>").expect("it is writable");
    if !run_again("load::xacro_files_are_expanded", &folder) {
        return;
    }
    let expected = builtin_robot("pendulum_2").expect("built in");
    let (model, _) = load_urdf(&path).expect("it is expanded");
    assert_eq!(format!("{model:?}"), format!("{expected:?}"));
    let (model, _) = load_robot(path.to_str().expect("it is UTF-8")).expect("it is expanded");
    assert_eq!(format!("{model:?}"), format!("{expected:?}"));
}

#[test]
fn xacro_that_is_missing_or_fails_is_named_with_the_file() {
    for (name, scripts, words) in [
        ("ros_none", &[][..], "failed to execute xacro; consider"),
        ("ros_fails", &[("xacro", "echo no such macro >&2; exit 2")][..], "no such macro"),
    ] {
        let folder = folder(name, scripts);
        let path = folder.join("arm.xacro");
        fs::write(&path, "<robot/>").expect("it is writable");
        if env::var("PATH").is_ok_and(|path| Path::new(&path) != folder) {
            run_again("load::xacro_that_is_missing_or_fails_is_named_with_the_file", &folder);
            continue;
        }
        let error = load_urdf(&path).expect_err("it cannot be expanded");
        let text = error.to_string();
        let start = format!("{}: robot: ", path.display());
        assert!(text.starts_with(&start) && text.contains(words), "{text}");
    }
}

#[test]
fn packages_of_ros_come_after_the_folders() {
    let folder = folder("ros_package", &[("rospack", "echo \"${0%/*}/installed/$2\"")]);
    let corner = |path: &str, x: f64| {
        let path = folder.join(path);
        fs::create_dir_all(path.parent().expect("it has one")).expect("it is writable");
        let text = format!("v {x} 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n");
        fs::write(path, text).expect("it is writable");
    };
    corner("installed/hand/both.obj", 1.0);
    corner("installed/hand/one.obj", 2.0);
    corner("hand/both.obj", 3.0);
    corner("ros_1/hand/path.obj", 4.0);
    corner("ros_2/share/hand/path.obj", 5.0);
    corner("ros_2/share/hand/prefix.obj", 6.0);
    if !run_again("load::packages_of_ros_come_after_the_folders", &folder) {
        return;
    }
    let load = |file| load_mesh(file, &folder, &Vector3::repeat(1.0));
    let first = |file| load(file).expect("it is there")[0][0].x;
    assert_eq!(first("package://hand/both.obj"), 3.0);
    assert_eq!(first("package://hand/one.obj"), 2.0);
    assert_eq!(first("package://hand/path.obj"), 4.0);
    assert_eq!(first("package://hand/prefix.obj"), 6.0);
    let error = load("package://hand/none.obj").expect_err("it is nowhere");
    let text = error.to_string();
    let words = ["package://hand/none.obj: mesh: ", "ros_1", "ros_2", "installed/hand'"];
    assert!(words.iter().all(|w| text.contains(w)), "{text}");
}

/// A package is above the folder that a link leads to.
#[test]
fn symbolic_links_above_a_package_are_followed() {
    let folder = folder("links_package", &[]);
    let urdf = folder.join("there/hand/urdf");
    fs::create_dir_all(&urdf).expect("it is writable");
    let text = "v 7 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n";
    fs::write(folder.join("there/hand/one.obj"), text).expect("it is writable");
    let link = folder.join("link");
    if !link.exists() {
        std::os::unix::fs::symlink(&urdf, &link).expect("it is writable");
    }
    let mesh = load_mesh("package://hand/one.obj", &link, &Vector3::repeat(1.0));
    assert_eq!(mesh.expect("it is there")[0][0].x, 7.0);
}
