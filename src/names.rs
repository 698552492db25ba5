//! Enums whose values have names.

use crate::error::{Error, Result};
use std::fmt::Display;
use std::str::FromStr;

/// An enum whose values are chosen by name, in files and on the command line. [`Display`] writes the name and [`FromStr`] reads it.
pub trait Named: Copy + Display + FromStr<Err = Error> + Send + Sync + 'static {
    /// The kind of thing that is chosen, such as `method`; errors name it.
    const WHAT: &'static str;
    /// All values with their names and one line of help each. The first is the default.
    const ALL: &'static [(Self, &'static str, &'static str)];
}

/// The value with this name.
///
/// # Errors
/// There is none; the error lists those that there are.
pub(crate) fn parse<T: Named>(name: &str) -> Result<T> {
    let names = || T::ALL.iter().map(|(_, own, _)| *own);
    match T::ALL.iter().find(|(_, own, _)| *own == name) {
        Some((value, _, _)) => Ok(*value),
        None => Err(none_of(T::WHAT, name, names())),
    }
}

/// The error that `name` is none of `names`.
pub(crate) fn none_of<'a>(what: &str, name: &str, names: impl Iterator<Item = &'a str>) -> Error {
    let names = names.collect::<Vec<_>>().join(", ");
    Error::input("options", what, format!("'{name}' is none of {names}"))
}

/// Defines an enum that is [`Named`]: each value with its documentation, which is its line of help, and its name, by which it is
/// serialised as well. The first value is the default.
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

pub(crate) use named_enum;
