//! Texts of other programs that look like tables but are none.

use super::collect::Collector;
use super::error::{InputError, Place};
use super::points::{PointFile, ReadOptions};
use super::text::{Lines, Source, integer, number};

/// The number of lines in which such a text shows what it is.
const LINES: usize = 12;

/// Refuses a text that is known not to be a table of points.
pub(super) fn refuse(source: Source<'_>) -> Result<(), InputError> {
    let lines = || Lines::new(source.data).take(LINES);
    if source.data.starts_with(b"# .PCD") || lines().any(|line| line.keyword() == "data" && is_pcd(source)) {
        let advice = "convert the point cloud to .ply, or save it as text and delete its header";
        return Err(source.unsupported(Place::Line(1), "a point cloud of PCL (PCD)", advice));
    }
    if let Some(line) = lines().find(|line| is_tecplot(line.text)) {
        let advice = "export the points as .csv, or the mesh as .vtu with ParaView";
        return Err(source.unsupported(line.place(), "a file of Tecplot", advice));
    }
    if is_grid(source.data) {
        return Err(InputError::Grid { path: source.path.to_owned() });
    }
    Ok(())
}

fn is_pcd(source: Source<'_>) -> bool {
    let mut keywords = Lines::new(source.data).take(LINES).map(|line| line.keyword());
    keywords.any(|word| word == "viewpoint" || word == "fields")
}

/// Whether a line begins as `VARIABLES = "X"`, `TITLE = "a"` or `ZONE I=12`.
fn is_tecplot(line: &[u8]) -> bool {
    let line = String::from_utf8_lossy(line).trim().to_ascii_lowercase();
    let rest = |word: &str| line.strip_prefix(word).map(|rest| rest.trim_start().to_owned());
    let assigns = |word| rest(word).is_some_and(|rest| rest.starts_with('='));
    assigns("variables") || assigns("title") || rest("zone").is_some_and(|rest| rest.contains('='))
}

/// Whether the first two lines give the numbers of columns and rows of an ESRI grid.
pub(super) fn is_grid(data: &[u8]) -> bool {
    let mut lines = Lines::new(data);
    ["ncols", "nrows"].iter().all(|keyword| {
        let line = lines.next();
        line.is_some_and(|line| {
            line.keyword() == *keyword && line.words().nth(1).is_some_and(|word| integer(word).is_some())
        })
    })
}

/// The heights of an ESRI grid.
#[derive(Clone, Copy)]
struct Grid {
    columns: usize,
    rows: u64,
    /// The centre of the first cell of the last row.
    origin: [f64; 2],
    /// The width and the height of a cell.
    cell: [f64; 2],
    no_data: f64,
}

impl Grid {
    /// Returns the centre of a cell, given by its number in the order of the file, with the height.
    fn point(&self, number: u64, z: f64) -> [f64; 3] {
        let (row, column) = (number / self.columns as u64, number % self.columns as u64);
        let up = (self.rows - 1 - row) as f64;
        [self.origin[0] + column as f64 * self.cell[0], self.origin[1] + up * self.cell[1], z]
    }

    /// Whether a cell of this height has no data.
    fn is_empty(&self, z: f64) -> bool {
        z == self.no_data || (z.is_nan() && self.no_data.is_nan())
    }
}

/// Reads the heights of an ESRI grid as points: x, y and z at the centre of each cell, in the order of the file. Cells
/// without data are left out, and a note counts them.
pub(super) fn read_grid(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
    let mut lines = Lines::new(source.data);
    let grid = header(source, &mut lines)?;
    let cells = (grid.columns as u64).checked_mul(grid.rows);
    let bytes = lines.rest().len() as u64;
    let cells = cells.filter(|cells| *cells <= bytes);
    let cells = cells.ok_or_else(|| source.truncated(Place::Line(1), "cells of a grid", grid.rows, 0))?;
    let mut points = Collector::new(source, options, (Place::Whole, 3), (cells, lines.rest().len(), 2))?;
    let (mut empty, mut met) = (0, 0);
    for line in lines.by_ref() {
        for word in line.words() {
            if met == cells {
                return Err(source.surplus(line.place(), "cells of the grid", cells));
            }
            match number(word) {
                None => points.malformed(&line, word)?,
                Some(z) if grid.is_empty(z) => empty += 1,
                Some(z) => points.push(line.place(), &grid.point(met, z))?,
            }
            met += 1;
        }
    }
    if met < cells {
        return Err(source.truncated(Place::Line(lines.number()), "cells of the grid", cells, met));
    }
    let (columns, rows) = (grid.columns, grid.rows);
    let left_out = match empty {
        0 => String::new(),
        1 => "; 1 cell without data is left out".to_owned(),
        more => format!("; {more} cells without data are left out"),
    };
    points.notes.push(format!("read as a grid of {columns} x {rows} heights{left_out}"));
    Ok(points.finish())
}

fn header(source: Source<'_>, lines: &mut Lines<'_>) -> Result<Grid, InputError> {
    const EXPECTED: &str = "a line of the header of a grid, such as `cellsize 10`";
    let mut grid = Grid { columns: 0, rows: 0, origin: [0.0; 2], cell: [0.0; 2], no_data: -9999.0 };
    let mut corner = [true; 2];
    let before = loop {
        let before = lines.clone();
        let Some(line) = lines.next() else { break before };
        let keyword = line.keyword();
        if keyword.is_empty() {
            continue;
        }
        // A height may be `nan`.
        let is_height = line.words().next().is_some_and(|word| number(word).is_some());
        if is_height || !keyword.starts_with(|c: char| c.is_ascii_alphabetic()) {
            break before;
        }
        let word = line.words().nth(1).ok_or_else(|| source.bad_line(&line, EXPECTED))?;
        let value = number(word).ok_or_else(|| source.bad_number(&line, word))?;
        let is_size = matches!(keyword.as_str(), "ncols" | "nrows" | "cellsize" | "dx" | "dy");
        if is_size && !(value > 0.0 && value.is_finite()) {
            return Err(source.bad_word(&line, word, "a number above 0"));
        }
        match keyword.as_str() {
            "ncols" => grid.columns = source.count(&line, Some(word), EXPECTED)? as usize,
            "nrows" => grid.rows = source.count(&line, Some(word), EXPECTED)?,
            "xllcorner" | "xllcenter" => (grid.origin[0], corner[0]) = (value, keyword.ends_with("corner")),
            "yllcorner" | "yllcenter" => (grid.origin[1], corner[1]) = (value, keyword.ends_with("corner")),
            "cellsize" => grid.cell = [value; 2],
            "dx" => grid.cell[0] = value,
            "dy" => grid.cell[1] = value,
            "nodata_value" => grid.no_data = value,
            _ => return Err(source.bad_line(&line, EXPECTED)),
        }
    };
    *lines = before;
    let given = [grid.columns > 0, grid.rows > 0, !grid.cell.contains(&0.0)];
    let found = given.iter().filter(|given| **given).count() as u64;
    if found < 3 {
        let place = Place::Line(lines.number());
        return Err(source.truncated(place, "lines ncols, nrows and cellsize", 3, found));
    }
    for axis in [0, 1] {
        grid.origin[axis] += if corner[axis] { grid.cell[axis] / 2.0 } else { 0.0 };
    }
    Ok(grid)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// Reads a grid. Returns its points, the number of skipped ones, and the notes.
    fn read(text: &str, skip_invalid: bool) -> Result<(Vec<[f64; 3]>, usize, String), InputError> {
        let source = Source { path: Path::new("a.asc"), data: text.as_bytes() };
        let options = ReadOptions { terrain: true, skip_invalid, ..ReadOptions::default() };
        let file = read_grid(source, &options)?;
        let points = file.points.coordinates().as_chunks::<3>().0.to_vec();
        Ok((points, file.skipped, file.notes.join("\n")))
    }

    #[test]
    fn heights_are_at_the_centres_of_cells() {
        let head = "ncols 2\nnrows 2\n";
        let corner = format!("{head}xllcorner 10\nyllcorner 20\ncellsize 2\nNODATA_value -1\n1 2\n3 -1\n");
        let (points, skipped, note) = read(&corner, false).unwrap();
        assert_eq!(points, [[11.0, 23.0, 1.0], [13.0, 23.0, 2.0], [11.0, 21.0, 3.0]]);
        assert_eq!(
            (skipped, &note[..]),
            (0, "read as a grid of 2 x 2 heights; 1 cell without data is left out")
        );
        // The lines of a grid may end anywhere.
        let centre = format!("{head}xllcenter 10\nyllcenter 20\ncellsize 2\n1 2 3\n4\n");
        let (points, _, note) = read(&centre, false).unwrap();
        assert_eq!((points[3], &note[..]), ([12.0, 20.0, 4.0], "read as a grid of 2 x 2 heights"));
        let mixed = format!("{head}XLLCENTER 10\nYLLCORNER 20\ndx 2\ndy 4\n1 2 3 4\n");
        assert_eq!(read(&mixed, false).unwrap().0[0], [10.0, 26.0, 1.0]);
    }

    #[test]
    fn heights_that_are_not_numbers_are_invalid() {
        let head = "ncols 2\nnrows 2\ncellsize 1\n";
        for bad in ["nan", "inf", "x"] {
            let text = format!("{head}1 2\n{bad} 4\n");
            let error = read(&text, false).unwrap_err();
            assert_eq!(error.line(), Some(5), "{error}");
            assert_eq!(read(&text, true).unwrap().1, 1);
        }
        let text = format!("{head}NODATA_value nan\n1 2\nNaN 4\n");
        let (points, skipped, note) = read(&text, false).unwrap();
        assert_eq!((points.len(), skipped), (3, 0));
        assert!(note.contains("1 cell without data"), "{note}");
        for (text, line) in
            [(format!("{head}nan 2\n3 4\n"), 4), (head.replace("ze 1", "ze 0") + "1 2 3 4\n", 3)]
        {
            assert_eq!(read(&text, false).unwrap_err().line(), Some(line), "{text}");
        }
        let text = format!("{head}NODATA_value nan\nnan 2\n3 4\n");
        assert_eq!(read(&text, false).unwrap().0.len(), 3);
        for text in [
            "ncols 2\nnrows 2\n1 2 3 4\n",
            "ncols 2\nnrows 2\ncellsize nan\n1 2 3 4\n",
            "ncols 2\nnrows 2\ndx 1\n1 2 3 4\n",
            "ncols 2\nnrows 2\ncellsize 1\n1 2 3\n",
            "ncols 2\nnrows 2\ncellsize 1\n1 2 3 4 5\n",
            "ncols 99999999999\nnrows 99999999999\ncellsize 1\n1 2\n",
            "ncols 2\nnrows 2\ncellsize\n",
        ] {
            assert!(read(text, true).is_err(), "{text}");
        }
    }

    #[test]
    fn other_texts_are_no_tables() {
        for (text, part) in [
            ("TITLE = \"a\"\nVARIABLES = \"X\"\n1 2\n", "Tecplot"),
            ("variables=x,y\n1 2\n", "Tecplot"),
            ("# .PCD v0.7\nVERSION 0.7\n", "PCD"),
            ("VERSION 0.7\nFIELDS x y\nDATA ascii\n", "PCD"),
            ("NCOLS 2\nNROWS 2\n", "grid"),
        ] {
            let error = refuse(Source { path: Path::new("a.txt"), data: text.as_bytes() }).unwrap_err();
            assert!(error.to_string().contains(part), "{error}");
        }
        for text in ["title x y\n1 2 3\n", "zone,x,y\n1,2,3\n", "1 2\n", ""] {
            refuse(Source { path: Path::new("a.txt"), data: text.as_bytes() }).unwrap();
        }
    }
}
