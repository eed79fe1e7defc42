//! Alpha complexes and alpha shapes.
//!
//! **Statement.** The alpha complex of a radius `r` has the faces of the triangulation that some empty ball of radius `r` or less has on
//! its sphere. The *value* of a face is the square of the smallest such radius. For a cell, it is the squared circumradius. A facet
//! or an edge is *Gabriel* if no vertex of a cell at it lies strictly inside of the smallest ball whose sphere passes through its
//! corners. Then its value is that of this ball. Otherwise, it is the smallest value of the faces of one more dimension at it. The value
//! of a vertex is 0. The complex of `r` has the faces of values up to `r^2`.
//!
//! **Source.** Edelsbrunner and Muecke, "Three-dimensional alpha shapes" (1994). Values are squared radii, as in CGAL and gudhi.
//!
//! **Signs.** The test of a ball is the sign of a polynomial of degree 2 for edges and 6 for triangles. It is rounded with a bound on its
//! error, then computed by big integers. Ties do not matter: a vertex on the sphere gives both rules the same value.
//!
//! **Work.** O(m log m) for m cells.
//!
//! **Departures.** Rounded values are lowered to those of the faces of one more dimension, so that the complex of each radius is a
//! complex.

use septet_core::cores::sort_rows;
use septet_geometry::measure::circumcircle;
use septet_geometry::point::{Point, Simplex, Vector, dist2};

use crate::dimension::Dimension;
use crate::dual::circumcentre;
use crate::error::QueryError;
use crate::exact;
use crate::incidence::facet;
use crate::loops;
use crate::seen::Seen;
use crate::tessellation::{NONE, Tessellation};

/// The values of all faces of a triangulation.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct AlphaFiltration<P: Dimension> {
    /// The squared radius of each cell.
    pub cells: Vec<f64>,
    /// All facets: vertices ascending, sorted.
    pub facets: Vec<P::Facet>,
    /// The squared radius of each facet.
    pub facet_values: Vec<f64>,
    /// All edges: smaller vertex first, sorted. In the plane, they are the facets.
    pub edges: Vec<[u32; 2]>,
    /// The squared radius of each edge.
    pub edge_values: Vec<f64>,
}

/// The alpha complex of a radius.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct AlphaShape<P: Dimension> {
    /// Whether each cell belongs to the complex.
    pub cells: Vec<bool>,
    /// The facets between a cell that belongs to the complex and one that does not, or the outside: counter-clockwise from
    /// outside, with the smallest vertex first, sorted. In the plane, the shape is to the left of each edge.
    pub boundary: Vec<P::Facet>,
    /// The facets of the complex without a cell of the complex on either side: vertices ascending, sorted.
    pub singular: Vec<P::Facet>,
    /// The area or volume of the cells of the complex.
    pub volume: f64,
}

/// The facets of all cells, in scaled units.
struct Facets<P: Dimension> {
    rows: Vec<P::Facet>,
    values: Vec<f64>,
    /// The number of the facet opposite each vertex of each cell.
    of_cells: Vec<P::Cell>,
}

impl<P: Dimension> Tessellation<P> {
    /// Returns the radii from which on faces belong to the alpha complex. Without cells, all lists are empty.
    pub fn alpha_filtration(&self) -> AlphaFiltration<P> {
        let cells = self.squared_radii();
        let facets = self.alpha_facets(&cells);
        let (mut edges, mut edge_values) = (Vec::new(), Vec::new());
        if P::DIM == 2 {
            edges.extend(facets.rows.iter().map(|row| [row.as_ref()[0], row.as_ref()[1]]));
            edge_values.clone_from(&facets.values);
        } else {
            let blocks = loops::blocks(self.points.len(), |block| {
                let (mut star, mut found) = (Seen::default(), Vec::new());
                for v in block.filter(|&v| self.vertex_cell[v] != NONE) {
                    self.alpha_edges(v as u32, &facets, &mut star, &mut found);
                }
                found
            });
            for (edge, value) in blocks.into_iter().flatten() {
                edges.push(edge);
                edge_values.push(value);
            }
        }
        let unscaled = |values: Vec<f64>| values.into_iter().map(|x| self.unscaled(x, 2)).collect();
        AlphaFiltration {
            cells: unscaled(cells),
            facets: facets.rows,
            facet_values: unscaled(facets.values),
            edges,
            edge_values: unscaled(edge_values),
        }
    }

    /// Returns the alpha complex of a radius. The parameter of some other programs is the squared radius, or one over the radius.
    ///
    /// # Errors
    /// Fails if the radius is negative or not a number.
    pub fn alpha_shape(&self, radius: f64) -> Result<AlphaShape<P>, QueryError> {
        if radius.is_nan() || radius < 0.0 {
            return Err(QueryError::Radius);
        }
        let radii = self.squared_radii();
        let facets = self.alpha_facets(&radii);
        let belongs = |&value: &f64| self.unscaled(value, 2) <= radius * radius;
        let cells: Vec<bool> = radii.iter().map(belongs).collect();
        let mut has_cell = vec![false; facets.rows.len()];
        let (mut boundary, mut volume) = (Vec::new(), 0.0);
        let volumes = self.cell_volumes();
        for cell in (0..cells.len()).filter(|&cell| cells[cell]) {
            volume += volumes[cell];
            for (slot, &next) in self.neighbours[cell].as_ref().iter().enumerate() {
                has_cell[facets.of_cells[cell].as_ref()[slot] as usize] = true;
                if next == NONE || !cells[next as usize] {
                    boundary.push(facet::<P>(&self.cells[cell], slot));
                }
            }
        }
        boundary.sort_unstable();
        let alone = has_cell.iter().zip(&facets.values).map(|(has_cell, value)| !has_cell && belongs(value));
        let singular =
            facets.rows.iter().zip(alone).filter(|(_, alone)| *alone).map(|(row, _)| *row).collect();
        Ok(AlphaShape { cells, boundary, singular, volume })
    }

    /// Returns the squared circumradius of each cell, from which on it belongs to the alpha complex.
    pub fn alpha_values(&self) -> Vec<f64> {
        self.squared_radii().into_iter().map(|x| self.unscaled(x, 2)).collect()
    }

    fn squared_radii(&self) -> Vec<f64> {
        loops::map(self.cells.len(), |cell| circumcentre(&self.corners(cell as u32)[..=P::DIM]).norm2())
    }

    /// Collects the facets, sorted, with their values.
    fn alpha_facets(&self, radii: &[f64]) -> Facets<P> {
        let width = P::DIM + 1;
        let blocks = loops::blocks(self.cells.len(), |block| {
            let mut rows: Vec<u64> = Vec::new();
            for cell in block {
                for (slot, &next) in self.neighbours[cell].as_ref().iter().enumerate() {
                    // Of two cells, the smaller one lists the facet.
                    if next == NONE || cell < next as usize {
                        let mut row = facet::<P>(&self.cells[cell], slot);
                        row.as_mut().sort_unstable();
                        rows.extend(row.as_ref().iter().map(|&v| u64::from(v)));
                        rows.push((cell as u64) << 2 | slot as u64);
                    }
                }
            }
            rows
        });
        let mut rows = loops::joined(0, blocks);
        sort_rows(&mut rows, width);
        let places: Vec<(usize, usize)> = rows
            .chunks_exact(width)
            .map(|row| ((row[P::DIM] >> 2) as usize, (row[P::DIM] & 3) as usize))
            .collect();
        let mut of_cells = vec![P::Cell::splat(NONE); self.cells.len()];
        for (&(cell, slot), at) in places.iter().zip(0u32..) {
            of_cells[cell].as_mut()[slot] = at;
            let next = self.neighbours[cell].as_ref()[slot];
            if next != NONE {
                let back = self.neighbours[next as usize].as_ref().iter().position(|&n| n as usize == cell);
                of_cells[next as usize].as_mut()[back.unwrap_or(0)] = at;
            }
        }
        let values = loops::map(places.len(), |at| self.facet_value(places[at], radii));
        let row = |row: &[u64]| {
            let mut facet = P::Facet::splat(0);
            facet.as_mut().iter_mut().zip(row).for_each(|(to, &v)| *to = v as u32);
            facet
        };
        Facets { rows: rows.chunks_exact(width).map(row).collect(), values, of_cells }
    }

    fn facet_value(&self, (cell, slot): (usize, usize), radii: &[f64]) -> f64 {
        let next = self.neighbours[cell].as_ref()[slot];
        let mut least = radii[cell];
        let mut apexes = vec![self.cells[cell].as_ref()[slot]];
        if next != NONE {
            least = least.min(radii[next as usize]);
            let back = self.neighbours[next as usize].as_ref().iter().position(|&n| n as usize == cell);
            apexes.extend(back.map(|slot| self.cells[next as usize].as_ref()[slot]));
        }
        let mut face: Vec<P> = self.corners(cell as u32)[..=P::DIM].to_vec();
        face.remove(slot);
        if apexes.into_iter().any(|apex| in_smallest_ball(&face, self.points[apex as usize])) {
            return least;
        }
        let own = if P::DIM == 2 {
            dist2(face[0], face[1]) / 4.0
        } else {
            radius2_of_triangle([face[0], face[1], face[2]])
        };
        own.min(least)
    }

    /// Appends the edges in space from a vertex to larger ones, with their values.
    fn alpha_edges(&self, v: u32, facets: &Facets<P>, star: &mut Seen, found: &mut Vec<([u32; 2], f64)>) {
        self.star(v, star);
        let mut ends: Vec<(u32, u32)> = Vec::new();
        for &cell in star.list() {
            ends.extend(self.cells[cell as usize].as_ref().iter().filter(|&&w| w > v).map(|&w| (w, cell)));
        }
        ends.sort_unstable();
        for ends in ends.chunk_by(|a, b| a.0 == b.0) {
            let edge = [v, ends[0].0];
            let face = edge.map(|v| self.points[v as usize]);
            let (mut least, mut is_gabriel) = (f64::INFINITY, true);
            for &(_, cell) in ends {
                let row = self.cells[cell as usize].as_ref();
                for (slot, &apex) in row.iter().enumerate().filter(|(_, v)| !edge.contains(v)) {
                    // The facet opposite a vertex off the edge is at the edge.
                    least = least.min(facets.values[facets.of_cells[cell as usize].as_ref()[slot] as usize]);
                    is_gabriel = is_gabriel && !in_smallest_ball(&face, self.points[apex as usize]);
                }
            }
            let own = dist2(face[0], face[1]) / 4.0;
            found.push((edge, if is_gabriel { own.min(least) } else { least }));
        }
    }
}

/// Whether `p` lies strictly inside of the smallest ball whose sphere passes through the corners of an edge or a triangle.
///
/// Returns the squared circumradius of a triangle in space. That of a thin triangle is computed by big integers.
fn radius2_of_triangle<P: Point>(triangle: [P; 3]) -> f64 {
    /// The sine of an angle, squared, below which the rounded radius loses more than a few digits.
    const THIN_ANGLE2: f64 = 1e-6;
    let [a, b, c] = triangle;
    let sides = [a - c, b - a, c - b];
    // In all three products of two sides, twice the area is the same.
    let normal2 = P::hull_normal(&[sides[1], sides[0] * -1.0]).norm2();
    let squares = sides.map(Vector::norm2);
    let largest = (squares[0] * squares[1]).max(squares[1] * squares[2]).max(squares[2] * squares[0]);
    if normal2 < THIN_ANGLE2 * largest {
        exact::radius2_of_triangle(&triangle)
    } else {
        circumcircle(triangle).1
    }
}

/// Let `m` be the largest rounded difference of coordinates to `p` or, for triangles, to the first corner. For an edge, each of at most
/// 3 products passes through 5 roundings, so the error is below `16 u m^2`. For a triangle, products of 6 differences have a
/// total of at most `108 m^6` and pass through at most 18 roundings, so the error is below `2048 u m^6`. The differences
/// are divided by a power of two near `m`, which is exact unless digits far below the bound are lost.
fn in_smallest_ball<P: Dimension>(face: &[P], p: P) -> bool {
    let base = if face.len() == 2 { p } else { face[0] };
    let mut rel: Vec<P> = face.iter().chain([&p]).map(|&x| x - base).collect();
    let largest = rel.iter().flat_map(|x| (0..P::DIM).map(|i| x.coord(i).abs())).fold(0.0, f64::max);
    // The power of two at or below the largest difference.
    let unit = f64::from_bits((largest.to_bits() & 0x7ff << 52).max(1 << 52));
    for x in &mut rel {
        *x = *x / unit;
    }
    let (det, bound) = if face.len() == 2 {
        (rel[0].dot(rel[1]), 16.0 * 4.0)
    } else {
        let (u, v, w) = (rel[1], rel[2], rel[3]);
        let n = P::hull_normal(&[u, v]);
        let (over_v, over_u) = (P::hull_normal(&[v, n]) * u.norm2(), P::hull_normal(&[n, u]) * v.norm2());
        (w.norm2() * n.norm2() - w.dot(over_v + over_u), 2048.0 * 64.0)
    };
    // The largest scaled difference is below 2, so `m^2 < 4` and `m^6 < 64`.
    if det.abs() > bound * (f64::EPSILON / 2.0) * 1.05 { det < 0.0 } else { exact::in_smallest_ball(face, p) }
}
