//! The verdict of the checker on each file of the conformance suite; its README has the notation.

use aghf_check::{check, find_mesh, sha256};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::fs::{read_dir, read_to_string};
use std::path::{Path, PathBuf};

/// The texts of the robot, the scenario, the summary and the certificate.
type Texts = BTreeMap<&'static str, String>;

const FILES: [(&str, &str); 4] = [
    ("robot", "robot.urdf"),
    ("scenario", "scenario.json"),
    ("summary", "summary.json"),
    ("certificate", "certificate.json"),
];

/// Fewer cases are a folder that was not found as a whole.
const MIN_CASES: usize = 600;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("conformance")
}

fn base(name: &str) -> Texts {
    let read = |file| read_to_string(folder().join("bases").join(name).join(file)).unwrap();
    FILES.into_iter().map(|(key, file)| (key, read(file))).collect()
}

/// Sets the value at a pointer, at the end of a list too, or removes it.
fn set(value: &mut Value, pointer: &str, new: Option<&Value>) {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match (value.pointer_mut(parent).unwrap(), new) {
        (Value::Object(members), Some(new)) => drop(members.insert(key.to_owned(), new.clone())),
        (Value::Object(members), None) => drop(members.remove(key).unwrap()),
        (Value::Array(entries), None) => drop(entries.remove(key.parse().unwrap())),
        (Value::Array(entries), Some(new)) if key.parse() == Ok(entries.len()) => entries.push(new.clone()),
        (Value::Array(entries), Some(new)) => entries[key.parse::<usize>().unwrap()] = new.clone(),
        (other, _) => panic!("{pointer}: {other} has no members"),
    }
}

/// The texts of a case.
fn texts(case: &Value) -> Texts {
    let before = base(case["base"].as_str().unwrap());
    let mut texts = before.clone();
    let none = Map::new();
    let members = |key: &str| case.get(key).map_or(&none, |value| value.as_object().unwrap());
    for (file, pairs) in members("replace") {
        let text = texts.get_mut(file.as_str()).unwrap();
        for pair in pairs.as_array().unwrap() {
            let [old, new] = [0, 1].map(|i| pair[i].as_str().unwrap());
            assert!(text.contains(old), "'{old}' does not occur in the {file}");
            *text = text.replacen(old, new, 1);
        }
    }
    for (file, edits) in members("set") {
        let text = texts.get_mut(file.as_str()).unwrap();
        let mut value = serde_json::from_str(text).unwrap();
        for edit in edits.as_array().unwrap() {
            set(&mut value, edit[0].as_str().unwrap(), edit.get(1));
        }
        *text = value.to_string();
    }
    for (file, pieces) in members("text") {
        let repeated = |p: &Value| p[0].as_str().unwrap().repeat(p[1].as_u64().unwrap() as usize);
        *texts.get_mut(file.as_str()).unwrap() = pieces.as_array().unwrap().iter().map(repeated).collect();
    }
    if case.get("scenario_of_summary").is_some() {
        let summary = texts["summary"].clone();
        texts.insert("scenario", summary);
    }
    if case.get("hashes").is_none() {
        for file in ["robot", "scenario", "summary"] {
            let new = texts["certificate"].replace(&sha256(&before[file]), &sha256(&texts[file]));
            texts.insert("certificate", new);
        }
    }
    texts
}

/// The difference between what a case expects and what the checker finds, or nothing.
fn difference(case: &Value) -> Option<String> {
    let texts = texts(case);
    let robot = folder().join("bases").join(case["base"].as_str().unwrap()).join("robot.urdf");
    let mesh = |name: &str| if case.get("meshes").is_none() { find_mesh(name, &robot, &[]) } else { None };
    let found = check(["robot", "scenario", "summary", "certificate"].map(|file| &*texts[file]), &mesh);
    let (verdict, message) = match found {
        Ok(report) => (if report.is_complete { "all" } else { "in part" }, report.text),
        Err(reason) => ("refused", reason),
    };
    let is_one =
        |reasons: &Value| reasons.as_array().unwrap().iter().any(|one| message.contains(one.as_str().unwrap()));
    let is_right = case["verdict"] == verdict && case.get("reason").is_none_or(is_one);
    (!is_right).then(|| format!("{verdict}: {message}"))
}

#[test]
fn the_checker_gives_the_verdict_and_the_reason_of_each_case() {
    let mut paths: Vec<PathBuf> =
        read_dir(folder().join("cases")).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let (mut count, mut wrong) = (0, Vec::new());
    for path in paths {
        let cases: Vec<Value> = serde_json::from_str(&read_to_string(&path).unwrap()).unwrap();
        for (i, case) in cases.iter().enumerate() {
            count += 1;
            let found = difference(case);
            wrong.extend(found.map(|found| format!("{}[{i}]: {found}", path.file_stem().unwrap().display())));
        }
    }
    assert!(count >= MIN_CASES, "{count} cases");
    assert!(wrong.is_empty(), "{} of {count} cases:\n{}", wrong.len(), wrong.join("\n"));
}
