//! Reading YAML, with errors that name the key.

use crate::error::{Error, Result};
use saphyr::{LoadableYamlNode, Scalar, Yaml};
use serde::de::DeserializeOwned;
use serde_json::{Map, Number, Value};

/// Reads a value from the only document of a YAML text; an error names the key that is wrong. `what` is in the file, such as a scene.
pub(super) fn read_yaml<T: DeserializeOwned>(text: &str, file: &str, what: &str) -> Result<T> {
    let refuse = |key: &str, condition: String| Err(Error::input(file, key, condition));
    let documents = match Yaml::load_from_str(text) {
        Ok(documents) => documents,
        Err(error) => return refuse(what, format!("not valid YAML: {error}")),
    };
    let [document] = documents.as_slice() else {
        let found = documents.len();
        return refuse(
            what,
            format!("it has {found} YAML documents, one is needed"),
        );
    };
    if !document.is_mapping() {
        return refuse(what, "it is no YAML with keys".to_owned());
    }
    let value = match as_json(document) {
        Ok(value) => value,
        Err(condition) => return refuse(what, condition),
    };
    serde_path_to_error::deserialize(value).or_else(|error| {
        let path = error.path().to_string();
        let key = if path == "." { what } else { &path };
        refuse(key, error.inner().to_string())
    })
}

/// The same value in the model of JSON, or what is not in it.
fn as_json(yaml: &Yaml<'_>) -> std::result::Result<Value, String> {
    Ok(match yaml {
        Yaml::Value(scalar) => match scalar {
            Scalar::Null => Value::Null,
            Scalar::Boolean(x) => Value::Bool(*x),
            Scalar::Integer(x) => Value::from(*x),
            Scalar::FloatingPoint(x) => match Number::from_f64(x.into_inner()) {
                Some(number) => Value::Number(number),
                None => return Err(format!("it has the number {x}, only finite ones are read")),
            },
            Scalar::String(x) => Value::from(x.as_ref()),
        },
        Yaml::Sequence(list) => {
            let list: std::result::Result<_, _> = list.iter().map(as_json).collect();
            Value::Array(list?)
        }
        Yaml::Mapping(mapping) => {
            let mut object = Map::new();
            for (key, value) in mapping {
                let Some(key) = key.as_str() else {
                    return Err("it has a key that is no text".to_owned());
                };
                object.insert(key.to_owned(), as_json(value)?);
            }
            Value::Object(object)
        }
        Yaml::Tagged(_, inner) => as_json(inner)?,
        Yaml::Representation(..) | Yaml::Alias(_) | Yaml::BadValue => {
            return Err("it has a value that is no text, number, list or mapping".to_owned());
        }
    })
}
