//! Sizes at points: a text table or a `.npy` array of rows `x y size` or `x y z size`, or a mesh with sizes at its points.

use std::path::Path;

use super::error::{InputError, Place};
use super::formats::{described, of_content, reader};
use super::load::{self, Packing};
use super::points::ReadProgress;
use super::size_rows;
use super::text::Source;
use crate::format::{Format, Role};
use septet_core::mesh::field::SizeField;

/// Reads sizes at points from a file, or from standard input if `path` is `-`. Decompresses gzip.
///
/// # Errors
/// Returns [`InputError`] if the file is missing or damaged, the number of columns varies, a number is not finite, or a
/// size is not positive.
pub fn read_sizes(path: &Path, progress: &mut ReadProgress<'_>) -> Result<SizeField, InputError> {
    let data = load::load(path, Packing::of(path), progress)?;
    let source = Source { path, data: &data };
    let content = of_content(&data).filter(|format| format.has(Role::Sizes));
    let Some(format) = content.or_else(|| Format::of_path(path)) else { return size_rows::read(source) };
    if let Some(read) = reader(format).sizes {
        return read(source);
    }
    let what = format!("{} of sizes", described(format));
    let known = Role::Sizes.extensions(|_| true);
    Err(source.unsupported(Place::Whole, what, format!("give rows of `x y z size` as one of {known}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(name: &str, content: &[u8]) -> Result<SizeField, InputError> {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join(name);
        std::fs::write(&path, content).unwrap();
        read_sizes(&path, &mut |_, _| {})
    }

    #[test]
    fn rows_of_all_kinds() {
        let expected = [([1.0, 2.0, 3.0], 0.5), ([-4.0, 0.0, 1e3], 0.25)];
        for text in [
            "1 2 3 0.5\n-4 0 1e3 0.25\n",
            "# sizes\nx,y,z,size\n1,2,3,0.5\n\n-4,-0.0,1e3,0.25 # here\n",
            "1;2; 3; .5\r\n-4\t;0;1000;0.25",
            "id,Size [m],z,y,x\n7,0.5,3,2,1\n8,.25,1000,0,-4\n",
        ] {
            for name in ["f.txt", "f.csv", "f"] {
                let field = read(name, text.as_bytes()).unwrap();
                assert_eq!((field.dimension, &field.rows[..]), (3, &expected[..]));
            }
        }
        let plane = read("f.txt", b"1 2 3\n").unwrap();
        assert_eq!((plane.dimension, &plane.rows[..]), (2, &[([1.0, 2.0, 0.0], 3.0)][..]));
    }

    #[test]
    fn arrays() {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        let head = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }\n";
        bytes.extend((head.len() as u16).to_le_bytes());
        bytes.extend(head.as_bytes());
        let start = bytes.len();
        for x in [1.0f64, 2.0, 0.5, 3.0, 4.0, 0.25] {
            bytes.extend(x.to_le_bytes());
        }
        let field = read("f.npy", &bytes).unwrap();
        assert_eq!(field.rows, [([1.0, 2.0, 0.0], 0.5), ([3.0, 4.0, 0.0], 0.25)]);
        bytes[start + 40..start + 48].copy_from_slice(&(-1.0f64).to_le_bytes());
        let error = read("f.npy", &bytes).unwrap_err();
        assert_eq!(error.place(), Place::Byte(start as u64 + 40));
        assert!(error.to_string().contains("positive"), "{error}");
        let wide = head.replace("(2, 3)", "(1, 6)");
        bytes.splice(10..10 + head.len(), wide.bytes());
        assert!(read("f.npy", &bytes).unwrap_err().to_string().contains('6'));
    }

    #[test]
    fn faults_name_their_lines() {
        for (text, line, words) in [
            ("1 2\n", 1, "three or four numbers"),
            ("1 2 3 4\n1 2 3\n", 2, "4 numbers"),
            ("1 2 3 4\n\n1 2 x 4\n", 3, "a number"),
            ("1 2 3 0\n", 1, "positive"),
            ("1 2 3 -1\n", 1, "positive"),
            ("1 2 3 nan\n", 1, "positive"),
            ("1 inf 3 1\n", 1, "finite"),
            ("x y z size\na b c d\n", 2, "a number"),
            ("size x y\n1 2\n", 2, "columns of the header row"),
        ] {
            let error = read("f.txt", text.as_bytes()).unwrap_err();
            assert_eq!(error.line(), Some(line), "{error}");
            assert!(error.to_string().contains(words), "{error}");
        }
        assert!(read("f.txt", b"# nothing\n").unwrap_err().to_string().contains("rows of sizes"));
        assert!(read("f.vtk", b"# vtk DataFile").unwrap_err().to_string().contains(".vtk"));
    }
}
