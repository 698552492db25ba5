//! Strict reading: what the grammar of a certificate's files does not have is refused. `proofs/certificate_format.md`
//! has the notation.

use crate::Checked;
use crate::json::require;
use crate::robot::numbers;
use roxmltree::Node;
use serde_json::{Map, Value};
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// The largest length, mass and similar number, in SI units.
const MAX_NUMBER: f64 = 1e6;

/// A value of a file: of JSON, an element of XML, or an attribute of one.
#[derive(Clone, Copy)]
pub(crate) enum Item<'a> {
    Json(&'a Value),
    Element(Node<'a, 'a>),
    Attribute(&'a str),
}

/// The value of a JSON text, in which no key may be repeated within an object.
pub(crate) fn parse(text: &str) -> Checked<Value> {
    let value = serde_json::from_str(text).map_err(|e| e.to_string())?;
    // In a valid text each colon outside of strings follows a key.
    let (mut colons, mut in_string, mut is_escaped) = (0, false, false);
    for byte in text.bytes() {
        match byte {
            _ if is_escaped => is_escaped = false,
            b'\\' => is_escaped = true,
            b'"' => in_string = !in_string,
            b':' if !in_string => colons += 1,
            _ => {}
        }
    }
    require(colons == keys(&value), "a key is repeated in an object")?;
    Ok(value)
}

/// The number of keys in all objects of a value.
fn keys(value: &Value) -> usize {
    match value {
        Value::Array(all) => all.iter().map(keys).sum(),
        Value::Object(all) => all.values().map(|inner| 1 + keys(inner)).sum(),
        _ => 0,
    }
}

/// The grammar.
pub(crate) struct Grammar(Value);

impl Grammar {
    pub(crate) fn new() -> Checked<Self> {
        Ok(Self(parse(include_str!("grammar.json"))?))
    }

    /// Refuses an item that is not what the rule of this name has.
    pub(crate) fn check(&self, item: Item, rule: &str) -> Checked<()> {
        self.fits(item, &Value::from(rule), rule)
    }

    fn fits(&self, item: Item, rule: &Value, at: &str) -> Checked<()> {
        match rule {
            Value::String(names) => match names.split('|').collect::<Vec<_>>()[..] {
                [name] if self.0.get(name).is_some() => self.fits(item, &self.0[name], at),
                [name] => require(is_atom(item, name), format!("{at} is not of the kind {name}")),
                ref all => {
                    let fits = |name: &&str| self.fits(item, &Value::from(*name), at).is_ok();
                    require(all.iter().any(fits), format!("{at} is not of the kind {}", all.join(" or ")))
                }
            },
            Value::Array(rules) => {
                let Item::Json(Value::Array(all)) = item else { return Err(format!("{at} is no list")) };
                let count = rules.len();
                require(count == 1 || count == all.len(), format!("{at} has {} entries, not {count}", all.len()))?;
                let rules = rules.iter().cycle();
                let fits = |(i, (value, rule))| self.fits(Item::Json(value), rule, &format!("{at}[{i}]"));
                all.iter().zip(rules).enumerate().try_for_each(fits)
            }
            Value::Object(rules) => self.members(item, rules, at),
            _ => Err(format!("the grammar has no rule for {at}")),
        }
    }

    /// Refuses unknown, repeated and missing keys, attributes and elements. A rule for the key `k` is `k`, `k?` if it
    /// may be left out, `k*` if it is of any number of elements, or that of the empty key.
    fn members(&self, item: Item, rules: &Map<String, Value>, at: &str) -> Checked<()> {
        let mut found = BTreeSet::new();
        for (key, inner) in members(item).ok_or_else(|| format!("{at} is no object"))? {
            let own = rules.iter().find(|(name, _)| name.trim_end_matches(['?', '*']) == key);
            let (name, rule) =
                own.or_else(|| rules.get_key_value("")).ok_or_else(|| format!("{at}: '{key}' is not in the subset"))?;
            self.fits(inner, rule, &format!("{at}.{key}"))?;
            let is_new = found.insert(key.clone()) || name.ends_with('*');
            require(is_new, format!("{at}: '{key}' is there twice"))?;
        }
        let needed = rules.keys().filter(|name| !name.ends_with(['?', '*']) && !name.is_empty());
        needed.into_iter().try_for_each(|name| require(found.contains(name), format!("{at}: '{name}' is missing")))
    }
}

/// The values of an object by their keys, or the attributes and the elements of an element.
fn members(item: Item) -> Option<Vec<(String, Item)>> {
    // `xmlns=""` is no namespace.
    let prefix = |space: &str| if space.is_empty() { String::new() } else { format!("{{{space}}}") };
    let named = |space: Option<&str>, name: &str| prefix(space.unwrap_or_default()) + name;
    Some(match item {
        Item::Json(Value::Object(all)) => all.iter().map(|(key, value)| (key.clone(), Item::Json(value))).collect(),
        Item::Element(node) => {
            let attributes = node.attributes().map(|a| (a.namespace(), a.name(), Item::Attribute(a.value())));
            let attributes = attributes.map(|(space, name, value)| (format!("@{}", named(space, name)), value));
            let elements = node.children().filter(Node::is_element);
            let elements = elements.map(|e| (named(e.tag_name().namespace(), e.tag_name().name()), Item::Element(e)));
            attributes.chain(elements).collect()
        }
        _ => return None,
    })
}

/// True if an item is of a kind that the notation itself has.
fn is_atom(item: Item, kind: &str) -> bool {
    let is_in = |x: f64| match kind {
        "number" | "decimal" => x.is_finite(),
        "positive" | "decimal1" | "decimals1" => x > 0.0 && x <= MAX_NUMBER,
        "magnitude" => (0.0..=MAX_NUMBER).contains(&x),
        "length" | "decimals" => x.abs() <= MAX_NUMBER,
        "weight" | "decimal0" => x >= 0.0 && x.is_finite(),
        "share" => x > 0.0 && x <= 1.0,
        "angle" => x > 0.0 && x < PI,
        "place" => x.abs() <= 1.0,
        "reserve" => (-crate::TOLERANCE..=1.0).contains(&x),
        _ => false,
    };
    let text = match item {
        Item::Json(Value::String(text)) => Some(text.as_str()),
        Item::Attribute(text) => Some(text),
        _ => None,
    };
    match (kind, item) {
        ("any", _) | ("bool", Item::Json(Value::Bool(_))) | ("null", Item::Json(Value::Null)) => true,
        ("text", _) => text.is_some(),
        ("name", _) => text.is_some_and(|text| !text.is_empty()),
        ("hash", _) => text.is_some_and(|text| text.len() == 64 && text.bytes().all(|b| b.is_ascii_hexdigit())),
        ("index", Item::Json(value)) => value.as_u64().is_some_and(|i| i as f64 <= MAX_NUMBER),
        (_, Item::Json(Value::Number(x))) => x.as_f64().is_some_and(is_in),
        (_, Item::Attribute(text)) if kind.starts_with("decimal") => {
            let count = if kind.starts_with("decimals") { 3 } else { 1 };
            numbers(text).is_ok_and(|all| all.len() == count && all.into_iter().all(is_in))
        }
        _ => text.is_some_and(|text| kind == format!("'{text}'")),
    }
}
