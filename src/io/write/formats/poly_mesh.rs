//! `polyMesh`: the folder of a mesh of `OpenFOAM`, text, with the files `points`, `faces`, `owner`,
//! `neighbour`, `boundary`, `cellZones` and `faceZones`.
//!
//! Faces between cells come first, in the order of `OpenFOAM`: by the smaller cell, then by the larger one, and out of
//! the smaller one. Boundary faces follow, a patch for each marker, out of their cells. A region is a zone of cells. The faces
//! of a marker that lie between two cells are a zone of faces.

use std::io::{self, Write};

use crate::write::elements::Elements;
use crate::write::error::{OutputError, WriteFault};
use crate::write::folder::Pieces;
use crate::write::options::Order;
use crate::write::records::{WriteProgress, push_integer, push_point, write_records};
use crate::write::topology::{self, OUTSIDE};
use septet_core::model::MeshView;

/// The files of the folder.
pub const FILES: [&str; 7] = ["points", "faces", "owner", "neighbour", "boundary", "cellZones", "faceZones"];

/// A face: its vertices, out of its owner.
struct Face {
    vertices: [u64; 3],
    owner: u64,
    /// The other cell, or [`OUTSIDE`].
    neighbour: u64,
    /// The position of the group of its marker, if it lies on a facet.
    group: Option<usize>,
}

/// The faces in the order of the file, and the number of those between cells.
struct Faces {
    all: Vec<Face>,
    inner: usize,
    /// The names of the patches, and their numbers of faces.
    patches: Vec<(String, usize)>,
}

/// Writes a mesh in space into a folder.
pub fn write(
    folder: &Pieces,
    mesh: &MeshView<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), OutputError> {
    let target = folder.target();
    let topology = |error| WriteFault::Topology(error).at(target);
    let elements = &Elements::of(mesh, Order::One).map_err(topology)?;
    let faces = &collect(elements).map_err(|fault| fault.at(target))?;
    let cells = mesh.cell_count();
    folder.write_named("points", |out| {
        head(out, "vectorField", "points", "")?;
        list(out, mesh.point_count(), progress, |buffer, i| {
            buffer.push(b'(');
            push_point(buffer, &mesh.place(i), b' ', true);
            buffer.extend_from_slice(b")\n");
        })
    })?;
    folder.write_named("faces", |out| {
        head(out, "faceList", "faces", "")?;
        list(out, faces.all.len(), progress, |buffer, i| {
            let [a, b, c] = faces.all[i].vertices;
            // Writing to a vector cannot fail.
            let _ = writeln!(buffer, "3({a} {b} {c})");
        })
    })?;
    let (count, inner) = (faces.all.len(), faces.inner);
    let note =
        format!("nPoints:{}  nCells:{cells}  nFaces:{count}  nInternalFaces:{inner}", mesh.point_count());
    for (name, length) in [("owner", count), ("neighbour", inner)] {
        folder.write_named(name, |out| {
            head(out, "labelList", name, &note)?;
            list(out, length, progress, |buffer, i| {
                let face = &faces.all[i];
                push_integer(buffer, if name == "owner" { face.owner } else { face.neighbour });
                buffer.push(b'\n');
            })
        })?;
    }
    folder.write_named("boundary", |out| Ok(write_boundary(out, faces)?))?;
    folder.write_named("cellZones", |out| Ok(write_cell_zones(out, elements)?))?;
    folder.write_named("faceZones", |out| Ok(write_face_zones(out, elements, faces)?))
}

/// Returns the vertices of the side of a cell that is opposite to a corner, out of the cell.
fn outward(cell: &[u64], opposite: usize) -> [u64; 3] {
    let [a, b, c] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]][opposite];
    [cell[a], cell[b], cell[c]]
}

fn collect(elements: &Elements<'_>) -> Result<Faces, WriteFault> {
    let mesh = &elements.mesh;
    let neighbours = topology::adjacency(3, mesh.point_count(), mesh.cells)?.neighbours;
    let mut groups = vec![None; neighbours.len()];
    let of_markers = &elements.faces.groups;
    elements.each_side(|side, face| {
        groups[4 * side.cell + side.opposite] = Some(of_markers.position(elements.faces.numbers[face]));
    });
    let mut faces = Vec::new();
    for (at, &neighbour) in neighbours.iter().enumerate() {
        let (owner, opposite) = ((at / 4) as u64, at % 4);
        if neighbour > owner {
            let vertices = outward(elements.cells.corners(at / 4), opposite);
            faces.push(Face { vertices, owner, neighbour, group: groups[at] });
        }
    }
    // The outside comes last. Its faces without a marker, which a conforming mesh does not have, come after all patches.
    let patch = |face: &Face| {
        if face.neighbour == OUTSIDE { face.group.map_or(usize::MAX, |group| group + 1) } else { 0 }
    };
    faces.sort_by_key(|face| (patch(face), face.owner, face.neighbour, face.vertices));
    let inner = faces.partition_point(|face| patch(face) == 0);
    let mut patches: Vec<(String, usize)> = Vec::new();
    for face in &faces[inner..] {
        let name = face.group.map_or_else(|| "unmarked".to_owned(), |group| of_markers.name(group));
        match patches.last_mut() {
            Some((last, count)) if *last == name => *count += 1,
            _ => patches.push((name, 1)),
        }
    }
    Ok(Faces { all: faces, inner, patches })
}

/// Writes the head of a file.
fn head(out: &mut dyn Write, class: &str, object: &str, note: &str) -> io::Result<()> {
    write!(out, "FoamFile\n{{\n    version     2.0;\n    format      ascii;\n    class       {class};\n")?;
    if !note.is_empty() {
        writeln!(out, "    note        \"{note}\";")?;
    }
    writeln!(out, "    location    \"constant/polyMesh\";\n    object      {object};\n}}\n")
}

/// Writes a list of records.
fn list(
    out: &mut dyn Write,
    count: usize,
    progress: &mut WriteProgress<'_>,
    record: impl Fn(&mut Vec<u8>, usize) + Sync,
) -> Result<(), WriteFault> {
    write!(out, "{count}\n(\n")?;
    write_records(out, count, progress, record)?;
    Ok(writeln!(out, ")")?)
}

fn write_boundary(out: &mut dyn Write, faces: &Faces) -> io::Result<()> {
    head(out, "polyBoundaryMesh", "boundary", "")?;
    write!(out, "{}\n(\n", faces.patches.len())?;
    let mut start = faces.inner;
    for (name, count) in &faces.patches {
        writeln!(out, "    {name}\n    {{\n        type            patch;")?;
        writeln!(out, "        nFaces          {count};\n        startFace       {start};\n    }}")?;
        start += count;
    }
    writeln!(out, ")")
}

/// Writes the members of a zone.
fn labels(out: &mut dyn Write, key: &str, members: &[usize]) -> io::Result<()> {
    write!(out, "        {key} List<label>\n{}\n(\n", members.len())?;
    members.iter().try_for_each(|member| writeln!(out, "{member}"))?;
    writeln!(out, ")\n;")
}

fn write_cell_zones(out: &mut dyn Write, elements: &Elements<'_>) -> io::Result<()> {
    head(out, "regIOobject", "cellZones", "")?;
    let zones = elements.cells.rows_of_groups();
    write!(out, "{}\n(\n", zones.len())?;
    for (at, cells) in zones.iter().enumerate() {
        writeln!(out, "    {}\n    {{\n        type            cellZone;", elements.cells.groups.name(at))?;
        labels(out, "cellLabels     ", cells)?;
        writeln!(out, "    }}")?;
    }
    writeln!(out, ")")
}

fn write_face_zones(out: &mut dyn Write, elements: &Elements<'_>, faces: &Faces) -> io::Result<()> {
    head(out, "regIOobject", "faceZones", "")?;
    let groups = &elements.faces.groups;
    let mut zones = vec![Vec::new(); groups.len()];
    for (at, face) in faces.all[..faces.inner].iter().enumerate() {
        if let Some(group) = face.group {
            zones[group].push(at);
        }
    }
    let zones: Vec<(usize, Vec<usize>)> =
        zones.into_iter().enumerate().filter(|(_, zone)| !zone.is_empty()).collect();
    write!(out, "{}\n(\n", zones.len())?;
    for (group, zone) in &zones {
        writeln!(out, "    {}\n    {{\n        type            faceZone;", groups.name(*group))?;
        labels(out, "faceLabels     ", zone)?;
        write!(out, "        flipMap         List<bool>\n{}\n(\n", zone.len())?;
        zone.iter().try_for_each(|_| writeln!(out, "0"))?;
        writeln!(out, ")\n;\n    }}")?;
    }
    writeln!(out, ")")
}
