//! A worker's piece, triangulated at once where only the answer is wanted (`triangulate`).
//!
//! The stars of its home points are those of one triangulation, so cells whose vertices are all at home agree
//! by construction; what two workers must agree on are the cells between them. Links are written out only if
//! stars have to be compared or changed one by one.

use septet_geometry::ball::Reach;
use septet_geometry::complex::INFINITE;
use septet_geometry::incremental::{Incremental, facet_without};
use septet_geometry::point::{Point, Simplex, dist2, lex_cmp};
use septet_protocol::message::Merged;

use crate::config::Stop;
use crate::merge::{HULL, SEAM};

/// The triangulation of a worker's piece and of the foreign points it was sent. Home points are its first
/// vertices, by their local numbers.
#[derive(Debug)]
pub(crate) struct Piece<P: Point> {
    delaunay: Incremental<P>,
    /// Local number of each vertex.
    numbers: Vec<u32>,
    home: u32,
    /// For every slot the number of its cell among those that belong here, or [`HULL`] or [`SEAM`].
    rows: Vec<u32>,
}

/// Links as arrays: the facets of all, and where each begins and how many it has.
pub(crate) type Links<P> = (Vec<<P as Point>::Facet>, Vec<(u32, u32)>);

impl<P: Point> Piece<P> {
    /// Triangulates the home points, which are numbered in the order of insertion, and those of `others` (local
    /// numbers) that are not among them. Nothing if all lie in a plane, or if told to stop.
    pub(crate) fn new(positions: &[P], home: u32, others: &[u32], stop: &Stop) -> Option<Self> {
        let mut numbers: Vec<u32> = (0..home).collect();
        numbers.extend(others.iter().copied().filter(|&v| v >= home));
        let mut points = positions[..home as usize].to_vec();
        points.extend(numbers[home as usize..].iter().map(|&v| positions[v as usize]));
        let delaunay = Incremental::build_while(points, None, &mut || !stop.is_raised()).ok()?;
        Some(Piece { delaunay, numbers, home, rows: Vec::new() })
    }

    /// Adds foreign points, by their local numbers; those that are vertices already change nothing. False if told
    /// to stop.
    pub(crate) fn add(&mut self, foreign: &[u32], positions: &[P], stop: &Stop) -> bool {
        let points: Vec<P> = foreign.iter().map(|&g| positions[g as usize]).collect();
        let before = self.numbers.len();
        let Ok(vertices) = self.delaunay.insert_all(&points, &mut || !stop.is_raised()) else { return false };
        self.numbers.resize(self.delaunay.vertices().len(), 0);
        for (&vertex, &number) in vertices.iter().zip(foreign) {
            if vertex as usize >= before {
                self.numbers[vertex as usize] = number;
            }
        }
        true
    }

    /// The kernel's rounded sphere of a cell, which is somewhat larger than [`reach_of`] and costs nothing.
    pub(crate) fn ball(&self, slot: u32) -> Option<Reach<P>> {
        let (centre, radius2) = self.delaunay.ball(slot)?;
        Some(Reach::Ball { centre, radius: radius2.sqrt() * (1.0 + f64::EPSILON) })
    }

    /// Number of slots for cells.
    pub(crate) fn slots(&self) -> u32 {
        self.delaunay.complex().slots()
    }

    /// Calls `f` with every cell of which a vertex is at home: its slot and its vertices' local numbers,
    /// [`INFINITE`] among them in infinite ones.
    pub(crate) fn each_cell(&self, mut f: impl FnMut(u32, &P::Cell)) {
        for (slot, cell, _) in self.delaunay.complex().entries() {
            let foreign = cell.as_ref().iter().filter(|&&v| v >= self.home).count();
            if foreign == 0 {
                f(slot, cell);
            } else if foreign <= P::DIM {
                f(slot, &self.local(cell));
            }
        }
    }

    /// Is the cell as large as a look at its own edges lets expect? Cells that bridge a concave part of the
    /// boundary, and infinite ones, are not: foreign points will undo most of them.
    pub(crate) fn is_ordinary(reach: &Reach<P>, corners: &[P]) -> bool {
        let Reach::Ball { radius, .. } = *reach else { return false };
        let mut least = f64::INFINITY;
        for (i, &a) in corners.iter().enumerate() {
            for &b in &corners[..i] {
                least = least.min(dist2(a, b));
            }
        }
        radius * radius <= ORDINARY * ORDINARY * least
    }

    /// Calls `f` with every cell, infinite ones too, that has vertices at home and foreign ones.
    pub(crate) fn each_mixed_cell(&self, mut f: impl FnMut(u32, &P::Cell)) {
        let complex = self.delaunay.complex();
        let mut seen = vec![0u64; complex.slots().div_ceil(64) as usize];
        let mut star = Vec::new();
        for foreign in self.home..self.numbers.len() as u32 {
            self.delaunay.star(foreign, &mut star);
            for &slot in &star {
                let (word, bit) = (&mut seen[slot as usize / 64], 1 << (slot % 64));
                let cell = complex.cell(slot);
                if *word & bit == 0 && cell.as_ref().iter().any(|&v| v < self.home) {
                    *word |= bit;
                    f(slot, &self.local(cell));
                }
            }
        }
    }

    /// A cell by local numbers.
    pub(crate) fn cell(&self, slot: u32) -> P::Cell {
        self.local(self.delaunay.complex().cell(slot))
    }

    /// Is there still a cell in this slot?
    pub(crate) fn is_live(&self, slot: u32) -> bool {
        self.delaunay.complex().is_live(slot)
    }

    fn local(&self, cell: &P::Cell) -> P::Cell {
        let mut own = *cell;
        for v in own.as_mut().iter_mut().filter(|v| **v >= self.home && **v != INFINITE) {
            *v = self.numbers[*v as usize];
        }
        own
    }

    /// What the stars of all home points contribute to the merged result. Numbers the cells whose smallest vertex
    /// is at home, for [`Piece::into_rows`].
    pub(crate) fn merge(&mut self, positions: &[P]) -> Merged {
        const CELL: u8 = 1;
        const SMALLER: u8 = 2;
        let mut seen = vec![0u8; self.home as usize];
        let mut sum = Merged::default();
        let mut rows = vec![SEAM; self.slots() as usize];
        self.each_cell(|slot, cell| {
            // Nearly every cell is at home and tells nothing new.
            let known = |&v: &u32| seen.get(v as usize).is_some_and(|&s| s == CELL | SMALLER);
            if cell.as_ref().iter().all(known) {
                rows[slot as usize] = sum.cells as u32;
                sum.cells += 1;
                return;
            }
            let smallest = smallest_of(positions, cell);
            let finite = !cell.as_ref().contains(&INFINITE);
            for &v in cell.as_ref() {
                if let Some(seen) = seen.get_mut(v as usize) {
                    *seen |= if finite { CELL } else { 0 } | if v == smallest { 0 } else { SMALLER };
                }
            }
            if !finite {
                rows[slot as usize] = HULL;
                sum.hull_facets += u64::from(smallest < self.home);
            } else if smallest < self.home {
                rows[slot as usize] = sum.cells as u32;
                sum.cells += 1;
            }
        });
        self.rows = rows;
        sum.stars = seen.iter().filter(|&&s| s & CELL != 0).count() as u64;
        sum.minima = seen.iter().filter(|&&s| s & SMALLER == 0).count() as u64;
        sum
    }

    /// The cells whose smallest vertex is at home, once [`Piece::merge`] has numbered them: rows of their vertices'
    /// local numbers and of their neighbours, which are cells by their new numbers, [`HULL`], or [`SEAM`] for a
    /// cell of another piece.
    pub(crate) fn into_rows(self) -> Vec<u32> {
        let Piece { delaunay, numbers, home, rows } = self;
        delaunay.into_rows(&rows, SEAM, |v| if v < home { v } else { numbers[v as usize] })
    }

    /// The squared distance of every home point to its nearest vertex, which is a neighbour.
    pub(crate) fn nearest_edges(&self) -> Vec<f64> {
        let mut radii2 = vec![f64::INFINITY; self.home as usize];
        let points = self.delaunay.vertices();
        for cell in self.delaunay.cells() {
            let vertices = cell.as_ref();
            for (i, &a) in vertices.iter().enumerate() {
                for &b in &vertices[..i] {
                    let d2 = dist2(points[a as usize], points[b as usize]);
                    for v in [a, b] {
                        if let Some(r2) = radii2.get_mut(v as usize) {
                            *r2 = r2.min(d2);
                        }
                    }
                }
            }
        }
        radii2
    }

    /// All links of home points in local numbers, by two passes over the cells.
    pub(crate) fn links(&self) -> Links<P> {
        let mut ranges = vec![(0u32, 0u32); self.home as usize];
        self.each_cell(|_, cell| {
            for &v in cell.as_ref() {
                if let Some(range) = ranges.get_mut(v as usize) {
                    range.1 += 1;
                }
            }
        });
        let mut total = 0;
        for range in &mut ranges {
            let start = total;
            total += range.1;
            *range = (start, 0);
        }
        let mut facets = vec![P::Facet::splat(0); total as usize];
        self.each_cell(|_, cell| {
            for &v in cell.as_ref() {
                if let Some(range) = ranges.get_mut(v as usize) {
                    facets[(range.0 + range.1) as usize] = facet_without::<P>(cell, v);
                    range.1 += 1;
                }
            }
        });
        (facets, ranges)
    }
}

/// Circumradius over shortest edge up to which a cell is ordinary (random points: 2 on average).
const ORDINARY: f64 = 4.0;

/// The lexicographically smallest finite vertex of a cell of local numbers.
pub(crate) fn smallest_of<P: Point>(positions: &[P], cell: &P::Cell) -> u32 {
    let mut best = INFINITE;
    for &v in cell.as_ref().iter().filter(|&&v| v != INFINITE) {
        if best == INFINITE || lex_cmp(&positions[v as usize], &positions[best as usize]).is_lt() {
            best = v;
        }
    }
    best
}

/// What holds every point that conflicts with a cell; `corner` gives the position of a finite vertex.
pub(crate) fn reach_of<P: Point>(cell: &P::Cell, corner: impl Fn(u32) -> P) -> (Reach<P>, [P; 4]) {
    let mut corners = [P::default(); 4];
    let mut infinite = None;
    for (slot, &v) in cell.as_ref().iter().enumerate() {
        if v == INFINITE {
            infinite = Some(slot);
        } else {
            corners[slot] = corner(v);
        }
    }
    let Some(slot) = infinite else {
        return (Reach::of_cell(&corners[..=P::DIM]), corners);
    };
    // A point beyond, in the place of infinity, makes the cell positive: bring that place to the end.
    corners.swap(slot, P::DIM);
    if slot != P::DIM {
        corners.swap(0, 1);
    }
    (Reach::of_facet(&corners[..P::DIM]), corners)
}
