//! Terrains with break lines: points with heights, and edges that a triangulation in the plane must keep.
//!
//! **Statement.** Points of break lines that coincide with points of the terrain in x and y are these points, whose
//! heights count. Other points are added after them, each once. The height of an added point is the first one that the
//! lines state for it. If they state none, it is interpolated linearly in the Delaunay triangle of the terrain's points
//! that contains it.

use glam::DVec2;
use septet_geometry::incremental::Incremental;
use septet_geometry::point::lex_cmp;
use septet_geometry::range::{scale, scale_exponent};

use super::constrained::{Constrained, Crossed};
use super::shapes::Shapes;
use crate::generate::Delaunay;
use crate::space::ascending;

/// A terrain with break lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Terrain {
    /// The points of the terrain, and then those of the break lines that are not among them.
    pub points: Vec<DVec2>,
    /// The heights of the points.
    pub heights: Vec<f64>,
    /// The edges of the break lines, ascending, each once.
    pub edges: Vec<[u32; 2]>,
    /// The number of points added whose heights are interpolated.
    pub interpolated: usize,
}

/// The error for a point of a break line that has no height and lies outside the terrain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoHeight(pub DVec2);

/// An edge of a line, and an edge that it crosses.
pub type Crossing = ([u32; 2], Crossed);

impl Terrain {
    /// Joins a terrain with break lines.
    ///
    /// # Errors
    /// Returns [`NoHeight`].
    pub fn new(mut points: Vec<DVec2>, mut heights: Vec<f64>, lines: &Shapes) -> Result<Self, NoHeight> {
        let own = points.len();
        points.extend(&lines.points);
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        let point = |v: u32| points[v as usize];
        order.sort_unstable_by(|&a, &b| lex_cmp(&point(a), &point(b)).then(a.cmp(&b)));
        let mut first: Vec<u32> = vec![0; points.len()];
        let mut stated = lines.heights.clone();
        for group in order.chunk_by(|&a, &b| point(a) == point(b)) {
            let of =
                |&v: &u32| (v as usize).checked_sub(own).map(|i| lines.heights[i]).filter(|z| !z.is_nan());
            let height = group.iter().find_map(of);
            for &v in group {
                first[v as usize] = group[0];
            }
            if let (Some(i), Some(z)) = ((group[0] as usize).checked_sub(own), height) {
                stated[i] = z;
            }
        }
        let mut number: Vec<u32> = (0..points.len() as u32).collect();
        let mut kept = own;
        for v in own..points.len() {
            if first[v] as usize == v {
                number[v] = kept as u32;
                points[kept] = points[v];
                heights.push(stated[v - own]);
                kept += 1;
            } else {
                number[v] = number[first[v] as usize];
            }
        }
        points.truncate(kept);
        let named = |edge: [u32; 2]| ascending(edge.map(|v| number[v as usize + own]));
        let mut edges: Vec<[u32; 2]> = lines.edges().map(named).filter(|e| e[0] != e[1]).collect();
        edges.sort_unstable();
        edges.dedup();
        let distinct: Vec<u32> = (0..own as u32).filter(|&v| first[v as usize] == v).collect();
        let mut terrain = Terrain { points, heights, edges, interpolated: 0 };
        terrain.interpolate(own, &distinct)?;
        Ok(terrain)
    }

    /// Interpolates the heights that are not stated, from the given points.
    fn interpolate(&mut self, own: usize, distinct: &[u32]) -> Result<(), NoHeight> {
        let open: Vec<usize> = (own..self.points.len()).filter(|&v| self.heights[v].is_nan()).collect();
        let Some(&any) = open.first() else { return Ok(()) };
        let none = |v: usize| NoHeight(self.points[v]);
        let exponent = scale_exponent(&self.points).map_err(|_| none(any))?;
        let scaled = |v: usize| scale(self.points[v], exponent);
        let base: Vec<DVec2> = distinct.iter().map(|&v| scaled(v as usize)).collect();
        let built = Incremental::new(base).map_err(|_| none(any))?;
        let mut hint = None;
        let mut found = Vec::with_capacity(open.len());
        for &v in &open {
            let cell = built.locate(scaled(v), hint);
            hint = Some(cell);
            if built.complex().is_infinite(cell) {
                return Err(none(v));
            }
            let corners = built.complex().cell(cell).map(|i| distinct[i as usize] as usize);
            found.push(interpolated(corners.map(|c| (self.points[c], self.heights[c])), self.points[v]));
        }
        self.interpolated = open.len();
        for (v, height) in open.into_iter().zip(found) {
            self.heights[v] = height;
        }
        Ok(())
    }

    /// Inserts the break lines into the Delaunay triangulation of the points. Returns the cells in canonical order:
    /// smallest vertex first, sorted.
    ///
    /// # Errors
    /// Returns the edges that cross other ones, with an edge that each crosses. Coordinates out of range do not cause an
    /// error, because they have no triangulation.
    pub fn constrained(&self, cells: Vec<[u32; 3]>) -> Result<Vec<[u32; 3]>, Vec<Crossing>> {
        let exponent = scale_exponent(&self.points).unwrap_or(0);
        let points = self.points.iter().map(|&p| scale(p, exponent)).collect();
        let mut made = Constrained::new(points, with_neighbours(cells));
        let crossed = self.edges.iter().filter_map(|&[a, b]| Some(([a, b], made.constrain(a, b).err()?)));
        let crossed: Vec<_> = crossed.collect();
        if !crossed.is_empty() {
            return Err(crossed);
        }
        let mut cells = made.into_delaunay().cells;
        for cell in &mut cells {
            let least = (1..3).fold(0, |k, i| if cell[i] < cell[k] { i } else { k });
            cell.rotate_left(least);
        }
        cells.sort_unstable();
        Ok(cells)
    }
}

/// Interpolates linearly in a triangle.
fn interpolated(corners: [(DVec2, f64); 3], q: DVec2) -> f64 {
    let [(a, za), (b, zb), (c, zc)] = corners;
    let whole = (b - a).perp_dot(c - a);
    let [u, v] = [(q - a).perp_dot(c - a) / whole, (b - a).perp_dot(q - a) / whole];
    za + u * (zb - za) + v * (zc - za)
}

/// Returns the cells with their adjacency.
fn with_neighbours(cells: Vec<[u32; 3]>) -> Delaunay<[u32; 3]> {
    let mut edges: Vec<([u32; 2], u32, usize)> = Vec::with_capacity(3 * cells.len());
    for (number, cell) in (0u32..).zip(&cells) {
        for corner in 0..3 {
            edges.push((ascending([cell[(corner + 1) % 3], cell[(corner + 2) % 3]]), number, corner));
        }
    }
    edges.sort_unstable();
    let mut neighbours = vec![[u32::MAX; 3]; cells.len()];
    for pair in edges.windows(2) {
        let [(edge, c, i), (other, d, j)] = [pair[0], pair[1]];
        if edge == other {
            neighbours[c as usize][i] = d;
            neighbours[d as usize][j] = c;
        }
    }
    Delaunay { cells, neighbours }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{Alone, MeshMachine};

    fn lattice(k: u32) -> (Vec<DVec2>, Vec<f64>) {
        let at = |i: u32| DVec2::new(f64::from(i % k), f64::from(i / k));
        let points: Vec<DVec2> = (0..k * k).map(at).collect();
        let heights = points.iter().map(|p| 2.0 * p.x - 3.0 * p.y + 5.0).collect();
        (points, heights)
    }

    fn lines(all: &[&[([f64; 2], Option<f64>)]]) -> Shapes {
        let mut shapes = Shapes { features: all.len() as u32, ..Shapes::default() };
        for (line, feature) in all.iter().zip(1..) {
            let line = line.iter().map(|&(p, z)| shapes.push(p.into(), z)).collect();
            shapes.lines.push((feature, line));
        }
        shapes
    }

    #[test]
    fn heights_are_those_of_points_stated_or_interpolated() {
        let (points, heights) = lattice(5);
        let line: &[([f64; 2], Option<f64>)] =
            &[([1.0, 1.0], Some(99.0)), ([2.25, 1.5], None), ([3.5, 2.5], Some(7.0)), ([3.5, 2.5], None)];
        let terrain = Terrain::new(points.clone(), heights.clone(), &lines(&[line])).unwrap();
        assert_eq!(terrain.points.len(), 27);
        assert_eq!((terrain.heights[6], terrain.heights[25], terrain.heights[26]), (4.0, 5.0, 7.0));
        assert_eq!((terrain.edges.clone(), terrain.interpolated), (vec![[6, 25], [25, 26]], 1));
        let delaunay = MeshMachine::<DVec2>::delaunay(&mut Alone { seed: 1 }, &terrain.points).unwrap();
        let cells = terrain.constrained(delaunay.cells.clone()).unwrap();
        assert_eq!(cells.len(), delaunay.cells.len());
        for edge in &terrain.edges {
            assert!(cells.iter().any(|c| edge.iter().all(|v| c.contains(v))), "{edge:?}");
        }
        let far = lines(&[&[([1.0, 1.0], None), ([9.0, 1.0], None)]]);
        assert_eq!(Terrain::new(points, heights, &far), Err(NoHeight(DVec2::new(9.0, 1.0))));
    }

    #[test]
    fn crossing_lines_are_named() {
        let (points, heights) = lattice(4);
        let a: &[([f64; 2], Option<f64>)] = &[([0.0, 0.0], None), ([3.0, 2.0], None)];
        let b: &[([f64; 2], Option<f64>)] = &[([3.0, 0.0], None), ([0.0, 2.0], None)];
        let terrain = Terrain::new(points, heights, &lines(&[a, b])).unwrap();
        let delaunay = MeshMachine::<DVec2>::delaunay(&mut Alone { seed: 1 }, &terrain.points).unwrap();
        let crossed = terrain.constrained(delaunay.cells).unwrap_err();
        assert_eq!(crossed.len(), 1);
        assert_eq!(crossed[0].0, [3, 8]);
    }
}
