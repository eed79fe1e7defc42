//! `.msh` files of a mesh of a domain. Entities are the elements of the domain, and physical groups are their markers.
//!
//! Segments are curves, facets are surfaces, and components are volumes. In the plane, segments are curves and
//! components are surfaces. The tag of a segment or facet is its index in the domain plus one. The tag of a component
//! is its 1-based number. If the marker of an element or the attribute of a component is a positive integer, it is the
//! physical group. Other numbers are not groups, because Gmsh reads the sign of a group as a direction.

use std::collections::BTreeMap;
use std::io::Write;

use crate::write::error::WriteFault;
use crate::write::options::MshVersion;
use crate::write::records::{WriteProgress, push_float, push_indices, push_integer, write_records};
use septet_core::model::{Labels, MeshView};

/// The element types of Gmsh by dimension: line, triangle and tetrahedron.
const TYPES: [u8; 4] = [15, 1, 2, 4];

/// The elements of one dimension, grouped by entity.
pub struct Group<'a> {
    /// The dimension of the elements: 1, 2 or 3.
    dimension: usize,
    /// The points of the elements, `dimension + 1` per row.
    vertices: &'a [u64],
    /// For each tag, the physical group (0 for none) and the rows of its entity.
    entities: BTreeMap<u32, (u64, Vec<usize>)>,
}

impl<'a> Group<'a> {
    fn new(dimension: usize, vertices: &'a [u64], entity: impl Fn(usize) -> (u32, u64)) -> Self {
        let mut entities: BTreeMap<u32, (u64, Vec<usize>)> = BTreeMap::new();
        for row in 0..vertices.len() / (dimension + 1) {
            let (tag, physical) = entity(row);
            entities.entry(tag).or_insert((physical, Vec::new())).1.push(row);
        }
        Group { dimension, vertices, entities }
    }

    fn row(&self, row: usize) -> &[u64] {
        &self.vertices[row * (self.dimension + 1)..(row + 1) * (self.dimension + 1)]
    }
}

fn physical(marker: f64) -> u64 {
    if marker.fract() == 0.0 && marker > 0.0 && marker <= f64::from(i32::MAX) { marker as u64 } else { 0 }
}

/// Returns the curves, surfaces and volumes of a mesh. In the plane, there are no volumes.
pub fn groups<'a>(mesh: &MeshView<'a>, labels: &'a Labels) -> Vec<Group<'a>> {
    let of = |patches: &'a septet_core::model::Patches| {
        move |row: usize| (patches.of[row] + 1, physical(patches.markers[row] as f64))
    };
    let mut groups = Vec::new();
    if mesh.dimension == 3 {
        groups.push(Group::new(1, &labels.edges.vertices, of(&labels.edges)));
    }
    groups.push(Group::new(mesh.dimension - 1, &labels.faces.vertices, of(&labels.faces)));
    let region = |row: usize| (labels.regions[row], physical(labels.attributes[row]));
    groups.push(Group::new(mesh.dimension, mesh.cells, region));
    groups
}

/// Writes the section of entities of version 4.1.
pub fn write_entities(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    groups: &[Group<'_>],
) -> Result<(), WriteFault> {
    let count =
        |d: usize| groups.iter().filter(|g| g.dimension == d).map(|g| g.entities.len()).sum::<usize>();
    writeln!(out, "$Entities\n0 {} {} {}", count(1), count(2), count(3))?;
    for group in groups {
        for (tag, (physical, rows)) in &group.entities {
            let mut line = Vec::new();
            push_integer(&mut line, u64::from(*tag));
            let points = rows.iter().flat_map(|&row| group.row(row));
            for c in bounding_box(mesh, points.copied()) {
                line.push(b' ');
                push_float(&mut line, c);
            }
            if *physical > 0 {
                push_indices(&mut line, &[1, *physical], 0);
            } else {
                line.extend_from_slice(b" 0");
            }
            line.extend_from_slice(b" 0\n");
            out.write_all(&line)?;
        }
    }
    writeln!(out, "$EndEntities")?;
    Ok(())
}

/// Returns the three smallest and then the three largest coordinates of `points`, or zeros if there are none.
pub fn bounding_box(mesh: &MeshView<'_>, points: impl Iterator<Item = u64>) -> [f64; 6] {
    let mut found = None;
    for v in points {
        let point = mesh.place(v as usize);
        let (low, high) = found.get_or_insert(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]));
        for axis in 0..3 {
            low[axis] = f64::min(low[axis], point[axis]);
            high[axis] = f64::max(high[axis], point[axis]);
        }
    }
    let (low, high) = found.unwrap_or_default();
    [low[0], low[1], low[2], high[0], high[1], high[2]]
}

/// Returns the dimension and tag of the entity to which all nodes are assigned.
pub fn node_entity(mesh: &MeshView<'_>, groups: &[Group<'_>]) -> (usize, u32) {
    let cells = groups.iter().find(|g| g.dimension == mesh.dimension);
    (mesh.dimension, cells.and_then(|g| g.entities.keys().next().copied()).unwrap_or(1))
}

/// Writes the section of elements.
pub fn write_elements(
    out: &mut dyn Write,
    groups: &[Group<'_>],
    version: MshVersion,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let entities = groups.iter().flat_map(|g| g.entities.iter().map(move |e| (g, e)));
    let total: usize = entities.clone().map(|(_, (_, (_, rows)))| rows.len()).sum();
    writeln!(out, "$Elements")?;
    match version {
        MshVersion::V22 => writeln!(out, "{total}")?,
        MshVersion::V41 if total == 0 => writeln!(out, "0 0 0 0")?,
        MshVersion::V41 => writeln!(out, "{} {total} 1 {total}", entities.clone().count())?,
    }
    let mut first = 1;
    for (group, (tag, (physical, rows))) in entities {
        let kind = TYPES[group.dimension];
        let mut between = Vec::new();
        match version {
            MshVersion::V22 => write!(between, " {kind} 2 {physical} {tag}")?,
            MshVersion::V41 => writeln!(out, "{} {tag} {kind} {}", group.dimension, rows.len())?,
        }
        write_records(out, rows.len(), progress, |buffer, i| {
            push_integer(buffer, first + i as u64);
            buffer.extend_from_slice(&between);
            push_indices(buffer, group.row(rows[i]), 1);
            buffer.push(b'\n');
        })?;
        first += rows.len() as u64;
    }
    writeln!(out, "$EndElements")?;
    Ok(())
}
