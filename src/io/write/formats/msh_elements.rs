//! `.msh` files of elements with groups: meshes of domains, and quadratic triangulations.
//!
//! A group of cells, faces or edges is one entity and one physical group with the same tag and a name. Positive numbers
//! of regions and markers are the tags. Other numbers get tags above them, because Gmsh reads the sign of a group as a
//! direction, and meshio needs a group for each entity.

use std::io::Write;

use crate::write::elements::{Block, Elements};
use crate::write::error::WriteFault;
use crate::write::options::{MshVersion, Order};
use crate::write::records::{
    WriteProgress, push_float, push_indices, push_integer, push_point, write_records,
};

/// Writes the elements of a mesh.
pub fn write(
    out: &mut dyn Write,
    elements: &Elements<'_>,
    version: MshVersion,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let number = match version {
        MshVersion::V41 => "4.1",
        MshVersion::V22 => "2.2",
    };
    writeln!(out, "$MeshFormat\n{number} 0 8\n$EndMeshFormat")?;
    write_names(out, elements)?;
    match version {
        MshVersion::V41 => {
            write_entities(out, elements)?;
            write_nodes_41(out, elements, progress)?;
        }
        MshVersion::V22 => write_nodes_22(out, elements, progress)?,
    }
    write_elements(out, elements, version, progress)
}

/// Returns the groups, from edges up to cells: the block, the position of the group, and its rows.
fn groups<'a, 'b>(elements: &'b Elements<'a>) -> Vec<(&'b Block<'a>, usize, Vec<usize>)> {
    let mut blocks = elements.blocks();
    blocks.reverse();
    let of = |block: &'b Block<'a>| {
        block.rows_of_groups().into_iter().enumerate().map(move |(at, rows)| (block, at, rows))
    };
    blocks.into_iter().flat_map(of).collect()
}

fn write_names(out: &mut dyn Write, elements: &Elements<'_>) -> Result<(), WriteFault> {
    let mut blocks = elements.blocks();
    blocks.reverse();
    let count: usize = blocks.iter().map(|block| block.groups.len()).sum();
    writeln!(out, "$PhysicalNames\n{count}")?;
    for block in blocks {
        for at in 0..block.groups.len() {
            let (tag, name) = (block.groups.tag(at), block.groups.name(at));
            writeln!(out, "{} {tag} \"{name}\"", block.dimension)?;
        }
    }
    writeln!(out, "$EndPhysicalNames")?;
    Ok(())
}

/// Writes the section of entities of version 4.1.
fn write_entities(out: &mut dyn Write, elements: &Elements<'_>) -> Result<(), WriteFault> {
    let groups = groups(elements);
    let count = |d: usize| groups.iter().filter(|(block, ..)| block.dimension == d).count();
    writeln!(out, "$Entities\n0 {} {} {}", count(1), count(2), count(3))?;
    for (block, at, rows) in &groups {
        let mut line = Vec::new();
        let tag = u64::from(block.groups.tag(*at));
        push_integer(&mut line, tag);
        let nodes = rows.iter().flat_map(|&row| block.row(row)).copied();
        for c in bounding_box(nodes.map(|node| elements.place(node as usize))) {
            line.push(b' ');
            push_float(&mut line, c);
        }
        push_indices(&mut line, &[1, tag, 0], 0);
        line.push(b'\n');
        out.write_all(&line)?;
    }
    writeln!(out, "$EndEntities")?;
    Ok(())
}

/// Returns the three smallest and then the three largest coordinates of places, or zeros if there are none.
pub fn bounding_box(places: impl Iterator<Item = [f64; 3]>) -> [f64; 6] {
    let mut found = None;
    for place in places {
        let (low, high) = found.get_or_insert(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]));
        for axis in 0..3 {
            low[axis] = f64::min(low[axis], place[axis]);
            high[axis] = f64::max(high[axis], place[axis]);
        }
    }
    let (low, high) = found.unwrap_or_default();
    [low[0], low[1], low[2], high[0], high[1], high[2]]
}

/// Writes all nodes in one block, which belongs to the first group of cells.
fn write_nodes_41(
    out: &mut dyn Write,
    elements: &Elements<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let (count, dimension) = (elements.node_count(), elements.mesh.dimension);
    writeln!(out, "$Nodes")?;
    if count > 0 {
        let groups = &elements.cells.groups;
        let tag = if groups.len() > 0 { groups.tag(0) } else { 1 };
        write!(out, "1 {count} 1 {count}\n{dimension} {tag} 0 {count}\n")?;
    } else {
        writeln!(out, "0 0 0 0")?;
    }
    let mut silent = |_, _| {};
    write_records(out, count, &mut WriteProgress::new(count as u64, &mut silent), |buffer, i| {
        push_integer(buffer, i as u64 + 1);
        buffer.push(b'\n');
    })?;
    write_records(out, count, progress, |buffer, i| {
        push_point(buffer, &elements.place(i), b' ', true);
        buffer.push(b'\n');
    })?;
    writeln!(out, "$EndNodes")?;
    Ok(())
}

fn write_nodes_22(
    out: &mut dyn Write,
    elements: &Elements<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let count = elements.node_count();
    writeln!(out, "$Nodes\n{count}")?;
    write_records(out, count, progress, |buffer, i| {
        push_integer(buffer, i as u64 + 1);
        buffer.push(b' ');
        push_point(buffer, &elements.place(i), b' ', true);
        buffer.push(b'\n');
    })?;
    writeln!(out, "$EndNodes")?;
    Ok(())
}

/// Returns the number of a type of elements in Gmsh.
fn element_type(dimension: usize, order: Order) -> u8 {
    match (order, dimension) {
        (Order::One, 1) => 1,
        (Order::One, 2) => 2,
        (Order::One, _) => 4,
        (Order::Two, 1) => 8,
        (Order::Two, 2) => 9,
        (Order::Two, _) => 11,
    }
}

/// Appends the nodes of an element in the order of Gmsh, which swaps the last two midpoints of a tetrahedron.
fn push_nodes(buffer: &mut Vec<u8>, nodes: &[u64]) {
    match *nodes {
        [ref first @ .., a, b] if nodes.len() == 10 => {
            push_indices(buffer, first, 1);
            push_indices(buffer, &[b, a], 1);
        }
        _ => push_indices(buffer, nodes, 1),
    }
}

fn write_elements(
    out: &mut dyn Write,
    elements: &Elements<'_>,
    version: MshVersion,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let groups = groups(elements);
    let total = elements.len();
    writeln!(out, "$Elements")?;
    match version {
        MshVersion::V22 => writeln!(out, "{total}")?,
        MshVersion::V41 if total == 0 => writeln!(out, "0 0 0 0")?,
        MshVersion::V41 => writeln!(out, "{} {total} 1 {total}", groups.len())?,
    }
    let mut first = 1;
    for (block, at, rows) in &groups {
        let (kind, tag) = (element_type(block.dimension, elements.order), block.groups.tag(*at));
        let mut between = Vec::new();
        match version {
            MshVersion::V22 => write!(between, " {kind} 2 {tag} {tag}")?,
            MshVersion::V41 => writeln!(out, "{} {tag} {kind} {}", block.dimension, rows.len())?,
        }
        write_records(out, rows.len(), progress, |buffer, i| {
            push_integer(buffer, first + i as u64);
            buffer.extend_from_slice(&between);
            push_nodes(buffer, block.row(rows[i]));
            buffer.push(b'\n');
        })?;
        first += rows.len() as u64;
    }
    writeln!(out, "$EndElements")?;
    Ok(())
}
