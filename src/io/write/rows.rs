//! Lists of rows of the input: text with a number on each line, or a `.npy` array.

use std::io::{self, Write};
use std::path::Path;

use super::error::{OutputError, WriteFault};
use super::formats::npy;
use super::stage::{self, Stage};
use crate::format::{Format, Role};

/// Checks that a list of rows can be written under this path, before any other work. `-` is always accepted.
///
/// # Errors
/// Returns an [`OutputError`] if the extension is that of a format that holds no list of rows, or if the file cannot be written.
pub fn check_rows_output(path: &Path) -> Result<(), OutputError> {
    format_of(path)?;
    if path.as_os_str() == "-" { Ok(()) } else { stage::probe(path) }
}

/// Writes numbers of rows to a file: a `.npy` array `<u8` of shape (n,), or text with a number on each line. If the name ends in
/// `.gz`, the content is compressed. The write is atomic, except that a device or pipe receives the bytes directly.
///
/// # Errors
/// Returns an [`OutputError`] if writing fails. An existing file then remains unchanged.
pub fn write_rows(path: &Path, rows: &[u64]) -> Result<(), OutputError> {
    let format = format_of(path)?;
    let mut stage = Stage::default();
    stage.write(path, |out| Ok(write(out, format, rows)?))?;
    stage.commit().map(|_| ())
}

/// Writes numbers of rows to a stream as text, a number on each line.
///
/// # Errors
/// Returns [`OutputError::Stream`] if writing to the stream fails.
pub fn write_rows_to(out: &mut dyn Write, rows: &[u64]) -> Result<(), OutputError> {
    let written = write(out, Format::Xyz, rows).and_then(|()| out.flush());
    written.map_err(|source| WriteFault::of_stream(source.into()))
}

/// Returns the format of a list of rows. Names that no format has are those of text.
fn format_of(path: &Path) -> Result<Format, OutputError> {
    match Format::of_path(path) {
        Some(format) if !format.has(Role::RowList) => Err(OutputError::unknown(path, Role::RowList)),
        format => Ok(format.unwrap_or(Format::Xyz)),
    }
}

fn write(out: &mut dyn Write, format: Format, rows: &[u64]) -> io::Result<()> {
    if format == Format::Npy {
        return npy::write_rows(out, rows);
    }
    rows.iter().try_for_each(|row| writeln!(out, "{row}"))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn rows_are_text_or_an_array() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["a.txt", "a.csv", "a", "a.rows"] {
            write_rows(&at(name), &[3, 17]).unwrap();
            assert_eq!(fs::read_to_string(at(name)).unwrap(), "3\n17\n");
        }
        for rows in [&[][..], &[3, u64::MAX]] {
            write_rows(&at("a.npy"), rows).unwrap();
            let bytes = fs::read(at("a.npy")).unwrap();
            let (head, data) = bytes.split_at(bytes.len() - 8 * rows.len());
            let shape = format!("{{'descr': '<u8', 'fortran_order': False, 'shape': ({},), }}", rows.len());
            assert!(head.len().is_multiple_of(64) && head[10..].starts_with(shape.as_bytes()));
            assert_eq!(data, rows.iter().flat_map(|row| row.to_le_bytes()).collect::<Vec<u8>>());
        }
        let error = check_rows_output(&at("a.vtu")).unwrap_err();
        assert_eq!(error.exit_code() as u8, 2);
        assert!(error.remedy().unwrap().to_string().contains(".npy"), "{error}");
        check_rows_output(Path::new("-")).unwrap();
        let mut text = Vec::new();
        write_rows_to(&mut text, &[5]).unwrap();
        assert_eq!(text, b"5\n");
    }
}
