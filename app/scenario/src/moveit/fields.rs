//! The fields of MoveIt's messages and of `joint_limits.yaml`, and what becomes of each.

use super::field_table::OF_MOVEIT;
use super::other_fields::OF_OTHERS;
use aghf::error::{Error, Result};
use aghf::names::instead;
use serde_json::Value;

/// The treatment of a field.
#[derive(Clone, Copy)]
pub(super) enum Treatment {
    /// It is read, as this.
    Read(&'static str),
    /// It is a message of this type, or a list of them.
    In(&'static str),
    /// It has no meaning for the motion, for this reason.
    Accepted(&'static str),
    /// It is refused unless it is zero, false or empty; with the reason or the remedy.
    Refused(&'static str),
    /// The same, but for this number or word.
    Only(&'static str, &'static str),
}

/// The fields of a message by their names.
pub(super) type Fields = &'static [(&'static str, Treatment)];

/// The Markdown table of all fields, which the guide contains.
#[must_use]
pub fn moveit_fields() -> String {
    let mut table = "| message or file | field | |  |\n| --- | --- | --- | --- |\n".to_owned();
    for (message, fields) in all() {
        for (field, treatment) in *fields {
            let (what, words) = match treatment {
                Treatment::Read(what) => ("read", (*what).to_owned()),
                Treatment::In(inner) => ("read", format!("`{inner}`")),
                Treatment::Accepted(reason) => ("accepted", (*reason).to_owned()),
                Treatment::Refused(remedy) => ("refused", (*remedy).to_owned()),
                Treatment::Only(value, remedy) => ("refused", format!("unless `{value}`: {remedy}")),
            };
            table += &format!("| `{message}` | `{field}` | {what} | {words} |\n");
        }
    }
    table
}

/// Refuses keys of a value that are no fields of this message, and fields that are refused. The place is the file and
/// the element of the value.
///
/// # Errors
/// Names the file, the element and the fault.
pub(crate) fn check_fields(value: &Value, message: &str, [file, at]: [&str; 2]) -> Result<()> {
    match value {
        Value::Null => Ok(()),
        Value::Array(all) => {
            let mut all = all.iter().enumerate();
            all.try_for_each(|(i, one)| check_fields(one, message, [file, &format!("{at}[{i}]")]))
        }
        Value::Object(object) => {
            let fields = fields_of(message);
            for (key, value) in object {
                let element = match at {
                    "" => key.clone(),
                    _ => format!("{at}.{key}"),
                };
                check_field(key, value, (message, fields), [file, &element])?;
            }
            Ok(())
        }
        _ => Err(Error::input(file, at, format!("an object with fields of {message} is needed"))),
    }
}

/// The same for one key of a message.
fn check_field(key: &str, value: &Value, (message, fields): (&str, Fields), place: [&str; 2]) -> Result<()> {
    let refuse = |condition: String| Err(Error::input(place[0], place[1], condition));
    let Some((_, treatment)) = fields.iter().find(|(field, _)| *field == key) else {
        let known = instead(key, fields.iter().map(|(field, _)| *field));
        return refuse(format!("it is no field of {message}{known}"));
    };
    match treatment {
        Treatment::Read(_) | Treatment::Accepted(_) => Ok(()),
        Treatment::In(inner) => check_fields(value, inner, place),
        Treatment::Refused(remedy) if has_value(value) => refuse(format!("it is not read: {remedy}")),
        Treatment::Only(only, remedy) if has_value(value) && !is_word(value, only) => {
            refuse(format!("{only} alone is read: {remedy}"))
        }
        Treatment::Refused(_) | Treatment::Only(..) => Ok(()),
    }
}

/// All messages and files with their fields.
fn all() -> impl Iterator<Item = &'static (&'static str, Fields)> {
    OF_MOVEIT.iter().chain(OF_OTHERS)
}

fn fields_of(message: &str) -> Fields {
    let found = all().find(|(name, _)| *name == message);
    found.map_or(&[], |(_, fields)| fields)
}

/// Returns true if a value is a number, or a word in any case.
fn is_word(value: &Value, word: &str) -> bool {
    match value {
        Value::String(text) => text.eq_ignore_ascii_case(word),
        other => other.as_f64().is_some_and(|number| word.parse() == Ok(number)),
    }
}

/// Returns true if a value is anything but zero, false and empty. A list has one unless it has zeros alone.
fn has_value(value: &Value) -> bool {
    match value {
        Value::Null => false,
        Value::Bool(flag) => *flag,
        Value::Number(number) => number.as_f64() != Some(0.0),
        // A byte of ROS 2 is a text of one character.
        Value::String(text) => text.chars().any(|letter| letter != '\0'),
        Value::Array(list) => list
            .iter()
            .any(|one| matches!(one, Value::String(_) | Value::Array(_) | Value::Object(_)) || has_value(one)),
        Value::Object(object) => object.values().any(has_value),
    }
}
