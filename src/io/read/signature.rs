//! What the first bytes of a file tell of its format.

/// Bytes before the first facet of a binary file, and bytes of a facet.
pub(super) const HEAD: usize = 84;
pub(super) const FACET: usize = 50;

/// Facets a binary file announces.
pub(super) fn announced(data: &[u8]) -> Option<u64> {
    let count = data.get(80..HEAD)?;
    Some(u64::from(u32::from_le_bytes([count[0], count[1], count[2], count[3]])))
}

/// Is the size just right for a binary file? That is the only reliable sign: binary files, too, may
/// begin with `solid`.
pub(super) fn is_binary(data: &[u8]) -> bool {
    announced(data).is_some_and(|count| HEAD as u64 + FACET as u64 * count == data.len() as u64)
}

/// Is the word `OFF` with any of the prefixes `ST`, `C`, `N`, `4`, `n`?
pub(super) fn is_keyword(word: &[u8]) -> bool {
    let prefix = word.strip_suffix(b"OFF");
    prefix.is_some_and(|p| {
        p.len() <= 6 && p.iter().all(|b| matches!(b, b'S' | b'T' | b'C' | b'N' | b'4' | b'n'))
    })
}
