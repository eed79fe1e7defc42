//! `.node`, `.ele`, `.face`, `.edge` and `.neigh` files: the set of `TetGen` in space and of Triangle in the plane.

use std::io::Write;
use std::path::Path;

use crate::write::error::{OutputError, WriteFault};
use crate::write::names::member;
use crate::write::options::WriteOptions;
use crate::write::records::{
    WriteProgress, push_float, push_indices, push_integer, push_point, push_signed, write_records,
};
use crate::write::stage::Stage;
use crate::write::topology::{self, OUTSIDE};
use septet_core::model::{Labels, MeshView, Points};

/// Returns the number of records that `write` reports. The number of edges is an estimate.
pub fn records(mesh: &MeshView<'_>) -> u64 {
    (mesh.point_count() + 5 * mesh.cell_count()) as u64
}

/// Writes the set.
pub fn write(
    path: &Path,
    mesh: &MeshView<'_>,
    options: &WriteOptions<'_>,
    stage: &mut Stage,
    progress: &mut WriteProgress<'_>,
) -> Result<(), OutputError> {
    let (dimension, base) = (mesh.dimension, options.first_id);
    let corners = dimension + 1;
    let sizes = mesh.labels.map(|l| l.sizes.as_slice());
    let markers = mesh.labels.map(|l| l.point_markers.as_slice());
    let of_points = Attributes { values: sizes.or(mesh.heights), markers };
    stage.write(&member(path, "node"), |out| {
        write_nodes(out, dimension, (mesh.coordinates, of_points), base, progress)
    })?;
    let attributes = mesh.labels.map(|l| l.attributes.as_slice());
    let head = format!("{} {corners} {}\n", mesh.cell_count(), u8::from(attributes.is_some()));
    stage.write(&member(path, "ele"), |out| {
        write_rows(out, &head, (mesh.cells, corners), base, progress, |row, buffer| {
            if let Some(attributes) = attributes {
                buffer.push(b' ');
                push_float(buffer, attributes[row]);
            }
        })
    })?;
    let hull = {
        let target = member(path, "neigh");
        let found = topology::adjacency(dimension, mesh.point_count(), mesh.cells);
        let found = found.map_err(|error| WriteFault::from(error).at(&target))?;
        progress.advance(mesh.cell_count() as u64);
        let neighbours = &found.neighbours;
        stage.write(&target, |out| write_neighbours(out, neighbours, corners, base, progress))?;
        found.hull
    };
    if let Some(labels) = mesh.labels {
        return write_labelled(path, mesh, labels, base, stage, progress);
    }
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
    let edges = edges.map_err(|error| WriteFault::from(error).at(&target))?;
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

/// Writes points as a `.node` file.
pub fn write_points(
    out: &mut dyn Write,
    points: &Points,
    base: u64,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    write_nodes(out, points.dimension(), (points.coordinates(), Attributes::default()), base, progress)
}

/// Writes the faces and edges of a mesh of a domain with their markers. `.face` contains the triangles on facets. In
/// space, `.edge` contains the edges on segments. In the plane, it contains all edges, and edges that are not on a
/// segment have marker 0.
fn write_labelled(
    path: &Path,
    mesh: &MeshView<'_>,
    labels: &Labels,
    base: u64,
    stage: &mut Stage,
    progress: &mut WriteProgress<'_>,
) -> Result<(), OutputError> {
    if mesh.dimension == 3 {
        for (extension, width, patches) in [("face", 3, &labels.faces), ("edge", 2, &labels.edges)] {
            let head = format!("{} 1\n", patches.len());
            stage.write(&member(path, extension), |out| {
                let rows = (patches.vertices.as_slice(), width);
                write_rows(out, &head, rows, base, progress, |row, buffer| {
                    push_signed(buffer, patches.markers[row]);
                })
            })?;
        }
        return Ok(());
    }
    let target = member(path, "edge");
    let edges = topology::edges(2, mesh.point_count(), mesh.cells);
    let edges = edges.map_err(|error| WriteFault::from(error).at(&target))?;
    let ends = labels.faces.vertices.chunks_exact(2).map(|e| [e[0].min(e[1]), e[0].max(e[1])]);
    let mut marked: Vec<([u64; 2], i64)> = ends.zip(labels.faces.markers.iter().copied()).collect();
    marked.sort_unstable();
    let head = format!("{} 1\n", edges.len());
    stage.write(&target, |out| {
        write_rows(out, &head, (edges.as_flattened(), 2), base, progress, |row, buffer| {
            let at = marked.binary_search_by_key(&edges[row], |m| m.0);
            push_signed(buffer, at.map_or(0, |at| marked[at].1));
        })
    })
}

/// What the points have besides their coordinates.
#[derive(Clone, Copy, Default)]
struct Attributes<'a> {
    /// The attribute of each point: its size in a mesh of a domain, its height in a terrain.
    values: Option<&'a [f64]>,
    /// The marker of each point.
    markers: Option<&'a [i64]>,
}

/// Writes a `.node` file.
fn write_nodes(
    out: &mut dyn Write,
    dimension: usize,
    (coordinates, attributes): (&[f64], Attributes<'_>),
    base: u64,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let count = coordinates.len() / dimension;
    let Attributes { values, markers } = attributes;
    let columns = [values.is_some(), markers.is_some()].map(u8::from);
    writeln!(out, "{count} {dimension} {} {}", columns[0], columns[1])?;
    write_records(out, count, progress, |buffer, row| {
        push_integer(buffer, row as u64 + base);
        buffer.push(b' ');
        let point = &coordinates[row * dimension..(row + 1) * dimension];
        push_point(buffer, point, b' ', false);
        if let Some(values) = values {
            buffer.push(b' ');
            push_float(buffer, values[row]);
        }
        if let Some(markers) = markers {
            push_signed(buffer, markers[row]);
        }
        buffer.push(b'\n');
    })?;
    Ok(())
}

/// Writes a header and numbered rows of indices. `tail` appends text to each row.
fn write_rows(
    out: &mut dyn Write,
    head: &str,
    (indices, width): (&[u64], usize),
    base: u64,
    progress: &mut WriteProgress<'_>,
    tail: impl Fn(usize, &mut Vec<u8>) + Sync,
) -> Result<(), WriteFault> {
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
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
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
