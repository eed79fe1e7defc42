//! Weights of points: where they are, and the rules for their numbers.
//!
//! A weight is a squared length. A radius is a length, and its square is the weight.

use std::path::{Path, PathBuf};

use super::error::{InputError, Place, WeightError, WeightFault};
use crate::ending::extension;
use crate::format::{Format, Role, may_be_table};

/// Where the weights of points are, and whether they are radii.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WeightOption {
    /// The place of the numbers.
    pub source: WeightSource,
    /// Whether the numbers are radii, whose squares are the weights. By default they are weights.
    pub are_radii: bool,
}

/// The place of the weights of points.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WeightSource {
    /// A column of the file of the points: a name, or a 1-based number. It is no column of coordinates.
    Column(String),
    /// A file of one number a row. Its rows are those of the input, including rows of points that are dropped.
    File(PathBuf),
}

impl WeightSource {
    /// Returns the file if the text ends as the name of a file of a known format, otherwise the column.
    pub fn of_argument(text: &str) -> Self {
        let path = Path::new(text);
        let is_file = !extension(path).is_empty() && (Format::of_path(path).is_some() || may_be_table(path));
        if is_file { WeightSource::File(path.to_owned()) } else { WeightSource::Column(text.to_owned()) }
    }
}

impl WeightOption {
    /// Returns the column, if the weights are in a column.
    pub(super) fn column(&self) -> Option<&str> {
        match &self.source {
            WeightSource::Column(name) => Some(name),
            WeightSource::File(_) => None,
        }
    }

    /// Returns the file, if the weights are in a file of their own.
    pub fn file(&self) -> Option<&Path> {
        match &self.source {
            WeightSource::Column(_) => None,
            WeightSource::File(path) => Some(path),
        }
    }
}

/// Refuses a column of weights in files of a format without columns to choose.
pub(super) fn check_format(path: &Path, format: Format) -> Result<(), InputError> {
    if format.has(Role::WeightColumn) {
        return Ok(());
    }
    Err(WeightError::NoColumns { path: path.to_owned(), format: format.name() }.into())
}

/// Returns the 0-based position of a column that a number from 1 to `width` selects.
pub(super) fn numbered(name: &str, width: usize) -> Option<usize> {
    name.trim().parse::<usize>().ok().filter(|number| (1..=width).contains(number)).map(|number| number - 1)
}

/// Returns the weight that a number gives.
pub(super) fn of_number(number: f64, are_radii: bool) -> Result<f64, WeightFault> {
    let weight = if are_radii { number * number } else { number };
    match (number.is_finite(), are_radii && number < 0.0, weight.is_finite()) {
        (false, _, _) => Err(WeightFault::NotFinite),
        (_, true, _) => Err(WeightFault::Negative),
        (_, _, false) => Err(WeightFault::Overflow),
        // Adding zero converts -0.0 to 0.0.
        _ => Ok(weight + 0.0),
    }
}

/// Returns the error for a number that is no weight, at a place in a file, of the row `index`.
pub(super) fn blame(
    path: &Path,
    (place, index): (Place, u64),
    value: f64,
    (are_radii, fault): (bool, WeightFault),
) -> InputError {
    WeightError::Value { path: path.to_owned(), place, index, value, are_radii, fault }.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_are_files() {
        for (text, is_file) in [
            ("w.txt", true),
            ("a/b.NPY", true),
            ("w.csv.gz", true),
            ("w.dat", true),
            ("w.vtu", true),
            ("radius", false),
            ("4", false),
            ("r.2", false),
            ("w.h5", false),
            ("txt", false),
            ("w.gz", false),
            ("-", false),
        ] {
            let found = WeightSource::of_argument(text);
            assert_eq!(matches!(found, WeightSource::File(_)), is_file, "{text}");
        }
    }

    #[test]
    fn radii_are_squared() {
        assert_eq!(of_number(-3.0, false), Ok(-3.0));
        assert_eq!(of_number(3.0, true), Ok(9.0));
        assert_eq!(of_number(-0.0, true).map(f64::to_bits), Ok(0.0_f64.to_bits()));
        assert_eq!(of_number(-0.0, false).map(f64::to_bits), Ok(0.0_f64.to_bits()));
        for (number, are_radii, fault) in [
            (f64::NAN, false, WeightFault::NotFinite),
            (f64::NEG_INFINITY, true, WeightFault::NotFinite),
            (-1.0, true, WeightFault::Negative),
            (1e200, true, WeightFault::Overflow),
        ] {
            assert_eq!(of_number(number, are_radii), Err(fault));
        }
    }
}
