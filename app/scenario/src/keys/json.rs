//! JSON input with errors that name the key.

use crate::keys::upgrade::instead_of;
use aghf::error::{Error, Result};
use aghf::names::instead;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{DeserializeOwned, Error as _, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

/// Reads a value from JSON; an error names the faulty key. `file` names the text.
pub(crate) fn read_json<T: DeserializeOwned + Serialize>(text: &str, file: &str) -> Result<T> {
    let refuse = |key: &str, condition: String| Error::input(file, key, condition);
    if text.trim_start().starts_with('<') {
        return Err(refuse("scenario", "it is XML, such as a URDF, and no JSON".to_owned()));
    }
    // Checked first, because otherwise the message would name the first entry.
    if text.trim_start().starts_with('[') {
        return Err(refuse("scenario", NO_OBJECT.to_owned()));
    }
    let reader = &mut serde_json::Deserializer::from_str(text);
    let value: T = serde_path_to_error::deserialize(&mut *reader).map_err(|error| {
        let path = error.path().to_string();
        let key = if path == "." { "scenario" } else { &path };
        let mut condition = error.inner().to_string();
        if condition.starts_with("invalid type: unit variant") {
            let name = path.rsplit('.').next().unwrap_or_default();
            condition = format!("it has keys of its own: {{\"{name}\": {{...}}}} is needed");
        }
        if let Some(needed) = instead_of(&path).or_else(|| with_nearest(&condition)) {
            condition = needed;
        }
        refuse(key, condition)
    })?;
    let of_text = |e: serde_json::Error| refuse("scenario", e.to_string());
    reader.end().map_err(of_text)?;
    let given = serde_json::from_str(text).map_err(of_text)?;
    let read = serde_json::to_value(&value).map_err(of_text)?;
    match list_for_object(&given, &read) {
        Some(path) => Err(refuse(path.trim_start_matches('.'), NO_OBJECT.to_owned())),
        None => Ok(value),
    }
}

/// The message of serde about an unknown key, with the nearest known keys instead of all if there are many.
fn with_nearest(condition: &str) -> Option<String> {
    let of_key = condition.strip_prefix("unknown field `")?;
    let (key, rest) = of_key.split_once("`, expected one of `")?;
    let (known, place) = rest.rsplit_once('`')?;
    let known = known.split("`, `");
    Some(format!("unknown field `{key}`{}{place}", instead(key, known)))
}

/// Reads a value from the keys of an object; an error names the faulty key. `file` names the object.
pub(crate) fn read_keys<T: DeserializeOwned>(keys: Map<String, Value>, file: &str) -> Result<T> {
    serde_path_to_error::deserialize(Value::Object(keys)).map_err(|error| {
        let (key, condition) = (error.path().to_string(), error.inner().to_string());
        let condition = with_nearest(&condition).unwrap_or(condition);
        Error::input(file, key, condition)
    })
}

const NO_OBJECT: &str = "it is a list, not an object with keys";

/// The path of a list in `given` that serde read as an object: it accepts one as the values of the keys in order.
fn list_for_object(given: &Value, read: &Value) -> Option<String> {
    match (given, read) {
        (Value::Object(given), Value::Object(read)) => given.iter().find_map(|(key, given)| {
            let path = list_for_object(given, read.get(key)?)?;
            Some(format!(".{key}{path}"))
        }),
        (Value::Array(given), Value::Array(read)) => {
            let mut both = given.iter().zip(read).enumerate();
            both.find_map(|(i, (given, read))| Some(format!("[{i}]{}", list_for_object(given, read)?)))
        }
        (Value::Array(_), _) => Some(String::new()),
        _ => None,
    }
}

/// Reads an object of values and refuses repeated keys, of which serde would silently keep the last.
pub(crate) fn by_name<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
) -> std::result::Result<BTreeMap<String, T>, D::Error> {
    struct Values<T>(PhantomData<T>);
    impl<'de, T: Deserialize<'de>> Visitor<'de> for Values<T> {
        type Value = BTreeMap<String, T>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("an object of values by their names")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<Self::Value, A::Error> {
            let mut values = BTreeMap::new();
            while let Some((name, value)) = map.next_entry::<String, T>()? {
                if values.contains_key(&name) {
                    return Err(A::Error::custom(format!("duplicate field `{name}`")));
                }
                values.insert(name, value);
            }
            Ok(values)
        }
    }
    deserializer.deserialize_map(Values(PhantomData))
}

/// Reads an object, or a list of them.
pub(crate) fn one_or_more<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
) -> std::result::Result<Vec<T>, D::Error> {
    struct Values<T>(PhantomData<T>);
    impl<'de, T: Deserialize<'de>> Visitor<'de> for Values<T> {
        type Value = Vec<T>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("an object, or a list of objects")
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> std::result::Result<Vec<T>, A::Error> {
            Ok(vec![T::deserialize(MapAccessDeserializer::new(map))?])
        }

        fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> std::result::Result<Vec<T>, A::Error> {
            Vec::deserialize(SeqAccessDeserializer::new(seq))
        }
    }
    deserializer.deserialize_any(Values(PhantomData))
}
