//! Values of JSON, refused if they have the wrong type.

use crate::Checked;
use serde_json::Value;

pub(crate) fn get<'a>(value: &'a Value, key: &str) -> Checked<&'a Value> {
    value.get(key).filter(|v| !v.is_null()).ok_or_else(|| format!("'{key}' is missing"))
}

pub(crate) fn option<'a>(value: &'a Value, key: &str) -> Option<&'a Value> {
    value.get(key).filter(|v| !v.is_null())
}

/// The entries of a list, a single value that is not a list, or nothing.
pub(crate) fn entries<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    option(value, key).map_or(&[], |all| all.as_array().map_or(std::slice::from_ref(all), Vec::as_slice))
}

pub(crate) fn number(value: &Value) -> Checked<f64> {
    let x = value.as_f64().filter(|x| x.is_finite());
    x.ok_or_else(|| format!("{value} is no finite number"))
}

pub(crate) fn list(value: &Value) -> Checked<Vec<f64>> {
    array(value)?.iter().map(number).collect()
}

pub(crate) fn array(value: &Value) -> Checked<&Vec<Value>> {
    value.as_array().ok_or_else(|| "a list is missing".to_owned())
}

pub(crate) fn text(value: &Value) -> Checked<&str> {
    value.as_str().ok_or_else(|| format!("{value} is no text"))
}

pub(crate) fn three(value: &Value) -> Checked<[f64; 3]> {
    list(value)?.try_into().map_err(|_| "three numbers are needed".to_owned())
}

pub(crate) fn require(condition: bool, fault: impl Into<String>) -> Checked<()> {
    if condition { Ok(()) } else { Err(fault.into()) }
}
