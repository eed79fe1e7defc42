//! Sizes at points: a text table or a `.npy` array of rows `x y size` or `x y z size`. In a text table, fields are
//! separated by whitespace, commas or semicolons, and comments begin with `#` or `%`. If a header row names `x`, `y`,
//! optionally `z`, and `size`, the names select the columns.

use std::path::Path;

use super::error::{InputError, Place};
use super::format::Format;
use super::header::Header;
use super::load::{self, Packing};
use super::npy;
use super::points::ReadProgress;
use super::size_row::push;
use super::text::{Line, Lines, NUMBER, Source, number};
use septet_core::mesh::field::SizeField;

/// Reads sizes at points from a file, or from standard input if `path` is `-`. Decompresses gzip.
///
/// # Errors
/// Returns [`InputError`] if the file is missing or damaged, the number of columns varies, a number is not finite, or a
/// size is not positive.
pub fn read_sizes(path: &Path, progress: &mut ReadProgress<'_>) -> Result<SizeField, InputError> {
    let format = Format::of_path(path);
    let data = load::load(path, Packing::of(path), progress)?;
    let source = Source { path, data: &data };
    if format == Some(Format::Npy) || data.starts_with(b"\x93NUMPY") {
        return npy::read_sizes(source);
    }
    match format {
        None | Some(Format::Text) => columns(source),
        Some(other) => {
            let what = format!("a .{} file of sizes", other.name());
            Err(source.unsupported(Place::Whole, what, "give rows of `x y z size`: .txt, .csv or .npy"))
        }
    }
}

fn columns(source: Source<'_>) -> Result<SizeField, InputError> {
    let mut field = SizeField::default();
    let mut headed = false;
    // The positions of the named columns, and the width of the header row.
    let mut by_name: Option<(Vec<usize>, usize)> = None;
    for line in Lines::new(source.data) {
        let end = line.text.iter().position(|b| matches!(b, b'#' | b'%')).unwrap_or(line.text.len());
        let mut words = split(&line.text[..end]);
        if words.is_empty() {
            continue;
        }
        let named = |w: &&[u8]| w.first().is_some_and(|b| b.is_ascii_alphabetic() || *b == b'"');
        if field.rows.is_empty() && !headed && words.iter().all(|w| named(w) && number(w).is_none()) {
            let separated_by_blanks = !line.text[..end].contains(&b',') && !line.text[..end].contains(&b';');
            headed = true;
            let header = Header::of(line.number, &words, separated_by_blanks);
            by_name = header.sizes().map(|positions| (positions, header.width()));
            continue;
        }
        if let Some((positions, width)) = &by_name {
            if words.len() != *width {
                return Err(source.bad_line(&line, "the columns of the header row"));
            }
            words = positions.iter().map(|&i| words[i]).collect();
        }
        if field.rows.is_empty() {
            field.dimension = match words.len() {
                3 => 2,
                4 => 3,
                _ => return Err(source.bad_line(&line, "three or four numbers: `x y size` or `x y z size`")),
            };
        }
        row(source, &mut field, &line, &words)?;
    }
    if field.rows.is_empty() {
        return Err(source.truncated(Place::Whole, "rows of sizes", 1, 0));
    }
    Ok(field)
}

fn row(
    source: Source<'_>,
    field: &mut SizeField,
    line: &Line<'_>,
    words: &[&[u8]],
) -> Result<(), InputError> {
    let width = field.dimension + 1;
    if words.len() != width {
        return Err(source.bad_line(line, format!("{width} numbers, as in the first row")));
    }
    let mut numbers = [0.0; 4];
    for (slot, word) in numbers.iter_mut().zip(words) {
        *slot = number(word).ok_or_else(|| source.bad_word(line, word, NUMBER))?;
    }
    push(field, &numbers[..width], |at, expected| source.bad_word(line, words[at], expected))
}

/// Splits a line at semicolons if it has any, otherwise at commas if it has any, otherwise at whitespace.
fn split(text: &[u8]) -> Vec<&[u8]> {
    if text.trim_ascii().is_empty() {
        return Vec::new();
    }
    let by =
        |mark: u8| text.contains(&mark).then(|| text.split(|b| *b == mark).map(<[u8]>::trim_ascii).collect());
    by(b';').or_else(|| by(b',')).unwrap_or_else(|| Line { number: 0, text }.words().collect())
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
        assert!(read("f.vtu", b"<VTKFile/>").unwrap_err().to_string().contains(".vtu"));
    }
}
