//! Size functions, and sets of points searched by size.
//!
//! **Statement.** A size function here is `f(x) = least + slope * dist(x, centre)`, the centre being a
//! point or a line (or the slope 0): exactly `slope`-Lipschitz. Two points conflict when they are
//! closer than `min(f(P), f(Q))` (the paper's Definition 5.2 read with `>=`). If they do, their sizes
//! differ by a factor of at most `1 + slope`, so points live in grids by the binary exponent of
//! `f / least`, and a search looks into at most three of them.
//!
//! **Work.** O(1) per search: a cell of level `k` has side `least * 2^k` and holds O(1) points of that
//! level. Each grid spans only the box that its sizes occur in, O(slope^-d) cells (times the length
//! for a line, times the whole box for slope 0), so storage is O(n).

use septet_geometry::point::{Point, dist2};

/// Where the size function is least.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Centre {
    /// The midpoint of the domain.
    Point,
    /// The line through the midpoint along the last axis.
    Line,
}

/// A size function on the unit square or cube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sizing {
    /// Where it is least.
    pub centre: Centre,
    /// Its Lipschitz constant.
    pub slope: f64,
    /// Its least value.
    pub least: f64,
}

impl Sizing {
    /// The value at a point.
    #[inline]
    pub fn at<P: Point>(&self, p: &P) -> f64 {
        if self.slope == 0.0 {
            return self.least;
        }
        self.least + self.slope * self.distance(p)
    }

    /// Distance from the centre.
    #[inline]
    pub fn distance<P: Point>(&self, p: &P) -> f64 {
        let axes = match self.centre {
            Centre::Point => P::DIM,
            Centre::Line => P::DIM - 1,
        };
        let mut sum = 0.0;
        for i in 0..axes {
            let x = p.coord(i) - 0.5;
            sum += x * x;
        }
        sum.sqrt()
    }

    /// The level of a size: the exponent of its ratio to the least.
    #[inline]
    fn level(&self, size: f64) -> usize {
        let ratio = (size / self.least).max(1.0);
        (ratio.to_bits() >> 52) as usize - 1023
    }

    /// The box outside of which sizes exceed `size`, as low and high corner.
    fn region<P: Point>(&self, size: f64) -> (P, P) {
        let mut low = P::splat(0.0);
        let mut high = P::splat(1.0);
        if self.slope > 0.0 {
            let reach = (size - self.least) / self.slope;
            let axes = if self.centre == Centre::Line { P::DIM - 1 } else { P::DIM };
            for i in 0..axes {
                low.set_coord(i, (0.5 - reach).max(0.0));
                high.set_coord(i, (0.5 + reach).min(1.0));
            }
        }
        (low, high)
    }
}

const NONE: u32 = u32::MAX;

/// The points whose sizes share an exponent.
#[derive(Debug)]
struct Level<P> {
    low: P,
    inverse_side: f64,
    /// Cells per axis; 1 along an axis that does not exist.
    cells: [i64; 3],
    heads: Vec<u32>,
}

impl<P: Point> Level<P> {
    fn index(&self, at: [i64; 3]) -> usize {
        ((at[2] * self.cells[1] + at[1]) * self.cells[0] + at[0]) as usize
    }

    /// The cell of `p` moved by `shift` along every axis, not yet clamped.
    #[inline]
    fn cell(&self, p: &P, shift: f64) -> [i64; 3] {
        let mut at = [0; 3];
        for (i, a) in at.iter_mut().enumerate().take(P::DIM) {
            *a = ((p.coord(i) + shift - self.low.coord(i)) * self.inverse_side).floor() as i64;
        }
        at
    }
}

#[derive(Clone, Copy, Debug)]
struct Node<P> {
    point: P,
    size: f64,
    next: u32,
}

/// A set of points in which no two conflict.
#[derive(Debug)]
pub(super) struct Spaced<P> {
    sizing: Sizing,
    nodes: Vec<Node<P>>,
    levels: Vec<Level<P>>,
}

impl<P: Point> Spaced<P> {
    /// The empty set.
    pub fn new(sizing: Sizing) -> Self {
        let greatest = sizing.at(&P::splat(0.0));
        let levels = (0..=sizing.level(greatest))
            .map(|k| {
                let side = sizing.least * (1u64 << k) as f64;
                let (low, high) = sizing.region::<P>(2.0 * side);
                let mut cells = [1; 3];
                for (i, c) in cells.iter_mut().enumerate().take(P::DIM) {
                    *c = ((high.coord(i) - low.coord(i)) / side).floor() as i64 + 1;
                }
                let heads = vec![NONE; cells.iter().product::<i64>() as usize];
                Level { low, inverse_side: 1.0 / side, cells, heads }
            })
            .collect();
        Spaced { sizing, nodes: Vec::new(), levels }
    }

    /// The size function.
    pub fn sizing(&self) -> &Sizing {
        &self.sizing
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// The points, in order of addition.
    pub fn points(&self) -> impl Iterator<Item = P> + '_ {
        self.nodes.iter().map(|node| node.point)
    }

    /// Is some point of the set closer to `p` than both their sizes?
    pub fn conflicts(&self, p: &P) -> bool {
        let size = self.sizing.at(p);
        let factor = (1.0 + self.sizing.slope) * 1.000_001;
        let first = self.sizing.level(size / factor);
        let last = self.sizing.level(size * factor).min(self.levels.len() - 1);
        (first..=last).any(|k| self.conflicts_in(&self.levels[k], p, size))
    }

    fn conflicts_in(&self, level: &Level<P>, p: &P, size: f64) -> bool {
        let low = level.cell(p, -size).map(|a| a.max(0));
        let mut high = level.cell(p, size);
        for (h, &cells) in high.iter_mut().zip(&level.cells) {
            *h = (*h).min(cells - 1);
        }
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                if low[0] > high[0] {
                    return false;
                }
                let row = level.index([low[0], y, z])..=level.index([high[0], y, z]);
                for &head in &level.heads[row] {
                    let mut at = head;
                    while at != NONE {
                        let node = &self.nodes[at as usize];
                        let apart = size.min(node.size);
                        if dist2(node.point, *p) < apart * apart {
                            return true;
                        }
                        at = node.next;
                    }
                }
            }
        }
        false
    }

    /// Adds a point, which must lie in the domain and not conflict.
    pub fn add(&mut self, p: P) {
        let size = self.sizing.at(&p);
        let last = self.levels.len() - 1;
        let level = &mut self.levels[self.sizing.level(size).min(last)];
        let mut at = level.cell(&p, 0.0);
        for (a, &cells) in at.iter_mut().zip(&level.cells) {
            *a = (*a).clamp(0, cells - 1);
        }
        let index = level.index(at);
        let new = self.nodes.len() as u32;
        let next = std::mem::replace(&mut level.heads[index], new);
        self.nodes.push(Node { point: p, size, next });
    }

    /// Adds the point if it does not conflict; was it added?
    pub fn offer(&mut self, p: P) -> bool {
        let free = !self.conflicts(&p);
        if free {
            self.add(p);
        }
        free
    }
}
