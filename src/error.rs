//! Errors of the input.

#[cfg(feature = "solvers")]
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// The result of all functions that read input.
pub type Result<T> = std::result::Result<T, Error>;

/// Invalid input: names the file, the element and the fault.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A slice or matrix has the wrong size.
    #[error("{what}: expected {expected} entries, found {found}")]
    Length {
        /// The argument.
        what: &'static str,
        /// The number of entries it should have.
        expected: usize,
        /// The number of entries it has.
        found: usize,
    },
    /// An element of a file, or of a model made in code, is invalid.
    #[error("{file}: {element}: {condition}")]
    Input {
        /// The file, or the name of a built-in or programmatic object.
        file: String,
        /// The element of the file: a link, a joint, a key.
        element: String,
        /// The fault.
        condition: String,
    },
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The cause of the failure.
        source: std::io::Error,
    },
}

impl Error {
    /// Builds an [`Error::Input`].
    pub fn input(file: impl Into<String>, element: impl Into<String>, condition: impl Into<String>) -> Self {
        Self::Input { file: file.into(), element: element.into(), condition: condition.into() }
    }

    /// Builds an [`Error::Io`] about `path`.
    pub fn io(path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Self::Io { path: path.into(), source }
    }
}

/// Checks the length of an argument.
pub fn check_length(what: &'static str, expected: usize, found: usize) -> Result<()> {
    if expected == found { Ok(()) } else { Err(Error::Length { what, expected, found }) }
}

/// Checks that a requested number is within its bounds. `what` names the setting.
#[cfg(feature = "solvers")]
pub fn check_count(what: &str, found: usize, allowed: RangeInclusive<usize>) -> Result<()> {
    if allowed.contains(&found) {
        return Ok(());
    }
    let (least, most) = allowed.into_inner();
    let condition = format!("it is {found} and must be at least {least} and at most {most}");
    Err(Error::input("settings", what, condition))
}

/// Checks that a requested number is positive and finite. `of` and `what` name the group and the number in it.
#[cfg(feature = "solvers")]
pub fn check_positive(of: &str, what: &str, value: f64) -> Result<()> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    let condition = format!("it is {value} and must be a positive number");
    Err(Error::input(of, what, condition))
}

/// Formats a number for a message, without hundreds of digits.
pub fn plain(x: f64) -> String {
    if x == 0.0 || !x.is_finite() || (1e-4..1e9).contains(&x.abs()) { format!("{x}") } else { format!("{x:e}") }
}
