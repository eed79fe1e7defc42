//! The words for a file in the place of a command: the commands that use such a file, with its name.

use std::path::{Path, PathBuf};

use septet_io::read::FileList;
use septet_io::{Format, Role, extension, without_gz};

use super::text::name;

/// A command for a file, and the reason to choose it.
struct Use {
    line: String,
    purpose: &'static str,
}

/// Returns the message for a word in the place of a command, if the word names a file or a sample.
pub fn message(typed: &str) -> Option<String> {
    let uses = uses(typed)?;
    let is_sample = typed.starts_with("sample:");
    let what = if is_sample { "a sample" } else { "a file" };
    let mut text =
        format!("error: {} is {what}, and a command must come before it\n", name(Path::new(typed)));
    let width = uses.iter().map(|use_| use_.line.chars().count()).max().unwrap_or(0);
    for (at, Use { line, purpose }) in uses.iter().enumerate() {
        let label = if at == 0 { "help: " } else { "      " };
        let line = if uses.len() == 1 { line.clone() } else { format!("{line:<width$}   {purpose}") };
        text.extend([label, line.as_str(), "\n"]);
    }
    Some(text)
}

/// Returns the commands that use a file, or `None` if the word names no file.
fn uses(typed: &str) -> Option<Vec<Use>> {
    let path = Path::new(typed);
    let word = quoted(typed);
    let output = if without_gz(path).0 == Path::new("mesh.vtu") { "out.vtu" } else { "mesh.vtu" };
    let triangulate = |purpose| Use { line: format!("septet triangulate {word} -o {output}"), purpose };
    if typed.starts_with("sample:") || FileList::is_named_by(typed) {
        return Some(vec![triangulate("triangulate the points")]);
    }
    let format = Format::of_path(path);
    if !path.is_file() && format.is_none() {
        return None;
    }
    let Some(format) = format else {
        return Some(of_other(path, &word, triangulate("triangulate its points")));
    };
    let mesh =
        || Use { line: format!("septet mesh {word} -o {output}"), purpose: "mesh the inside of the surface" };
    let verify = |line| Use { line, purpose: "check its cells" };
    let both = |first, second| Some(vec![first, second]);
    match (format.has(Role::Points), format.has(Role::Domain)) {
        // Most of these files are scans.
        (true, true) if format == Format::Ply => both(triangulate("triangulate its points"), mesh()),
        (true, true) => both(mesh(), triangulate("triangulate its points")),
        (false, true) => Some(vec![mesh()]),
        (true, false) if format.holds_mesh() => {
            both(verify(format!("septet verify {word}")), triangulate("triangulate its points"))
        }
        (true, false) => Some(vec![triangulate("triangulate its points")]),
        (false, false) if format.holds_mesh() => Some(vec![verify(format!("septet verify {word}"))]),
        (false, false) => {
            let (points, cells) = set_of(path);
            Some(vec![verify(format!("septet verify {points} {cells}"))])
        }
    }
}

/// Returns the commands that use a file without an extension of points, cells or domains.
fn of_other(path: &Path, word: &str, triangulate: Use) -> Vec<Use> {
    let report = || Use { line: format!("septet report {word} -o page.html"), purpose: "draw its figures" };
    match extension(path).as_str() {
        "json" => vec![report()],
        "jsonl" => {
            vec![
                Use { line: format!("septet fit {word}"), purpose: "fit growth laws to its counts" },
                report(),
            ]
        }
        _ => vec![triangulate],
    }
}

/// Returns the files of points and cells of the set of a file of cells. A `.node` file that does not exist is a placeholder.
fn set_of(path: &Path) -> (String, String) {
    let (plain, is_packed) = without_gz(path);
    let with = |extension: &str| -> PathBuf {
        plain.with_extension(if is_packed { format!("{extension}.gz") } else { extension.to_owned() })
    };
    let (points, cells) = (with("node"), with("ele"));
    let points = if points.is_file() { quoted(&points.display().to_string()) } else { "POINTS".to_owned() };
    (points, quoted(&cells.display().to_string()))
}

/// Quotes a word for the shell, if it needs that. Control characters are escaped.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "._/,:=@%+-".contains(c);
    let shown = name(Path::new(word));
    if shown.chars().all(is_plain) { shown } else { format!("'{}'", shown.replace('\'', "'\\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(typed: &str) -> Vec<String> {
        uses(typed).unwrap_or_default().into_iter().map(|use_| use_.line).collect()
    }

    #[test]
    fn the_use_of_a_file_follows_its_format() {
        for (typed, expected) in [
            ("points.csv", &["septet triangulate points.csv -o mesh.vtu"][..]),
            ("a b.npy", &["septet triangulate 'a b.npy' -o mesh.vtu"]),
            ("it's.las", &["septet triangulate 'it'\\''s.las' -o mesh.vtu"]),
            ("part-*.npy", &["septet triangulate 'part-*.npy' -o mesh.vtu"]),
            ("sample:uniform:9", &["septet triangulate sample:uniform:9 -o mesh.vtu"]),
            ("part.poly", &["septet mesh part.poly -o mesh.vtu"]),
            ("a.stl.gz", &["septet mesh a.stl.gz -o mesh.vtu", "septet triangulate a.stl.gz -o mesh.vtu"]),
            ("a.ply", &["septet triangulate a.ply -o mesh.vtu", "septet mesh a.ply -o mesh.vtu"]),
            ("mesh.vtu", &["septet verify mesh.vtu", "septet triangulate mesh.vtu -o out.vtu"]),
            ("m.pvtu", &["septet verify m.pvtu"]),
            ("m.1.neigh", &["septet verify POINTS m.1.ele"]),
            ("triangluate", &[]),
            ("none.json", &[]),
        ] {
            assert_eq!(lines(typed), expected, "{typed}");
        }
        assert_eq!(message("report"), None);
    }
}
