//! The program `aghf-check ROBOT.urdf SCENARIO.json SUMMARY.json CERTIFICATE.json`: exit code 0 if all promises are
//! proved, 4 if the certificate leaves some out, 1 if it is refused.

use std::process::ExitCode;

fn main() -> ExitCode {
    let files: Vec<String> = std::env::args().skip(1).collect();
    let read = |file: &String| std::fs::read_to_string(file).map_err(|e| format!("{file}: {e}"));
    let texts: Result<Vec<String>, String> = files.iter().map(read).collect();
    let checked = texts.and_then(|texts| match texts.as_slice() {
        [robot, scenario, run, certificate] => aghf_check::check(robot, scenario, run, certificate),
        _ => Err("usage: aghf-check ROBOT.urdf SCENARIO.json SUMMARY.json CERTIFICATE.json".to_owned()),
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
