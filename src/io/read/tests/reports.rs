//! Small files, each with the points that its writer meant: `tests/reports/points` after public reports, and
//! `tests/reports/made` by programs (`tests/foreign/files_of_others.py`).

use std::path::{Path, PathBuf};

use fancy_regex::Regex;
use septet_core::model::Points;
use septet_core::remedy::Door;
use serde_json::Value;

use super::super::{InputError, PointFile, ReadOptions, read};

/// A table of cases, and the folder of their files.
struct Cases {
    folder: PathBuf,
    table: Value,
}

impl Cases {
    fn of(name: &str) -> Self {
        let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/reports")).join(name);
        let text = std::fs::read_to_string(folder.join("cases.json")).unwrap();
        Cases { folder, table: serde_json::from_str(&text).unwrap() }
    }

    /// Returns the fault of a case, if it has one.
    fn fault(&self, case: &Value) -> Option<String> {
        let ending = Path::new(text(case, "file")).extension();
        let is_scan = ending.is_some_and(|ending| ending == "las" || ending == "laz");
        if is_scan && cfg!(not(feature = "las")) {
            return None;
        }
        let options = options(case);
        let found = read(&self.folder.join(text(case, "file")), &options, &mut |_, _| {});
        let right = case["right"].as_array().unwrap();
        let is_right = |found: &PointFile| right.iter().any(|one| self.accepts(one, found));
        let error = match found {
            Ok(found) if is_right(&found) => return None,
            Ok(found) => return Some(format!("other points, with the notes {:?}", found.notes)),
            Err(error) => error,
        };
        let message = message(&error);
        let is_named = |one: &Value| {
            let pattern = one["refuse"].as_str();
            pattern.is_some_and(|pattern| Regex::new(pattern).unwrap().is_match(&message).unwrap())
        };
        if !matches!(error.exit_code() as u8, 2 | 3) || !right.iter().any(is_named) {
            return Some(format!("exit {}: {message}", error.exit_code() as u8));
        }
        let advised = advised(&message)?;
        let options = ReadOptions { columns: Some(advised.clone()), ..options };
        match read(&self.folder.join(text(case, "file")), &options, &mut |_, _| {}) {
            Ok(found) if is_right(&found) => None,
            Ok(_) => Some(format!("the advised columns {advised:?} have other points")),
            Err(error) => Some(format!("the advised columns {advised:?} are refused: {error}")),
        }
    }

    /// Whether an outcome consists of these points.
    fn accepts(&self, outcome: &Value, found: &PointFile) -> bool {
        let Some(set) = outcome["points"].as_str() else { return false };
        let wanted = self.table["sets"][set].as_array().unwrap();
        let row = |row: &Value| -> Vec<u64> {
            row.as_array().unwrap().iter().map(|c| c.as_f64().unwrap().to_bits()).collect()
        };
        let mut wanted: Vec<Vec<u64>> = wanted.iter().map(row).collect();
        let mut found = rows(&found.points);
        wanted.sort();
        found.sort();
        wanted == found
    }
}

fn text<'a>(case: &'a Value, key: &str) -> &'a str {
    case[key].as_str().unwrap_or_default()
}

fn rows(points: &Points) -> Vec<Vec<u64>> {
    let bits = |row: &[f64]| row.iter().map(|c| c.to_bits()).collect();
    points.coordinates().chunks_exact(points.dimension()).map(bits).collect()
}

/// Returns the options of the arguments of a case.
fn options(case: &Value) -> ReadOptions {
    let arguments: Vec<&str> = case["args"].as_array().unwrap().iter().map(|a| a.as_str().unwrap()).collect();
    let mut options = ReadOptions::default();
    for pair in arguments.chunks(2) {
        match *pair {
            ["-d", dimension] => options.dimension = dimension.parse().ok(),
            ["--columns", columns] => options.columns = Some(columns.split(',').map(str::to_owned).collect()),
            ref other => panic!("{other:?}"),
        }
    }
    options
}

/// Returns the message and the remedy in the words of the command line.
fn message(error: &InputError) -> String {
    let remedy = error.remedy().map_or_else(String::new, |remedy| remedy.spelled(Door::Shell));
    format!("{error}; help: {remedy}")
}

/// Returns the columns that a message advises.
fn advised(message: &str) -> Option<Vec<String>> {
    let (_, columns) = message.split_once("such as --columns ")?;
    Some(columns.split(',').map(str::to_owned).collect())
}

#[test]
fn files_of_reports_are_read_as_their_writers_meant() {
    all_are_right("points");
}

#[test]
fn files_of_programs_are_read_as_their_writers_meant() {
    all_are_right("made");
}

fn all_are_right(folder: &str) {
    let cases = Cases::of(folder);
    let all = cases.table["cases"].as_array().unwrap();
    let fault = |case: &Value| Some(format!("{}: {}", text(case, "name"), cases.fault(case)?));
    let faults: Vec<String> = all.iter().filter_map(fault).collect();
    assert!(faults.is_empty(), "{} of {} cases:\n{}", faults.len(), all.len(), faults.join("\n"));
}
