//! The layout of the JSON. Each field of the outermost object begins a line, and so does each object that is an element
//! of a list near the top. Deeper values stay on the line of the object that contains them. Reports are therefore
//! small, and can be read and compared line by line.

use std::io::{self, Write};

use serde::Serialize;
use serde_json::ser::Formatter;

use super::RunReport;

/// Largest number of open containers at which an object in a list begins a line.
const OPEN_LEVELS: usize = 3;

/// A formatter that breaks lines in the outer levels.
#[derive(Default)]
struct Rows {
    /// For each open container, whether it is broken into lines.
    open: Vec<bool>,
    /// Whether the next value is an element of a list.
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

    /// Begins an element on its own line.
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
        // A row of a list begins on a new line.
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

impl RunReport {
    /// Returns the report as JSON.
    ///
    /// # Errors
    /// Fails if a number has no JSON form. A report has no such number.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        rows(self)
    }
}

/// Returns any value as JSON in this layout.
pub(crate) fn rows(value: &impl Serialize) -> Result<String, serde_json::Error> {
    let mut bytes = Vec::new();
    value.serialize(&mut serde_json::Serializer::with_formatter(&mut bytes, Rows::default()))?;
    String::from_utf8(bytes).map_err(serde::ser::Error::custom)
}
