//! Rows of words of 64 bits: their order, and their bytes on the wire.

pub(super) use septet_core::cores::sort_rows;

/// Bytes per word.
const WORD: usize = 8;

/// Keeps the first of consecutive rows with the same first word.
pub(super) fn dedup_rows(words: &mut Vec<u64>, width: usize) {
    let mut end = 0;
    for row in (0..words.len()).step_by(width) {
        if end == 0 || words[end - width] != words[row] {
            words.copy_within(row..row + width, end);
            end += width;
        }
    }
    words.truncate(end);
}

/// Returns the position of the first word of the first row that is not less than another.
pub(super) fn first_not_less(words: &[u64], width: usize, other: &[u64]) -> usize {
    let (mut low, mut high) = (0, words.len() / width);
    while low < high {
        let middle = low.midpoint(high);
        if words[middle * width..][..width] < *other { low = middle + 1 } else { high = middle }
    }
    low * width
}

/// Returns the bytes of words, with room for the checksum that a wire appends.
pub(super) fn bytes_of(words: &[u64]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity((words.len() + 1) * WORD);
    append(&mut bytes, words.iter().copied());
    bytes
}

/// Appends the bytes of words.
pub(super) fn append(bytes: &mut Vec<u8>, words: impl IntoIterator<Item = u64>) {
    for word in words {
        bytes.extend_from_slice(&word.to_le_bytes());
    }
}

/// Returns the words of bytes. A remainder that is less than a word is ignored.
pub(super) fn words_of(bytes: &[u8]) -> impl Iterator<Item = u64> + '_ {
    bytes.as_chunks::<WORD>().0.iter().map(|word| u64::from_le_bytes(*word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_sorted_by_their_first_words() {
        for width in 3..=7 {
            let row = |first: u64| (0..width as u64).map(move |i| first + i);
            let mut words: Vec<u64> = [7, 2, 7, 0, 9, 2].into_iter().flat_map(row).collect();
            sort_rows(&mut words, width);
            dedup_rows(&mut words, width);
            let expected: Vec<u64> = [0, 2, 7, 9].into_iter().flat_map(row).collect();
            assert_eq!(words, expected);
            assert_eq!(words_of(&bytes_of(&words)).collect::<Vec<_>>(), words);
        }
        let mut none = Vec::new();
        dedup_rows(&mut none, 3);
        assert!(none.is_empty());
    }
}
