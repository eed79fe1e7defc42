//! `.bdf`: bulk data of Nastran, with ids from 1. Cells, then faces, are elements, and the ids of their properties are
//! the tags of regions and markers. Comments name them. The properties themselves belong to the solver's input.
//!
//! Coordinates are in the long fields of Nastran, which have 16 characters. In the plane, faces are rods between their
//! corners.

use std::io::{self, Write};

use crate::write::elements::{Block, Elements};
use crate::write::error::WriteFault;
use crate::write::options::WriteOptions;
use crate::write::records::{WriteProgress, push_float_within, write_records};
use septet_core::model::MeshView;

/// The largest id that fits into a field.
const LARGEST: u64 = 99_999_999;

/// The number of fields in a line, without its name and the mark of its continuation.
const FIELDS: usize = 8;

/// Writes a mesh.
pub fn write(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    options: &WriteOptions<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let elements = &Elements::of(mesh, options.order)?;
    let blocks = [&elements.cells, &elements.faces];
    let tags = blocks.iter().flat_map(|b| (0..b.groups.len()).map(move |at| u64::from(b.groups.tag(at))));
    let most = tags.chain([elements.node_count() as u64, elements.len() as u64]).max().unwrap_or(0);
    if most > LARGEST {
        return Err(WriteFault::TooLarge(most));
    }
    writeln!(out, "$ septet")?;
    for block in blocks {
        for at in 0..block.groups.len() {
            let (tag, name) = (block.groups.tag(at), block.groups.name(at));
            writeln!(out, "$ property {tag} of {}: {name}", card(block))?;
        }
    }
    writeln!(out, "BEGIN BULK")?;
    write_records(out, elements.node_count(), progress, |buffer, i| push_grid(buffer, i, elements.place(i)))?;
    let mut first = 1;
    for block in blocks {
        write_block(out, block, first, progress)?;
        first += block.len() as u64;
    }
    writeln!(out, "ENDDATA")?;
    Ok(())
}

/// Returns the name of the elements of a block.
fn card(block: &Block<'_>) -> &'static str {
    match (block.dimension, block.width) {
        (1, _) => "CROD",
        (2, 3) => "CTRIA3",
        (2, _) => "CTRIA6",
        _ => "CTETRA",
    }
}

/// Appends a point in long fields: two lines with a star each. The second field is the coordinate system.
fn push_grid(buffer: &mut Vec<u8>, node: usize, place: [f64; 3]) {
    let [x, y, z] = place.map(real);
    // Writing to a vector cannot fail.
    let _ = writeln!(buffer, "GRID*   {:<16}{:16}{x:<16}{y:<16}", node + 1, "");
    let _ = writeln!(buffer, "*       {z}");
}

/// Returns a number with a point, which Nastran demands, in at most 16 characters.
fn real(value: f64) -> String {
    let mut text = Vec::new();
    push_float_within(&mut text, value, 15);
    if !text.contains(&b'.') {
        let end = text.iter().position(|b| *b == b'e').unwrap_or(text.len());
        text.insert(end, b'.');
    }
    text.make_ascii_uppercase();
    String::from_utf8_lossy(&text).into_owned()
}

fn write_block(
    out: &mut dyn Write,
    block: &Block<'_>,
    first: u64,
    progress: &mut WriteProgress<'_>,
) -> io::Result<()> {
    let name = card(block);
    write_records(out, block.len(), progress, |buffer, i| {
        let tag = u64::from(block.groups.tag(block.groups.position(block.numbers[i])));
        let nodes = if block.dimension == 1 { block.corners(i) } else { block.row(i) };
        let fields = [first + i as u64, tag].into_iter().chain(nodes.iter().map(|node| node + 1));
        let fields: Vec<u64> = fields.collect();
        let count = fields.len();
        for (line, fields) in fields.chunks(FIELDS).enumerate() {
            let name = if line == 0 { name } else { "+" };
            // Writing to a vector cannot fail.
            let _ = write!(buffer, "{name:<8}");
            for field in fields {
                let _ = write!(buffer, "{field:<8}");
            }
            if (line + 1) * FIELDS < count {
                buffer.push(b'+');
            }
            buffer.push(b'\n');
        }
    })
}
