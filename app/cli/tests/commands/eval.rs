//! `aghf eval`: what it prints agrees with itself, with differences and with the library.

use crate::command::{aghf, assert_bad_input, empty_folder, parsed};
use aghf::flow::{ControlForm, Node, RightHandSide};
use aghf::urdf::builtin_robot;
use nalgebra::{DMatrix, DVector};
use serde_json::{Map, Value, json};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// A state of Kinova and an acceleration.
fn state() -> Value {
    json!({
        "q": [0.3, -1.2, 2.1, 0.7, -0.4, 1.9, -2.6], "v": [1.1, -0.3, 0.8, 0.0, -1.7, 0.6, 0.9],
        "a": [-0.5, 2.0, 0.1, 1.3, -0.9, 0.4, 0.0]
    })
}

/// Two vectors, one after the other.
fn both(first: &Value, second: &Value) -> Value {
    let list = |v: &Value| v.as_array().expect("a list").clone();
    Value::from([list(first), list(second)].concat())
}

/// The same state as the flow reads it, with the given velocity of the curve.
fn node(xdot_p1: &Value) -> Value {
    let s = state();
    json!({
        "x": both(&s["q"], &s["v"]), "xdot": both(xdot_p1, &s["a"]),
        "xddot": [0.1, 0.2, -0.3, 0.4, 0.5, -0.6, 0.7, 1.1, -1.2, 1.3, 1.4, -1.5, 1.6, 1.7], "k": 1e5
    })
}

/// Evaluates `input` for Kinova from a file.
fn eval(test: &str, input: &Value) -> Value {
    let folder = empty_folder(test);
    std::fs::write(folder.join("input.json"), input.to_string()).expect("writable");
    parsed(&aghf(&folder, &["eval", "kinova_gen3", "input.json"]))
}

fn vector(value: &Value) -> DVector<f64> {
    let list = value.as_array().expect("a list");
    DVector::from_iterator(list.len(), list.iter().map(|x| x.as_f64().expect("a number")))
}

fn matrix(value: &Value) -> DMatrix<f64> {
    let rows: Vec<_> = value.as_array().expect("a list").iter().map(|r| vector(r).transpose()).collect();
    DMatrix::from_rows(&rows)
}

const KEYS: [&str; 7] =
    ["inverse_dynamics", "mass_matrix", "mass_matrix_dot", "bias", "forward_dynamics", "did_dq", "did_dv"];

fn keys(value: &Value) -> Vec<&str> {
    let mut keys: Vec<_> = value.as_object().map(Map::keys).expect("an object").map(String::as_str).collect();
    keys.sort_unstable();
    keys
}

fn sorted<'a>(keys: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let mut keys: Vec<_> = keys.into_iter().collect();
    keys.sort_unstable();
    keys
}

#[test]
fn the_printed_dynamics_agree_with_each_other() {
    let mut input = state();
    let out = eval("identities", &input);
    assert_eq!(keys(&out), sorted(KEYS));
    let (h, a) = (matrix(&out["mass_matrix"]), vector(&input["a"]));
    let (tau, c) = (vector(&out["inverse_dynamics"]), vector(&out["bias"]));
    assert_eq!((h.shape(), tau.len()), ((7, 7), 7));
    assert!((&h * &a + &c - &tau).amax() < 1e-12 * tau.amax(), "{tau}");
    assert!((&h - h.transpose()).amax() == 0.0 && h.symmetric_eigenvalues().min() > 0.0);
    // Without a torque, what is left is the bias.
    assert!((&h * vector(&out["forward_dynamics"]) + &c).amax() < 1e-12 * c.amax(), "{c}");

    // Central differences of what is printed.
    let step = 1e-5;
    let nudged = |key: &str, by: f64| {
        let mut input = state();
        for (x, v) in
            input[key].as_array_mut().expect("a list").iter_mut().zip(state()["v"].as_array().expect("a list"))
        {
            *x = json!(x.as_f64().expect("a number") + by * v.as_f64().expect("a number"));
        }
        eval("identities", &input)
    };
    let v = vector(&input["v"]);
    for (key, derivative) in [("q", "did_dq"), ("v", "did_dv")] {
        let (up, down) = (nudged(key, step), nudged(key, -step));
        let rate = (vector(&up["inverse_dynamics"]) - vector(&down["inverse_dynamics"])) / (2.0 * step);
        let printed = matrix(&out[derivative]) * &v;
        assert!((rate - &printed).amax() < 1e-7 * printed.amax().max(1.0), "{derivative}");
        if key == "q" {
            let rate = (matrix(&up["mass_matrix"]) - matrix(&down["mass_matrix"])) / (2.0 * step);
            let printed = matrix(&out["mass_matrix_dot"]);
            assert!(printed.amax() > 0.1 && (rate - &printed).amax() < 1e-7, "{printed}");
        }
    }

    input["tau"] = out["inverse_dynamics"].clone();
    let forward = vector(&eval("identities", &input)["forward_dynamics"]);
    assert!((&forward - &a).amax() < 1e-9, "{forward}");
}

#[test]
fn the_form_of_the_flow_agrees_with_that_of_the_state() {
    let state = eval("state_form", &state());
    let v = self::state()["v"].clone();
    let input = node(&v);
    let out = eval("flow_form", &input);
    assert_eq!(keys(&out), sorted(KEYS.into_iter().chain(["omega"])));
    for key in KEYS {
        assert_eq!(out[key], state[key], "{key}");
    }
    let model = builtin_robot("kinova_gen3").expect("built in");
    let [x, xdot, xddot] = ["x", "xdot", "xddot"].map(|key| vector(&input[key]));
    let curve = Node { t: 0.0, x: x.as_slice(), xdot: xdot.as_slice(), xddot: xddot.as_slice() };
    let mut omega = [0.0; 14];
    let rhs = &mut ControlForm::new(&model);
    rhs.omega(curve, 1e5, &mut omega).expect("lengths agree");
    assert_eq!(vector(&out["omega"]).as_slice(), omega);

    // The mass matrix changes along the curve, all else belongs to the state.
    let twice = Value::from((vector(&v) * 2.0).as_slice().to_vec());
    let faster = eval("flow_form", &node(&twice));
    for key in KEYS.into_iter().filter(|key| *key != "mass_matrix_dot") {
        assert_eq!(faster[key], state[key], "{key}");
    }
    let (once, twice) = (matrix(&state["mass_matrix_dot"]), matrix(&faster["mass_matrix_dot"]));
    assert!((once * 2.0 - &twice).amax() < 1e-12 * twice.amax(), "{twice}");
}

#[test]
fn eval_reads_the_standard_input() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_aghf"));
    command.args(["eval", "kinova_gen3", "-"]).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.spawn().expect("it runs");
    let mut stdin = child.stdin.take().expect("it is piped");
    stdin.write_all(state().to_string().as_bytes()).expect("it reads");
    drop(stdin);
    let output = child.wait_with_output().expect("it ends");
    assert!(output.status.success());
    let out: Value = serde_json::from_slice(&output.stdout).expect("it is JSON");
    assert_eq!(out, eval("from_file", &state()));
}

#[test]
fn eval_reads_robots_from_files() {
    let folder = empty_folder("eval_robot");
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("robots/kinova_gen3/kinova_gen3.urdf");
    std::fs::write(folder.join("input.json"), state().to_string()).expect("writable");
    let file = path.to_str().expect("it is text");
    let run = aghf(&folder, &["eval", file, "input.json"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let out: Value = serde_json::from_str(&run.stdout).expect("it is JSON and nothing else");
    assert_eq!(out, eval("eval_built_in", &state()));
}

/// Asserts that `eval` refuses each input with all words (between semicolons).
fn assert_refused(test: &str, inputs: &[(String, &str)]) {
    let folder = empty_folder(test);
    for (input, words) in inputs {
        std::fs::write(folder.join("input.json"), input).expect("writable");
        let arguments = ["eval", "kinova_gen3", "input.json"];
        assert_bad_input(&folder, &arguments, &format!("aghf: input.json: ; {words}"));
    }
}

fn with(mut input: Value, key: &str, value: Value) -> String {
    input[key] = value;
    input.to_string()
}

fn without(mut input: Value, key: &str) -> String {
    input.as_object_mut().expect("an object").remove(key);
    input.to_string()
}

#[test]
fn vectors_of_another_length_are_refused() {
    let good = node(&state()["v"]);
    let short = |input: &Value, key| with(input.clone(), key, json!([1.0, 2.0]));
    assert_refused(
        "eval_short",
        &[
            (short(&state(), "q"), "q: expected 7 numbers, found 2"),
            (short(&state(), "v"), "v: expected 7 numbers, found 2"),
            (with(state(), "a", json!([])), "a: expected 7 numbers, found 0"),
            (short(&state(), "tau"), "tau: expected 7 numbers, found 2"),
            (short(&good, "x"), "x: expected 14 numbers, found 2"),
            (short(&good, "xdot"), "xdot: expected 14 numbers, found 2"),
            (short(&good, "xddot"), "xddot: expected 14 numbers, found 2"),
            (short(&good, "tau"), "tau: expected 7 numbers, found 2"),
        ],
    );
}

#[test]
fn bad_inputs_to_eval_exit_with_2() {
    let good = node(&state()["v"]);
    assert_refused(
        "eval_bad",
        &[
            (with(good.clone(), "k", json!(-2.0)), "k: it is -2; positive"),
            (with(good.clone(), "k", json!(0)), "k: it is 0; positive"),
            (without(state(), "a"), "expected numbers; q, v, a"),
            (without(good, "k"), "expected numbers; x, xdot, xddot, k"),
            (with(state(), "k", json!(1.0)), "expected numbers; q, v, a"),
            (with(state(), "q", json!("up")), "expected numbers; q, v, a"),
            (state().to_string().replace("2.1", "1e999"), "out of range; line 1"),
            (state().to_string() + "}", "line 1"),
            (String::new(), "line 1"),
        ],
    );
    let folder = empty_folder("eval_missing");
    assert_bad_input(&folder, &["eval", "kinova_gen3", "none.json"], "aghf: none.json: ; No such file");
    assert_bad_input(
        &folder,
        &["eval", "hexapod", "none.json"],
        "aghf: hexapod: ; neither a file nor a built-in robot",
    );
}

/// Results that are no numbers must not be printed as `null` under exit code 0.
#[test]
fn results_that_overflow_are_told() {
    let mut input = state();
    input["v"][0] = json!(1e200);
    assert_refused("eval_overflow", &[(input.to_string(), "finite")]);
}
