//! Cells between walls: a tetrahedralization of a domain whose faces on facets and edges on segments are known.
//!
//! **Statement.** Every cell is positive (exact sign). Two cells share each face that is not on the hull. A face that
//! lies on a patch of a facet is a *wall*: the cells on its two sides know the patch. An edge of the input is *kept*:
//! it is an edge of the cells until it is divided.
//!
//! **Work and depth.** O(1) for each step around an edge.

use std::collections::BTreeMap;

use glam::DVec3;
use septet_geometry::point::Simplex;

use crate::constrained::cells::{NONE, edges_of, face_of, key};
use crate::constrained::recovered::{Line, Recovered};
use crate::constrained::segments::acute;
use crate::generate::{CellLabels, Delaunay, GeneratedMesh, Subsegment, Vertices};
use crate::mesh::{Carrier, OUTSIDE};
use crate::points::conflicts::Site;
use crate::space::{Space, ascending};

/// A face of a cell: the one opposite the vertex in a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Side {
    pub(super) cell: u32,
    pub(super) slot: usize,
}

/// What a cell has in its slots: vertices, and for the faces opposite them the cells beyond and the patches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub(super) corners: [u32; 4],
    /// The cells beyond the faces, or [`NONE`].
    pub(super) across: [u32; 4],
    /// The patches that contain the faces, or [`NONE`].
    pub(super) walls: [u32; 4],
    /// The component of the domain.
    pub(super) label: u32,
}

/// A row that no cell uses.
pub(super) const FREE: Row = Row { corners: [NONE; 4], across: [NONE; 4], walls: [NONE; 4], label: NONE };

/// A face around a region of cells, positive towards it, with the cell inside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outer {
    pub(super) corners: [u32; 3],
    pub(super) side: Side,
}

/// The cells of a domain.
#[derive(Debug)]
pub(super) struct Solid {
    pub(super) at: Vec<DVec3>,
    pub(super) carriers: Vec<Carrier>,
    pub(super) rows: Vec<Row>,
    pub(super) free: Vec<u32>,
    /// The edges of the input.
    pub(super) lines: Vec<Line>,
    /// The lines at each vertex.
    pub(super) lines_at: Vec<Vec<u32>>,
    /// The edges that must be kept, with their lines.
    pub(super) kept: BTreeMap<[u32; 2], u32>,
    /// One cell of each fan, at kept edges that have several fans of cells with walls and the outside between them.
    pub(super) fans: BTreeMap<[u32; 2], Vec<u32>>,
    /// The facet of each patch.
    pub(super) facets: Vec<u32>,
    /// A point and the unit normal of the plane of each patch.
    pub(super) planes: Vec<[DVec3; 2]>,
    /// The last cavity that contains each cell.
    pub(super) inside: Vec<u32>,
    /// The last cavity for which each cell was examined.
    pub(super) seen: Vec<u32>,
    /// Whether each vertex was removed.
    pub(super) gone: Vec<bool>,
    /// The number of the present cavity.
    pub(super) epoch: u32,
    /// The number of cells that were examined.
    pub(super) visits: u64,
}

impl Solid {
    pub(super) fn new(made: &Recovered) -> Self {
        let patch = |face| made.faces.get(&key(face)).copied().unwrap_or(NONE);
        let row = |(&corners, &label)| {
            let walls = [0, 1, 2, 3].map(|slot| patch(face_of(&corners, slot)));
            Row { corners, across: [NONE; 4], walls, label }
        };
        let rows: Vec<Row> = made.cells.iter().zip(&made.labels).map(row).collect();
        let count = rows.len();
        let mut lines_at = vec![Vec::new(); made.at.len()];
        for (line, ends) in (0u32..).zip(made.lines.iter().map(|l| l.ends)) {
            for v in ends {
                lines_at[v as usize].push(line);
            }
        }
        for (v, &(_, line)) in made.edges.iter().flat_map(|e| e.0.map(|v| (v, e))) {
            if v >= made.given && !lines_at[v as usize].contains(&line) {
                lines_at[v as usize].push(line);
            }
        }
        let mut solid = Solid {
            lines: made.lines.clone(),
            lines_at,
            gone: vec![false; made.at.len()],
            at: made.at.clone(),
            carriers: made.carriers.clone(),
            rows,
            free: Vec::new(),
            kept: made.edges.iter().copied().collect(),
            fans: BTreeMap::new(),
            facets: made.facets.clone(),
            planes: made.planes.clone(),
            inside: vec![0; count],
            seen: vec![0; count],
            epoch: 0,
            visits: 0,
        };
        solid.connect();
        solid.find_fans();
        solid
    }

    /// Joins the cells that share a face.
    fn connect(&mut self) {
        let mut faces: Vec<([u32; 3], u32, usize)> = Vec::with_capacity(4 * self.rows.len());
        for (cell, row) in (0u32..).zip(&self.rows) {
            faces.extend((0..4).map(|slot| (key(face_of(&row.corners, slot)), cell, slot)));
        }
        faces.sort_unstable();
        for pair in faces.windows(2).filter(|w| w[0].0 == w[1].0) {
            let [(_, a, i), (_, b, j)] = [pair[0], pair[1]];
            self.rows[a as usize].across[i] = b;
            self.rows[b as usize].across[j] = a;
        }
    }

    /// Finds the kept edges with several fans of cells.
    pub(super) fn find_fans(&mut self) {
        self.fans.clear();
        let mut at: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
        for (cell, row) in (0u32..).zip(&self.rows) {
            for edge in edges_of(&row.corners).into_iter().filter(|e| self.kept.contains_key(e)) {
                at.entry(edge).or_default().push(cell);
            }
        }
        for (edge, mut cells) in at {
            let mut firsts = Vec::new();
            while let Some(&first) = cells.first() {
                let fan = self.fan(first, edge);
                cells.retain(|c| !fan.contains(c));
                firsts.push(first);
            }
            if firsts.len() > 1 {
                self.fans.insert(edge, firsts);
            }
        }
    }

    pub(super) fn corners(&self, cell: u32) -> &[u32; 4] {
        &self.rows[cell as usize].corners
    }

    /// Returns the vertices of a face, positive towards the cell.
    pub(super) fn face(&self, side: Side) -> [u32; 3] {
        face_of(self.corners(side.cell), side.slot)
    }

    /// Returns the faces of a cell, positive towards it.
    pub(super) fn faces(&self, cell: u32) -> [Outer; 4] {
        [0, 1, 2, 3].map(|slot| Outer { corners: self.face(Side { cell, slot }), side: Side { cell, slot } })
    }

    pub(super) fn points<const N: usize>(&self, vertices: [u32; N]) -> [DVec3; N] {
        vertices.map(|v| self.at[v as usize])
    }

    /// Returns the cells around an edge of a cell that faces connect, walls included.
    pub(super) fn fan(&self, cell: u32, edge: [u32; 2]) -> Vec<u32> {
        let mut found = vec![cell];
        let mut next = 0;
        while next < found.len() {
            let row = &self.rows[found[next] as usize];
            for slot in 0..4 {
                let other = row.across[slot];
                if !edge.contains(&row.corners[slot]) && other != NONE && !found.contains(&other) {
                    found.push(other);
                }
            }
            next += 1;
        }
        found
    }

    /// Returns all cells around a kept edge of a cell.
    pub(super) fn around(&self, cell: u32, edge: [u32; 2]) -> Vec<u32> {
        let mut found = self.fan(cell, edge);
        for &other in self.fans.get(&ascending(edge)).into_iter().flatten() {
            if !found.contains(&other) && edge.iter().all(|v| self.corners(other).contains(v)) {
                found.extend(self.fan(other, edge));
            }
        }
        found
    }

    /// Returns the next wall around an edge of a wall, on the side of its cell.
    pub(super) fn next_wall(&self, side: Side, edge: [u32; 2]) -> Option<Side> {
        let Side { mut cell, mut slot } = side;
        for _ in 0..self.rows.len() {
            let row = &self.rows[cell as usize];
            let other = (0..4).find(|&i| i != slot && !edge.contains(&row.corners[i]))?;
            if row.walls[other] != NONE {
                return Some(Side { cell, slot: other });
            }
            let next = row.across[other];
            if next == NONE {
                return None;
            }
            // In the next cell, the shared face is opposite the vertex that this cell does not have.
            slot = self.corners(next).iter().position(|v| !row.corners.contains(v))?;
            cell = next;
        }
        None
    }

    /// Returns whether a face is a wall.
    pub(super) fn is_wall(&self, side: Side) -> bool {
        self.rows[side.cell as usize].walls[side.slot] != NONE
    }

    /// Returns whether an edge is kept.
    pub(super) fn is_kept(&self, [a, b]: [u32; 2]) -> bool {
        let on_boundary = |v: u32| self.carriers[v as usize] != Carrier::Volume;
        on_boundary(a) && on_boundary(b) && self.kept.contains_key(&ascending([a, b]))
    }

    /// Returns whether kept edges meet at less than 60 degrees at each vertex.
    pub(super) fn acute_ends(&self) -> Vec<bool> {
        acute(&self.at, self.kept.keys().copied())
    }

    /// Returns the point on the line of a kept edge, from its ends in the input, that is nearest to a point. Points that
    /// were rounded before do not move it away from the line.
    pub(super) fn on_line(&self, line: u32, p: DVec3) -> DVec3 {
        let [a, b] = self.points(self.lines[line as usize].ends);
        a + (b - a) * ((p - a).dot(b - a) / a.distance_squared(b))
    }

    /// Returns the point in the plane of a patch that is nearest to a point.
    pub(super) fn on_patch(&self, patch: u32, p: DVec3) -> DVec3 {
        let [at, normal] = self.planes[patch as usize];
        p - normal * normal.dot(p - at)
    }

    /// Adds a vertex, which no cell has yet.
    pub(super) fn push(&mut self, at: DVec3, carrier: Carrier, line: Option<u32>) -> u32 {
        self.lines_at.push(line.into_iter().collect());
        self.at.push(at);
        self.carriers.push(carrier);
        self.gone.push(false);
        self.at.len() as u32 - 1
    }

    /// Removes the last vertex, which no cell has.
    pub(super) fn pop(&mut self) {
        self.at.pop();
        self.lines_at.pop();
        self.carriers.pop();
        self.gone.pop();
    }

    /// Returns the length of the shortest edge at each vertex, or 1 without edges.
    fn shortest_edges(&self) -> Vec<f64> {
        let mut least = vec![f64::INFINITY; self.at.len()];
        for row in self.rows.iter().filter(|row| row.corners[0] != NONE) {
            for [a, b] in edges_of(&row.corners) {
                let length2 = self.at[a as usize].distance_squared(self.at[b as usize]);
                for v in [a, b] {
                    least[v as usize] = least[v as usize].min(length2);
                }
            }
        }
        least.iter().map(|&l| if l.is_finite() { l.sqrt() } else { 1.0 }).collect()
    }

    /// Returns the mesh. The size at a vertex is the length of its shortest edge.
    pub(in crate::constrained) fn into_mesh<P: Space>(self) -> GeneratedMesh<P> {
        let sizes = self.shortest_edges();
        let mut vertices = Vertices { points: vec![], sizes: vec![], carriers: vec![] };
        let mut short = vec![OUTSIDE; self.at.len()];
        for (v, (p, &carrier)) in
            self.at.iter().zip(&self.carriers).enumerate().filter(|(v, _)| !self.gone[*v])
        {
            short[v] = vertices.len() as u32;
            let at = P::from_coords(&p.to_array());
            vertices.push(Site { at, size: sizes[v] }, carrier);
        }
        let mut number = vec![OUTSIDE; self.rows.len()];
        let live = self.rows.iter().enumerate().filter(|(_, row)| row.corners[0] != NONE);
        for ((cell, _), i) in live.clone().zip(0..) {
            number[cell] = i;
        }
        let mut faces = Vec::new();
        for (cell, row) in live.clone() {
            for slot in (0..4).filter(|&slot| row.walls[slot] != NONE) {
                let other = row.across[slot];
                if other == NONE || cell < other as usize {
                    let beyond = if other == NONE { OUTSIDE } else { number[other as usize] };
                    let facet = self.facets[row.walls[slot] as usize];
                    faces.push((
                        facet,
                        simplex::<P::Facet>(&face_of(&row.corners, slot).map(|v| short[v as usize])),
                        [number[cell], beyond],
                    ));
                }
            }
        }
        let mut subsegments: Vec<Subsegment> = Vec::new();
        for (&edge, &line) in &self.kept {
            if let Carrier::Segment(s) = self.lines[line as usize].carrier {
                subsegments.push((s, edge.map(|v| short[v as usize])));
            }
        }
        subsegments.sort_unstable();
        let cells: Vec<P::Cell> =
            live.clone().map(|(_, row)| simplex(&row.corners.map(|v| short[v as usize]))).collect();
        GeneratedMesh {
            vertices,
            labels: CellLabels { of: live.map(|(_, row)| row.label).collect() },
            faces,
            delaunay: Delaunay { neighbours: vec![P::Cell::splat(u32::MAX); cells.len()], cells },
            subsegments,
            stages: Vec::new(),
        }
    }
}

fn simplex<S: Simplex>(vertices: &[u32]) -> S {
    let mut row = S::splat(u32::MAX);
    row.as_mut().copy_from_slice(vertices);
    row
}
