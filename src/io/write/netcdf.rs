//! Files of netCDF-3, the classic format: dimensions, attributes and arrays, all numbers big-endian.
//!
//! Source: "The `NetCDF` Classic Format Specification" of Unidata. A file has the version 1, with offsets of 32 bits, unless
//! an array begins beyond 2 GiB. Then it has the version 2, with offsets of 64 bits.

use std::io::Write;

use super::error::WriteFault;
use super::records::{WriteProgress, write_records};

/// The tags of the lists of a header.
const DIMENSIONS: u32 = 10;
const VARIABLES: u32 = 11;
const ATTRIBUTES: u32 = 12;

/// The type of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Bytes of text.
    Char,
    /// Integers of 32 bits.
    Int,
    /// Numbers of 64 bits.
    Double,
}

impl Kind {
    fn number(self) -> u32 {
        match self {
            Kind::Char => 2,
            Kind::Int => 4,
            Kind::Double => 6,
        }
    }

    fn bytes(self) -> u64 {
        match self {
            Kind::Char => 1,
            Kind::Int => 4,
            Kind::Double => 8,
        }
    }
}

/// The value of an attribute.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Text.
    Text(String),
    /// An integer.
    Int(i32),
    /// A number of 32 bits.
    Float(f32),
}

/// Appends a record in big-endian order.
type Record<'a> = Box<dyn Fn(&mut Vec<u8>, usize) + Sync + 'a>;

/// An array.
struct Variable<'a> {
    name: String,
    dimensions: Vec<u32>,
    attributes: Vec<(&'static str, Value)>,
    kind: Kind,
    /// The number of records.
    rows: usize,
    record: Record<'a>,
}

/// A file that is not yet written.
#[derive(Default)]
pub struct File<'a> {
    /// The dimensions. The unlimited one has the length 0.
    dimensions: Vec<(String, u32)>,
    /// The attributes of the file.
    pub attributes: Vec<(&'static str, Value)>,
    variables: Vec<Variable<'a>>,
}

/// A dimension of a file.
#[derive(Clone, Copy, Debug)]
pub struct Dimension(u32);

impl<'a> File<'a> {
    /// Adds a dimension. The unlimited dimension has the length 0.
    ///
    /// # Errors
    /// Returns [`WriteFault::TooLarge`] if the length does not fit into 31 bits.
    pub fn dimension(&mut self, name: impl Into<String>, length: usize) -> Result<Dimension, WriteFault> {
        let fault = WriteFault::TooLarge(length as u64);
        let length = i32::try_from(length).map_err(|_| fault)?;
        self.dimensions.push((name.into(), length as u32));
        Ok(Dimension(self.dimensions.len() as u32 - 1))
    }

    /// Adds an array. `record` appends the numbers of a position in the first dimension in big-endian order. The file has
    /// no records of an unlimited dimension.
    pub fn variable(
        &mut self,
        name: impl Into<String>,
        kind: Kind,
        dimensions: &[Dimension],
        record: impl Fn(&mut Vec<u8>, usize) + Sync + 'a,
    ) {
        let rows = dimensions.first().map_or(1, |d| self.dimensions[d.0 as usize].1 as usize);
        self.variables.push(Variable {
            name: name.into(),
            dimensions: dimensions.iter().map(|d| d.0).collect(),
            attributes: Vec::new(),
            kind,
            rows,
            record: Box::new(record),
        });
    }

    /// Adds an attribute to the array that was added last.
    pub fn describe(&mut self, name: &'static str, value: Value) {
        if let Some(variable) = self.variables.last_mut() {
            variable.attributes.push((name, value));
        }
    }

    /// Adds an array of names, of `width` bytes each.
    pub fn names(&mut self, name: &str, dimensions: [Dimension; 2], width: usize, names: Vec<String>) {
        self.variable(name, Kind::Char, &dimensions, move |buffer, i| {
            let text = names.get(i).map_or(&[][..], |name| name.as_bytes());
            buffer.extend(text.iter().copied().chain(std::iter::repeat(0)).take(width));
        });
    }

    /// Returns the bytes of an array without padding, of one record if the first dimension is unlimited.
    fn bytes(&self, variable: &Variable<'_>) -> u64 {
        let lengths = variable.dimensions.iter().map(|&d| u64::from(self.dimensions[d as usize].1));
        let count: u64 = match lengths.clone().next() {
            Some(0) => lengths.skip(1).product(),
            _ => lengths.product(),
        };
        count * variable.kind.bytes()
    }

    /// Writes the file.
    ///
    /// # Errors
    /// Returns [`WriteFault::TooLarge`] if an array has more than 2 GiB, or if writing fails.
    pub fn write(self, out: &mut dyn Write, progress: &mut WriteProgress<'_>) -> Result<(), WriteFault> {
        for variable in &self.variables {
            if i32::try_from(self.bytes(variable)).is_err() {
                return Err(WriteFault::TooLarge(variable.rows as u64));
            }
        }
        let is_large = self.header(false).1 > i32::MAX as u64;
        out.write_all(&self.header(is_large).0)?;
        for variable in self.variables.iter().filter(|variable| variable.rows > 0) {
            write_records(out, variable.rows, progress, &*variable.record)?;
            let bytes = self.bytes(variable);
            out.write_all(&[0; 3][..(padded(bytes) - bytes) as usize])?;
        }
        Ok(())
    }

    /// Returns the header and the size of the file. Arrays follow the header in their order.
    fn header(&self, is_large: bool) -> (Vec<u8>, u64) {
        let width = if is_large { 8 } else { 4 };
        let mut head = b"CDF".to_vec();
        head.push(if is_large { 2 } else { 1 });
        push(&mut head, 0);
        push_length(&mut head, DIMENSIONS, self.dimensions.len());
        for (name, length) in &self.dimensions {
            push_name(&mut head, name);
            push(&mut head, *length);
        }
        push_attributes(&mut head, &self.attributes);
        push_length(&mut head, VARIABLES, self.variables.len());
        let mut holes = Vec::new();
        for variable in &self.variables {
            push_name(&mut head, &variable.name);
            push(&mut head, variable.dimensions.len() as u32);
            for dimension in &variable.dimensions {
                push(&mut head, *dimension);
            }
            push_attributes(&mut head, &variable.attributes);
            push(&mut head, variable.kind.number());
            push(&mut head, padded(self.bytes(variable)) as u32);
            holes.push(head.len());
            head.resize(head.len() + width, 0);
        }
        let mut offset = head.len() as u64;
        let (fixed, records): (Vec<_>, Vec<_>) =
            self.variables.iter().zip(holes).partition(|(variable, _)| variable.rows > 0);
        for (variable, hole) in fixed {
            head[hole..hole + width].copy_from_slice(&offset.to_be_bytes()[8 - width..]);
            offset += padded(self.bytes(variable));
        }
        // Records follow all other arrays. There are none.
        for (_, hole) in records {
            head[hole..hole + width].copy_from_slice(&offset.to_be_bytes()[8 - width..]);
        }
        (head, offset)
    }
}

/// Returns the number of bytes with padding to whole words.
fn padded(bytes: u64) -> u64 {
    bytes.next_multiple_of(4)
}

fn push(head: &mut Vec<u8>, number: u32) {
    head.extend_from_slice(&number.to_be_bytes());
}

/// Appends the tag and the length of a list. An empty list has no tag.
fn push_length(head: &mut Vec<u8>, tag: u32, length: usize) {
    push(head, if length == 0 { 0 } else { tag });
    push(head, length as u32);
}

fn push_name(head: &mut Vec<u8>, name: &str) {
    push(head, name.len() as u32);
    push_padded(head, name.as_bytes());
}

fn push_padded(head: &mut Vec<u8>, bytes: &[u8]) {
    head.extend_from_slice(bytes);
    head.resize(head.len() + padded(bytes.len() as u64) as usize - bytes.len(), 0);
}

fn push_attributes(head: &mut Vec<u8>, attributes: &[(&str, Value)]) {
    push_length(head, ATTRIBUTES, attributes.len());
    for (name, value) in attributes {
        push_name(head, name);
        match value {
            Value::Text(text) => {
                push(head, Kind::Char.number());
                push(head, text.len() as u32);
                push_padded(head, text.as_bytes());
            }
            Value::Int(number) => {
                push(head, Kind::Int.number());
                push(head, 1);
                head.extend_from_slice(&number.to_be_bytes());
            }
            Value::Float(number) => {
                push(head, 5);
                push(head, 1);
                head.extend_from_slice(&number.to_be_bytes());
            }
        }
    }
}

/// Appends integers in big-endian order.
pub fn push_ints(buffer: &mut Vec<u8>, numbers: impl IntoIterator<Item = u64>) {
    for number in numbers {
        buffer.extend_from_slice(&(number as i32).to_be_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_file_has_these_bytes() {
        let mut file = File::default();
        file.attributes.push(("t", Value::Text("ab".to_owned())));
        let n = file.dimension("n", 3).unwrap();
        file.variable("x", Kind::Int, &[n], |buffer, i| push_ints(buffer, [i as u64 + 7]));
        file.describe("u", Value::Int(5));
        let mut bytes = Vec::new();
        let mut silent = |_, _| {};
        file.write(&mut bytes, &mut WriteProgress::new(0, &mut silent)).unwrap();
        let word = |number: u32| number.to_be_bytes();
        let expected = [
            *b"CDF\x01",
            word(0), // no records
            word(10),
            word(1),
            word(1),
            *b"n\0\0\0",
            word(3), // dimensions
            word(12),
            word(1),
            word(1),
            *b"t\0\0\0",
            word(2),
            word(2),
            *b"ab\0\0", // attributes
            word(11),
            word(1),
            word(1),
            *b"x\0\0\0",
            word(1),
            word(0), // variables
            word(12),
            word(1),
            word(1),
            *b"u\0\0\0",
            word(4),
            word(1),
            word(5), // its attributes
            word(4),
            word(12),
            word(120), // type, bytes, offset
            word(7),
            word(8),
            word(9),
        ];
        assert_eq!(bytes, expected.concat());
    }
}
