//! Rows of sizes in text. Fields are separated by whitespace, commas or semicolons, and comments begin with `#` or `%`. If a
//! header row names `x`, `y`, optionally `z`, and `size`, the names select the columns.

use super::error::{InputError, Place};
use super::header::Header;
use super::text::{Line, Lines, Source, number};
use septet_core::mesh::field::SizeField;

/// The description of a valid size in messages.
const SIZE: &str = "a size: a positive number";

/// Adds a row of coordinates and a size. `blame` creates the error for an invalid number, from its column and the
/// requirement.
pub(super) fn push(
    field: &mut SizeField,
    row: &[f64],
    blame: impl Fn(usize, &'static str) -> InputError,
) -> Result<(), InputError> {
    let (at, size) = (&row[..field.dimension], row[field.dimension]);
    if let Some(bad) = at.iter().position(|c| !c.is_finite()) {
        return Err(blame(bad, "a finite coordinate"));
    }
    if !(size > 0.0 && size.is_finite()) {
        return Err(blame(field.dimension, SIZE));
    }
    let mut point = [0.0; 3];
    // Adding zero converts -0.0 to 0.0.
    point.iter_mut().zip(at).for_each(|(slot, c)| *slot = c + 0.0);
    field.rows.push((point, size));
    Ok(())
}

/// Reads the rows of a text.
pub(super) fn read(source: Source<'_>) -> Result<SizeField, InputError> {
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
        *slot = number(word).ok_or_else(|| source.bad_number(line, word))?;
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
