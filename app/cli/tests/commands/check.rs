//! `aghf check` and `aghf prove`.

use crate::command::{aghf, empty_folder, parsed};
use serde_json::Value;

#[test]
fn check_passes_and_names_every_jacobian() {
    let folder = empty_folder("check");
    let run = aghf(&folder, &["check", "pendulum_2", "--samples", "3"]);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{}", run.stdout);
    for name in ["control_form", "theorem_b4", "dual", "difference", "inverse dynamics", "Omega on a curve, weak form"]
    {
        assert!(run.stdout.contains(name), "{name} in {}", run.stdout);
    }
    assert!(!run.stdout.contains("OFF"));
    let rows = run.stdout.lines().filter(|line| line.trim_end().ends_with(" ok")).count();
    let summary = format!("{rows} quantities at 3 states, 0 off");
    assert_eq!(run.stdout.lines().last(), Some(summary.as_str()));
}

#[test]
fn check_prints_what_reproduces_a_finding() {
    let folder = empty_folder("check_json");
    let of = |seed: &str| {
        let arguments = ["check", "pendulum_3", "--samples", "2", "--seed", seed, "--json"];
        parsed(&aghf(&folder, &arguments))
    };
    let json = of("7");
    assert_eq!((&json["robot"], &json["seed"]), (&Value::from("pendulum_3"), &Value::from(7)));
    assert_eq!(json["passed"], Value::from(true));
    let findings = json["findings"].as_array().expect("a list");
    assert!(findings.len() > 40, "{}", findings.len());
    for finding in findings {
        assert_eq!(finding["state"]["x"].as_array().map(Vec::len), Some(6), "{finding}");
        assert!(finding["error"].as_f64() <= finding["bound"].as_f64(), "{finding}");
    }
    assert_eq!(json, of("7"));
    assert_ne!(json, of("8"));
}

#[test]
fn check_reads_a_file() {
    let folder = empty_folder("check_file");
    let urdf = concat!(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."), "/robots/pendulum_1/pendulum_1.urdf");
    let run = aghf(&folder, &["check", urdf, "--samples", "1"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
}

#[test]
fn prove_prints_the_ledger() {
    let folder = empty_folder("prove");
    let json = parsed(&aghf(&folder, &["prove", "--points", "1", "--json"]));
    assert_eq!(json["failures"], Value::from(0), "{json}");
    let verdicts = json["verdicts"].as_array().expect("a list");
    assert_eq!(json["identities"], Value::from(verdicts.len()));
    for verdict in verdicts {
        assert_eq!(verdict["failure"], Value::Null);
        assert!(verdict["entries"].as_u64() > Some(0), "{verdict}");
        assert!(verdict["bound"].as_f64() < Some(1e-13), "{verdict}");
    }
}
