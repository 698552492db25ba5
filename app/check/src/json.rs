//! Values of JSON of which the grammar has checked the types: a value of another type would be NaN or empty.

use crate::Checked;
use serde_json::Value;

pub(crate) fn option<'a>(value: &'a Value, key: &str) -> Option<&'a Value> {
    value.get(key).filter(|v| !v.is_null())
}

/// The entries of a list, a single value that is not a list, or nothing.
pub(crate) fn entries<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    option(value, key).map_or(&[], |all| all.as_array().map_or(std::slice::from_ref(all), Vec::as_slice))
}

pub(crate) fn is_true(value: &Value, key: &str) -> bool {
    value[key] == true
}

pub(crate) fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

pub(crate) fn number_or(value: &Value, key: &str, default: f64) -> f64 {
    option(value, key).map_or(default, number)
}

pub(crate) fn list(value: &Value) -> Vec<f64> {
    value.as_array().into_iter().flatten().map(number).collect()
}

pub(crate) fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

pub(crate) fn three(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|i| number(&value[i]))
}

pub(crate) fn require(condition: bool, fault: impl Into<String>) -> Checked<()> {
    if condition { Ok(()) } else { Err(fault.into()) }
}
