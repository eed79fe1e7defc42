//! The golden files: a line `case NAME` and the case's lines, in the order of the cases.

use std::collections::HashSet;
use std::fs;
use std::path::PathBuf;

use crate::record::Record;

/// Differing lines of a case that are printed.
const MOST_LINES: usize = 12;

/// Both files.
pub struct Store {
    outputs: File,
    counts: File,
}

/// One file: what it is called, and the lines of each case.
struct File {
    name: &'static str,
    cases: Vec<(String, Vec<String>)>,
}

impl File {
    fn path(name: &str) -> PathBuf {
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name)
    }

    /// Reads a file; one that is missing is empty if it is to be written.
    fn open(name: &'static str, write: bool) -> Result<File, String> {
        let text = match fs::read_to_string(File::path(name)) {
            Ok(text) => text,
            Err(_) if write => String::new(),
            Err(error) => {
                let path = File::path(name);
                return Err(format!("{}: {error}: SEPTET_GOLDEN=write writes it", path.display()));
            }
        };
        let mut file = File { name, cases: Vec::new() };
        for line in text.lines() {
            match (line.strip_prefix("case "), file.cases.last_mut()) {
                (Some(case), _) => file.cases.push((case.to_owned(), Vec::new())),
                (None, Some((_, lines))) => lines.push(line.to_owned()),
                (None, None) => return Err(format!("{name}: a line before the first case")),
            }
        }
        Ok(file)
    }

    fn of(&self, case: &str) -> &[String] {
        self.cases.iter().find(|(name, _)| name == case).map_or(&[], |(_, lines)| lines)
    }

    fn replace(&mut self, case: &str, lines: &[String]) {
        match self.cases.iter_mut().find(|(name, _)| name == case) {
            Some((_, old)) => *old = lines.to_vec(),
            None => self.cases.push((case.to_owned(), lines.to_vec())),
        }
    }

    /// The lines of a case that differ, by run and by section or output: `-` is golden, `+` was found.
    fn differences(&self, case: &str, found: &[String]) -> Vec<String> {
        let golden = self.of(case);
        if golden == found {
            return Vec::new();
        }
        let only = |sign: char, lines: &[String], others: &[String]| -> Vec<String> {
            let others: HashSet<&String> = others.iter().collect();
            let lines = lines.iter().filter(|line| !others.contains(line));
            lines.map(|line| format!("{} {sign} {line}", self.name)).collect()
        };
        let mut all = only('-', golden, found);
        all.extend(only('+', found, golden));
        if all.is_empty() {
            all.push(format!("{}: the lines of {case} are in another order", self.name));
        }
        // The two lines of a run and section follow each other.
        all.sort_by_cached_key(|line| line.split(' ').skip(2).take(2).collect::<Vec<_>>().join(" "));
        all
    }

    fn close(&self) -> Result<(), String> {
        let mut text = String::new();
        for (case, lines) in &self.cases {
            text.extend(["case ", case, "\n"]);
            for line in lines {
                text.push_str(line);
                text.push('\n');
            }
        }
        let path = File::path(self.name);
        fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))
    }
}

impl Store {
    /// Reads both files.
    pub fn open(write: bool) -> Result<Store, String> {
        Ok(Store { outputs: File::open("outputs.txt", write)?, counts: File::open("counts.txt", write)? })
    }

    /// Where a case differs: the first lines of both files, and the number of the others.
    pub fn differences(&self, case: &str, record: &Record) -> Vec<String> {
        let outputs = self.outputs.differences(case, &record.outputs);
        let mut all: Vec<String> =
            outputs.into_iter().chain(self.counts.differences(case, &record.counts)).collect();
        if let Some(others) = all.len().checked_sub(MOST_LINES).filter(|&others| others > 0) {
            all.truncate(MOST_LINES);
            all.push(format!("and {others} lines more"));
        }
        all
    }

    /// Takes over the lines of a case.
    pub fn replace(&mut self, case: &str, record: &Record) {
        self.outputs.replace(case, &record.outputs);
        self.counts.replace(case, &record.counts);
    }

    /// Returns the names in the files that are not cases. If the files are written, these are removed and the others are
    /// sorted.
    pub fn retain(&mut self, names: &[&str], write: bool) -> Vec<String> {
        let mut unknown = Vec::new();
        for file in [&mut self.outputs, &mut self.counts] {
            let position = |case: &str| names.iter().position(|&name| name == case);
            if write {
                file.cases.retain(|(case, _)| position(case).is_some());
                file.cases.sort_by_key(|(case, _)| position(case));
            } else {
                let gone = file.cases.iter().filter(|(case, _)| position(case).is_none());
                unknown.extend(gone.map(|(case, _)| format!("{}: {case}", file.name)));
            }
        }
        unknown
    }

    /// Writes both files if that was asked for.
    pub fn close(&self, write: bool) -> Result<(), String> {
        if write {
            self.outputs.close()?;
            self.counts.close()?;
        }
        Ok(())
    }
}

/// Writes the text whose hashes are in the golden files to a file of its own, and returns its path.
pub fn explain(case: &str, record: &Record) -> Result<PathBuf, String> {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("golden");
    let path = folder.join(format!("{case}.txt"));
    let written = fs::create_dir_all(&folder).and_then(|()| fs::write(&path, &record.text));
    written.map(|()| path.clone()).map_err(|error| format!("{}: {error}", path.display()))
}
