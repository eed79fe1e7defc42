//! `.vtu` files of elements with groups: meshes of domains, and quadratic triangulations.
//!
//! Cells come first, then the triangles on facets, then the edges on segments. `dimension` tells them apart. Cells have
//! marker 0, and lower elements region 0. A lower element has the facet or segment on which it lies as `feature`, and the
//! components on its two sides; component 0 is the exterior. Numbers that an element does not have are -1, or NaN.

use std::io::Write;

use super::vtu::{
    self, Array, GRID_DATA, POINT_DATA, Record, Section, cell_array, leaves, owners, plain_data_arrays,
    points_of, write_whole,
};
use crate::write::elements::Elements;
use crate::write::error::WriteFault;
use crate::write::options::{Order, WriteOptions};
use crate::write::quality::{least_angle, radius_edge_ratio};
use crate::write::records::WriteProgress;
use septet_core::model::{Labels, MeshView};

/// The opening tags of the data of a mesh of a domain.
const LABELLED_DATA: [&str; 2] = [POINT_DATA, "CellData GlobalIds=\"GlobalCellIds\" Scalars=\"region\""];

/// Writes a triangulation or a mesh of a domain.
pub fn write(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    options: &WriteOptions<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    if mesh.labels.is_none() && options.order == Order::One {
        return vtu::write(out, mesh, options, progress);
    }
    let elements = &Elements::of(mesh, options.order)?;
    let count = elements.len();
    let mut arrays = data_arrays(elements, options, count);
    arrays.push(points(elements));
    let connectivity: Record<'_> = Box::new(|buffer, i| {
        let (block, row) = elements.at(i);
        for node in elements.blocks()[block].row(row) {
            buffer.extend_from_slice(&node.to_le_bytes());
        }
    });
    let bytes = 8 * elements.blocks().iter().map(|block| block.len() * block.width).sum::<usize>();
    arrays
        .push(cell_array(Section::Cells, "connectivity", "Int64", (count, 0), connectivity).of_bytes(bytes));
    let end: Record<'_> = Box::new(|buffer, i| {
        let (at, row) = elements.at(i);
        let before: usize = elements.blocks()[..at].iter().map(|block| block.len() * block.width).sum();
        let end = before + (row + 1) * elements.blocks()[at].width;
        buffer.extend_from_slice(&(end as u64).to_le_bytes());
    });
    arrays.push(cell_array(Section::Cells, "offsets", "Int64", (count, 8), end));
    let kind: Record<'_> = Box::new(|buffer, i| {
        buffer.push(cell_type(elements.blocks()[elements.at(i).0].dimension, elements.order));
    });
    arrays.push(cell_array(Section::Cells, "types", "UInt8", (count, 1), kind));
    let data = if mesh.labels.is_some() { LABELLED_DATA } else { GRID_DATA };
    Ok(write_whole(out, data, &arrays, progress)?)
}

/// Returns the type of an element in VTK.
pub fn cell_type(dimension: usize, order: Order) -> u8 {
    match (order, dimension) {
        (Order::One, 1) => 3,
        (Order::One, 2) => vtu::TRIANGLE,
        (Order::One, _) => vtu::TETRAHEDRON,
        (Order::Two, 1) => 21,
        (Order::Two, 2) => 22,
        (Order::Two, _) => 24,
    }
}

/// Returns the array of the places of nodes.
pub fn points<'a>(elements: &'a Elements<'_>) -> Array<'a> {
    points_of(elements.node_count(), move |i| elements.place(i))
}

/// Returns the arrays of point data and cell data. `count` is the number of elements in the file, from the cells down.
pub fn data_arrays<'a>(
    elements: &'a Elements<'_>,
    options: &WriteOptions<'a>,
    count: usize,
) -> Vec<Array<'a>> {
    let mesh = &elements.mesh;
    let (dimension, coordinates) = (mesh.dimension, mesh.coordinates);
    let ratio = of_cells(elements, move |cell| radius_edge_ratio(dimension, coordinates, cell));
    let mut arrays = plain_data_arrays((elements.node_count(), count), &[], ratio);
    for column in options.point_data {
        arrays.push(of_nodes(elements, &column.name, &column.values));
    }
    if options.with_owner && mesh.labels.is_none() && count == mesh.cell_count() {
        arrays.extend(mesh.owner.map(|owner| owners(owner.len(), move |i| owner[i])));
        arrays.extend(mesh.owning_leaf.map(|leaf| leaves(leaf.len(), move |i| leaf[i])));
    }
    arrays.push(numbers(elements, "region", count, move |block, row| {
        if block == 0 { elements.blocks()[0].numbers[row] } else { 0 }
    }));
    if count > elements.cells.len() {
        arrays.push(numbers(elements, "marker", count, move |block, row| {
            if block == 0 { 0 } else { elements.blocks()[block].numbers[row] }
        }));
        let dimension = move |block: usize, _: usize| elements.blocks()[block].dimension as i64;
        arrays.push(numbers(elements, "dimension", count, dimension));
    }
    if let Some(labels) = mesh.labels {
        arrays.extend(labelled(elements, labels, count));
    }
    arrays
}

/// Returns the arrays that only a mesh of a domain has.
fn labelled<'a>(elements: &'a Elements<'_>, labels: &'a Labels, count: usize) -> Vec<Array<'a>> {
    let (dimension, coordinates) = (elements.mesh.dimension, elements.mesh.coordinates);
    let angle = of_cells(elements, move |cell| least_angle(dimension, coordinates, cell));
    let attribute: Record<'a> = Box::new(move |buffer, i| {
        let value = labels.attributes.get(i).copied().unwrap_or(f64::NAN);
        buffer.extend_from_slice(&value.to_le_bytes());
    });
    let mut arrays = vec![
        cell_array(Section::CellData, "attribute", "Float64", (count, 8), attribute),
        cell_array(Section::CellData, "least_angle", "Float64", (count, 8), angle),
    ];
    if count > elements.cells.len() {
        arrays.push(numbers(elements, "feature", count, move |block, row| match block {
            0 => -1,
            1 => i64::from(labels.faces.of[row]),
            _ => i64::from(labels.edges.of[row]),
        }));
        for (side, name) in ["inner_region", "outer_region"].into_iter().enumerate() {
            let of =
                move |block, row: usize| if block == 1 { i64::from(labels.sides[row][side]) } else { -1 };
            arrays.push(numbers(elements, name, count, of));
        }
    }
    arrays.extend(of_carriers(elements, labels));
    arrays
}

/// Returns the sizes, markers and carriers of nodes.
fn of_carriers<'a>(elements: &'a Elements<'_>, labels: &'a Labels) -> [Array<'a>; 4] {
    let points = labels.point_markers.iter().copied().zip(labels.carriers.iter().copied());
    let all: std::sync::Arc<[(i64, [i32; 2])]> = points.chain(elements.midpoint_labels(labels)).collect();
    let count = all.len();
    let marked = all.clone();
    let marker: Record<'a> = Box::new(move |buffer, i| buffer.extend_from_slice(&marked[i].0.to_le_bytes()));
    let on = |k: usize| -> Record<'a> {
        let all = all.clone();
        Box::new(move |buffer, i| buffer.extend_from_slice(&all[i].1[k].to_le_bytes()))
    };
    [
        of_nodes(elements, "size", &labels.sizes),
        cell_array(Section::PointData, "marker", "Int64", (count, 8), marker),
        cell_array(Section::PointData, "carrier_dimension", "Int32", (count, 4), on(0)),
        cell_array(Section::PointData, "carrier", "Int32", (count, 4), on(1)),
    ]
}

/// Returns an array of values at nodes.
fn of_nodes<'a>(elements: &'a Elements<'_>, name: &'a str, values: &'a [f64]) -> Array<'a> {
    let record: Record<'a> =
        Box::new(move |buffer, i| buffer.extend_from_slice(&elements.value(values, i).to_le_bytes()));
    cell_array(Section::PointData, name, "Float64", (elements.node_count(), 8), record)
}

/// Returns records of a value of cells, which lower elements do not have.
fn of_cells<'a>(elements: &'a Elements<'_>, value: impl Fn(&[u64]) -> f64 + Sync + 'a) -> Record<'a> {
    Box::new(move |buffer, i| {
        let value = if i < elements.cells.len() { value(elements.cells.corners(i)) } else { f64::NAN };
        buffer.extend_from_slice(&value.to_le_bytes());
    })
}

/// Returns an array of whole numbers of elements, given by their blocks and rows.
fn numbers<'a>(
    elements: &'a Elements<'_>,
    name: &'a str,
    count: usize,
    number: impl Fn(usize, usize) -> i64 + Sync + 'a,
) -> Array<'a> {
    let record: Record<'a> = Box::new(move |buffer, i| {
        let (block, row) = elements.at(i);
        buffer.extend_from_slice(&number(block, row).to_le_bytes());
    });
    cell_array(Section::CellData, name, "Int64", (count, 8), record)
}
