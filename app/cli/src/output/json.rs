//! Readable JSON: objects over several lines, lists in one.

use serde::Serialize;
use serde_json::ser::{Formatter, PrettyFormatter, Serializer};
use std::io::{self, Write};

/// Writes a value as readable JSON: one line per key of an object, lists on one line.
///
/// # Errors
/// The writer fails.
pub fn write_json(value: &impl Serialize, writer: impl Write) -> io::Result<()> {
    let mut serializer = Serializer::with_formatter(writer, Lines::default());
    value.serialize(&mut serializer).map_err(io::Error::from)
}

/// A formatter with line breaks outside of lists and none inside.
#[derive(Default)]
struct Lines {
    pretty: PrettyFormatter<'static>,
    /// The nesting depth of lists.
    lists: usize,
}

/// Writes the separator between the entries of a list, or the keys of an object in a list.
fn separate<W: ?Sized + Write>(writer: &mut W, first: bool) -> io::Result<()> {
    writer.write_all(if first { b"" } else { b", " })
}

impl Formatter for Lines {
    fn begin_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.lists += 1;
        writer.write_all(b"[")
    }

    fn end_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.lists -= 1;
        writer.write_all(b"]")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, w: &mut W, first: bool) -> io::Result<()> {
        separate(w, first)
    }

    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        match self.lists {
            0 => self.pretty.begin_object(writer),
            _ => writer.write_all(b"{"),
        }
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        match self.lists {
            0 => self.pretty.end_object(writer),
            _ => writer.write_all(b"}"),
        }
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, w: &mut W, first: bool) -> io::Result<()> {
        match self.lists {
            0 => self.pretty.begin_object_key(w, first),
            _ => separate(w, first),
        }
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b": ")
    }

    fn end_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.pretty.end_object_value(writer)
    }
}
