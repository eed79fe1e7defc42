//! Lines, words and numbers of text files, and errors with their locations.

mod reasons;

use std::path::Path;

use super::error::{InputError, Place};

pub(super) use reasons::expected;

/// The bytes of a file, and its path.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub path: &'a Path,
    pub data: &'a [u8],
}

/// A line of text without its line ending.
#[derive(Clone, Copy)]
pub(super) struct Line<'a> {
    /// The 1-based line number.
    pub number: u64,
    pub text: &'a [u8],
}

impl<'a> Line<'a> {
    pub fn place(&self) -> Place {
        Place::Line(self.number)
    }

    /// Returns the words, which are separated by whitespace.
    pub fn words(&self) -> Words<'a> {
        Words { rest: self.text }
    }

    /// Returns the first word in lower case, or an empty string.
    pub fn keyword(&self) -> String {
        let word = self.words().next().unwrap_or_default();
        String::from_utf8_lossy(word).to_ascii_lowercase()
    }
}

/// The words of a line.
#[derive(Clone)]
pub(super) struct Words<'a> {
    rest: &'a [u8],
}

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        // Iterators without counters, because the checks of counters for overflow take most of the time.
        let mut bytes = self.rest.iter();
        while bytes.as_slice().first().is_some_and(|b| is_blank(*b)) {
            bytes.next();
        }
        let from = bytes.as_slice();
        while bytes.as_slice().first().is_some_and(|b| !is_blank(*b)) {
            bytes.next();
        }
        self.rest = bytes.as_slice();
        let word = &from[..from.len() - self.rest.len()];
        (!word.is_empty()).then_some(word)
    }
}

/// Returns `true` for whitespace within a line.
pub(super) fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\x0b' | b'\x0c')
}

/// The lines of a text file. A line ends in a line feed, a carriage return or both. A byte order mark is skipped.
#[derive(Clone)]
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    number: u64,
}

impl<'a> Lines<'a> {
    pub fn new(data: &'a [u8]) -> Self {
        let rest = data.strip_prefix(b"\xef\xbb\xbf").unwrap_or(data);
        Lines { rest, number: 0 }
    }

    /// Creates the lines of a part of a file with `number` lines before it.
    pub fn after(data: &'a [u8], number: u64) -> Self {
        Lines { rest: data, number }
    }

    /// Returns the number of the last line read.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// Returns the bytes that were not read yet.
    pub fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// Returns the next line that is not blank after removal of a `#` comment.
    pub fn next_data(&mut self) -> Option<Line<'a>> {
        loop {
            let mut line = self.next()?;
            if line.text.contains(&b'#') {
                line.text = line.text.split(|b| *b == b'#').next().unwrap_or_default();
            }
            if line.text.iter().any(|b| !is_blank(*b)) {
                return Some(line);
            }
        }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        if self.rest.is_empty() {
            return None;
        }
        let (text, rest) = self.rest.split_at(line_length(self.rest));
        self.rest = match rest {
            [b'\r', b'\n', rest @ ..] | [b'\r' | b'\n', rest @ ..] | rest => rest,
        };
        self.number += 1;
        Some(Line { number: self.number, text })
    }
}

/// Returns the number of bytes before the end of the first line. Blocks without an end are passed whole.
fn line_length(data: &[u8]) -> usize {
    const BLOCK: usize = 16;
    let is_end = |b: &u8| matches!(b, b'\n' | b'\r');
    let (blocks, _) = data.as_chunks::<BLOCK>();
    // No branch per byte, so that a block is compared at once.
    let has_end = |block: &&[u8; BLOCK]| block.iter().fold(false, |found, b| found | is_end(b));
    let passed = BLOCK * blocks.iter().take_while(|block| !has_end(block)).count();
    let rest = &data[passed..];
    passed + rest.iter().position(is_end).unwrap_or(rest.len())
}

/// Returns the number of line feeds.
pub(super) fn line_feeds(data: &[u8]) -> u64 {
    data.split(|b| *b == b'\n').count() as u64 - 1
}

/// Parses a real number with exact rounding: `1`, `-.5`, `1e-3`, `nan` or `inf`, but not `1,5`.
pub(super) fn number(word: &[u8]) -> Option<f64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Parses an integer.
pub(super) fn integer(word: &[u8]) -> Option<i64> {
    // So few digits do not overflow.
    const SHORT: usize = 18;
    if !word.is_empty() && word.len() <= SHORT && word.iter().all(u8::is_ascii_digit) {
        let digits = word.iter().map(|digit| i64::from(digit.wrapping_sub(b'0')));
        return Some(digits.fold(0_i64, |value, digit| value.wrapping_mul(10).wrapping_add(digit)));
    }
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Removes the double or single quotes around a field.
pub(super) fn unquoted(field: &[u8]) -> &[u8] {
    match field {
        [b'"', inner @ .., b'"'] | [b'\'', inner @ .., b'\''] => inner.trim_ascii(),
        _ => field,
    }
}

/// Shortens text for a message and replaces control characters.
pub(super) fn excerpt(text: &[u8]) -> String {
    const LONGEST: usize = 60;
    let short = &text[..text.len().min(LONGEST)];
    let mut shown: String =
        String::from_utf8_lossy(short).chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    if text.len() > LONGEST {
        shown.push('…');
    }
    shown
}

impl Source<'_> {
    /// Returns a syntax error for a line.
    pub fn bad_line(&self, line: &Line<'_>, expected: impl Into<String>) -> InputError {
        InputError::Syntax {
            path: self.path.to_owned(),
            line: line.number,
            column: None,
            text: excerpt(line.text.trim_ascii()).into(),
            expected: expected.into().into(),
            row: None,
            columns: None,
        }
    }

    /// Returns a syntax error for a word, which must be a slice of the line.
    pub fn bad_word(&self, line: &Line<'_>, word: &[u8], expected: impl Into<String>) -> InputError {
        let offset = (word.as_ptr() as usize).wrapping_sub(line.text.as_ptr() as usize);
        InputError::Syntax {
            path: self.path.to_owned(),
            line: line.number,
            column: (offset <= line.text.len()).then(|| u32::try_from(offset + 1).ok()).flatten(),
            text: excerpt(word).into(),
            expected: expected.into().into(),
            row: None,
            columns: None,
        }
    }

    /// Returns the syntax error for a word that is no number, with the reason. The word must be a slice of the line.
    pub fn bad_number(&self, line: &Line<'_>, word: &[u8]) -> InputError {
        self.bad_word(line, word, expected(word))
    }

    pub fn truncated(&self, place: Place, what: &'static str, expected: u64, found: u64) -> InputError {
        InputError::Truncated { path: self.path.to_owned(), place, expected, found, what }
    }

    pub fn surplus(&self, place: Place, what: &'static str, expected: u64) -> InputError {
        InputError::Count { path: self.path.to_owned(), place, expected, what }
    }

    pub fn unsupported(
        &self,
        place: Place,
        what: impl Into<String>,
        advice: impl Into<String>,
    ) -> InputError {
        let (path, what, advice) = (self.path.to_owned(), what.into(), advice.into());
        InputError::Unsupported { path, place, what, advice }
    }

    pub fn malformed(&self, offset: usize, found: impl Into<String>, expected: &'static str) -> InputError {
        let offset = offset as u64;
        InputError::Malformed { path: self.path.to_owned(), offset, found: found.into(), expected }
    }

    /// Returns the number of the line that contains a byte.
    pub fn line_at(&self, offset: usize) -> u64 {
        let before = &self.data[..offset.min(self.data.len())];
        line_feeds(before) + 1
    }

    /// Returns a syntax error for text at a byte offset.
    pub fn bad_at(&self, offset: usize, text: impl Into<String>, expected: &str) -> InputError {
        InputError::Syntax {
            path: self.path.to_owned(),
            line: self.line_at(offset),
            column: None,
            text: text.into().into_boxed_str(),
            expected: expected.into(),
            row: None,
            columns: None,
        }
    }

    /// Parses a count.
    pub fn count(&self, line: &Line<'_>, word: Option<&[u8]>, what: &str) -> Result<u64, InputError> {
        let word = word.ok_or_else(|| self.bad_line(line, what))?;
        integer(word).and_then(|n| u64::try_from(n).ok()).ok_or_else(|| self.bad_word(line, word, what))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_at_any_byte() {
        for length in 0..70 {
            for end in ["\n", "\r", "\r\n"] {
                let text = format!("{0}{end}{end}7 {0}{end}8", "a".repeat(length));
                let found: Vec<&[u8]> = Lines::new(text.as_bytes()).map(|line| line.text).collect();
                let wanted: Vec<&[u8]> = text.split(end).map(str::as_bytes).collect();
                assert_eq!(found, wanted, "{length} {end:?}");
            }
        }
    }

    #[test]
    fn integers_are_those_of_rust() {
        let long = "9223372036854775807,9223372036854775808,-9223372036854775808,1000000000000000000";
        let words = "0,-0,+7,007,,-,1.,1 ,12a,/,:,999999999999999999,0000000000000000000042,\u{661}";
        for word in words.split(',').chain(long.split(',')) {
            assert_eq!(integer(word.as_bytes()), word.parse().ok(), "{word}");
        }
        assert_eq!(integer(b"\xff"), None);
    }

    #[test]
    fn words_and_comments_are_divided() {
        let words = |text: &'static str| -> Vec<&[u8]> {
            Lines::new(text.as_bytes()).next_data().map_or_else(Vec::new, |line| line.words().collect())
        };
        assert_eq!(words("  1\t2 \x0b\x0c3 "), [b"1", b"2", b"3"]);
        assert_eq!(words(" \t\n\n#1\n 4#5 # 6"), [b"4"]);
        assert_eq!(words("  \x0b \n#"), Vec::<&[u8]>::new());
    }
}
