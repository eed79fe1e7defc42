//! An excerpt of a text file around a defect, printed below an error.

use std::io::BufRead;
use std::path::Path;

use super::gzip;
use super::progress::Talk;
use super::text::name;

/// Maximum number of characters printed of a line.
const SHOWN: usize = 120;

/// A line with a defect, with the line before and after it.
#[derive(Debug)]
pub struct Excerpt {
    /// The file.
    name: String,
    /// 1-based number of the line with the defect.
    line: usize,
    /// The printed lines, with their numbers.
    lines: Vec<(usize, String)>,
    /// 0-based position of the defect in its line, in characters.
    start: usize,
    /// Length of the defect, in characters.
    length: usize,
}

impl Excerpt {
    /// Reads the lines around the 1-based line number `line`. Returns `None` if the file or the line does not exist.
    pub fn of(path: &Path, line: u64, column: Option<u64>) -> Option<Self> {
        if path.as_os_str() == "-" {
            return None;
        }
        let reader = gzip::open(path).ok()?;
        let line = usize::try_from(line).ok().filter(|&line| line > 0)?;
        let first = line.saturating_sub(1).max(1);
        let raw = reader.split(b'\n').skip(first - 1).map_while(Result::ok);
        let lines: Vec<_> = (first..=line + 1).zip(raw.map(|raw| shown(&raw))).collect();
        let text = &lines.iter().find(|(number, _)| *number == line)?.1;
        let (start, length) = fault(text, column);
        Some(Excerpt { name: name(path), line, start, length, lines })
    }

    /// Formats the lines with their numbers, and marks the defect below its line.
    pub fn draw(&self, talk: &Talk) -> String {
        let last = self.lines.last().map_or(self.line, |(number, _)| *number);
        let width = last.to_string().len();
        let blank = " ".repeat(width + 2);
        let place = format!("{}:{}:{}", self.name, self.line, self.start + 1);
        let mut rows = vec![format!("{blank}╭─[{}]", talk.paint(&place, "36;1;4"))];
        for (number, line) in &self.lines {
            rows.push(format!(" {} │ {line}", talk.paint(&format!("{number:>width$}"), "2")));
            if *number == self.line {
                let marks = self.marks();
                rows.extend(marks.map(|mark| format!("{blank}· {}", talk.paint(&mark, "35;1"))));
            }
        }
        rows.push(format!("{blank}╰────"));
        rows.join("\n")
    }

    /// Returns the two lines that mark the defect.
    fn marks(&self) -> [String; 2] {
        let middle = self.length / 2;
        let indent = " ".repeat(self.start);
        let under = match self.length {
            0 => "▲".to_owned(),
            length => format!("{}┬{}", "─".repeat(middle), "─".repeat(length - middle - 1)),
        };
        [format!("{indent}{under}"), format!("{indent}{}╰── here", " ".repeat(middle))]
    }
}

/// Returns the beginning of a line, with control characters replaced by spaces.
fn shown(raw: &[u8]) -> String {
    let text = String::from_utf8_lossy(raw);
    let clean = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    clean.take(SHOWN).collect::<String>().trim_end().to_owned()
}

/// Returns the start and length, in characters, of the word at a column, or of the whole line. The column is a 1-based
/// byte position.
fn fault(line: &str, column: Option<u64>) -> (usize, usize) {
    let within = column.map_or(0, |c| c.saturating_sub(1) as usize).min(line.len());
    let within = (0..=within).rev().find(|&i| line.is_char_boundary(i)).unwrap_or(0);
    let rest = &line[within..];
    let word = rest.find([' ', '\t', ',', ';']).filter(|&end| column.is_some() && end > 0);
    let length = rest[..word.unwrap_or(rest.len())].chars().count();
    (line[..within].chars().count(), length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_is_a_word_or_a_line() {
        assert_eq!(fault("1 foo 2", Some(3)), (2, 3));
        assert_eq!(fault("1 bär;2", Some(3)), (2, 3));
        assert_eq!(fault("ä foo", Some(4)), (2, 3));
        assert_eq!(fault("1 2", None), (0, 3));
        assert_eq!(fault("1 2", Some(99)), (3, 0));
        assert_eq!(fault("", None), (0, 0));
    }

    #[test]
    fn the_lines_around_a_fault_are_kept() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.xyz");
        std::fs::write(&path, "1 2\n3\tx  \r\n5 6\n7 8\n").unwrap();
        let lines = |line| Excerpt::of(&path, line, None).map(|e| e.lines);
        let line = |number, text: &str| (number, text.to_owned());
        assert_eq!(lines(1), Some(vec![line(1, "1 2"), line(2, "3 x")]));
        assert_eq!(lines(2), Some(vec![line(1, "1 2"), line(2, "3 x"), line(3, "5 6")]));
        assert_eq!(lines(4), Some(vec![line(3, "5 6"), line(4, "7 8")]));
        assert_eq!(lines(5), None);
        assert_eq!(lines(0), None);
        assert!(Excerpt::of(Path::new("-"), 1, None).is_none());
    }
}
