//! A mesh as arrays for the writers.

use bytemuck::cast_slice;
use septet_geometry::point::{Point, Simplex};
use septet_meshing::domain::Domain;
use septet_meshing::mesh::{Carrier, Face, Mesh, OUTSIDE, point_markers, region_names};
use septet_meshing::space::Space;

use crate::model::{Labels, MeshView, Patches};

/// The arrays of a mesh.
#[derive(Clone, Debug)]
pub struct Labelled<'a, P: Point> {
    mesh: &'a Mesh<P>,
    cells: Vec<u64>,
    labels: Labels,
}

impl<'a, P: Space> Labelled<'a, P> {
    /// Collects the arrays of a mesh of this domain. All indices in the mesh must be valid.
    pub fn of(domain: &Domain<P>, mesh: &'a Mesh<P>) -> Self {
        let names = region_names(domain);
        let cells = mesh.cells.iter().flat_map(AsRef::as_ref).map(|&v| u64::from(v)).collect();
        let mut faces = Patches::default();
        let mut sides = Vec::with_capacity(mesh.faces.len());
        for face in &mesh.faces {
            let cells = inner_first(mesh, face);
            faces.vertices.extend(outward(mesh, face, cells[0]).as_ref().iter().map(|&v| u64::from(v)));
            faces.of.push(face.facet);
            faces.markers.push(face.marker);
            sides.push(cells.map(|c| if c == OUTSIDE { 0 } else { mesh.regions[c as usize] }));
        }
        let edges = Patches {
            vertices: mesh.edges.iter().flat_map(|e| e.vertices).map(u64::from).collect(),
            of: mesh.edges.iter().map(|e| e.segment).collect(),
            markers: mesh.edges.iter().map(|e| e.marker).collect(),
        };
        let labels = Labels {
            regions: mesh.regions.clone(),
            attributes: mesh.regions.iter().map(|&c| names[c as usize]).collect(),
            faces,
            sides,
            edges,
            point_markers: point_markers(domain, mesh),
            sizes: mesh.sizes.clone(),
            carriers: mesh.carriers.iter().map(|&c| carrier::<P>(c)).collect(),
        };
        Labelled { mesh, cells, labels }
    }

    /// Returns the view that writers take.
    pub fn view(&self) -> MeshView<'_> {
        MeshView {
            dimension: P::DIM,
            coordinates: cast_slice(&self.mesh.points),
            heights: None,
            cells: &self.cells,
            owner: None,
            owning_leaf: None,
            run: None,
            labels: Some(&self.labels),
        }
    }
}

fn carrier<P: Point>(carrier: Carrier) -> [i32; 2] {
    let number = match carrier {
        Carrier::Corner(i) | Carrier::Segment(i) | Carrier::Facet(i) => i as i32,
        Carrier::Volume => -1,
    };
    [carrier.dimension(P::DIM) as i32, number]
}

/// Returns the cells of a face: existing cells first, then by region.
fn inner_first<P: Point>(mesh: &Mesh<P>, face: &Face<P>) -> [u32; 2] {
    let mut cells = face.cells;
    cells.sort_by_key(|&c| (c == OUTSIDE, mesh.regions.get(c as usize).copied(), c));
    cells
}

/// Returns the vertices of a face in an order in which its normal points out of a cell. In the plane, the cell lies on
/// the left. Of three vertices, the smallest comes first.
fn outward<P: Point>(mesh: &Mesh<P>, face: &Face<P>, cell: u32) -> P::Facet {
    let Some(row) = mesh.cells.get(cell as usize) else { return face.vertices };
    let row = row.as_ref();
    let opposite = row.iter().position(|v| !face.vertices.as_ref().contains(v)).unwrap_or(0);
    let mut out = P::Facet::splat(0);
    let rest = row.iter().enumerate().filter(|&(i, _)| i != opposite);
    for (slot, (_, &v)) in out.as_mut().iter_mut().zip(rest) {
        *slot = v;
    }
    let vertices = out.as_mut();
    if opposite % 2 == 1 {
        vertices.swap(P::DIM - 2, P::DIM - 1);
    }
    if P::DIM == 3 {
        let least = (1..3).fold(0, |k, i| if vertices[i] < vertices[k] { i } else { k });
        vertices.rotate_left(least);
    }
    out
}
