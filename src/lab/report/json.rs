//! The layout of the JSON: an object's fields and a list's rows each on a line of their own, what is deeper
//! on that line. So a report can be read, compared line by line, and stays small.

use std::io::{self, Write};

use serde::Serialize;
use serde_json::ser::Formatter;

use super::Report;

/// Containers deeper than this stay on one line.
const OPEN_LEVELS: usize = 3;

/// Writes the outer levels line by line.
#[derive(Default)]
struct Rows {
    /// What is open: does it hold lines?
    open: Vec<bool>,
    /// Is the value that comes next an element of a list?
    in_list: bool,
}

impl Rows {
    fn line<W: ?Sized + Write>(&self, out: &mut W) -> io::Result<()> {
        out.write_all(b"\n")?;
        (0..self.open.len()).try_for_each(|_| out.write_all(b"  "))
    }

    fn begin(&mut self) {
        self.open.push(false);
    }

    /// An element that begins on a line of its own.
    fn own_line<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        if let Some(held) = self.open.last_mut() {
            *held = true;
        }
        self.line(out)
    }

    fn end<W: ?Sized + Write>(&mut self, out: &mut W, close: &[u8]) -> io::Result<()> {
        if self.open.pop() == Some(true) {
            self.line(out)?;
        }
        out.write_all(close)
    }
}

impl Formatter for Rows {
    fn begin_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.begin();
        out.write_all(b"[")
    }

    fn end_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.end(out, b"]")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        self.in_list = true;
        if first { Ok(()) } else { out.write_all(b",") }
    }

    fn begin_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        // A row of a list begins a line.
        if (2..=OPEN_LEVELS).contains(&self.open.len()) && self.in_list {
            self.own_line(out)?;
        }
        self.begin();
        out.write_all(b"{")
    }

    fn end_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.end(out, b"}")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        let spread = self.open.len() == 1;
        match (first, spread) {
            (true, false) => Ok(()),
            (false, false) => out.write_all(b", "),
            (true, true) => self.own_line(out),
            (false, true) => out.write_all(b",").and_then(|()| self.own_line(out)),
        }
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.in_list = false;
        out.write_all(b": ")
    }
}

impl Report {
    /// The report as JSON.
    ///
    /// # Errors
    /// A number that JSON cannot say; the report holds none.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        rows(self)
    }
}

/// Anything as JSON of this layout.
pub(crate) fn rows(value: &impl Serialize) -> Result<String, serde_json::Error> {
    let mut bytes = Vec::new();
    value.serialize(&mut serde_json::Serializer::with_formatter(&mut bytes, Rows::default()))?;
    String::from_utf8(bytes).map_err(serde::ser::Error::custom)
}
