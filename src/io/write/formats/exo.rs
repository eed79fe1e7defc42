//! `.exo`: Exodus II in the classic format of netCDF. A region is an element block, a marker a side set, and a marker of
//! edges a node set, each with an id and a name.
//!
//! Source: "EXODUS II: A Finite Element Data Model", Sandia report SAND92-2137. Cells are numbered from 1, block after
//! block. A side set has a side of one cell for each face.

use std::io::Write;

use crate::write::elements::{Block, Elements, Side};
use crate::write::error::WriteFault;
use crate::write::netcdf::{Dimension, File, Kind, Value, push_ints};
use crate::write::options::{Order, WriteOptions};
use crate::write::records::WriteProgress;
use septet_core::model::MeshView;

/// The number of bytes of a name.
const NAME: usize = 33;

/// Writes a mesh.
pub fn write(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    options: &WriteOptions<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let elements = &Elements::of(mesh, options.order)?;
    let axes = if mesh.heights.is_some() { 3 } else { mesh.dimension };
    let blocks = elements.cells.rows_of_groups();
    let mut file = File::default();
    file.attributes = vec![
        ("api_version", Value::Float(5.1)),
        ("version", Value::Float(5.1)),
        ("floating_point_word_size", Value::Int(8)),
        ("file_size", Value::Int(1)),
        ("title", Value::Text("septet".to_owned())),
    ];
    let time = file.dimension("time_step", 0)?;
    let name = file.dimension("len_string", NAME)?;
    file.dimension("len_line", 81)?;
    file.dimension("four", 4)?;
    let space = file.dimension("num_dim", axes)?;
    // A list without entries has no dimension, because the length 0 would be the unlimited dimension.
    if elements.node_count() > 0 {
        let nodes = file.dimension("num_nodes", elements.node_count())?;
        for axis in 0..axes {
            let coordinate = ["coordx", "coordy", "coordz"][axis];
            file.variable(coordinate, Kind::Double, &[nodes], move |buffer, i| {
                buffer.extend_from_slice(&elements.place(i)[axis].to_be_bytes());
            });
        }
    }
    if elements.cells.len() > 0 {
        file.dimension("num_elem", elements.cells.len())?;
    }
    file.variable("time_whole", Kind::Double, &[time], |_, _| {});
    let axis_names = ["x", "y", "z"][..axes].iter().map(|&axis| axis.to_owned()).collect();
    file.names("coor_names", [space, name], NAME, axis_names);
    add_blocks(&mut file, name, elements, &blocks)?;
    add_side_sets(&mut file, name, elements, &blocks)?;
    add_node_sets(&mut file, name, &elements.edges)?;
    file.write(out, progress)
}

/// Adds the list of groups: states, ids and names.
fn add_list(
    file: &mut File<'_>,
    name: Dimension,
    (dimension, prefix): (&str, &str),
    block: &Block<'_>,
) -> Result<(), WriteFault> {
    let groups = block.groups.clone();
    let list = file.dimension(dimension, groups.len())?;
    file.variable(format!("{prefix}_status"), Kind::Int, &[list], |buffer, _| push_ints(buffer, [1]));
    let names = (0..groups.len()).map(|at| groups.name(at)).collect();
    file.variable(format!("{prefix}_prop1"), Kind::Int, &[list], move |buffer, at| {
        push_ints(buffer, [u64::from(groups.tag(at))]);
    });
    file.describe("name", Value::Text("ID".to_owned()));
    file.names(&format!("{prefix}_names"), [list, name], NAME, names);
    Ok(())
}

fn element_type(dimension: usize, order: Order) -> &'static str {
    match (dimension, order) {
        (3, Order::One) => "TETRA",
        (3, Order::Two) => "TETRA10",
        (_, Order::One) => "TRI3",
        (_, Order::Two) => "TRI6",
    }
}

/// Adds the cells of each region.
fn add_blocks<'a>(
    file: &mut File<'a>,
    name: Dimension,
    elements: &'a Elements<'_>,
    blocks: &'a [Vec<usize>],
) -> Result<(), WriteFault> {
    if blocks.is_empty() {
        return Ok(());
    }
    let cells = &elements.cells;
    add_list(file, name, ("num_el_blk", "eb"), cells)?;
    for (number, rows) in (1..).zip(blocks) {
        let count = file.dimension(format!("num_el_in_blk{number}"), rows.len())?;
        let width = file.dimension(format!("num_nod_per_el{number}"), cells.width)?;
        file.variable(format!("connect{number}"), Kind::Int, &[count, width], move |buffer, i| {
            push_ints(buffer, cells.row(rows[i]).iter().map(|node| node + 1));
        });
        let kind = element_type(cells.dimension, elements.order);
        file.describe("elem_type", Value::Text(kind.to_owned()));
    }
    Ok(())
}

/// Returns the number of a side: those of a tetrahedron are opposite to its nodes 3, 1, 2 and 4, and those of a triangle
/// to its nodes 3, 1 and 2. The first two sides of a triangle in space are its faces.
fn side_number(elements: &Elements<'_>, opposite: usize) -> u64 {
    let first = if elements.mesh.heights.is_some() { 2 } else { 0 };
    first + [2, 3, 1, 4][opposite]
}

/// Adds the sides of each marker.
fn add_side_sets(
    file: &mut File<'_>,
    name: Dimension,
    elements: &Elements<'_>,
    blocks: &[Vec<usize>],
) -> Result<(), WriteFault> {
    // The number of each cell in the order of the blocks.
    let mut numbers = vec![0; elements.cells.len()];
    blocks.iter().flatten().zip(1..).for_each(|(&cell, number)| numbers[cell] = number);
    let sides = elements.sides();
    let mut sets = Vec::new();
    for rows in elements.faces.rows_of_groups() {
        let own = rows.into_iter().filter_map(|row| sides[row]);
        let mut own: Vec<[u64; 2]> =
            own.map(|Side { cell, opposite }| [numbers[cell], side_number(elements, opposite)]).collect();
        own.sort_unstable();
        sets.push(own);
    }
    // Every face of a mesh is a side, so that no set is empty.
    if sets.is_empty() || sets.iter().any(Vec::is_empty) {
        return Ok(());
    }
    add_list(file, name, ("num_side_sets", "ss"), &elements.faces)?;
    for (number, own) in (1..).zip(sets) {
        let count = file.dimension(format!("num_side_ss{number}"), own.len())?;
        for (column, name) in ["elem_ss", "side_ss"].into_iter().enumerate() {
            let own: Vec<u64> = own.iter().map(|side| side[column]).collect();
            file.variable(format!("{name}{number}"), Kind::Int, &[count], move |buffer, i| {
                push_ints(buffer, [own[i]]);
            });
        }
    }
    Ok(())
}

/// Adds the nodes of each marker of edges.
fn add_node_sets(file: &mut File<'_>, name: Dimension, edges: &Block<'_>) -> Result<(), WriteFault> {
    let groups = edges.rows_of_groups();
    if groups.is_empty() {
        return Ok(());
    }
    add_list(file, name, ("num_node_sets", "ns"), edges)?;
    for (number, rows) in (1..).zip(groups) {
        let mut nodes: Vec<u64> = rows.iter().flat_map(|&row| edges.row(row)).map(|node| node + 1).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let count = file.dimension(format!("num_nod_ns{number}"), nodes.len())?;
        file.variable(format!("node_ns{number}"), Kind::Int, &[count], move |buffer, i| {
            push_ints(buffer, [nodes[i]]);
        });
    }
    Ok(())
}
