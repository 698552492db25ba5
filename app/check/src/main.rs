//! The program `aghf-check ROBOT.urdf SCENARIO.json SUMMARY.json CERTIFICATE.json [FOLDER ...]`: exit code 0 if all
//! promises are proved, 4 if the certificate leaves some out or a mesh is not read, 1 if it is refused. Packages with
//! meshes are in the folders of the URDF and above it, or in those that are named.

use aghf_check::{check, find_mesh};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const USAGE: &str = "usage: aghf-check ROBOT.urdf SCENARIO.json SUMMARY.json CERTIFICATE.json [FOLDER ...]";

fn main() -> ExitCode {
    let files: Vec<String> = std::env::args().skip(1).collect();
    let read = |file: &String| std::fs::read_to_string(file).map_err(|e| format!("{file}: {e}"));
    let texts: Result<Vec<String>, String> = files.iter().take(4).map(read).collect();
    let folders: Vec<PathBuf> = files.iter().skip(4).map(PathBuf::from).collect();
    let checked = texts.and_then(|texts| match texts.as_slice() {
        [robot, scenario, run, certificate] => {
            check([robot, scenario, run, certificate], &|name| find_mesh(name, Path::new(&files[0]), &folders))
        }
        _ => Err(USAGE.to_owned()),
    });
    match checked {
        Ok(report) => {
            println!("{}", report.text);
            if report.is_complete { ExitCode::SUCCESS } else { ExitCode::from(4) }
        }
        Err(fault) => {
            eprintln!("refused: {fault}");
            ExitCode::FAILURE
        }
    }
}
