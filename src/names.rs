//! Enums with named values.

use crate::error::{Error, Result};
use std::fmt::Display;
use std::str::FromStr;

/// The number of names up to which a message lists all.
const MAX_LISTED: usize = 8;
/// The number of nearest names in a message otherwise.
const NEAREST: usize = 3;

/// An enum whose values are selected by name, in files and on the command line. [`Display`] writes the name and
/// [`FromStr`] reads it.
pub trait Named: Copy + Display + FromStr<Err = Error> + Send + Sync + 'static {
    /// The kind of choice, such as `method`, for error messages.
    const WHAT: &'static str;
    /// All values with their names and one line of help each. The first is the default.
    const ALL: &'static [(Self, &'static str, &'static str)];
}

/// Finds the value with this name.
///
/// # Errors
/// There is no such value; the error lists the names.
pub fn parse<T: Named>(name: &str) -> Result<T> {
    let names = || T::ALL.iter().map(|(_, own, _)| *own);
    match T::ALL.iter().find(|(_, own, _)| *own == name) {
        Some((value, _, _)) => Ok(*value),
        None => Err(none_of(T::WHAT, name, names())),
    }
}

/// The error for a `name` that is not one of `names`.
pub fn none_of<'a>(what: &str, name: &str, names: impl Iterator<Item = &'a str>) -> Error {
    let names = names.collect::<Vec<_>>().join(", ");
    Error::input("options", what, format!("'{name}' is none of {names}"))
}

/// The end of a message about a `name` that is none of `names`: these if they are few, otherwise the nearest.
pub fn instead<'a>(name: &str, names: impl Iterator<Item = &'a str>) -> String {
    let mut all: Vec<_> = names.collect();
    let count = all.len();
    let mut words = "there are".to_owned();
    if count > MAX_LISTED {
        // The one is for pieces of a longer name, the other for a digit that differs.
        let likeness = |other: &str| strsim::sorensen_dice(name, other) + strsim::jaro_winkler(name, other);
        all.sort_by(|a, b| likeness(b).total_cmp(&likeness(a)));
        all.truncate(NEAREST);
        words = format!("the nearest of {count} are");
    }
    let all: Vec<_> = all.iter().map(|name| format!("'{name}'")).collect();
    match all.as_slice() {
        [] => String::new(),
        all => format!("; {words} {}", all.join(", ")),
    }
}

/// Defines a [`Named`] enum: each value has documentation, which is also its line of help, and a name, by which it is
/// serialised. The first value is the default.
#[macro_export]
macro_rules! named_enum {
    ($(#[$about:meta])* $visibility:vis enum $Enum:ident($what:literal) {
        $($(#[doc = $help:literal])+ $Value:ident = $name:literal,)+
    }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        $visibility enum $Enum {
            $($(#[doc = $help])+ #[serde(rename = $name)] $Value,)+
        }

        impl $crate::names::Named for $Enum {
            const WHAT: &'static str = $what;
            const ALL: &'static [(Self, &'static str, &'static str)] =
                &[$((Self::$Value, $name, concat!($($help),+))),+];
        }

        impl $Enum {
            /// All values with their names.
            $visibility fn by_name() -> impl Iterator<Item = (&'static str, Self)> {
                let all = <Self as $crate::names::Named>::ALL.iter();
                all.map(|(value, name, _)| (*name, *value))
            }
        }

        impl Default for $Enum {
            fn default() -> Self {
                <Self as $crate::names::Named>::ALL[0].0
            }
        }

        impl std::fmt::Display for $Enum {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(match self {
                    $(Self::$Value => $name,)+
                })
            }
        }

        impl std::str::FromStr for $Enum {
            type Err = $crate::error::Error;

            fn from_str(name: &str) -> $crate::error::Result<Self> {
                $crate::names::parse(name)
            }
        }
    };
}

pub use named_enum;
