//! `.inp`: a flat input file of Abaqus, with ids from 1.
//!
//! Cells are C3D4 or C3D10, in the plane CPS3 or CPS6, and in a terrain S3 or STRI65. A region is an element set. A
//! marker is a surface of element faces and a set of their nodes, and so is a marker of edges a set of nodes. Numbers
//! have at most 20 characters, the limit of Abaqus.

use std::io::{self, Write};

use crate::write::elements::{Block, Elements, Side};
use crate::write::error::WriteFault;
use crate::write::options::{Order, WriteOptions};
use crate::write::records::{WriteProgress, push_float_within, push_integer, write_records};
use septet_core::model::MeshView;

/// The largest number of characters of a number.
const WIDTH: usize = 20;

/// The largest number of ids in a line.
const IDS: usize = 16;

/// Writes a mesh.
pub fn write(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    options: &WriteOptions<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let elements = &Elements::of(mesh, options.order)?;
    writeln!(out, "*HEADING\nseptet\n*NODE")?;
    write_records(out, elements.node_count(), progress, |buffer, i| {
        push_integer(buffer, i as u64 + 1);
        for c in elements.place(i) {
            buffer.extend_from_slice(b", ");
            push_float_within(buffer, c, WIDTH);
        }
        buffer.push(b'\n');
    })?;
    writeln!(out, "*ELEMENT, TYPE={}", element_type(mesh, options.order))?;
    let cells = &elements.cells;
    write_records(out, cells.len(), progress, |buffer, i| {
        push_integer(buffer, i as u64 + 1);
        for node in cells.row(i) {
            buffer.extend_from_slice(b", ");
            push_integer(buffer, node + 1);
        }
        buffer.push(b'\n');
    })?;
    for (at, rows) in cells.rows_of_groups().into_iter().enumerate() {
        writeln!(out, "*ELSET, ELSET={}", cells.groups.name(at))?;
        write_ids(out, &rows.iter().map(|&row| row as u64 + 1).collect::<Vec<_>>())?;
    }
    for block in [&elements.faces, &elements.edges] {
        write_node_sets(out, block)?;
    }
    Ok(write_surfaces(out, elements)?)
}

fn element_type(mesh: &MeshView<'_>, order: Order) -> &'static str {
    match (mesh.dimension, mesh.heights, order) {
        (3, _, Order::One) => "C3D4",
        (3, _, Order::Two) => "C3D10",
        (_, None, Order::One) => "CPS3",
        (_, None, Order::Two) => "CPS6",
        (_, Some(_), Order::One) => "S3",
        (_, Some(_), Order::Two) => "STRI65",
    }
}

/// Writes the nodes of each group of faces or edges.
fn write_node_sets(out: &mut dyn Write, block: &Block<'_>) -> io::Result<()> {
    for (at, rows) in block.rows_of_groups().into_iter().enumerate() {
        writeln!(out, "*NSET, NSET={}", block.groups.name(at))?;
        let mut nodes: Vec<u64> = rows.iter().flat_map(|&row| block.row(row)).map(|node| node + 1).collect();
        nodes.sort_unstable();
        nodes.dedup();
        write_ids(out, &nodes)?;
    }
    Ok(())
}

fn write_ids(out: &mut dyn Write, ids: &[u64]) -> io::Result<()> {
    for line in ids.chunks(IDS) {
        let line: Vec<String> = line.iter().map(u64::to_string).collect();
        writeln!(out, "{}", line.join(", "))?;
    }
    Ok(())
}

/// Returns the number of a side of a cell: S1 to S4 of a tetrahedron are opposite to its nodes 4, 3, 1 and 2, and S1 to
/// S3 of a triangle to its nodes 3, 1 and 2.
fn side_number(dimension: usize, opposite: usize) -> usize {
    match (dimension, opposite) {
        (3, 3) | (2, 2) => 1,
        (3, 2) | (2, 0) => 2,
        (3, 0) | (2, _) => 3,
        _ => 4,
    }
}

/// Writes the element faces of each marker. An edge of a shell has the letter E.
fn write_surfaces(out: &mut dyn Write, elements: &Elements<'_>) -> io::Result<()> {
    let letter = if elements.mesh.heights.is_some() { 'E' } else { 'S' };
    let sides = elements.sides();
    for (at, rows) in elements.faces.rows_of_groups().into_iter().enumerate() {
        writeln!(out, "*SURFACE, NAME={}, TYPE=ELEMENT", elements.faces.groups.name(at))?;
        let mut own: Vec<Side> = rows.into_iter().filter_map(|row| sides[row]).collect();
        own.sort_unstable();
        for Side { cell, opposite } in own {
            let number = side_number(elements.mesh.dimension, opposite);
            writeln!(out, "{}, {letter}{number}", cell + 1)?;
        }
    }
    Ok(())
}
