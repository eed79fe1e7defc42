//! The graph neighbours of a leaf's points through a grid, where balls are small beside the leaf.
//!
//! **Statement.** An edge of `i` is no longer than its reach `R_i` ([`Supergraph::reach`]) into the largest ball. The
//! box of the members is divided into `m` to `2m` equal cells, its longest side always halved first, so that a flat or
//! thin set has a flat or thin grid. All neighbours of `i` lie in the cells that the box of half side `R_i` around
//! it meets, and each of their members is compared by the one symmetric expression of the graph: the lists are those
//! of [`graph_direct`](crate::graph::graph_direct), edge by edge.
//!
//! *No neighbour is missed by rounding.* Where `|x - y| <= R` for two floats, rounded `x - R` is at most y, for y is a
//! float itself and rounding is monotone; the number of a cell is a monotone function of the coordinate. The reach is
//! rounded up by more than the rounding of a distance.
//!
//! **Source.** Cells of fixed size for near neighbours: Bentley, Stanat and Williams (1977).
//!
//! **Work and depth.** `O(m log m)` for the order of the cells, and the members of the cells that are met: a constant
//! number a point where members are spread evenly at the scale of the balls, and never more than all. Depth
//! `O(log m)`, of the sort; all else is a constant number of steps.

use crate::cost::Cost;
use crate::graph::Supergraph;
use crate::lists::Lists;
use crate::point::{Point, dist2};

/// A member, laid out for the search.
#[derive(Clone, Copy)]
struct Member<P> {
    x: P,
    r2: f64,
    number: u32,
}

/// Equal cells over a box.
struct Grid<P> {
    low: P,
    /// Cells along each axis: powers of two, 1 beyond the dimension.
    cells: [usize; 3],
    /// Cells a unit of length.
    scale: [f64; 3],
}

impl<P: Point> Grid<P> {
    /// One to two cells for each member.
    fn of(members: &[Member<P>], cost: &mut Cost) -> Self {
        let start = (P::splat(f64::INFINITY), P::splat(f64::NEG_INFINITY));
        let (low, high) = cost.reduce(members, start, |(mut low, mut high), m| {
            for i in 0..P::DIM {
                low.set_coord(i, low.coord(i).min(m.x.coord(i)));
                high.set_coord(i, high.coord(i).max(m.x.coord(i)));
            }
            (low, high)
        });
        let mut side = [0.0; 3];
        for (i, side) in side.iter_mut().enumerate().take(P::DIM) {
            *side = (high.coord(i) - low.coord(i)).max(0.0);
        }
        let (extent, mut cells, mut all) = (side, [1; 3], 1);
        while all < members.len() {
            let longest = (1..3).fold(0, |best, i| if side[i] > side[best] { i } else { best });
            cells[longest] *= 2;
            side[longest] *= 0.5;
            all *= 2;
        }
        let mut scale = [0.0; 3];
        for i in 0..3 {
            if extent[i] > 0.0 {
                scale[i] = cells[i] as f64 / extent[i];
            }
        }
        Grid { low, cells, scale }
    }

    /// The cell of a coordinate along an axis; monotone, and the nearest one for what lies outside.
    #[inline]
    fn along(&self, axis: usize, x: f64) -> usize {
        (((x - self.low.coord(axis)) * self.scale[axis]) as usize).min(self.cells[axis] - 1)
    }

    fn cell(&self, x: P) -> usize {
        (0..P::DIM).rev().fold(0, |at, i| at * self.cells[i] + self.along(i, x.coord(i)))
    }

    fn len(&self) -> usize {
        self.cells.iter().product()
    }

    /// The cells that the box of half side `reach` around `x` meets, as runs `first..=last` along the first axis.
    #[inline]
    fn runs(&self, x: P, reach: f64, mut f: impl FnMut(usize, usize)) {
        let range = |i: usize| {
            let ends = [x.coord(i) - reach, x.coord(i) + reach];
            ends.map(|end| self.along(i, end))
        };
        let [first, last] = range(0);
        let [y, y_last] = range(1);
        let [z, z_last] = if P::DIM == 3 { range(2) } else { [0, 0] };
        for k in z..=z_last {
            for j in y..=y_last {
                let row = (k * self.cells[1] + j) * self.cells[0];
                f(row + first, row + last);
            }
        }
    }
}

/// The graph neighbours, among the `members`, of the first `rows` of them; positions in the table, in the order of
/// cells.
pub fn graph_by_grid<P: Point>(
    rule: Supergraph,
    table: &[P],
    radii2: &[f64],
    members: &[u32],
    rows: usize,
    cost: &mut Cost,
) -> Lists<u32> {
    let member = |&i: &u32| Member { x: table[i as usize], r2: radii2[i as usize], number: i };
    let members: Vec<Member<P>> = cost.map(members, member);
    let largest2 = cost.reduce(&members, 0.0, |m: f64, c| m.max(c.r2));
    let grid = Grid::of(&members, cost);
    let numbered: Vec<(u64, &Member<P>)> = (0..).zip(&members).collect();
    // Members of a cell in their own order.
    let mut keys = cost.map(&numbered, |(i, m)| (grid.cell(m.x) as u64) << 32 | i);
    cost.sort(&mut keys, Ord::cmp);
    let sorted = cost.map(&keys, |&key| members[key as u32 as usize]);
    let counts = cost.reduce(&keys, vec![0; grid.len() + 1], |mut counts, &key| {
        counts[(key >> 32) as usize] += 1;
        counts
    });
    let (starts, _) = cost.scan(&counts);

    let mut lists = Lists::default();
    // Which members join is not foreseen by anything: each is written, and the next over it if it does not.
    let mut found = vec![0; members.len() + 1];
    cost.map_nested(&members[..rows], |row, own| {
        let mut sweep = own.sweep();
        let mut count = 0;
        grid.runs(row.x, rule.reach(row.r2, largest2), |first, last| {
            sweep.each(&sorted[starts[first]..starts[last + 1]], |c| {
                found[count] = c.number;
                let joins = rule.joins(dist2(row.x, c.x), row.r2, c.r2) && row.number != c.number;
                count += usize::from(joins);
            });
        });
        own.swept_inside(sweep);
        lists.push(found[..count].iter().copied());
    });
    lists
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::graph_direct;
    use crate::hash::Draw;
    use glam::{DVec2, DVec3};

    /// The lists of all pairs, and how many pairs were looked at for each row.
    fn checked<P: Point>(points: &[P], radii2: &[f64], rows: usize) -> f64 {
        let members: Vec<u32> = (0..points.len() as u32).collect();
        let rule = Supergraph::Density { alpha: 1.0 };
        let (mut cost, mut all) = (Cost::ZERO, Cost::ZERO);
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
            let mut place = || DVec3::new(draw.unit(), draw.unit(), draw.unit());
            let cloud: Vec<DVec3> = (0..n).map(|_| place()).collect();
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
        // A grid of cells that coincide with the points' own.
        let points: Vec<DVec2> =
            (0..4096).map(|i| DVec2::new(f64::from(i % 64), f64::from(i / 64)) * 0.1).collect();
        checked(&points, &vec![dist2(points[0], points[1]); 4096], 4096);
    }
}
