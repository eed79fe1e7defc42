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
    cell: f64,
    no_data: f64,
}

/// Reads the heights of an ESRI grid as points.
pub(super) fn read_grid(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
    let (heights, empty) = heights(source)?;
    let size = (heights.len() as u64, source.data.len(), 2);
    let mut points = Collector::new(source, options, (Place::Whole, 3), size)?;
    heights.iter().try_for_each(|point| points.push(Place::Whole, point))?;
    points.notes.push(format!("read as a grid of heights: {empty} cells without data are left out"));
    Ok(points.finish())
}

/// Reads the heights of an ESRI grid: x, y and z at the centre of each cell, in the order of the file. Cells without data are
/// left out, and counted.
fn heights(source: Source<'_>) -> Result<(Vec<[f64; 3]>, u64), InputError> {
    let mut lines = Lines::new(source.data);
    let grid = header(source, &mut lines)?;
    let cells = (grid.columns as u64).checked_mul(grid.rows);
    let bytes = lines.rest().len() as u64;
    let cells = cells.filter(|cells| *cells <= bytes);
    let cells = cells.ok_or_else(|| source.truncated(Place::Line(1), "cells of a grid", grid.rows, 0))?;
    let (mut heights, mut empty, mut met) = (Vec::new(), 0, 0);
    for line in lines.by_ref() {
        for word in line.words() {
            if met == cells {
                return Err(source.surplus(line.place(), "cells of the grid", cells));
            }
            let z = number(word).ok_or_else(|| source.bad_number(&line, word))?;
            let (row, column) = (met / grid.columns as u64, met % grid.columns as u64);
            met += 1;
            if z == grid.no_data || !z.is_finite() {
                empty += 1;
                continue;
            }
            let up = (grid.rows - 1 - row) as f64;
            heights.push([grid.origin[0] + column as f64 * grid.cell, grid.origin[1] + up * grid.cell, z]);
        }
    }
    if met < cells {
        return Err(source.truncated(Place::Line(lines.number()), "cells of the grid", cells, met));
    }
    Ok((heights, empty))
}

fn header(source: Source<'_>, lines: &mut Lines<'_>) -> Result<Grid, InputError> {
    const EXPECTED: &str = "a line of the header of a grid, such as `cellsize 10`";
    let mut grid = Grid { columns: 0, rows: 0, origin: [0.0; 2], cell: 0.0, no_data: -9999.0 };
    let mut corner = [false; 2];
    let before = loop {
        let before = lines.clone();
        let Some(line) = lines.next() else { break before };
        let keyword = line.keyword();
        if keyword.is_empty() {
            continue;
        }
        if !keyword.starts_with(|c: char| c.is_ascii_alphabetic()) {
            break before;
        }
        let word = line.words().nth(1).ok_or_else(|| source.bad_line(&line, EXPECTED))?;
        let value = number(word).ok_or_else(|| source.bad_number(&line, word))?;
        match keyword.as_str() {
            "ncols" => grid.columns = source.count(&line, Some(word), EXPECTED)? as usize,
            "nrows" => grid.rows = source.count(&line, Some(word), EXPECTED)?,
            "xllcorner" | "xllcenter" => (grid.origin[0], corner[0]) = (value, keyword.ends_with("corner")),
            "yllcorner" | "yllcenter" => (grid.origin[1], corner[1]) = (value, keyword.ends_with("corner")),
            "cellsize" => grid.cell = value,
            "nodata_value" => grid.no_data = value,
            _ => return Err(source.bad_line(&line, EXPECTED)),
        }
    };
    *lines = before;
    if grid.columns == 0 || grid.rows == 0 || grid.cell <= 0.0 {
        return Err(source.truncated(Place::Line(lines.number()), "lines ncols, nrows and cellsize", 3, 2));
    }
    for (origin, is_corner) in grid.origin.iter_mut().zip(corner) {
        *origin += if is_corner { grid.cell / 2.0 } else { 0.0 };
    }
    Ok(grid)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn read(text: &str) -> Result<(Vec<[f64; 3]>, u64), InputError> {
        heights(Source { path: Path::new("a.asc"), data: text.as_bytes() })
    }

    #[test]
    fn heights_are_at_the_centres_of_cells() {
        let head = "ncols 2\nnrows 2\n";
        let corner = format!("{head}xllcorner 10\nyllcorner 20\ncellsize 2\nNODATA_value -1\n1 2\n3 -1\n");
        let (points, empty) = read(&corner).unwrap();
        assert_eq!(points, [[11.0, 23.0, 1.0], [13.0, 23.0, 2.0], [11.0, 21.0, 3.0]]);
        assert_eq!(empty, 1);
        let centre = format!("{head}xllcenter 10\nyllcenter 20\ncellsize 2\n1 2 3\n4\n");
        assert_eq!(read(&centre).unwrap().0[3], [12.0, 20.0, 4.0]);
        for text in [
            "ncols 2\nnrows 2\n1 2 3 4\n",
            "ncols 2\nnrows 2\ncellsize 1\n1 2 3\n",
            "ncols 2\nnrows 2\ncellsize 1\n1 2 3 4 5\n",
            "ncols 2\nnrows 2\ncellsize 1\n1 2 3 x\n",
            "ncols 99999999999\nnrows 99999999999\ncellsize 1\n1 2\n",
            "ncols 2\nnrows 2\ncellsize\n",
        ] {
            assert!(read(text).is_err(), "{text}");
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
