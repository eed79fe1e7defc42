//! Runs as read from reports or from the lines of a sweep.

use serde_json::Value;

use septet_core::spec;
use septet_lab::report::mesh::MESH_SCHEMA;

use super::error::PageError;
use super::mesh::{MeshData, read as read_mesh};

/// A run.
#[derive(Clone, Debug)]
pub struct RunData {
    /// Name of the file, with the line number in a sweep.
    pub name: String,
    /// The JSON object.
    pub value: Value,
}

/// An entry of an input file.
#[derive(Clone, Debug)]
pub(super) enum Entry {
    /// A run.
    Run(RunData),
    /// A mesh.
    Mesh(Box<MeshData>),
}

/// Reads the runs and meshes of an input file. Its text is one JSON object or one object per line.
pub(super) fn read(name: &str, text: &str) -> Result<Vec<Entry>, PageError> {
    let whole = serde_json::from_str::<Value>(text);
    if let Ok(value) = whole {
        return Ok(vec![entry(name.to_owned(), name, 1, value)?]);
    }
    // In a sweep, the first line is a JSON object. If it is not, the error refers to the whole text as one object.
    let first = text.lines().find(|l| !l.trim().is_empty()).unwrap_or_default();
    if let (Err(error), Err(_)) = (&whole, serde_json::from_str::<Value>(first)) {
        return Err(PageError::Syntax { name: name.into(), line: error.line(), why: error.to_string() });
    }
    let mut runs = Vec::new();
    for (line, row) in (1..).zip(text.lines()).filter(|(_, row)| !row.trim().is_empty()) {
        let value = serde_json::from_str(row).map_err(|e| PageError::Syntax {
            name: name.to_owned(),
            line,
            why: e.to_string(),
        })?;
        runs.push(entry(format!("{name}:{line}"), name, line, value)?);
    }
    Ok(runs)
}

fn entry(full: String, name: &str, line: usize, value: Value) -> Result<Entry, PageError> {
    if value["schema"] == MESH_SCHEMA {
        let mesh = read_mesh(name, line, &value)?;
        return Ok(Entry::Mesh(Box::new(MeshData { name: full, ..mesh })));
    }
    run(full, name, line, value).map(Entry::Run)
}

fn run(full: String, name: &str, line: usize, value: Value) -> Result<RunData, PageError> {
    let whole = value["schema"] == septet_lab::report::SCHEMA;
    let other_mesh = text(&value["schema"]).starts_with("septet-mesh/");
    if other_mesh || !whole && !value["phases"].is_array() {
        return Err(PageError::NoRun { name: name.into(), line });
    }
    for field in ["points", "phases", "machine", "tree", "parameters"] {
        if whole && value.get(field).is_none() {
            return Err(PageError::Missing { name: name.into(), line, field });
        }
    }
    Ok(RunData { name: full, value })
}

/// Returns the text of a field, or an empty string if the field is missing.
pub(super) fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

/// Returns the number in a field, or 0 if the field is missing.
pub(super) fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(0.0)
}

impl RunData {
    /// Returns the number at a JSON pointer.
    pub(super) fn number(&self, pointer: &str) -> Option<f64> {
        self.value.pointer(pointer)?.as_f64()
    }

    /// Returns the rows at a JSON pointer.
    pub(super) fn rows(&self, pointer: &str) -> &[Value] {
        self.value.pointer(pointer).and_then(Value::as_array).map_or(&[], Vec::as_slice)
    }

    /// Returns `true` for a report, `false` for a line of a sweep.
    pub(super) fn is_whole(&self) -> bool {
        self.value["schema"] == septet_lab::report::SCHEMA && self.value["points"].is_object()
    }

    /// Returns whether the run proved stars without the hypothesis, as `triangulate` does.
    pub(super) fn is_direct(&self) -> bool {
        self.number("/how_proved/direct").is_some_and(|stars| stars > 0.0)
    }

    /// Returns the number of points.
    pub(super) fn n(&self) -> Option<f64> {
        self.number("/n").or_else(|| self.number("/points/used")).filter(|&n| n > 1.0)
    }

    /// Returns the number of coordinates.
    pub(super) fn space(&self) -> f64 {
        ["/space", "/d", "/dimension"].iter().find_map(|p| self.number(p)).unwrap_or(3.0)
    }

    /// Returns the number of workers.
    pub(super) fn workers(&self) -> Option<f64> {
        self.number("/machine/workers").or_else(|| self.number("/workers"))
    }

    /// Returns the kind of a generated set, or the name of a file.
    pub(super) fn kind(&self) -> String {
        let input = self.value.pointer("/parameters/input").or(self.value.get("input")).map_or("", text);
        let sample = input.strip_prefix("sample:").and_then(|s| s.split(':').next());
        self.value["kind"].as_str().or(sample).unwrap_or(input).to_owned()
    }

    /// Returns all options that differ from their defaults, except size, seed and number of workers. Runs with equal
    /// options are fitted together.
    pub(super) fn options(&self) -> Vec<String> {
        let word = |key: &str| {
            // A report contains the leaf size that was used, and whether it was chosen automatically.
            if key == "leaf" && self.value.pointer("/parameters/leaf_auto") == Some(&Value::Bool(true)) {
                return None;
            }
            let value = self.value.pointer(&format!("/parameters/{key}"));
            let value = value.or_else(|| self.value.pointer(&format!("/settings/{key}")))?;
            value.as_str().map(str::to_owned).or_else(|| value.as_f64().map(|x| x.to_string()))
        };
        spec::series_name(false, |row| word(row.key))
    }

    /// Returns the requested number of workers, or `leaves`.
    pub(super) fn asked_workers(&self) -> String {
        let asked =
            self.value.pointer("/parameters/workers").or_else(|| self.value.pointer("/settings/workers"));
        match asked.and_then(Value::as_str) {
            Some(word) => word.to_owned(),
            None => self.workers().map_or_else(String::new, |p| p.to_string()),
        }
    }

    /// Returns a quantity of the machine, or its sum over the phases.
    pub(super) fn total(&self, key: &str) -> Option<f64> {
        let sum = || {
            let parts: Vec<f64> = self.rows("/phases").iter().filter_map(|p| p[key].as_f64()).collect();
            (!parts.is_empty()).then(|| parts.iter().sum())
        };
        self.number(&format!("/machine/{key}")).or_else(sum)
    }

    /// Returns a quantity of a phase.
    pub(super) fn phase(&self, name: &str, key: &str) -> Option<f64> {
        self.rows("/phases").iter().find(|p| p["name"] == name)?[key].as_f64()
    }

    /// Returns the number of points whose balls cross the separator of the root.
    pub(super) fn root_separator(&self) -> Option<f64> {
        let root = self.rows("/nodes").iter().find(|n| n["id"] == 1);
        root.map(|n| number(&n["crossing_inside"]) + number(&n["crossing_outside"]))
            .or_else(|| self.number("/tree/by_level/0/separator_points"))
    }
}
