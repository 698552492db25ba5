//! The JSON Schema of scenario files, and tables of keys made from schemas.

use crate::{Method, ScenarioFile, SolveOptions};
use aghf::names::Named;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Map, Value, json};

/// The schema of a value that is selected by name.
pub(crate) fn one_of<T: Named>(_: &mut SchemaGenerator) -> Schema {
    let values =
        T::ALL.iter().map(|(_, name, help)| json!({ "const": name, "description": help.trim().trim_end_matches('.') }));
    json_schema!({ "oneOf": values.collect::<Vec<_>>() })
}

/// The schema of a value, or of a list of such values.
pub(crate) fn one_or_more<T: JsonSchema>(generator: &mut SchemaGenerator) -> Schema {
    let (one, more) = (generator.subschema_for::<T>(), generator.subschema_for::<Vec<T>>());
    json_schema!({ "anyOf": [one, more] })
}

/// The gains of the feedback $u - k_p (q - q_{des}) - k_v (v - v_{des})$.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "it describes aghf::motion::Feedback")]
#[schemars(rename = "Feedback", deny_unknown_fields)]
pub(crate) struct FeedbackKeys {
    /// Position gain $k_p$, N m/rad or N/m.
    kp: f64,
    /// Velocity gain $k_v$, N m s/rad or N s/m.
    kv: f64,
}

/// The JSON Schema of a scenario file.
#[must_use]
pub fn scenario_schema() -> Value {
    schemars::schema_for!(ScenarioFile).to_value()
}

/// A Markdown table of the keys of a scenario file, made from its schema.
#[must_use]
pub fn scenario_keys() -> String {
    let schema = scenario_schema();
    let mut table = "| key | value | default |\n| --- | --- | --- |\n".to_owned();
    for keys in objects_in(&schema, &schema) {
        add_keys(&schema, &keys, "", &mut table);
    }
    table
}

/// A Markdown table of the options of all methods, made from their schemas.
#[must_use]
pub fn option_keys() -> String {
    let mut table = "| option | value | methods |\n| --- | --- | --- |\n".to_owned();
    for option in described_options() {
        for (help, methods) in option.helps {
            let (name, help) = (&option.name, in_cell(&help));
            table += &format!("| `{name}` | {help} | {} |\n", methods.join(", "));
        }
    }
    table
}

/// An option of a solve with its schema, and its description by the methods that have it.
#[derive(Clone, Debug)]
pub struct DescribedOption {
    /// The key in JSON.
    pub name: String,
    /// The JSON Schema of its value.
    pub schema: Value,
    /// The descriptions, each with the names of its methods.
    pub helps: Vec<(String, Vec<&'static str>)>,
}

/// The options of all methods, in the order in which the structs declare them.
#[must_use]
pub fn described_options() -> Vec<DescribedOption> {
    let mut all = Vec::<DescribedOption>::new();
    for (method, method_name, _) in Method::ALL {
        let schema = SolveOptions::schema_of(*method);
        for (name, schema) in properties(&schema).into_iter().flatten() {
            let help = text(schema, "description").to_owned();
            let at = all.iter().position(|option| option.name == *name);
            let at = at.unwrap_or_else(|| {
                let (name, schema) = (name.clone(), schema.clone());
                let helps = Vec::new();
                all.push(DescribedOption { name, schema, helps });
                all.len() - 1
            });
            let helps = &mut all[at].helps;
            match helps.iter_mut().find(|(other, _)| *other == help) {
                Some((_, methods)) => methods.push(method_name),
                None => helps.push((help, vec![method_name])),
            }
        }
    }
    all
}

/// An object with keys in a schema.
struct Keys<'s> {
    schema: &'s Value,
    /// `[]` for each list around it.
    suffix: String,
    /// True if it is one of several objects, of which a value has one.
    is_alternative: bool,
}

/// Adds a row for each property of an object, below those of the objects in it, to a table. `root` has the definitions.
fn add_keys(root: &Value, object: &Keys<'_>, prefix: &str, table: &mut String) {
    let Keys { schema: object, is_alternative, .. } = object;
    for (name, schema) in properties(object).into_iter().flatten() {
        let key = format!("{prefix}{name}");
        let required = object["required"].as_array();
        let required = required.is_some_and(|all| all.iter().any(|other| other == name));
        let default = match &schema["default"] {
            _ if required && *is_alternative => "one of these".to_owned(),
            _ if required => "required".to_owned(),
            Value::Null | Value::Object(_) | Value::Array(_) => String::new(),
            scalar => format!("`{scalar}`"),
        };
        let help = in_cell(text(schema, "description"));
        *table += &format!("| `{key}` | {help} | {default} |\n");
        for inner in objects_in(root, schema) {
            let prefix = format!("{key}{}.", inner.suffix);
            add_keys(root, &inner, &prefix, table);
        }
    }
}

/// The objects with keys among the alternatives of a schema and of the entries of a list.
fn objects_in<'s>(root: &'s Value, schema: &'s Value) -> Vec<Keys<'s>> {
    let mut found = Vec::new();
    if !schema.is_object() {
        return found;
    }
    if let Some(name) = text(schema, "$ref").strip_prefix("#/$defs/") {
        found.extend(objects_in(root, &root["$defs"][name]));
    }
    if schema["properties"].is_object() {
        found.push(Keys { schema, suffix: String::new(), is_alternative: false });
    }
    for mut entry in objects_in(root, &schema["items"]) {
        entry.suffix.insert_str(0, "[]");
        found.push(entry);
    }
    for (key, is_alternative) in [("anyOf", false), ("oneOf", true)] {
        for alternative in schema[key].as_array().into_iter().flatten() {
            for mut inner in objects_in(root, alternative) {
                inner.is_alternative |= is_alternative && alternative["properties"].is_object();
                found.push(inner);
            }
        }
    }
    found
}

fn properties(schema: &Value) -> Option<&Map<String, Value>> {
    schema["properties"].as_object()
}

fn text<'s>(schema: &'s Value, key: &str) -> &'s str {
    schema[key].as_str().unwrap_or_default()
}

/// A description in one cell of a table.
fn in_cell(description: &str) -> String {
    let line = description.split_whitespace().collect::<Vec<_>>();
    line.join(" ").trim_end_matches('.').replace('|', "\\|")
}
