//! Text input from files and the standard input.

use crate::error::{Error, Result};
use std::io::{self, ErrorKind, Read};
use std::path::Path;
use std::path::PathBuf;
use std::sync::OnceLock;

/// The path that denotes the standard input.
const STANDARD_INPUT: &str = "-";

/// The largest text that is read, in bytes; those of robots and scenarios have a few thousand, at most a million.
/// Devices such as `/dev/zero` have no end.
const MAX_TEXT: u64 = 1 << 26;

/// Reads the text of a file, or of the standard input for `-`, without a byte-order mark.
///
/// # Errors
/// The file cannot be read, is larger than 64 MiB or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    if !is_standard_input(path) {
        let text = std::fs::File::open(path).and_then(read_whole);
        return text.map_err(|e| Error::io(path, e));
    }
    // The standard input can be read only once, but a robot from there may be loaded several times.
    static TEXT: OnceLock<String> = OnceLock::new();
    if let Some(text) = TEXT.get() {
        return Ok(text.clone());
    }
    let text = read_whole(io::stdin().lock()).map_err(|e| Error::io(path, e))?;
    Ok(TEXT.get_or_init(|| text).clone())
}

/// Reads as [`read_text`] does; the error for a missing file says that there is no built-in `kind` of that name either.
pub fn read_named(path: &Path, kind: &str) -> Result<String> {
    read_text(path).map_err(|error| match error {
        Error::Io { source, .. } if source.kind() == ErrorKind::NotFound => {
            let condition = format!("there is neither a file nor a built-in {kind} of this name");
            Error::input(path.display().to_string(), kind, condition)
        }
        other => other,
    })
}

/// Returns true if this path denotes the standard input.
pub fn is_standard_input(path: &Path) -> bool {
    path == Path::new(STANDARD_INPUT)
}

/// The file name without its extension, which names the contents.
pub fn name_of(path: &str) -> String {
    if is_standard_input(Path::new(path)) {
        return "stdin".to_owned();
    }
    let stem = Path::new(path).file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

/// The entries of a folder, by name.
pub fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let of = |error| Error::io(folder, error);
    let entries = std::fs::read_dir(folder).map_err(of)?;
    let paths = entries.map(|entry| Ok(entry.map_err(of)?.path()));
    let mut paths = paths.collect::<Result<Vec<_>>>()?;
    paths.sort();
    Ok(paths)
}

/// Reads the bytes of a file.
///
/// # Errors
/// The file cannot be read, or is larger than 64 MiB.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    let bytes = std::fs::File::open(path).and_then(read_some);
    bytes.map_err(|e| Error::io(path, e))
}

fn read_some(source: impl Read) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    source.take(MAX_TEXT + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_TEXT {
        let condition = "it has more than 64 MiB, which no robot, scenario or sweep has";
        return Err(io::Error::new(ErrorKind::InvalidData, condition));
    }
    Ok(bytes)
}

fn read_whole(source: impl Read) -> io::Result<String> {
    let bytes = read_some(source)?;
    let refuse = |condition: &str| Err(io::Error::new(ErrorKind::InvalidData, condition));
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return refuse("it is text in UTF-16, and UTF-8 is needed");
    }
    match String::from_utf8(bytes) {
        Ok(text) => Ok(match text.strip_prefix('\u{feff}') {
            Some(rest) => rest.to_owned(),
            None => text,
        }),
        Err(error) => {
            let valid = error.utf8_error().valid_up_to();
            let line = 1 + error.as_bytes()[..valid].iter().filter(|b| **b == b'\n').count();
            refuse(&format!("it is no text in UTF-8, from line {line} on"))
        }
    }
}
