//! The rows of raw files, as their text describes them.

use std::fmt;
use std::str::FromStr;

use super::scalar::{Endian, Scalar};

/// The rows of a raw file: the type of the coordinates, their byte order, and the number of coordinates of a point.
///
/// Their text has the form `TYPE,D`. `TYPE` is `f32` or `f64` for little-endian numbers, `f32be` or `f64be` for big-endian
/// ones, and `D` is 2 or 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RawRows {
    pub(super) scalar: Scalar,
    pub(super) endian: Endian,
    pub(super) dimension: usize,
}

/// The types of coordinates, and their names.
const TYPES: [(&str, Scalar, Endian); 4] = [
    ("f32", Scalar::F32, Endian::Little),
    ("f64", Scalar::F64, Endian::Little),
    ("f32be", Scalar::F32, Endian::Big),
    ("f64be", Scalar::F64, Endian::Big),
];

/// The error for a text that describes no rows of a raw file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected TYPE,D, such as f64,3: TYPE is f32, f64, f32be or f64be, and D is 2 or 3")]
pub struct UnknownRawRows;

impl FromStr for RawRows {
    type Err = UnknownRawRows;

    fn from_str(text: &str) -> Result<Self, UnknownRawRows> {
        let (name, dimension) = text.split_once(',').ok_or(UnknownRawRows)?;
        let (_, scalar, endian) = *TYPES.iter().find(|known| known.0 == name).ok_or(UnknownRawRows)?;
        let dimension = match dimension {
            "2" => 2,
            "3" => 3,
            _ => return Err(UnknownRawRows),
        };
        Ok(RawRows { scalar, endian, dimension })
    }
}

impl fmt::Display for RawRows {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = TYPES.iter().find(|known| (known.1, known.2) == (self.scalar, self.endian));
        write!(f, "{},{}", name.map_or("", |known| known.0), self.dimension)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_have_a_text() {
        for text in ["f32,2", "f64,3", "f32be,3", "f64be,2"] {
            assert_eq!(text.parse::<RawRows>().unwrap().to_string(), text);
        }
        for text in
            ["", "f64", "f64,4", "f64,", "f8,3", "f64le,3", "f64,3,", " f64,3", "F64,3", "f64 3", "i4,2"]
        {
            assert_eq!(text.parse::<RawRows>(), Err(UnknownRawRows), "{text}");
        }
    }
}
