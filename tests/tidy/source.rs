//! The sources of a crate: its modules, and which module imports which.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Folders that are not searched: outputs of builds, downloads, vendored code.
const SKIPPED: [&str; 4] = ["target", "node_modules", "data", "three"];

/// The root of the repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All Rust files below a folder, as paths from the root of the repository, with their texts.
pub fn files(under: &str) -> Vec<(String, String)> {
    let found = files_of(under, &["rs"]);
    assert!(!found.is_empty(), "no Rust file is below {under}");
    found
}

/// All files with one of these extensions below a folder, except vendored files.
pub fn files_of(under: &str, extensions: &[&str]) -> Vec<(String, String)> {
    let mut paths = Vec::new();
    collect(&root().join(under), extensions, &mut paths);
    paths.sort();
    let read = |path: PathBuf| {
        let name = path.strip_prefix(root()).unwrap().to_string_lossy().into_owned();
        (name, fs::read_to_string(&path).unwrap())
    };
    paths.into_iter().map(read).collect()
}

fn collect(directory: &Path, extensions: &[&str], found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let skipped = name.starts_with('.') || SKIPPED.contains(&name.as_str());
        if path.is_dir() && !skipped {
            collect(&path, extensions, found);
        } else if path.extension().is_some_and(|e| extensions.iter().any(|extension| e == *extension)) {
            found.push(path);
        }
    }
}

/// Whether a file holds tests only.
pub fn is_test(name: &str) -> bool {
    name.ends_with("/tests.rs") || name.contains("/tests/")
}

/// A text without comments and without items that are compiled for tests only.
pub fn code(text: &str) -> String {
    let mut kept = Vec::new();
    let mut lines = text.lines().map(without_comment);
    while let Some(line) = lines.next() {
        if line.trim() == "#[cfg(test)]" {
            let indent = &line[..line.len() - line.trim_start().len()];
            skip_item(&mut lines, &format!("{indent}}}"));
        } else {
            kept.push(line);
        }
    }
    kept.join("\n")
}

/// A line up to its comment; a slash pair within a string begins none.
fn without_comment(line: &str) -> &str {
    let comment = line.match_indices("//").find(|(at, _)| line[..*at].matches('"').count().is_multiple_of(2));
    comment.map_or(line, |(at, _)| line[..at].trim_end())
}

/// Passes over an item: up to its semicolon, or to the brace that closes it.
fn skip_item<'a>(lines: &mut impl Iterator<Item = &'a str>, close: &str) {
    let mut opened = false;
    for line in lines {
        let one_line = !opened && (line.ends_with(';') || line.ends_with('}'));
        if one_line || line == close {
            return;
        }
        opened |= line.ends_with('{') && !line.contains("use ");
    }
}

/// A module of a crate by its path, such as `neighbours::query`; the crate's root has the empty path.
pub type Module = String;

/// Rooms of the machine that every room may import.
pub const COMMON: [&str; 3] = ["config", "machine", "state"];

/// The room of a module: its first folder or file below the root.
pub fn room(module: &str) -> String {
    module.split("::").next().unwrap_or("").to_string()
}

/// The modules of a crate and their imports.
pub struct Crate {
    /// Files by module.
    pub files: BTreeMap<Module, (String, String)>,
}

impl Crate {
    /// The crate whose root file lies in this folder; folders of other crates below it are left out.
    pub fn read(folder: &str) -> Self {
        let mut modules = BTreeMap::new();
        let others = nested_crates(folder);
        for (name, text) in files(folder) {
            let inside = name[folder.len() + 1..].to_string();
            if is_test(&name) || inside == "main.rs" || others.iter().any(|o| inside.starts_with(o)) {
                continue;
            }
            let path = inside.trim_end_matches(".rs").trim_end_matches("/mod").replace('/', "::");
            let path = if path == "lib" || path == "mod" { String::new() } else { path };
            modules.insert(path, (name, code(&text)));
        }
        Crate { files: modules }
    }

    /// A crate of these modules and texts.
    pub fn of(files: &[(&str, &str)]) -> Self {
        let file =
            |(module, text): &(&str, &str)| (module.to_string(), (module.to_string(), text.to_string()));
        Crate { files: files.iter().map(file).collect() }
    }

    /// The modules that each module imports, itself left out.
    pub fn imports(&self) -> BTreeMap<Module, BTreeSet<Module>> {
        let of = |module: &Module| {
            let mut found = BTreeSet::new();
            for path in self.paths(module) {
                found.extend(self.resolve(&path, 0));
            }
            found.remove(module);
            (module.clone(), found)
        };
        self.files.keys().map(of).collect()
    }

    /// All paths in a module that lead to modules of this crate, from its root.
    fn paths(&self, module: &Module) -> Vec<Vec<String>> {
        let text = &self.files[module].1;
        let names = self.names(module);
        let mut found = Vec::new();
        for (start, word) in heads(text) {
            let tails = tree(&text[start + word.len() + 2..]);
            if let Some(base) = self.base(module, word).or_else(|| names.get(word).cloned()) {
                found.extend(tails.into_iter().map(|tail| extend(&base, &tail.path)));
            }
        }
        found
    }

    /// Where a path that begins with this word begins, by the rules of the language.
    fn base(&self, module: &Module, word: &str) -> Option<Vec<String>> {
        let here = segments(module);
        match word {
            "crate" => Some(Vec::new()),
            "self" => Some(here),
            "super" => Some(here[..here.len().saturating_sub(1)].to_vec()),
            child => self.files.contains_key(&join(&here, child)).then(|| segments(&join(&here, child))),
        }
    }

    /// The modules that a module imports by name, as `graph` in `use crate::graph`.
    fn names(&self, module: &Module) -> BTreeMap<String, Vec<String>> {
        let uses = self.uses(module).into_iter();
        uses.filter(|used| self.files.contains_key(&used.path.join("::")))
            .map(|used| (used.name, used.path))
            .collect()
    }

    /// The module that a path leads to: through re-exports to where the item is.
    fn resolve(&self, path: &[String], depth: usize) -> Option<Module> {
        let longest = (0..=path.len()).rev().find(|&n| self.files.contains_key(&path[..n].join("::")))?;
        let module = path[..longest].join("::");
        let Some(item) = path.get(longest).filter(|_| depth < 4) else { return Some(module) };
        match self.uses(&module).into_iter().find(|export| export.name == *item) {
            Some(target) => self.resolve(&extend(&target.path, &path[longest + 1..]), depth + 1),
            None => Some(module),
        }
    }

    /// What the `use` declarations of a module make known to it, to its children and, if public, to others:
    /// names with paths from the crate's root.
    fn uses(&self, module: &Module) -> Vec<Used> {
        let text = &self.files[module].1;
        let mut found = Vec::new();
        for (at, _) in text.match_indices("use ") {
            let line = text[..at].rsplit('\n').next().unwrap_or("").trim_start();
            if !(line.is_empty() || line.starts_with("pub")) {
                continue;
            }
            for used in tree(&text[at + 4..]) {
                let Some(base) = used.path.first().and_then(|first| self.base(module, first)) else {
                    continue;
                };
                found.push(Used { path: extend(&base, &used.path[1..]), ..used });
            }
        }
        found
    }
}

/// A name and the path that it stands for.
struct Used {
    path: Vec<String>,
    name: String,
}

/// A path continued, where `super` leads back and `self` nowhere.
fn extend(base: &[String], tail: &[String]) -> Vec<String> {
    let mut path = base.to_vec();
    for step in tail {
        match step.as_str() {
            "super" => drop(path.pop()),
            "self" => {}
            step => path.push(step.to_string()),
        }
    }
    path
}

/// Folders of crates below a crate's own, with a slash.
fn nested_crates(folder: &str) -> Vec<String> {
    let base = root().join(folder);
    let mut found = Vec::new();
    for entry in fs::read_dir(&base).unwrap() {
        let path = entry.unwrap().path();
        if path.join("Cargo.toml").exists() {
            found.push(format!("{}/", path.file_name().unwrap().to_string_lossy()));
        }
    }
    found
}

fn segments(module: &str) -> Vec<String> {
    module.split("::").filter(|s| !s.is_empty()).map(str::to_string).collect()
}

fn join(here: &[String], child: &str) -> String {
    here.iter().map(String::as_str).chain([child]).collect::<Vec<_>>().join("::")
}

/// The first words of all paths in a text, with their places.
fn heads(text: &str) -> Vec<(usize, &str)> {
    let mut found = Vec::new();
    for (at, _) in text.match_indices("::") {
        let word_start = text[..at].trim_end_matches(|c: char| c.is_alphanumeric() || c == '_').len();
        let before = &text[..word_start];
        // The path of a visibility imports nothing.
        if word_start < at && !before.ends_with("::") && !before.ends_with("(in ") {
            found.push((word_start, &text[word_start..at]));
        }
    }
    found
}

/// The paths of a use tree (or the one path) that a text begins with.
fn tree(text: &str) -> Vec<Used> {
    let mut rest = text;
    branches(&mut rest)
}

fn branches(rest: &mut &str) -> Vec<Used> {
    *rest = rest.trim_start();
    if let Some(inside) = rest.strip_prefix('{') {
        *rest = inside;
        return group(rest);
    }
    let word = take_word(rest);
    if word.is_empty() {
        // A glob, or the end of the path.
        *rest = rest.strip_prefix('*').unwrap_or(rest);
        return vec![Used { path: Vec::new(), name: String::new() }];
    }
    if let Some(after) = rest.strip_prefix("::") {
        *rest = after;
        let mut below = branches(rest);
        for used in &mut below {
            if used.path == ["self"] && used.name == "self" {
                used.name.clone_from(&word);
            }
            used.path.insert(0, word.clone());
        }
        return below;
    }
    let mut name = word.clone();
    if let Some(after) = rest.strip_prefix(" as ") {
        *rest = after;
        name = take_word(rest);
    }
    vec![Used { path: vec![word], name }]
}

/// The paths between braces, the first of which is passed.
fn group(rest: &mut &str) -> Vec<Used> {
    let mut found = Vec::new();
    loop {
        *rest = rest.trim_start();
        if let Some(after) = rest.strip_prefix('}') {
            *rest = after;
            return found;
        }
        if let Some(after) = rest.strip_prefix(',') {
            *rest = after;
            continue;
        }
        let before = rest.len();
        found.extend(branches(rest));
        if rest.len() == before {
            return found;
        }
    }
}

fn take_word(rest: &mut &str) -> String {
    let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
    let word = rest[..end].to_string();
    *rest = &rest[end..];
    word
}
