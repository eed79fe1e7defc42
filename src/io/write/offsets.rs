//! Offsets of the vertices of periodic triangulations, as `.npy` arrays.

use std::io::{self, Write};
use std::path::Path;

use super::error::OutputError;
use super::formats::npy;
use super::stage::{self, Stage};
use crate::format::{Format, Role};

/// Checks that offsets can be written under this path, before any other work.
///
/// # Errors
/// Returns an [`OutputError`] if the extension is not that of a format that holds offsets, or if the file cannot be written.
pub fn check_offsets_output(path: &Path) -> Result<(), OutputError> {
    let is_known = Format::of_path(path).is_some_and(|format| format.has(Role::Offsets));
    if is_known { stage::probe(path) } else { Err(OutputError::unknown(path, Role::Offsets)) }
}

/// Writes offsets: an array of shape (cells, `space` + 1, `space`) of type `<i1`, or `<i4` if a number needs it. The vertices
/// are in the order of the cells. The write is atomic.
///
/// # Errors
/// Returns an [`OutputError`] if writing fails. An existing file then remains unchanged.
pub fn write_offsets(path: &Path, offsets: &[i32], space: usize) -> Result<(), OutputError> {
    let mut stage = Stage::default();
    stage.write(path, |out| Ok(write(out, offsets, space)?))?;
    stage.commit().map(|_| ())
}

fn write(out: &mut dyn Write, offsets: &[i32], space: usize) -> io::Result<()> {
    let cells = offsets.len() / (space * (space + 1));
    let shape = format!("({cells}, {}, {space})", space + 1);
    let small: Option<Vec<i8>> = offsets.iter().map(|&steps| i8::try_from(steps).ok()).collect();
    if let Some(small) = small {
        npy::write_head(out, "|i1", &shape)?;
        return small.iter().try_for_each(|steps| out.write_all(&steps.to_le_bytes()));
    }
    npy::write_head(out, "<i4", &shape)?;
    offsets.iter().try_for_each(|steps| out.write_all(&steps.to_le_bytes()))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn offsets_take_one_byte_if_they_fit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("o.npy");
        for (offsets, kind, bytes) in [
            (vec![0, 1, -1, 2, 0, -128], "|i1", 1),
            (vec![0, 1, -1, 2, 0, 128], "<i4", 4),
            (vec![], "|i1", 1),
        ] {
            write_offsets(&path, &offsets, 2).unwrap();
            let content = fs::read(&path).unwrap();
            let (head, data) = content.split_at(content.len() - bytes * offsets.len());
            let shape = format!(
                "{{'descr': '{kind}', 'fortran_order': False, 'shape': ({}, 3, 2), }}",
                offsets.len() / 6
            );
            assert!(head[10..].starts_with(shape.as_bytes()));
            let first = data.chunks(bytes.max(1)).map(|number| number[0] as i8).collect::<Vec<i8>>();
            assert_eq!(first, offsets.iter().map(|&steps| steps as i8).collect::<Vec<i8>>());
        }
        let error = check_offsets_output(&folder.path().join("o.vtu")).unwrap_err();
        assert!(
            error.exit_code() as u8 == 2 && error.remedy().unwrap().to_string().contains(".npy"),
            "{error}"
        );
    }
}
