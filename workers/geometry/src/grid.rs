//! The graph neighbours of a leaf's points by a grid, for balls that are small relative to the leaf.
//!
//! **Statement.** An edge of `i` is no longer than `R_i`, its reach ([`Supergraph::reach`]) into the largest ball.
//! The bounding box of the `m` members is divided into `m` to `2m` equal cells. The longest side of a cell is always
//! bisected first, so a flat or thin set has a flat or thin grid. All neighbours of `i` lie in the cells that meet
//! the box of half side `R_i` around `i`. Each member of these cells is tested by the symmetric expression of the
//! graph. The lists therefore equal the lists of [`graph_direct`](crate::graph::graph_direct), edge by edge.
//!
//! *Rounding misses no neighbour.* Let `|x - y| <= R` for floats `x` and `y`. Then `x - R <= y`. Since `y` is a float
//! and rounding is monotone, the rounded `x - R` is also at most `y`. The index of a cell is a monotone function of the
//! coordinate. The reach is rounded up by more than the rounding error of a distance.
//!
//! **Source.** Cells of fixed size for near neighbours: Bentley, Stanat and Williams (1977).
//!
//! **Work and depth.** Work `O(m log m)` for sorting the members by cells, plus the number of members in the searched
//! cells. For each point, this number is O(1) if the members are evenly spread at the scale of the balls, and never
//! more than `m`. The sort has depth `O(log m)`. All other phases take O(1) steps.

use crate::cost::Cost;
use crate::graph::Supergraph;
use crate::lists::Lists;
use crate::point::{Array, Point, dist2};

/// A member in the layout of the search.
#[derive(Clone, Copy)]
struct Member<P> {
    x: P,
    r2: f64,
    index: u32,
}

/// A box divided into equal cells.
struct Grid<P: Point> {
    low: P,
    /// Number of cells along each axis: a power of two; 1 for an axis beyond the dimension.
    cells: P::Axes<usize>,
    /// Number of cells for each unit of length.
    scale: P::Axes<f64>,
}

impl<P: Point> Grid<P> {
    /// Divides the bounding box into one to two cells for each member.
    fn of(members: &[Member<P>], cost: &mut Cost) -> Self {
        let start = (P::splat(f64::INFINITY), P::splat(f64::NEG_INFINITY));
        let (low, high) = cost.reduce(members, start, |(mut low, mut high), m| {
            for i in 0..P::DIM {
                low.set_coord(i, low.coord(i).min(m.x.coord(i)));
                high.set_coord(i, high.coord(i).max(m.x.coord(i)));
            }
            (low, high)
        });
        let mut sides = P::Axes::from_fn(|_| 0.0);
        let side = sides.as_mut();
        for (i, side) in side.iter_mut().enumerate().take(P::DIM) {
            *side = (high.coord(i) - low.coord(i)).max(0.0);
        }
        let (extents, mut all_cells, mut all) = (sides.clone(), P::Axes::from_fn(|_| 1), 1);
        let (side, extent, cells) = (sides.as_mut(), extents.as_ref(), all_cells.as_mut());
        while all < members.len() {
            let longest = (1..side.len()).fold(0, |best, i| if side[i] > side[best] { i } else { best });
            cells[longest] *= 2;
            side[longest] *= 0.5;
            all *= 2;
        }
        let mut scales = P::Axes::from_fn(|_| 0.0);
        let scale = scales.as_mut();
        for i in 0..extent.len() {
            if extent[i] > 0.0 {
                scale[i] = cells[i] as f64 / extent[i];
            }
        }
        Grid { low, cells: all_cells, scale: scales }
    }

    /// Returns the index, along one axis, of the cell that contains the coordinate `x`. A coordinate outside the box
    /// gets the nearest cell. The index is monotone in `x`.
    #[inline]
    fn along(&self, axis: usize, x: f64) -> usize {
        (((x - self.low.coord(axis)) * self.scale.as_ref()[axis]) as usize).min(self.cells.as_ref()[axis] - 1)
    }

    fn cell(&self, x: P) -> usize {
        (0..P::DIM).rev().fold(0, |at, i| at * self.cells.as_ref()[i] + self.along(i, x.coord(i)))
    }

    fn len(&self) -> usize {
        self.cells.as_ref().iter().product()
    }

    /// Visits the cells that meet the box of half side `reach` around `x`, as runs `first..=last` along the first axis.
    #[inline]
    fn each_run(&self, x: P, reach: f64, mut f: impl FnMut(usize, usize)) {
        let range = |i: usize| {
            let ends = [x.coord(i) - reach, x.coord(i) + reach];
            ends.map(|end| self.along(i, end))
        };
        let cells = self.cells.as_ref();
        let [first, last] = range(0);
        if P::DIM > 3 {
            // An odometer over the other axes.
            let ends = P::Axes::from_fn(|i| if i == 0 { [0, 0] } else { range(i) });
            let (ends, mut at) = (ends.as_ref(), P::Axes::from_fn(|i| ends.as_ref()[i][0]));
            let at = at.as_mut();
            loop {
                let row = (1..P::DIM).rev().fold(0, |row, i| row * cells[i] + at[i]) * cells[0];
                f(row + first, row + last);
                let Some(axis) = (1..P::DIM).find(|&i| at[i] < ends[i][1]) else { return };
                at[axis] += 1;
                at[1..axis].iter_mut().zip(&ends[1..axis]).for_each(|(at, end)| *at = end[0]);
            }
        }
        let [y, y_last] = range(1);
        let [z, z_last] = if P::DIM == 3 { range(2) } else { [0, 0] };
        for k in z..=z_last {
            for j in y..=y_last {
                let row = (k * cells[1] + j) * cells[0];
                f(row + first, row + last);
            }
        }
    }
}

/// Finds the graph neighbours, among the `members`, of the first `rows` of them. The neighbours are positions in the
/// table, in the order of the cells.
pub fn graph_by_grid<P: Point>(
    rule: Supergraph,
    table: &[P],
    radii2: &[f64],
    members: &[u32],
    rows: usize,
    cost: &mut Cost,
) -> Lists<u32> {
    let member = |&i: &u32| Member { x: table[i as usize], r2: radii2[i as usize], index: i };
    let members: Vec<Member<P>> = cost.map(members, member);
    let largest2 = cost.reduce(&members, 0.0, |m: f64, c| m.max(c.r2));
    let grid = Grid::of(&members, cost);
    let numbered: Vec<(u64, &Member<P>)> = (0..).zip(&members).collect();
    // Members of the same cell keep their order.
    let mut keys = cost.map(&numbered, |(i, m)| (grid.cell(m.x) as u64) << 32 | i);
    cost.sort(&mut keys, Ord::cmp);
    let sorted = cost.map(&keys, |&key| members[key as u32 as usize]);
    let counts = cost.reduce(&keys, vec![0; grid.len() + 1], |mut counts, &key| {
        counts[(key >> 32) as usize] += 1;
        counts
    });
    let (starts, _) = cost.scan(&counts);

    let mut lists = Lists::default();
    // A branch on membership would be unpredictable. Instead, each candidate is written, and the next one overwrites a
    // candidate that is not a neighbour.
    let mut neighbours = vec![0; members.len() + 1];
    cost.map_nested(&members[..rows], |row, own| {
        let mut sweep = own.sweep();
        let mut count = 0;
        grid.each_run(row.x, rule.reach(row.r2, largest2), |first, last| {
            sweep.each(&sorted[starts[first]..starts[last + 1]], |c| {
                neighbours[count] = c.index;
                let joins = rule.joins(dist2(row.x, c.x), row.r2, c.r2) && row.index != c.index;
                count += usize::from(joins);
            });
        });
        own.charge_sweep(sweep);
        lists.push(neighbours[..count].iter().copied());
    });
    lists
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::graph_direct;
    use crate::hash::Draw;
    use glam::{DVec2, DVec3};

    /// Compares with the lists of all pairs, and returns the number of pairs tested for each row.
    fn checked<P: Point>(points: &[P], radii2: &[f64], rows: usize) -> f64 {
        let members: Vec<u32> = (0..points.len() as u32).collect();
        let rule = Supergraph::Density { alpha: 1.0 };
        let (mut cost, mut all) = (Cost::default(), Cost::default());
        let near = graph_by_grid(rule, points, radii2, &members, rows, &mut cost);
        let direct = graph_direct(rule, points, radii2, &members[..rows], &members, &mut all);
        assert_eq!(near.len(), rows);
        for (i, expected) in direct.iter().enumerate() {
            let mut list = near[i].to_vec();
            list.sort_unstable();
            assert_eq!(list, expected, "row {i}");
        }
        cost.work() as f64 / rows.max(1) as f64
    }

    #[test]
    fn lists_are_those_of_all_pairs() {
        let mut draw = Draw::new(5);
        for n in [0usize, 1, 2, 5, 40, 700] {
            let mut random_point = || DVec3::new(draw.unit(), draw.unit(), draw.unit());
            let cloud: Vec<DVec3> = (0..n).map(|_| random_point()).collect();
            let flat: Vec<DVec3> = cloud.iter().map(|p| DVec3::new(0.25, p.y, p.z)).collect();
            let line: Vec<DVec3> = cloud.iter().map(|p| DVec3::new(p.x, 2.0 * p.x, -p.x)).collect();
            let plane: Vec<DVec2> = cloud.iter().map(|p| DVec2::new(p.x, p.y * p.y)).collect();
            for size in [1e-3, 0.05, 0.3, 2.0, 1e200] {
                let radii2: Vec<f64> = (0..n)
                    .map(|i| (size * size * (0.2 + draw.unit())).min(f64::MAX) * f64::from(i as u32 % 3 + 1))
                    .collect();
                checked(&cloud, &radii2, n);
                checked(&cloud, &radii2, n / 2);
                checked(&flat, &radii2, n);
                checked(&line, &radii2, n / 3);
                checked(&plane, &radii2, n);
            }
        }
    }

    #[test]
    fn work_is_linear_where_balls_hold_a_constant_number() {
        let mut draw = Draw::new(6);
        let works = [500usize, 4000].map(|n| {
            let points: Vec<DVec3> =
                (0..n).map(|_| DVec3::new(draw.unit(), draw.unit(), draw.unit())).collect();
            let r = 1.4 / (n as f64).cbrt();
            checked(&points, &vec![r * r; n], n)
        });
        assert!(works[1] < 1.7 * works[0] && works[1] < 200.0, "{works:?}");
    }

    #[test]
    fn distances_of_exactly_a_radius_are_found() {
        // A grid whose cells coincide with those of the points.
        let points: Vec<DVec2> =
            (0..4096).map(|i| DVec2::new(f64::from(i % 64), f64::from(i / 64)) * 0.1).collect();
        checked(&points, &vec![dist2(points[0], points[1]); 4096], 4096);
    }
}
