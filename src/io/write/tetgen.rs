//! `.node`, `.ele`, `.face`, `.edge` and `.neigh`: the set of `TetGen` in space and of Triangle in
//! the plane.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::WriteOptions;
use super::error::{Fault, OutputError};
use super::records::{Progress, push_indices, push_integer, push_point, write_records};
use super::stage::Stage;
use super::topology::{self, OUTSIDE};
use crate::model::MeshView;

/// The extensions of the set.
const EXTENSIONS: [&str; 5] = ["node", "ele", "face", "edge", "neigh"];

/// The member of the set with an extension; the named path itself keeps its spelling.
fn member(path: &Path, extension: &str) -> PathBuf {
    match path.extension() {
        Some(own) if own.eq_ignore_ascii_case(extension) => path.to_path_buf(),
        _ => path.with_extension(extension),
    }
}

/// All files of the set a path belongs to.
pub(super) fn siblings(path: &Path) -> impl Iterator<Item = PathBuf> {
    EXTENSIONS.iter().map(move |extension| member(path, extension))
}

/// How many records [`write`] reports; the number of edges is an estimate.
pub(super) fn records(mesh: &MeshView<'_>) -> u64 {
    (mesh.point_count() + 5 * mesh.cell_count()) as u64
}

/// Writes the set.
pub(super) fn write(
    path: &Path,
    mesh: &MeshView<'_>,
    options: &WriteOptions,
    stage: &mut Stage,
    progress: &mut Progress<'_>,
) -> Result<(), OutputError> {
    let (dimension, base) = (mesh.dimension, options.first_id);
    let corners = dimension + 1;
    stage
        .write(&member(path, "node"), |out| write_nodes(out, dimension, mesh.coordinates, base, progress))?;
    let head = format!("{} {corners} 0\n", mesh.cell_count());
    stage.write(&member(path, "ele"), |out| {
        write_rows(out, &head, (mesh.cells, corners), base, progress, |_, _| {})
    })?;
    let hull = {
        let target = member(path, "neigh");
        let found = topology::adjacency(dimension, mesh.point_count(), mesh.cells);
        let found = found.map_err(|error| Fault::from(error).at(&target))?;
        progress.advance(mesh.cell_count() as u64);
        let neighbours = &found.neighbours;
        stage.write(&target, |out| write_neighbours(out, neighbours, corners, base, progress))?;
        found.hull
    };
    if dimension == 3 {
        let head = format!("{} 1\n", hull.len() / 3);
        stage.write(&member(path, "face"), |out| {
            write_rows(out, &head, (&hull, 3), base, progress, |_, buffer| {
                buffer.extend_from_slice(b" 1");
            })
        })?;
    }
    let target = member(path, "edge");
    let edges = topology::edges(dimension, mesh.point_count(), mesh.cells);
    let edges = edges.map_err(|error| Fault::from(error).at(&target))?;
    progress.advance(mesh.cell_count() as u64);
    let hull = topology::hull_edges(dimension, &hull);
    let head = format!("{} 1\n", edges.len());
    stage.write(&target, |out| {
        write_rows(out, &head, (edges.as_flattened(), 2), base, progress, |row, buffer| {
            let on_hull = hull.binary_search(&edges[row]).is_ok();
            buffer.extend_from_slice(if on_hull { b" 1" } else { b" 0" });
        })
    })
}

/// Writes a `.node` file: no attributes, no markers.
pub(super) fn write_nodes(
    out: &mut dyn Write,
    dimension: usize,
    coordinates: &[f64],
    base: u64,
    progress: &mut Progress<'_>,
) -> Result<(), Fault> {
    let count = coordinates.len() / dimension;
    writeln!(out, "{count} {dimension} 0 0")?;
    write_records(out, count, progress, |buffer, row| {
        push_integer(buffer, row as u64 + base);
        buffer.push(b' ');
        let point = &coordinates[row * dimension..(row + 1) * dimension];
        push_point(buffer, point, b' ', false);
        buffer.push(b'\n');
    })?;
    Ok(())
}

/// Writes a heading and numbered rows of indices, each with what `tail` appends.
fn write_rows(
    out: &mut dyn Write,
    head: &str,
    (indices, width): (&[u64], usize),
    base: u64,
    progress: &mut Progress<'_>,
    tail: impl Fn(usize, &mut Vec<u8>) + Sync,
) -> Result<(), Fault> {
    out.write_all(head.as_bytes())?;
    write_records(out, indices.len() / width, progress, |buffer, row| {
        push_integer(buffer, row as u64 + base);
        push_indices(buffer, &indices[row * width..(row + 1) * width], base);
        tail(row, buffer);
        buffer.push(b'\n');
    })?;
    Ok(())
}

fn write_neighbours(
    out: &mut dyn Write,
    neighbours: &[u64],
    corners: usize,
    base: u64,
    progress: &mut Progress<'_>,
) -> Result<(), Fault> {
    let count = neighbours.len() / corners;
    writeln!(out, "{count} {corners}")?;
    write_records(out, count, progress, |buffer, row| {
        push_integer(buffer, row as u64 + base);
        for &neighbour in &neighbours[row * corners..(row + 1) * corners] {
            if neighbour == OUTSIDE {
                buffer.extend_from_slice(b" -1");
            } else {
                push_indices(buffer, &[neighbour], base);
            }
        }
        buffer.push(b'\n');
    })?;
    Ok(())
}
