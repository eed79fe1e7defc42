//! Reasons why a word is no number, which the errors of readers of text give.

use super::number;

/// A kind of word that is no number, and what is expected instead.
type Reason = (fn(&[u8]) -> bool, &'static str);

/// The kinds. The first one that applies is given.
const REASONS: [Reason; 10] = [
    (|word| word.is_empty(), "a number (the field is empty)"),
    (
        |word| word.contains(&0),
        "text in UTF-8 (this looks like UTF-16 without a mark: save the file as UTF-8)",
    ),
    (
        is_fortran_exponent,
        "an exponent with E, as in 1.5E+03 (this is a Fortran exponent: replace the D by E)",
    ),
    (
        is_decimal_comma,
        "a number with a decimal point (decimal commas and thousands separators are read only between semicolons)",
    ),
    (
        |word| word.iter().all(|b| *b == b'*'),
        "a number (asterisks stand for a number that was too wide to print)",
    ),
    (is_missing, "a number (this word stands for a missing value)"),
    (is_angle, "decimal degrees, as in 47.25 (degrees, minutes and seconds are not supported)"),
    (is_date, "a number (dates and times are not coordinates)"),
    (has_unit, "a number without a unit (put the unit into the name of the column)"),
    (|_| true, "a number, as in 1.5 or -2e-3"),
];

/// Returns what is expected instead of a word that is no number.
pub(in super::super) fn expected(word: &[u8]) -> &'static str {
    REASONS.iter().find(|(holds, _)| holds(word)).map_or("a number", |(_, text)| text)
}

/// Whether the word is a number of Fortran: `1.5D+03`.
fn is_fortran_exponent(word: &[u8]) -> bool {
    let at = word.iter().position(|b| matches!(b, b'd' | b'D' | b'q' | b'Q'));
    at.is_some_and(|at| {
        number(&word[..at]).is_some()
            && word.len() > at + 1
            && number(&word[at + 1..]).is_some_and(f64::is_finite)
    })
}

/// Whether the word is a number with commas: `1,5`, `1.234,5` or `1,234.5`.
fn is_decimal_comma(word: &[u8]) -> bool {
    let mut words = word.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    // The comma separated the fields.
    let is_cut = words.clone().nth(1).is_some() && words.all(|word| number(word).is_some());
    is_cut
        || word.contains(&b',')
            && word.iter().any(u8::is_ascii_digit)
            && word.iter().all(|b| b.is_ascii_digit() || matches!(b, b',' | b'.' | b'-' | b'+' | b'e' | b'E'))
}

fn is_missing(word: &[u8]) -> bool {
    const WORDS: [&str; 10] = ["na", "n/a", "#n/a", "null", "none", "missing", "-", "--", ".", "?"];
    WORDS.iter().any(|missing| word.eq_ignore_ascii_case(missing.as_bytes()))
}

/// Whether the word begins as an angle in degrees.
fn is_angle(word: &[u8]) -> bool {
    let text = String::from_utf8_lossy(word);
    let is_mark = |c: char| matches!(c, '°' | 'º' | '′' | '″' | '\'' | '"');
    text.starts_with(|c: char| c.is_ascii_digit() || c == '-') && text.contains(is_mark)
}

/// Whether the word is a date or a time: `2024-05-01` or `12:30`.
fn is_date(word: &[u8]) -> bool {
    let has = |mark: u8, times: usize| word.split(|b| *b == mark).count() > times;
    word.first().is_some_and(u8::is_ascii_digit) && (has(b':', 1) || has(b'-', 2) || has(b'/', 2))
}

/// Whether the word is a number and a unit: `1.5m`.
fn has_unit(word: &[u8]) -> bool {
    let at = word.iter().rposition(|b| b.is_ascii_digit() || *b == b'.');
    at.is_some_and(|at| at + 1 < word.len() && number(&word[..=at]).is_some())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_has_its_own_text() {
        for (word, part) in [
            ("", "empty"),
            ("0.5118D+00", "Fortran"),
            ("1.5d3", "Fortran"),
            ("0,5118", "decimal comma"),
            ("1.234,5", "decimal comma"),
            ("5 2", "decimal comma"),
            ("****", "too wide"),
            ("NA", "missing value"),
            ("--", "missing value"),
            ("47°15'", "decimal degrees"),
            ("2024-05-01", "dates"),
            ("12:30", "dates"),
            ("1.5m", "unit"),
            ("5x", "unit"),
            ("1\0", "UTF-16"),
            ("oops", "1.5"),
            ("#1", "1.5"),
        ] {
            assert!(expected(word.as_bytes()).contains(part), "{word}: {}", expected(word.as_bytes()));
        }
    }
}
