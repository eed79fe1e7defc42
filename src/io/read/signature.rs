//! Signatures: formats that are recognised by the first bytes or lines of a file.

use super::text::{Line, Lines, integer, number};

/// The number of bytes before the first facet of a binary STL file.
pub(super) const HEAD: usize = 84;
/// The number of bytes of a facet of a binary STL file.
pub(super) const FACET: usize = 50;

/// Returns the announced number of facets of a binary STL file.
pub(super) fn announced(data: &[u8]) -> Option<u64> {
    let count = data.get(80..HEAD)?;
    Some(u64::from(u32::from_le_bytes([count[0], count[1], count[2], count[3]])))
}

/// Returns `true` if the size fits a binary STL file with the announced number of facets. No other test is reliable,
/// because binary files may also begin with `solid`.
pub(super) fn is_binary(data: &[u8]) -> bool {
    begins_binary(data, data.len() as u64)
}

/// Returns `true` if a file of this size that begins with `data` is a binary STL file.
pub(super) fn begins_binary(data: &[u8], size: u64) -> bool {
    announced(data).is_some_and(|count| HEAD as u64 + FACET as u64 * count == size)
}

/// Returns the keyword at the beginning of an OFF file: `OFF` with any of the prefixes `ST`, `C`, `N`, `4`, `n`. Some
/// writers glue the first count to it.
pub(super) fn off_keyword(word: &[u8]) -> Option<&[u8]> {
    let end = word.windows(3).position(|w| w == b"OFF")?;
    let (prefix, count) = (&word[..end], &word[end + 3..]);
    let is_prefix =
        prefix.len() <= 6 && prefix.iter().all(|b| matches!(b, b'S' | b'T' | b'C' | b'N' | b'4' | b'n'));
    (is_prefix && count.iter().all(u8::is_ascii_digit)).then_some(&word[..end + 3])
}

/// Returns `true` if the first word of a text is the keyword of an OFF file.
pub(super) fn is_off(word: &[u8]) -> bool {
    off_keyword(word).is_some()
}

/// Returns `true` if the first lines are those of a `.node` file: a header, then rows of an id and as many numbers as
/// the header announces. Ids are consecutive and start at 0 or 1.
///
/// A line of fewer than four numbers may also be the first row of a table, or the header of a list of cells. It is a
/// header of points if it announces the exact number of rows, and a row has a number that is not an integer.
pub(super) fn is_node(data: &[u8]) -> bool {
    node(data).is_some_and(|is_sure| is_sure(data))
}

/// Returns `true` if the first lines are those of a `.node` file, of which only the number of rows may decide.
pub(super) fn may_be_node(data: &[u8]) -> bool {
    node(data).is_some()
}

/// Returns a test of the number of rows if the first lines are those of a `.node` file.
fn node(data: &[u8]) -> Option<impl Fn(&[u8]) -> bool> {
    const ROWS: i64 = 8;
    let mut lines = Lines::new(data);
    let header = header(lines.next_data()?, 2..=4)?;
    let field = |i: usize| header.get(i).copied().unwrap_or(0);
    let (points, dimension, attributes, marker) = (field(0), field(1), field(2), field(3));
    if points < 1 || !(2..=3).contains(&dimension) || attributes < 0 || !(0..=1).contains(&marker) {
        return None;
    }
    let width = attributes.saturating_add(1 + dimension + marker);
    let (mut rows, mut first_id, mut has_fraction) = (0, 0, false);
    while rows < points.min(ROWS)
        && let Some(line) = lines.next_data()
    {
        let id = line.words().next().and_then(integer).unwrap_or(-1);
        if rows == 0 {
            first_id = id;
        }
        let is_numeric = line.words().all(|word| number(word).is_some());
        if !matches!(first_id, 0 | 1)
            || id != first_id + rows
            || !is_numeric
            || line.words().count() as i64 != width
        {
            return None;
        }
        has_fraction |= line.words().any(|word| integer(word).is_none());
        rows += 1;
    }
    let (is_whole, lines) = (header.len() == 4, lines.number());
    let is_sure = move |data: &[u8]| {
        let mut rest = Lines::new(data);
        rest.by_ref().take(lines as usize).for_each(drop);
        rows + std::iter::from_fn(|| rest.next_data()).count() as i64 == points
    };
    ((is_whole && rows > 0) || has_fraction).then_some(move |data: &[u8]| is_whole || is_sure(data))
}

/// Returns the integers of a header line, or `None` if it has other words, or fewer or more than the limits.
fn header(line: Line<'_>, words: std::ops::RangeInclusive<usize>) -> Option<Vec<i64>> {
    let header = line.words().take(words.end() + 1).map(integer).collect::<Option<Vec<i64>>>()?;
    words.contains(&header.len()).then_some(header)
}

/// Returns `true` if the first lines are those of an `.ele` file: a header `cells corners [attributes]`, then rows of
/// an id and as many integers as the header announces. Ids are consecutive and start at 0 or 1. The header of a table
/// of points has other columns than its rows, so no table is taken for a list of cells.
pub(super) fn is_ele(data: &[u8]) -> bool {
    const ROWS: i64 = 8;
    let mut lines = Lines::new(data);
    let Some(header) = lines.next_data().and_then(|line| header(line, 2..=3)) else { return false };
    let (cells, corners, attributes) = (header[0], header[1], header.get(2).copied().unwrap_or(0));
    if cells < 1 || !matches!(corners, 3 | 4 | 6 | 10) || attributes < 0 {
        return false;
    }
    let width = attributes.saturating_add(1 + corners);
    let mut rows = (0..cells.min(ROWS)).map(|_| lines.next_data());
    let first = match rows.next().flatten() {
        Some(line) if is_cell(line, width) => line.words().next().and_then(integer),
        _ => return false,
    };
    let id = |line: Line<'_>| line.words().next().and_then(integer);
    matches!(first, Some(0 | 1))
        && rows
            .zip(1..)
            .all(|(line, i)| line.is_some_and(|l| is_cell(l, width) && id(l) == first.map(|f| f + i)))
}

/// Returns `true` if the content of a file named `.node` is that of an `.ele` file. Triangles have the header of points in
/// space, so the name decides.
pub(super) fn is_ele_despite_name(data: &[u8]) -> bool {
    let corners = Lines::new(data).next_data().and_then(|line| header(line, 2..=3)).map(|header| header[1]);
    corners.is_some_and(|corners| corners > 3) && is_ele(data)
}

/// Returns `true` if a line has this many integers and no other words, and its first two corners differ.
fn is_cell(line: Line<'_>, width: i64) -> bool {
    let differ = line.words().nth(1) != line.words().nth(2);
    differ && line.words().count() as i64 == width && line.words().all(|word| integer(word).is_some())
}

/// Returns `true` if the points of a `.node` file are followed by the header of a list of facets, as in a `.poly` file.
pub(super) fn is_poly(data: &[u8]) -> bool {
    let mut lines = Lines::new(data);
    let Some(points) = lines.next_data().and_then(|line| header(line, 2..=4)) else { return false };
    let is_header = points[0] >= 0 && matches!(points[1], 2 | 3);
    let after = usize::try_from(points[0]).unwrap_or(usize::MAX);
    let facets = std::iter::from_fn(|| lines.next_data()).nth(after).and_then(|line| header(line, 1..=2));
    is_header && facets.is_some_and(|f| f[0] >= 0 && matches!(f.get(1), None | Some(0 | 1)))
}
