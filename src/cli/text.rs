//! Human-readable text: plurals, sizes, durations and printable names.

use std::fmt::Write;
use std::path::Path;

use septet_io::read::ListedFile;

/// Formats a number with a noun in the singular or plural, such as `1 cell` and `2 cells`.
pub fn counted(number: impl TryInto<u64>, noun: &str) -> String {
    let number = number.try_into().unwrap_or(u64::MAX);
    if number == 1 { format!("1 {noun}") } else { format!("{} {}", grouped(number), plural(noun)) }
}

fn plural(noun: &str) -> String {
    match noun.rsplit_once(' ') {
        Some((adjective, noun)) => format!("{adjective} {}", plural(noun)),
        None => match noun {
            "tetrahedron" => "tetrahedra".to_owned(),
            "4-simplex" | "5-simplex" | "6-simplex" => noun.replace("simplex", "simplices"),
            "vertex" => "vertices".to_owned(),
            "query" => "queries".to_owned(),
            "circumcentre" => "circumcentres".to_owned(),
            _ => format!("{noun}s"),
        },
    }
}

/// Returns the noun for a cell in a space of 2 to 6 dimensions.
pub fn cell_noun(space: usize) -> &'static str {
    match space {
        2 => "triangle",
        3 => "tetrahedron",
        4 => "4-simplex",
        5 => "5-simplex",
        _ => "6-simplex",
    }
}

/// Formats a number with a comma between groups of three digits.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// Formats a number of bytes with three significant digits, such as `34.2 MB`.
pub fn bytes(number: u64) -> String {
    const UNITS: [&str; 5] = ["kB", "MB", "GB", "TB", "PB"];
    if number < 1000 {
        return counted(number, "byte");
    }
    let mut value = number as f64 / 1e3;
    let mut unit = 0;
    while value >= 999.5 && unit + 1 < UNITS.len() {
        (value, unit) = (value / 1e3, unit + 1);
    }
    let digits = if value < 9.995 { 2 } else { usize::from(value < 99.95) };
    format!("{value:.digits$} {}", UNITS[unit])
}

/// Formats a duration with as many digits as are significant.
pub fn seconds(seconds: f64) -> String {
    match seconds {
        s if s < 0.1 => format!("{:.1} ms", s * 1e3),
        s if s < 100.0 => format!("{s:.2} s"),
        s => format!("{} min {:02} s", (s / 60.0) as u64, (s % 60.0) as u64),
    }
}

/// Maximum length of a word in a message, in characters. Corrupt files can contain longer words.
const LONGEST_WORD: usize = 200;

/// Shortens words that are too long for a message.
fn shortened(text: &str) -> String {
    let short = |word: &str| match word.char_indices().nth(LONGEST_WORD) {
        Some((end, _)) => format!("{}...{}", &word[..end], &word[word.trim_end().len()..]),
        None => word.to_string(),
    };
    text.split_inclusive(char::is_whitespace).map(short).collect()
}

/// Escapes control characters, which could change the state of a terminal, and shortens long words. Line breaks and
/// tabs are kept.
pub fn printable(text: &str) -> String {
    let text = shortened(text);
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() && !matches!(c, '\n' | '\t') {
            let _ = write!(out, "{}", c.escape_default());
        } else {
            out.push(c);
        }
    }
    out
}

/// Returns a path with all control characters escaped, including line breaks.
pub fn name(path: &Path) -> String {
    printable(&path.display().to_string()).replace('\n', "\\n").replace('\t', "\\t")
}

/// Returns the names that are nearest to a mistyped one, the nearest first.
pub fn nearest<'a>(typed: &str, names: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let mut all: Vec<(usize, &str)> = names.into_iter().map(|name| (distance(typed, name), name)).collect();
    all.sort_by_key(|&(distance, _)| distance);
    all.into_iter().map(|(_, name)| name).collect()
}

/// Returns the name that is nearest to a mistyped one, if at most a third of its letters differ.
pub fn near<'a>(typed: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let first = nearest(typed, names).into_iter().next();
    first.filter(|name| 3 * distance(typed, name) <= name.chars().count())
}

/// Returns a clause such as `the nearest is uniform; `, or an empty string if no name is near the mistyped one.
pub fn suggestion<'a>(typed: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    near(typed, names).map_or_else(String::new, |name| format!("the nearest is {name}; "))
}

/// Returns the edit distance of two words: the number of insertions, deletions, replacements and swaps of adjacent
/// letters.
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            if i == 0 || j == 0 {
                rows[i][j] = i + j;
                continue;
            }
            let replaced = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            rows[i][j] = replaced.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                rows[i][j] = rows[i][j].min(rows[i - 2][j - 2] + 1);
            }
        }
    }
    rows[a.len()][b.len()]
}

/// Returns a clause with the file of a row of a list, and with the row in this file.
pub fn place_of(files: &[ListedFile], row: u64) -> Option<String> {
    let file = ListedFile::of_row(files, row)?;
    Some(format!("; point {row} is row {} of {}", row - file.first_row, file.path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nouns_agree_with_their_numbers() {
        assert_eq!(counted(7u64, cell_noun(4)), "7 4-simplices");
        assert_eq!(counted(1u64, "tetrahedron"), "1 tetrahedron");
        assert_eq!(counted(0u64, "worker"), "0 workers");
        assert_eq!(counted(12_345usize, "tetrahedron"), "12,345 tetrahedra");
        assert_eq!(counted(2u32, "hull facet"), "2 hull facets");
    }

    #[test]
    fn sizes_have_three_digits() {
        let all = [1, 999, 1000, 34_250_000, 999_600, 12_345_678_901].map(bytes);
        assert_eq!(all, ["1 byte", "999 bytes", "1.00 kB", "34.2 MB", "1.00 MB", "12.3 GB"]);
        assert_eq!([0.012, 2.7, 125.0].map(seconds), ["12.0 ms", "2.70 s", "2 min 05 s"]);
    }

    #[test]
    fn control_characters_are_escaped() {
        assert_eq!(printable("a\x1b[31mb\tc\n"), "a\\u{1b}[31mb\tc\n");
        assert_eq!(name(Path::new("a\nb\x07")), "a\\nb\\u{7}");
    }

    #[test]
    fn only_a_near_name_is_suggested() {
        let names = ["uniform", "ball", "vtu"];
        for (typed, expected) in [
            ("unifrm", "the nearest is uniform; "),
            ("unfirom", "the nearest is uniform; "),
            ("bal", "the nearest is ball; "),
            ("vut", "the nearest is vtu; "),
            ("foo", ""),
        ] {
            assert_eq!(suggestion(typed, names), expected);
        }
    }

    #[test]
    fn the_nearest_name_comes_first() {
        assert_eq!(nearest("triangluate", ["simulate", "rival", "triangulate"])[0], "triangulate");
        assert_eq!(distance("mehs", "mesh"), 1);
    }
}
