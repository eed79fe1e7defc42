//! The polygons beside a segment while it is inserted.

/// The neighbour beyond an edge of a chain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beyond {
    /// The cell of the chain before the segment was inserted, and the corner opposite the edge.
    pub(super) old: (u32, usize),
    /// The cell beyond, or `NONE`, and its corner opposite the edge.
    pub(super) cell: u32,
    pub(super) corner: usize,
    /// Whether the edge is a constraint.
    pub(super) is_constrained: bool,
    /// The position of the same edge in the chain, if both its sides lie in the polygon.
    pub(super) twin: Option<u32>,
}

/// A chain of vertices from one end of the segment to the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Chain {
    pub(super) vertices: Vec<u32>,
    pub(super) edges: Vec<Beyond>,
}

impl Chain {
    pub(super) fn start(&mut self, vertex: u32) {
        self.vertices.clear();
        self.edges.clear();
        self.vertices.push(vertex);
    }

    pub(super) fn reverse(&mut self) {
        self.vertices.reverse();
        self.edges.reverse();
        let last = self.edges.len() as u32;
        for edge in &mut self.edges {
            edge.twin = edge.twin.map(|i| last - 1 - i);
        }
    }
}

/// The polygons on the two sides of a segment. Memory is used again for the next segment.
#[derive(Clone, Debug, Default)]
pub(super) struct Cavity {
    pub(super) left: Chain,
    pub(super) right: Chain,
    pub(super) taken: Vec<u32>,
    /// Parts of a chain that are not filled yet: the first and last position, and the cell and corner at the base.
    pub(super) parts: Vec<(usize, usize, u32, usize)>,
    /// The new cell and corner at each edge of a chain whose other side lies in the polygon as well.
    pub(super) inner: Vec<(u32, usize)>,
}
