//! The guide to a crate of one's own, beside `Cargo.toml`.

use std::path::Path;
use toml::{Table, Value};

fn read(file: &str) -> String {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(file);
    std::fs::read_to_string(path).expect("it is there")
}

fn parsed(text: &str) -> Table {
    text.parse().expect("it is TOML")
}

/// The TOML blocks of the page.
fn blocks() -> Vec<Table> {
    let page = read("src/guide/your_crate.md");
    let blocks = page.split("```toml\n").skip(1);
    let blocks = blocks.map(|block| block.split("```").next().unwrap_or_default());
    blocks.map(parsed).collect()
}

/// Version and features of a dependency, however it is written.
fn version(dependency: &Value) -> (Option<&str>, Vec<&str>) {
    let text = |key: &str| dependency.get(key).and_then(Value::as_str);
    let features = dependency.get("features").and_then(Value::as_array);
    let features = features.into_iter().flatten().filter_map(Value::as_str);
    let version = dependency.as_str().or_else(|| text("version"));
    (version, features.collect())
}

#[test]
fn versions_are_those_of_this_crate() {
    let [manifest, app] = ["Cargo.toml", "app/cli/Cargo.toml"].map(|file| parsed(&read(file)));
    let mut compared = 0;
    for block in blocks() {
        let Some(dependencies) = block.get("dependencies").and_then(Value::as_table) else {
            continue;
        };
        for (name, theirs) in dependencies.iter().filter(|(name, _)| !name.starts_with("aghf")) {
            let tables = [&app["dependencies"], &manifest["dependencies"], &manifest["workspace"]["dependencies"]];
            let mut ours = tables.into_iter().filter_map(|table| table.get(name));
            let ours = ours.find(|ours| ours.get("workspace").is_none());
            let ours = ours.expect("a dependency");
            let ((version, features), (own_version, own_features)) = (version(theirs), version(ours));
            assert!(version.is_some() && version == own_version, "{name}: {own_version:?}");
            assert!(features.iter().all(|f| own_features.contains(f)), "{name}");
            compared += 1;
        }
    }
    assert_eq!(compared, 6);
}

#[test]
fn profile_and_flags_are_those_of_this_crate() {
    let manifest = parsed(&read("Cargo.toml"));
    let flags = parsed(&read(".cargo/config.toml"));
    let (mut levels, mut targets) = (0, 0);
    for block in blocks() {
        if let Some(profile) = block.get("profile") {
            let of = |profile: &Value| profile["dev"]["opt-level"].as_integer();
            assert_eq!(of(profile), of(&manifest["profile"]));
            levels += 1;
        }
        if let Some(target) = block.get("target") {
            assert_eq!(Some(target), flags.get("target"));
            targets += 1;
        }
    }
    assert_eq!((levels, targets), (1, 1));
}

/// The tables of features and of examples are complete.
#[test]
fn features_and_examples_are_named() {
    let page = read("src/guide/your_crate.md");
    let manifests = ["Cargo.toml", "app/cli/Cargo.toml"].map(|file| parsed(&read(file)));
    let features = manifests[0]["features"].as_table().expect("a table");
    for feature in features.keys().filter(|name| *name != "default") {
        assert!(page.contains(&format!("\n| `{feature}`")), "{feature}");
    }
    for (manifest, packages) in manifests.iter().zip(["| `aghf` |", "| `aghf`, `aghf-cli`, `aghf-scenario`"]) {
        for example in manifest["example"].as_array().expect("a list") {
            let name = example["name"].as_str().expect("a name");
            let rows = page.lines().filter(|line| line.starts_with(&format!("| `{name}` |")));
            let rows: Vec<&str> = rows.collect();
            assert!(rows.len() == 1 && rows[0].contains(packages), "{name}: {rows:?}");
        }
    }
}
