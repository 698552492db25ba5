//! YAML input with errors that name the key.

use aghf::error::{Error, Result};
use saphyr_parser::{Event, Parser, ScalarStyle, Tag};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

/// The largest nesting depth of lists and mappings. MoveIt's messages have ten.
const DEEPEST: usize = 64;

/// Reads a value from the only document of a YAML text; an error names the faulty key. `what` describes the contents,
/// such as a scene.
pub(crate) fn read_yaml<T: DeserializeOwned>(text: &str, file: &str, what: &str) -> Result<T> {
    of_value(yaml_value(text, file, what)?, file, what)
}

/// The only document of a YAML text, an object.
pub(crate) fn yaml_value(text: &str, file: &str, what: &str) -> Result<Value> {
    let refuse = |condition: String| Err(Error::input(file, what, condition));
    match value_of(text) {
        Ok(Value::Object(object)) => Ok(Value::Object(object)),
        Ok(_) => refuse("it is no YAML with keys".to_owned()),
        Err(condition) => refuse(format!("not valid YAML: {condition}")),
    }
}

/// Reads a value from such a document.
pub(crate) fn of_value<T: DeserializeOwned>(value: Value, file: &str, what: &str) -> Result<T> {
    serde_path_to_error::deserialize(value).map_err(|error| {
        let path = error.path().to_string();
        let key = if path == "." { what } else { &path };
        Error::input(file, key, error.inner().to_string())
    })
}

/// A list or mapping that is not complete yet.
enum Open {
    List(Vec<Value>),
    /// A mapping and the key whose value comes next.
    Mapping(Map<String, Value>, Option<String>),
}

/// The value of the only document of a text in the JSON data model, or the fault.
///
/// The events of the parser are assembled here; deep nesting and references, which can expand beyond any memory, are
/// refused.
fn value_of(text: &str) -> std::result::Result<Value, String> {
    let mut open: Vec<Open> = Vec::new();
    let mut whole = None;
    for event in Parser::new_from_str(text) {
        let (event, span) = event.map_err(|error| error.to_string())?;
        let refuse = |condition: &str| Err(format!("{condition} at line {}", span.start.line()));
        let value = match event {
            Event::SequenceStart(..) | Event::MappingStart(..) if open.len() == DEEPEST => {
                return refuse(&format!("more than {DEEPEST} lists in each other"));
            }
            Event::SequenceStart(_, Some(tag)) | Event::MappingStart(_, Some(tag)) => {
                return refuse(&unknown(&tag));
            }
            Event::SequenceStart(..) => {
                open.push(Open::List(Vec::new()));
                continue;
            }
            Event::MappingStart(..) => {
                open.push(Open::Mapping(Map::new(), None));
                continue;
            }
            Event::SequenceEnd | Event::MappingEnd => match open.pop() {
                Some(Open::List(list)) => Value::Array(list),
                Some(Open::Mapping(mapping, _)) => Value::Object(mapping),
                None => return refuse("an end without a beginning"),
            },
            Event::Scalar(text, style, _, tag) => match tagged(&text, style, tag.as_deref()) {
                Ok(value) => value,
                Err(condition) => return refuse(&condition),
            },
            Event::Alias(_) => return refuse("a reference, which is not read,"),
            _ => continue,
        };
        match open.last_mut() {
            None if whole.is_some() => return refuse("a second document"),
            None => whole = Some(value),
            Some(Open::List(list)) => list.push(value),
            Some(Open::Mapping(mapping, key)) => match key.take() {
                Some(key) => {
                    mapping.insert(key, value);
                }
                None => {
                    let Value::String(text) = value else {
                        return refuse("a key that is no text");
                    };
                    if mapping.contains_key(&text) {
                        return refuse(&format!("the key '{text}' for the second time"));
                    }
                    *key = Some(text);
                }
            },
        }
    }
    whole.ok_or_else(|| "it is empty".to_owned())
}

/// The value of a scalar with its tag, or the fault. The tags of angles are those that rosparam and xacro read.
fn tagged(text: &str, style: ScalarStyle, tag: Option<&Tag>) -> std::result::Result<Value, String> {
    let infinite = || format!("a number that is not finite, {text},");
    let value = scalar(text, style).ok_or_else(infinite)?;
    let Some(tag) = tag else {
        return Ok(value);
    };
    let of_number = |angle: Option<f64>| match angle {
        Some(angle) => Ok(Value::from(angle)),
        None => Err(format!("the tag {tag} without a number")),
    };
    match tag.to_string().as_str() {
        "!degrees" => of_number(value.as_f64().map(f64::to_radians)),
        "!radians" => of_number(value.as_f64()),
        _ => Err(unknown(tag)),
    }
}

/// The fault of a tag that is not read.
fn unknown(tag: &Tag) -> String {
    format!("the tag {tag}, of which !degrees and !radians alone are read,")
}

/// The value of a scalar by the core schema of YAML; `None` for a number that is not finite.
fn scalar(text: &str, style: ScalarStyle) -> Option<Value> {
    if style != ScalarStyle::Plain {
        return Some(Value::from(text));
    }
    let number = text.trim_start_matches(['+', '-']);
    Some(match text {
        "" | "~" | "null" | "Null" | "NULL" => Value::Null,
        "true" | "True" | "TRUE" => Value::Bool(true),
        "false" | "False" | "FALSE" => Value::Bool(false),
        _ if [".inf", ".nan"].contains(&number.to_lowercase().as_str()) => return None,
        // Words such as `infinity` are none here.
        _ if number.starts_with(|c: char| c.is_ascii_digit() || c == '.') => {
            match (text.parse::<i64>(), text.parse::<f64>()) {
                (Ok(integer), _) => Value::from(integer),
                (_, Ok(float)) if float.is_finite() => Value::from(float),
                (_, Ok(_)) => return None,
                _ => Value::from(text),
            }
        }
        _ => Value::from(text),
    })
}
