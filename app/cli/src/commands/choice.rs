//! Options that are selected by name.

use aghf::names::Named;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// Reads the name of a value; help and errors list all names.
pub(super) fn choice<T: Named>() -> impl TypedValueParser<Value = T> {
    let values = T::ALL.iter();
    let values = values.map(|(_, name, help)| PossibleValue::new(*name).help(help.trim().trim_end_matches('.')));
    PossibleValuesParser::new(values).try_map(|name| name.parse::<T>())
}
