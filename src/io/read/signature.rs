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
