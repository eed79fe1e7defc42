//! Voronoi cells: vertices, ridges, areas and volumes, unbounded or clipped to a box.
//!
//! **Statement.** The vertices of the Voronoi diagram are the circumcentres of the cells. Two sites that an edge joins have a
//! *ridge*, whose vertices are the centres of the cells around the edge, in their order. With a box: if all centres at an inner
//! vertex lie in the box, its Voronoi cell does, and has the volume of its parts (`dual`). Otherwise the box is cut by the bisectors
//! to all neighbours in the triangulation, which bound the Voronoi cell, also an unbounded one. So the volumes add up to the
//! volume of the box.
//!
//! **Source.** Aurenhammer, "Voronoi diagrams - a survey of a fundamental geometric data structure" (1991).
//!
//! **Work.** O(m) for m cells, plus O(k^2) for each vertex with k neighbours whose cell is cut. Depth: that of a block of vertices.
//!
//! **Departures.** Centres of cospherical cells are not merged: each cell has one vertex, and some ridges have no area.

use crate::clip::{self, Measures};
use crate::dimension::Dimension;
use crate::double::circumradius;
use crate::dual::{circumcentre, is_thin, parts, space_part};
use crate::error::QueryError;
use crate::exact;
use crate::loops;
use crate::ragged::Ragged;
use crate::seen::Seen;
use crate::tessellation::{NONE, Tessellation, least, most};

/// The ridges of a Voronoi diagram: the faces between two cells.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Ridges {
    /// The two vertices of each ridge, smaller first, sorted: the edges of the triangulation.
    pub points: Vec<[u32; 2]>,
    /// The Voronoi vertices of each ridge, as numbers of cells, in order around it. An unbounded ridge starts with [`NONE`].
    pub vertices: Ragged,
    /// The length or area of each ridge, or of its part in the box. Infinite if it is unbounded.
    pub areas: Vec<f64>,
}

/// A box, and the Voronoi vertices in it, in scaled units.
pub(crate) struct Frame<P> {
    low: P,
    high: P,
    /// Whether the Voronoi cell of each vertex is cut.
    pub(crate) is_cut: Vec<bool>,
}

impl<P: Dimension> Tessellation<P> {
    /// Returns the circumcentre of each cell. It is infinite if it is beyond the range of floats.
    pub fn circumcentres(&self) -> Vec<P> {
        let one = |cell: usize| {
            let corners = self.corners(cell as u32);
            let centre = circumcentre(&corners) + corners[0];
            let mut unscaled = centre;
            (0..P::DIM).for_each(|i| unscaled.set_coord(i, self.unscaled(centre.coord(i), 1)));
            unscaled
        };
        loops::map(self.cells.len(), one)
    }

    /// Returns the circumradius of each cell, with a relative error below `1e-14`. It is infinite if it is beyond the range of
    /// floats.
    pub fn circumradii(&self) -> Vec<f64> {
        let radius = |cell: usize| {
            let corners = self.corners(cell as u32);
            if is_thin(&corners) {
                exact::circumcentre(&corners).norm2().sqrt()
            } else {
                circumradius(&corners)
            }
        };
        loops::map(self.cells.len(), |cell| self.unscaled(radius(cell), 1))
    }

    /// Returns the area or volume of the Voronoi cell of each point: infinite if it is unbounded, and 0 for a point that is no
    /// vertex.
    ///
    /// # Errors
    /// Fails if the points do not span the space.
    pub fn voronoi_volumes(&self) -> Result<Vec<f64>, QueryError> {
        self.has_cells()?;
        let mut volumes = self.sums_of_parts(&self.centres());
        for (volume, &is_on_hull) in volumes.iter_mut().zip(&self.on_hull()) {
            *volume = if is_on_hull { f64::INFINITY } else { self.unscaled(*volume, P::DIM as i32) };
        }
        Ok(volumes)
    }

    /// Returns the area or volume of the part of the Voronoi cell of each point in a box, and 0 for a duplicate. They
    /// add up to that of the box.
    ///
    /// # Errors
    /// Fails if the points do not span the space, if the box is empty, or if a vertex lies outside of it.
    pub fn voronoi_volumes_in(&self, low: P, high: P) -> Result<Vec<f64>, QueryError> {
        self.has_cells()?;
        let centres = self.centres();
        let frame = self.frame((low, high), &centres)?;
        let mut volumes = self.sums_of_parts(&centres);
        let cut = loops::blocks(self.points.len(), |block| {
            let mut star = Seen::default();
            let cut = block.filter(|&v| frame.is_cut[v] && self.vertex_cell[v] != NONE);
            cut.map(|v| (v, self.cut(v as u32, &frame, &mut star).1.volume)).collect::<Vec<_>>()
        });
        for (v, volume) in cut.into_iter().flatten() {
            volumes[v] = volume;
        }
        for volume in &mut volumes {
            *volume = self.unscaled(*volume, P::DIM as i32);
        }
        Ok(volumes)
    }

    /// Returns the ridges of the Voronoi diagram.
    ///
    /// # Errors
    /// Fails if the points do not span the space.
    pub fn ridges(&self) -> Result<Ridges, QueryError> {
        self.has_cells()?;
        Ok(self.ridges_of(None))
    }

    /// Returns the ridges of the Voronoi diagram, with the areas of their parts in a box.
    ///
    /// # Errors
    /// Fails if the points do not span the space, if the box is empty, or if a vertex lies outside of it.
    pub fn ridges_in(&self, low: P, high: P) -> Result<Ridges, QueryError> {
        self.has_cells()?;
        let frame = self.frame((low, high), &self.centres())?;
        Ok(self.ridges_of(Some(&frame)))
    }

    /// Returns the Voronoi vertices of the cell of each point, as numbers of cells, ascending. The row of an unbounded cell starts
    /// with [`NONE`]. The row of a point that is not a vertex is empty.
    ///
    /// # Errors
    /// Fails if the points do not span the space.
    pub fn voronoi_regions(&self) -> Result<Ragged, QueryError> {
        self.has_cells()?;
        let on_hull = self.on_hull();
        let blocks = loops::blocks(self.points.len(), |block| {
            let (mut star, mut rows) = (Seen::default(), Ragged::default());
            for v in block {
                let mut row = Vec::new();
                if self.vertex_cell[v] != NONE {
                    self.star(v as u32, &mut star);
                    row.extend_from_slice(star.list());
                    row.sort_unstable();
                }
                if on_hull[v] {
                    row.insert(0, NONE);
                }
                rows.push(&row);
            }
            rows
        });
        let mut all = Ragged::default();
        for rows in &blocks {
            all.append(rows);
        }
        Ok(all)
    }

    pub(crate) fn has_cells(&self) -> Result<(), QueryError> {
        if self.cells.is_empty() { Err(QueryError::Flat { dimension: self.dimension }) } else { Ok(()) }
    }

    /// Returns the circumcentre of each cell relative to its first corner, scaled.
    pub(crate) fn centres(&self) -> Vec<P> {
        loops::map(self.cells.len(), |cell| circumcentre(&self.corners(cell as u32)))
    }

    /// Whether each vertex lies on the hull.
    pub(crate) fn on_hull(&self) -> Vec<bool> {
        let mut on_hull = vec![false; self.points.len()];
        for (cell, next) in self.cells.iter().zip(&self.neighbours) {
            for (slot, _) in next.as_ref().iter().enumerate().filter(|(_, next)| **next == NONE) {
                let facet = cell.as_ref().iter().enumerate().filter(|(i, _)| *i != slot);
                facet.for_each(|(_, &v)| on_hull[v as usize] = true);
            }
        }
        on_hull
    }

    /// Adds up the parts at each vertex.
    fn sums_of_parts(&self, centres: &[P]) -> Vec<f64> {
        /// Cells whose parts are in memory at the same time.
        const MANY: usize = 1 << 18;
        let mut volumes = vec![0.0; self.points.len()];
        for first in (0..self.cells.len()).step_by(MANY) {
            let parts = loops::map(MANY.min(self.cells.len() - first), |at| {
                parts(&self.corners((first + at) as u32), centres[first + at])
            });
            for (cell, parts) in self.cells[first..].iter().zip(parts) {
                for (&[v, i, ..], part) in P::EDGES.iter().zip(parts) {
                    volumes[cell.as_ref()[v] as usize] += part;
                    volumes[cell.as_ref()[i] as usize] += part;
                }
            }
        }
        volumes
    }

    /// Checks a box, and finds the Voronoi cells that are not inside of it.
    pub(crate) fn frame(&self, (low, high): (P, P), centres: &[P]) -> Result<Frame<P>, QueryError> {
        let scaled = |p: P| septet_geometry::range::scale(p, self.exponent);
        let (low, high) = (scaled(low), scaled(high));
        let is_range =
            |&axis: &usize| low.coord(axis) < high.coord(axis) && (high - low).coord(axis).is_finite();
        if let Some(axis) = (0..P::DIM).find(|axis| !is_range(axis)) {
            return Err(QueryError::EmptyBox { axis });
        }
        let inside = |p: P| least(low, p) == low && most(high, p) == high;
        let outside = |v: &usize| self.vertex_cell[*v] != NONE && !inside(self.points[*v]);
        if let Some(index) = (0..self.points.len()).find(outside) {
            return Err(QueryError::OutsideBox { index });
        }
        let mut is_cut = self.on_hull();
        for (cell, &centre) in self.cells.iter().zip(centres) {
            if !inside(self.points[cell.as_ref()[0] as usize] + centre) {
                cell.as_ref().iter().for_each(|&v| is_cut[v as usize] = true);
            }
        }
        Ok(Frame { low, high, is_cut })
    }

    /// Measures the part of the Voronoi cell of a vertex in the box, with the neighbour of each face.
    pub(crate) fn cut(&self, v: u32, frame: &Frame<P>, star: &mut Seen) -> (Vec<u32>, Measures) {
        self.star(v, star);
        let site = self.points[v as usize];
        let mut around: Vec<u32> = self.vertices_of(star.list()).filter(|&w| w != v).collect();
        around.sort_unstable();
        around.dedup();
        // Near bisectors first: most of the far ones then cut nothing.
        let mut planes: Vec<(f64, u32)> =
            around.iter().map(|&w| ((self.points[w as usize] - site).norm2().sqrt(), w)).collect();
        planes.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let sides: Vec<u32> = planes.iter().map(|&(_, w)| w).collect();
        let halves: Vec<(P, f64)> = planes
            .iter()
            .map(|&(length, w)| ((self.points[w as usize] - site) / length, length / 2.0))
            .collect();
        (sides, clip::measure(frame.low - site, frame.high - site, &halves))
    }

    /// Collects the ridges of each vertex with larger ones.
    fn ridges_of(&self, frame: Option<&Frame<P>>) -> Ridges {
        let blocks = loops::blocks(self.points.len(), |block| {
            let (mut star, mut ridges) = (Seen::default(), Ridges::default());
            for v in block.filter(|&v| self.vertex_cell[v] != NONE) {
                self.ridges_at(v as u32, frame, &mut star, &mut ridges);
            }
            ridges
        });
        let mut all = Ridges::default();
        for block in blocks {
            all.points.extend(block.points);
            all.areas.extend(block.areas);
            all.vertices.append(&block.vertices);
        }
        all
    }

    fn ridges_at(&self, v: u32, frame: Option<&Frame<P>>, star: &mut Seen, ridges: &mut Ridges) {
        self.star(v, star);
        let mut ends: Vec<(u32, u32)> = Vec::new();
        for &cell in star.list() {
            ends.extend(self.cells[cell as usize].as_ref().iter().filter(|&&w| w > v).map(|&w| (w, cell)));
        }
        ends.sort_unstable();
        ends.dedup_by_key(|end| end.0);
        let cut = frame.filter(|frame| frame.is_cut[v as usize]).map(|frame| self.cut(v, frame, star));
        let mut ring = Vec::new();
        for (w, cell) in ends {
            self.ring([v, w], cell, &mut ring);
            let area = match &cut {
                Some((sides, measures)) => {
                    let side = sides.iter().position(|&side| side == w);
                    side.map_or(0.0, |side| measures.faces[side])
                }
                None if ring.first() == Some(&NONE) => f64::INFINITY,
                None => self.ridge_area([v, w], &ring),
            };
            ridges.points.push([v, w]);
            ridges.areas.push(self.unscaled(area, P::DIM as i32 - 1));
            ridges.vertices.push(&ring);
        }
    }

    /// Adds up the parts of an edge in the cells around it.
    fn ridge_area(&self, edge: [u32; 2], ring: &[u32]) -> f64 {
        let part = |&cell: &u32| {
            let corners = self.corners(cell);
            let centre = circumcentre(&corners);
            let [v, w] = edge.map(|v| self.slot(cell, v));
            let is_edge = |slots: &&[usize; 4]| {
                [Some(slots[0]), Some(slots[1])] == [v, w] || [Some(slots[0]), Some(slots[1])] == [w, v]
            };
            let slots = P::EDGES.iter().position(|slots| is_edge(&slots)).unwrap_or(0);
            if P::DIM == 2 {
                parts(&corners, centre)[slots]
            } else {
                space_part(&corners, centre, P::EDGES[slots])
            }
        };
        let [a, b] = edge.map(|v| self.points[v as usize]);
        let sum: f64 = ring.iter().map(part).sum();
        (2 * P::DIM) as f64 * sum / (a - b).norm2().sqrt()
    }

    /// Replaces `ring` by the cells around an edge, in their order, given one of them. If the edge is on the hull, the ring
    /// starts with [`NONE`], and cells follow from one hull facet to the other.
    pub(crate) fn ring(&self, edge: [u32; 2], start: u32, ring: &mut Vec<u32>) {
        ring.clear();
        // In the plane, an edge has one facet: itself. In space, a cell has two facets at the edge.
        let mut apexes = self.cells[start as usize].as_ref().iter().copied().filter(|v| !edge.contains(v));
        let first = apexes.next().unwrap_or(NONE);
        if P::DIM == 2 {
            let next = self.across(start, first);
            ring.extend(if next == NONE { [NONE, start] } else { [start.min(next), start.max(next)] });
            return;
        }
        let second = apexes.next().unwrap_or(NONE);
        ring.push(start);
        if !self.turn(edge, (start, first, second), ring) {
            ring.reverse();
            self.turn(edge, (start, second, first), ring);
            ring.push(NONE);
            ring.reverse();
        }
    }

    /// Appends the cells around an edge after `start`, which the turn leaves across the facet opposite `apex`. Returns whether it
    /// comes back.
    fn turn(&self, edge: [u32; 2], (start, apex, other): (u32, u32, u32), ring: &mut Vec<u32>) -> bool {
        let (mut cell, mut apex, mut other) = (start, apex, other);
        loop {
            let next = self.across(cell, apex);
            if next == NONE {
                return false;
            }
            if next == start {
                return true;
            }
            ring.push(next);
            let row = self.cells[next as usize].as_ref();
            let new = row.iter().copied().find(|v| *v != other && !edge.contains(v)).unwrap_or(NONE);
            (cell, apex, other) = (next, other, new);
        }
    }

    /// Returns the cell across the facet opposite a vertex.
    fn across(&self, cell: u32, vertex: u32) -> u32 {
        self.slot(cell, vertex).map_or(NONE, |slot| self.neighbours[cell as usize].as_ref()[slot])
    }
}
