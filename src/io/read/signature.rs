//! Signatures: formats that are recognised by the first bytes of a file.

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
    announced(data).is_some_and(|count| HEAD as u64 + FACET as u64 * count == data.len() as u64)
}

/// Returns `true` if the word is `OFF` with any of the prefixes `ST`, `C`, `N`, `4`, `n`.
pub(super) fn is_keyword(word: &[u8]) -> bool {
    let prefix = word.strip_suffix(b"OFF");
    prefix.is_some_and(|p| {
        p.len() <= 6 && p.iter().all(|b| matches!(b, b'S' | b'T' | b'C' | b'N' | b'4' | b'n'))
    })
}

/// The number of rows of a node file that are compared with its header.
const CHECKED_ROWS: usize = 16;

/// Returns `true` if the data is a node file of Triangle or TetGen: a header with the number of points, the dimension,
/// and the numbers of attributes and of boundary markers, then rows of that many numbers with consecutive indices from
/// 0 or 1. A table that fits this description by chance has its own number of rows as its first value.
pub(super) fn is_node(data: &[u8]) -> bool {
    let lines = data.split(|&b| b == b'\n').map(<[u8]>::trim_ascii);
    let mut lines = lines.filter(|line| !line.is_empty() && !line.starts_with(b"#"));
    let header: Option<Vec<usize>> = lines.next().and_then(numbers);
    let Some(&[points, dimension @ (2 | 3), attributes, markers @ (0 | 1)]) = header.as_deref() else {
        return false;
    };
    let width = 1 + dimension + attributes + markers;
    let rows: Vec<Vec<f64>> = lines.take(CHECKED_ROWS.min(points)).map_while(numbers).collect();
    let first = rows.first().map_or(-1.0, |row| row[0]);
    rows.len() == CHECKED_ROWS.min(points)
        && (first == 0.0 || first == 1.0)
        && rows.iter().zip(0u32..).all(|(row, at)| row.len() == width && row[0] == first + f64::from(at))
}

/// Returns the numbers of a line, or `None` if a word is not a number. A comment ends the line.
fn numbers<T: std::str::FromStr>(line: &[u8]) -> Option<Vec<T>> {
    let line = std::str::from_utf8(line.split(|&b| b == b'#').next()?).ok()?;
    line.split_ascii_whitespace().map(|word| word.parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn node_files_are_recognised_by_their_header_and_indices() {
        for text in [
            "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n",
            "# points\n\n3 2 1 1 # header\n 1 0 0 7.5 1\n 2 1 0 7.5 0\n 3 0 1 7.5 1\n# end\n",
        ] {
            assert!(is_node(text.as_bytes()), "{text}");
        }
        for text in [
            "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n",
            "3 2 0 0\n0 0 0\n2 1 0\n3 0 1\n",
            "3 2 0 0\n0 0 0 5\n1 1 0 5\n2 0 1 5\n",
            "3 2 0\n0 0 0\n1 1 0\n2 0 1\n",
            "0.5 3 0 0\n0 0 0 0\n",
            "0 3 0 0\n",
            "",
        ] {
            assert!(!is_node(text.as_bytes()), "{text}");
        }
    }
}
