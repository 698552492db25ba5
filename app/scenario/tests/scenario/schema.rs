//! The JSON Schemas of scenarios and options, and the tables made from them.

use aghf_scenario::{
    Method, Scenario, SolveOptions, builtin_scenarios, described_options, option_keys, scenario_keys, scenario_schema,
};
use serde_json::{Map, Value, json};
use std::path::Path;

/// The tables of the documentation are those that the program prints: `aghf scenarios --keys > PATH`, and with
/// `--keys options`.
#[test]
fn the_tables_of_keys_are_current() {
    for (table, documented, command) in [
        (
            scenario_keys(),
            include_str!("../../src/scenario_keys.md"),
            "aghf scenarios --keys > app/scenario/src/scenario_keys.md",
        ),
        (
            option_keys(),
            include_str!("../../src/option_keys.md"),
            "aghf scenarios --keys options > app/scenario/src/option_keys.md",
        ),
    ] {
        assert!(table == documented, "to make it current: {command}\n{table}");
    }
}

/// A value that a schema allows.
fn example(schema: &Value) -> Value {
    let is = |name: &str| {
        let types = &schema["type"];
        types == name || types.as_array().is_some_and(|all| all.contains(&json!(name)))
    };
    match schema["oneOf"][0]["const"].clone() {
        Value::Null if is("integer") => json!(3),
        Value::Null if is("number") => json!(0.5),
        Value::Null => panic!("{schema}"),
        choice => choice,
    }
}

/// Each option that a schema names is read, kept and written, and no other.
#[test]
fn the_schema_of_the_options_has_what_is_read() {
    for option in described_options() {
        for (method, name) in Method::by_name().map(|(name, method)| (method, name)) {
            let keys = Map::from_iter([(option.name.clone(), example(&option.schema))]);
            let known = option.helps.iter().any(|(_, methods)| methods.contains(&name));
            let read = SolveOptions::from_keys(method, keys.clone());
            match read {
                Ok(options) => assert!(known && options.keys().expect("read") == keys),
                Err(error) => assert!(!known && error.to_string().contains("unknown field")),
            }
        }
    }
    let all = SolveOptions::schema();
    let methods = all["oneOf"].as_array().expect("a list").iter();
    let methods = methods.map(|one| one["properties"]["method"]["const"].clone());
    assert!(methods.eq(Method::by_name().map(|(name, _)| json!(name))));
}

/// Every key of the built-in scenarios is in the schema, down to those in objects, and a file may name the schema.
#[test]
fn the_schema_of_scenarios_has_their_keys() {
    let schema = scenario_schema();
    for name in builtin_scenarios() {
        let scenario = Scenario::load(name).expect("built in");
        let mut file = serde_json::to_value(&scenario.file).expect("numbers");
        for key in file.as_object().expect("an object").keys() {
            assert!(!schema["properties"][key].is_null(), "{name}: {key}");
        }
        file["$schema"] = json!("scenario.schema.json");
        let again = Scenario::parse(&file.to_string(), name, Path::new(""));
        let again = again.expect("it is as good with it").file;
        assert_eq!(again.schema.as_deref(), Some("scenario.schema.json"));
    }
    let table = scenario_keys();
    for key in ["horizon_s", "objective.velocity", "flow.k_cons", "feedback.kp"] {
        assert!(table.contains(&format!("| `{key}` | ")), "{key}: {table}");
    }
}

/// Other values of keys are those of a file that has them.
#[test]
fn keys_are_replaced_as_in_a_file() {
    let scenario = Scenario::load("limits_01").expect("generated");
    let with = |key: &str, value| scenario.with_keys(&Map::from_iter([(key.to_owned(), value)]));
    let weighted = with("objective.velocity", json!(2.0)).expect("good");
    let mut file = serde_json::to_value(&scenario.file).expect("numbers");
    file["objective"]["velocity"] = json!(2.0);
    assert_eq!(serde_json::to_value(&weighted.file).expect("numbers"), file);
    assert_eq!(weighted.name, scenario.name);
    for (key, value, words) in [
        ("objective.speed", json!(1), "limits_01: objective.speed: unknown field"),
        ("enforced_limits.velocity", json!(2), "limits_01: enforced_limits.velocity: it is 2"),
        ("objective", json!([1.0]), "limits_01: objective: invalid type: sequence, expected the name of an objective"),
    ] {
        let error = with(key, value).expect_err(words).to_string();
        assert!(error.starts_with(words), "{error}");
    }
}
