//! `.xdmf`: XDMF 3 with all numbers inline. Cells, faces and edges are one topology of mixed types, in this order.
//!
//! The arrays `region` and `marker` have a number for each element: cells have marker 0, and faces and edges have region
//! 0. `dimension` tells them apart.

use std::io::{self, Write};

use crate::write::elements::{Block, Elements};
use crate::write::error::WriteFault;
use crate::write::options::{Order, WriteOptions};
use crate::write::records::{
    WriteProgress, push_float, push_indices, push_integer, push_point, push_signed, write_records,
};
use septet_core::model::MeshView;

use super::vtu::escaped;

/// Writes a mesh.
pub fn write(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    options: &WriteOptions<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let elements = &Elements::of(mesh, options.order)?;
    let count = elements.node_count();
    writeln!(out, "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n<Domain>")?;
    writeln!(out, "<Grid Name=\"mesh\" GridType=\"Uniform\">")?;
    writeln!(out, "<Geometry GeometryType=\"XYZ\">")?;
    item(out, "Float", &format!("{count} 3"), |out| {
        write_records(out, count, progress, |buffer, i| {
            push_point(buffer, &elements.place(i), b' ', true);
            buffer.push(b'\n');
        })
    })?;
    writeln!(out, "</Geometry>")?;
    write_topology(out, elements, progress)?;
    if let Some(labels) = mesh.labels {
        attribute(out, ("size", "Node"), "Float", count, progress, |buffer, i| {
            push_float(buffer, elements.value(&labels.sizes, i));
        })?;
    }
    for column in options.point_data {
        attribute(out, (&column.name, "Node"), "Float", count, progress, |buffer, i| {
            push_float(buffer, elements.value(&column.values, i));
        })?;
    }
    let total = elements.len();
    let number = |i: usize, of_cells: bool| {
        let (block, row) = elements.at(i);
        if (block == 0) == of_cells { elements.blocks()[block].numbers[row] } else { 0 }
    };
    attribute(out, ("region", "Cell"), "Int", total, progress, |b, i| push_signed(b, number(i, true)))?;
    attribute(out, ("marker", "Cell"), "Int", total, progress, |b, i| push_signed(b, number(i, false)))?;
    attribute(out, ("dimension", "Cell"), "Int", total, progress, |b, i| {
        push_integer(b, elements.blocks()[elements.at(i).0].dimension as u64);
    })?;
    writeln!(out, "</Grid>\n</Domain>\n</Xdmf>")?;
    Ok(())
}

/// Returns the number of a type of elements in XDMF.
fn type_number(dimension: usize, order: Order) -> u64 {
    match (order, dimension) {
        (Order::One, 1) => 2,
        (Order::One, 2) => 4,
        (Order::One, _) => 6,
        (Order::Two, 1) => 0x22,
        (Order::Two, 2) => 0x24,
        (Order::Two, _) => 0x26,
    }
}

fn write_topology(
    out: &mut dyn Write,
    elements: &Elements<'_>,
    progress: &mut WriteProgress<'_>,
) -> io::Result<()> {
    // A line states its number of points, because its type is that of a polyline.
    let states_width = |dimension: usize| dimension == 1 && elements.order == Order::One;
    let entries =
        |block: &Block<'_>| block.len() * (block.width + 1 + usize::from(states_width(block.dimension)));
    let length: usize = elements.blocks().into_iter().map(entries).sum();
    writeln!(out, "<Topology TopologyType=\"Mixed\" NumberOfElements=\"{}\">", elements.len())?;
    item(out, "Int", &length.to_string(), |out| {
        for block in elements.blocks() {
            write_records(out, block.len(), progress, |buffer, i| {
                push_integer(buffer, type_number(block.dimension, elements.order));
                if states_width(block.dimension) {
                    push_indices(buffer, &[block.width as u64], 0);
                }
                push_indices(buffer, block.row(i), 0);
                buffer.push(b'\n');
            })?;
        }
        Ok(())
    })?;
    writeln!(out, "</Topology>")
}

/// Writes a list of numbers.
fn item(
    out: &mut dyn Write,
    kind: &str,
    dimensions: &str,
    body: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    write!(out, "<DataItem DataType=\"{kind}\" Dimensions=\"{dimensions}\" ")?;
    writeln!(out, "Format=\"XML\" Precision=\"8\">")?;
    body(out)?;
    writeln!(out, "</DataItem>")
}

/// Writes an array with a number for each node or element.
fn attribute(
    out: &mut dyn Write,
    (name, centre): (&str, &str),
    kind: &str,
    count: usize,
    progress: &mut WriteProgress<'_>,
    push: impl Fn(&mut Vec<u8>, usize) + Sync,
) -> io::Result<()> {
    let name = escaped(name);
    writeln!(out, "<Attribute Name=\"{name}\" AttributeType=\"Scalar\" Center=\"{centre}\">")?;
    item(out, kind, &count.to_string(), |out| {
        write_records(out, count, progress, |buffer, i| {
            push(buffer, i);
            buffer.push(b'\n');
        })
    })?;
    writeln!(out, "</Attribute>")
}
