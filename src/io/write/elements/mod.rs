//! A mesh as elements of all dimensions: cells, faces and edges, each with the number of its group.
//!
//! In a mesh of a domain, faces lie on facets, edges on segments, and groups are regions and markers. Of another
//! triangulation, the cells are region 1 and the facets of the hull have marker 1.
//!
//! Quadratic elements are straight: each edge of the mesh has one node at its midpoint, after all points. In an element,
//! midpoints follow the corners in the order of VTK, which most formats share: (0, 1), (1, 2), (0, 2), (0, 3), (1, 3),
//! (2, 3).

mod groups;
mod sides;
#[cfg(test)]
mod tests;

use std::borrow::Cow;

use septet_core::model::{Labels, MeshView};

use super::options::Order;
use super::topology::{self, TopologyError};

pub use groups::{Groups, Kind, region_numbers};
pub use sides::Side;

/// The edges of an element between its corners, in the order of VTK. An element of dimension d has the first 1, 3 or 6.
static EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

/// The number of nodes of an element.
pub const fn width(dimension: usize, order: Order) -> usize {
    let corners = dimension + 1;
    match order {
        Order::One => corners,
        Order::Two => corners + corners * dimension / 2,
    }
}

/// The elements of one dimension.
pub struct Block<'a> {
    /// The dimension of the elements: 1, 2 or 3.
    pub dimension: usize,
    /// The number of nodes of an element.
    pub width: usize,
    /// The nodes of all elements, corners first.
    nodes: Cow<'a, [u64]>,
    /// The number of the group of each element.
    pub numbers: Vec<i64>,
    /// The groups.
    pub groups: Groups,
}

impl<'a> Block<'a> {
    fn new(kind: Kind, dimension: usize, nodes: Cow<'a, [u64]>, numbers: Vec<i64>) -> Self {
        let groups = Groups::of(kind, &numbers);
        Block { dimension, width: dimension + 1, nodes, numbers, groups }
    }

    /// Returns the number of elements.
    pub fn len(&self) -> usize {
        self.numbers.len()
    }

    /// Returns the nodes of an element.
    pub fn row(&self, row: usize) -> &[u64] {
        &self.nodes[row * self.width..(row + 1) * self.width]
    }

    /// Returns the corners of an element.
    pub fn corners(&self, row: usize) -> &[u64] {
        &self.row(row)[..=self.dimension]
    }

    /// Returns the elements of each group, in the order of the groups.
    pub fn rows_of_groups(&self) -> Vec<Vec<usize>> {
        let mut rows = vec![Vec::new(); self.groups.len()];
        for (row, number) in self.numbers.iter().enumerate() {
            rows[self.groups.position(*number)].push(row);
        }
        rows
    }

    /// Adds the nodes at the midpoints of edges.
    fn raise(&mut self, points: u64, midpoints: &[[u64; 2]]) {
        let width = width(self.dimension, Order::Two);
        let mut nodes = Vec::with_capacity(self.len() * width);
        for row in 0..self.len() {
            nodes.extend_from_slice(self.row(row));
            // The search succeeds, because the list has all edges of all elements.
            let middle = |edge| midpoints.binary_search(&edge).map_or(0, |at| points + at as u64);
            nodes.extend(edges_of(self.row(row)).map(middle));
        }
        (self.nodes, self.width) = (Cow::Owned(nodes), width);
    }
}

/// Returns the edges between the corners of a simplex, each from its smaller point.
fn edges_of(corners: &[u64]) -> impl Iterator<Item = [u64; 2]> {
    let dimension = corners.len() - 1;
    let edges = &EDGES[..corners.len() * dimension / 2];
    edges.iter().map(move |&[i, j]| [corners[i].min(corners[j]), corners[i].max(corners[j])])
}

/// A mesh as elements.
pub struct Elements<'a> {
    /// The mesh.
    pub mesh: MeshView<'a>,
    /// The order of the elements.
    pub order: Order,
    /// The ends of the edges whose midpoints are nodes, after the points. Empty for linear elements.
    pub midpoints: Vec<[u64; 2]>,
    /// The cells, with the numbers of their regions.
    pub cells: Block<'a>,
    /// The triangles on facets (in the plane: the edges on segments), with their markers.
    pub faces: Block<'a>,
    /// The edges on segments, with their markers; empty in the plane.
    pub edges: Block<'a>,
}

impl<'a> Elements<'a> {
    /// Collects the elements of a mesh.
    ///
    /// # Errors
    /// Returns [`TopologyError`] if the cells do not form a manifold, which is found only if a list of edges or of hull
    /// facets is needed.
    pub fn of(mesh: &MeshView<'a>, order: Order) -> Result<Self, TopologyError> {
        let d = mesh.dimension;
        let (faces, markers, regions) = if let Some(labels) = mesh.labels {
            let faces = Cow::Borrowed(&labels.faces.vertices[..]);
            (faces, labels.faces.markers.clone(), region_numbers(labels))
        } else {
            let hull = topology::hull(d, mesh.point_count(), mesh.cells)?;
            let count = hull.len() / d;
            (Cow::Owned(hull), vec![1; count], vec![1; mesh.cell_count()])
        };
        let of_segments = mesh.labels.map_or((&[][..], Vec::new()), |labels: &'a Labels| {
            (&labels.edges.vertices[..], labels.edges.markers.clone())
        });
        let mut elements = Elements {
            mesh: *mesh,
            order,
            midpoints: Vec::new(),
            cells: Block::new(Kind::Region, d, Cow::Borrowed(mesh.cells), regions),
            faces: Block::new(Kind::Marker, d - 1, faces, markers),
            edges: Block::new(Kind::Segment, 1, Cow::Borrowed(of_segments.0), of_segments.1),
        };
        if order == Order::Two {
            elements.raise()?;
        }
        Ok(elements)
    }

    fn raise(&mut self) -> Result<(), TopologyError> {
        let points = self.mesh.point_count();
        let mut edges = topology::edges(self.mesh.dimension, points, self.mesh.cells)?;
        for block in [&self.faces, &self.edges] {
            edges.extend((0..block.len()).flat_map(|row| edges_of(block.corners(row))));
        }
        edges.sort_unstable();
        edges.dedup();
        for block in [&mut self.cells, &mut self.faces, &mut self.edges] {
            block.raise(points as u64, &edges);
        }
        self.midpoints = edges;
        Ok(())
    }

    /// Returns the blocks of elements, from cells down.
    pub fn blocks(&self) -> [&Block<'a>; 3] {
        [&self.cells, &self.faces, &self.edges]
    }

    /// Returns the number of nodes.
    pub fn node_count(&self) -> usize {
        self.mesh.point_count() + self.midpoints.len()
    }

    /// Returns the number of elements of all dimensions.
    pub fn len(&self) -> usize {
        self.blocks().iter().map(|block| block.len()).sum()
    }

    /// Returns the block of an element, as a position in [`Elements::blocks`], and its row there.
    pub fn at(&self, mut element: usize) -> (usize, usize) {
        for (block, own) in self.blocks().iter().enumerate() {
            if element < own.len() {
                return (block, element);
            }
            element -= own.len();
        }
        (2, element)
    }

    /// Returns the place of a node in space.
    pub fn place(&self, node: usize) -> [f64; 3] {
        match self.ends(node) {
            None => self.mesh.place(node),
            Some(ends) => {
                let [a, b] = ends.map(|v| self.mesh.place(v as usize));
                std::array::from_fn(|axis| middle(a[axis], b[axis]))
            }
        }
    }

    /// Returns the value at a node of a function that is given at the points, and linear along edges.
    pub fn value(&self, values: &[f64], node: usize) -> f64 {
        match self.ends(node) {
            None => values[node],
            Some([a, b]) => middle(values[a as usize], values[b as usize]),
        }
    }

    /// Returns the ends of the edge whose midpoint a node is, or `None` for a point.
    fn ends(&self, node: usize) -> Option<[u64; 2]> {
        node.checked_sub(self.mesh.point_count()).map(|at| self.midpoints[at])
    }

    /// Returns the marker, and the dimension and index of the carrier, of each midpoint.
    pub fn midpoint_labels(&self, labels: &Labels) -> Vec<(i64, [i32; 2])> {
        let mut found = vec![(0, [self.mesh.dimension as i32, -1]); self.midpoints.len()];
        // Edges on segments also belong to faces, so they come last.
        for (block, of) in [(&self.faces, &labels.faces.of), (&self.edges, &labels.edges.of)] {
            for (row, of) in of.iter().enumerate() {
                for node in &block.row(row)[block.dimension + 1..] {
                    let at = *node as usize - self.mesh.point_count();
                    found[at] = (block.numbers[row], [block.dimension as i32, *of as i32]);
                }
            }
        }
        found
    }
}

/// Returns the middle of two numbers, the same for either order. The sum of two large numbers does not overflow.
fn middle(a: f64, b: f64) -> f64 {
    a / 2.0 + b / 2.0
}
