//! Rows of weights: one number a row.

use std::path::Path;

use super::error::{InputError, Place};
use super::header::is_header;
use super::row::Row;
use super::text::{Lines, Source, number};
use super::weights::{WeightOption, blame, of_number};

/// Weights that are read, in the order of the rows.
pub(super) struct WeightRows<'a> {
    /// The file that has them.
    path: &'a Path,
    are_radii: bool,
    /// The number of rows before the first one.
    first: u64,
    /// The weights. A number that is no weight is NaN if such rows are dropped.
    pub values: Vec<f64>,
    /// Whether rows without a weight are dropped, and are no errors.
    drops: bool,
}

impl<'a> WeightRows<'a> {
    /// Creates an empty set.
    pub fn new(path: &'a Path, option: &WeightOption, drops: bool) -> Self {
        WeightRows { path, are_radii: option.are_radii, first: 0, values: Vec::new(), drops }
    }

    /// Returns an empty set of rows that follow `first` rows of the file.
    pub fn after(self, first: u64) -> Self {
        WeightRows { first, ..self }
    }

    /// Returns the number of the next row.
    fn next_row(&self) -> u64 {
        self.first + self.values.len() as u64
    }

    /// Adds the next row, which `error` says has no number.
    pub fn push_without(&mut self, error: impl FnOnce() -> InputError) -> Result<(), InputError> {
        if !self.drops {
            return Err(error().in_row(self.next_row()));
        }
        self.values.push(f64::NAN);
        Ok(())
    }

    /// Adds the number of the next row.
    pub fn push(&mut self, place: Place, number: f64) -> Result<(), InputError> {
        let index = self.next_row();
        let weight = match of_number(number, self.are_radii) {
            Ok(weight) => weight,
            Err(_) if self.drops => f64::NAN,
            Err(fault) => return Err(blame(self.path, (place, index), number, (self.are_radii, fault))),
        };
        self.values.push(weight);
        Ok(())
    }
}

/// Reads the rows of a text. A first row that is a name is a header.
pub(super) fn read_text(source: Source<'_>, rows: &mut WeightRows<'_>) -> Result<(), InputError> {
    let mut has_header = false;
    for line in Lines::new(source.data) {
        let row = Row::of(line, 3);
        if row.fields.is_empty() {
            continue;
        }
        if rows.values.is_empty() && !has_header && is_header(&row.fields) {
            has_header = true;
            continue;
        }
        match (&row.fields[..], row.fields.first().and_then(|field| number(field))) {
            ([_], Some(value)) => rows.push(line.place(), value)?,
            ([field], None) => rows.push_without(|| source.bad_number(&line, field))?,
            _ => return Err(source.bad_line(&line, "one number").in_row(rows.next_row())),
        }
    }
    Ok(())
}
