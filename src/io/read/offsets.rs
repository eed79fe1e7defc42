//! Files of the offsets of the vertices of periodic triangulations.

use std::path::Path;

use super::error::{InputError, Place};
use super::formats::{described, npy, of_content};
use super::load::{self, Packing};
use super::points::ReadProgress;
use super::text::Source;
use crate::format::{Format, Role};

/// Reads the offsets of a number of cells in a dimension: an array of integers of shape (cells, dimension + 1, dimension). The
/// numbers of a vertex are consecutive, then those of a cell.
///
/// # Errors
/// Returns an [`InputError`] if the file cannot be read, if it is no such array, or if a number has more than 32 bits.
pub fn read_offsets(
    path: &Path,
    (cells, dimension): (usize, usize),
    progress: &mut ReadProgress<'_>,
) -> Result<Vec<i32>, InputError> {
    let data = load::load(path, Packing::of(path), progress)?;
    let source = Source { path, data: &data };
    match of_content(&data).or_else(|| Format::of_path(path)) {
        Some(Format::Npy) => npy::read_offsets(source, (cells, dimension)),
        Some(format) => Err(refused(source, format!("{} of offsets", described(format)))),
        None => Err(refused(source, "a file of offsets of an unknown format".to_owned())),
    }
}

fn refused(source: Source<'_>, what: String) -> InputError {
    source.unsupported(Place::Whole, what, format!("give the offsets as one of {}", Role::Offsets.known()))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn array(header: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        bytes
    }

    fn read(name: &str, content: &[u8], cells: usize) -> Result<Vec<i32>, InputError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        fs::write(&path, content).unwrap();
        read_offsets(&path, (cells, 2), &mut |_, _| {})
    }

    #[test]
    fn both_orders_are_read() {
        let numbers = [0, 0, 1, 0, 0, 255, 0, 0, 2, 3, 4, 5];
        let head = |fortran: &str, shape: &str| {
            format!("{{'descr': '|i1', 'fortran_order': {fortran}, 'shape': {shape}, }}")
        };
        let rows = array(&head("False", "(2, 3, 2)"), &numbers);
        let expected = vec![0, 0, 1, 0, 0, -1, 0, 0, 2, 3, 4, 5];
        assert_eq!(read("o.npy", &rows, 2).unwrap(), expected);
        let transposed: Vec<u8> = (0..12).map(|i| numbers[i % 2 * 6 + i / 2 % 3 * 2 + i / 6]).collect();
        let columns = array(&head("True", "(2, 3, 2)"), &transposed);
        assert_eq!(read("o.npy", &columns, 2).unwrap(), expected);
        for shape in ["(2, 3, 3)", "(3, 2, 2)", "(2, 6)", "(12,)"] {
            let error = read("o.npy", &array(&head("False", shape), &numbers), 2).unwrap_err();
            assert!(error.to_string().contains("shape"), "{error}");
        }
        let error = read("o.npy", &rows, 3).unwrap_err().to_string();
        assert!(error.contains("offsets of 2 cells"), "{error}");
        assert!(read("o.csv", b"0,0\n", 1).is_err());
        assert!(read("o.npy", &rows[..rows.len() - 1], 2).is_err());
    }

    #[test]
    fn numbers_that_are_no_offsets_are_refused() {
        let of = |kind: &str, data: &[u8]| {
            let head = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': (1, 3, 2), }}");
            read("o.npy", &array(&head, data), 1)
        };
        assert_eq!(of("<i8", &[0; 48]).unwrap(), [0; 6]);
        assert!(of("<i8", &[255; 48]).unwrap() == [-1; 6]);
        assert!(of("<i8", &[127; 48]).unwrap_err().to_string().contains("32 bits"));
        assert!(of("<f8", &[0; 48]).unwrap_err().to_string().contains("reals"));
    }
}
