//! The golden files: a line `case NAME` and the case's lines, in the order of the cases.

use std::fs;
use std::path::PathBuf;

use crate::record::Record;

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

    /// Returns the first line that differs, with the line found.
    fn difference(&self, case: &str, found: &[String]) -> Option<String> {
        let golden = self.of(case);
        let at = (0..golden.len().max(found.len())).find(|&i| golden.get(i) != found.get(i))?;
        let differing = (0..golden.len().max(found.len())).filter(|&i| golden.get(i) != found.get(i)).count();
        let show = |lines: &[String]| lines.get(at).cloned().unwrap_or_else(|| "(no line)".to_owned());
        Some(format!(
            "{}, line {} of {case} ({differing} of {} lines differ)\n      golden: {}\n      found:  {}",
            self.name,
            at + 1,
            golden.len(),
            show(golden),
            show(found)
        ))
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

    /// Where a case differs: at most one place a file.
    pub fn differences(&self, case: &str, record: &Record) -> Vec<String> {
        let outputs = self.outputs.difference(case, &record.outputs);
        outputs.into_iter().chain(self.counts.difference(case, &record.counts)).collect()
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
