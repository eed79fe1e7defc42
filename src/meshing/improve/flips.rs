//! Flips: the removal of an edge, and the 2-3 flip of a face.
//!
//! **Statement.** The cells around an edge ab form a fan: a ring, or a path from one face on a facet to another. The
//! edge is removed by a triangulation of the polygon of the other vertices. Each triangle makes one cell with a and
//! one with b. Dynamic programming finds the triangulation with the best worst cell among those whose cells are all
//! positive (exact sign). Rings of three and four cells are the flips 3-2 and 4-4.
//! - *In a facet.* If two faces abc and abd of one facet meet at the edge and no segment contains it, the faces become
//!   cda and cdb (a 2-2 flip). The fan on each side changes with them. The diagonals must cross in the facet (exact).
//! - *At a remeshed boundary.* The two faces may lie on any facets. The mesh loses the cell abcd, which must be
//!   positive, so the new cells lie inside the old ones. If the fan is one cell, it is peeled. The edge cd must be no
//!   edge of the boundary before, so each edge keeps two faces and each vertex one fan. No face turns by more than 60
//!   degrees, and the boundary still follows the surface ([`super::surface`]).
//!
//! *The result covers the same part of space.* New and old cells have the same boundary, up to the cell abcd, which is
//! flat in a facet. As all cells are positive, they cover what they bound once ([`crate::conformity`]).
//!
//! **Source.** Freitag and Ollivier-Gooch (1997), Shewchuk (2002): Two discrete optimization algorithms; Klincsek
//! (1980) for the dynamic program.
//!
//! **Work and depth.** O(k^3) for k cells around an edge, k at most [`WIDEST`].

use septet_geometry::predicates::{Sign, orientation};

use super::change::{Change, Kind, sorted};
use super::editable::{Editable, without};
use super::moves::size_of;
use super::rules::{Rules, measured};
use super::shape::Grade;
use crate::angles::cosine;
use crate::quality::angles::measure;
use crate::space::{Space, ascending};

/// The largest number of cells around an edge that is removed.
const WIDEST: usize = 10;

/// A path of cells around an edge: the other vertices in order, and the component.
struct Fan {
    vertices: Vec<u32>,
    region: u32,
}

/// The cells around an edge.
struct Around {
    edge: [u32; 2],
    cells: Vec<u32>,
    fans: Vec<Fan>,
    /// The faces on facets at the edge, with their third vertices and their facets. Two or none.
    walls: Vec<(u32, u32)>,
}

/// Returns the vertices c and d of a positive row that is an even permutation of (a, b, c, d).
fn link(row: [u32; 4], [a, b]: [u32; 2]) -> [u32; 2] {
    let place = |v: u32| row.iter().position(|&w| w == v).unwrap_or_default();
    let (i, j) = (place(a), place(b));
    let mut rest = (0..4).filter(|&k| k != i && k != j);
    let (k, l) = (rest.next().unwrap_or_default(), rest.next().unwrap_or_default());
    let order = [i, j, k, l];
    let inversions =
        (0..4).flat_map(|x| (x + 1..4).map(move |y| (x, y))).filter(|&(x, y)| order[x] > order[y]);
    if inversions.count() % 2 == 0 { [row[k], row[l]] } else { [row[l], row[k]] }
}

impl Around {
    /// Finds the fans around an edge. Returns `None` if it cannot be removed.
    fn new<P: Space>(mesh: &Editable<P>, edge: [u32; 2]) -> Option<Self> {
        if mesh.edges.contains_key(&ascending(edge)) {
            return None;
        }
        let cells = mesh.around(edge);
        if cells.len() > WIDEST {
            return None;
        }
        let links: Vec<([u32; 2], u32)> =
            cells.iter().map(|&c| (link(mesh.cells[c as usize], edge), mesh.regions[c as usize])).collect();
        let mut ends: Vec<u32> = links.iter().flat_map(|l| l.0).collect();
        ends.sort_unstable();
        ends.dedup();
        let wall = |&v: &u32| Some((v, *mesh.faces.get(&sorted([edge[0], edge[1], v]))?));
        let walls: Vec<(u32, u32)> = ends.iter().filter_map(wall).collect();
        let starts = match walls[..] {
            [] => vec![*ends.first()?],
            [(x, _), (y, _)] => vec![x, y],
            _ => return None,
        };
        let mut fans = Vec::new();
        for &start in &starts {
            let next = |v: u32| links.iter().find(|l| l.0[0] == v).map(|l| (l.0[1], l.1));
            let Some((mut v, region)) = next(start) else { continue };
            let mut vertices = vec![start];
            while !starts.contains(&v) {
                vertices.push(v);
                v = next(v)?.0;
                if vertices.len() > links.len() {
                    return None;
                }
            }
            if starts.len() == 2 {
                vertices.push(v);
            }
            fans.push(Fan { vertices, region });
        }
        let used: usize = fans.iter().map(|f| f.vertices.len() + 1 - starts.len()).sum();
        (used == links.len()).then_some(Around { edge, cells, fans, walls })
    }
}

/// Returns the best change that removes an edge.
pub(super) fn remove_edge<P: Space>(
    mesh: &Editable<P>,
    rules: &Rules<'_, P>,
    edge: [u32; 2],
) -> Option<Change<P>> {
    let around = Around::new(mesh, edge)?;
    let (before, worst) = measured(mesh, &around.cells);
    let mut change = Change::of(Kind::Flip, Grade::BEST, around.cells.clone(), Vec::new());
    if !around.walls.is_empty() {
        walls(mesh, rules, &around, &mut change)?;
    }
    for fan in &around.fans {
        let grade = triangulate(mesh, rules, (edge, rules.ratio(worst), before.sine), fan, &mut change.new)?;
        change.grade = change.grade.and(grade);
    }
    change.grade.is_worth(before, rules.wanted).then_some(change)
}

/// Replaces the two faces at an edge. Returns `None` if they must remain.
fn walls<P: Space>(
    mesh: &Editable<P>,
    rules: &Rules<'_, P>,
    around: &Around,
    change: &mut Change<P>,
) -> Option<()> {
    let (&[(c, f), (d, g)], [a, b]) = (around.walls.as_slice(), around.edge) else { return None };
    if rules.target.fixed {
        return None;
    }
    change.lost_faces = vec![sorted([a, b, c]), sorted([a, b, d])];
    let new = [sorted([c, d, a]), sorted([c, d, b])];
    if new.iter().any(|face| mesh.faces.contains_key(face)) {
        return None;
    }
    let places = mesh.places([a, b, c, d]);
    let Some(surface) = &rules.surface else {
        if f != g || !rules.cross(f, places) {
            return None;
        }
        change.made_faces = new.map(|face| (face, f)).to_vec();
        return Some(());
    };
    let [fan] = around.fans.as_slice() else { return None };
    let (first, last) = (fan.vertices[0], fan.vertices[fan.vertices.len() - 1]);
    let removed = mesh.places([a, b, first, last]);
    if orientation(&removed) != Sign::Positive {
        return None;
    }
    change.fresh = Some(ascending([c, d]));
    if fan.vertices.len() == 2 {
        change.kind = Kind::Peel;
    }
    change.shrinks = measure(&removed);
    let [p, q, first, last] = removed;
    // All normals point out of the mesh.
    let normals = [[p, q, first], [q, p, last], [p, last, first], [q, first, last]];
    let normals = normals.map(|[x, y, z]| P::hull_normal(&[y - x, z - x]));
    if (0..2).any(|i| (2..4).any(|j| cosine(normals[i], normals[j]) < 0.5)) {
        return None;
    }
    let sized = |face: &[u32; 3]| (mesh.triangle(*face), size_of(mesh, *face));
    let old: Vec<_> = change.lost_faces.iter().map(sized).collect();
    let made: Vec<_> = new.iter().map(sized).collect();
    if !surface.permits(&old, || surface.off_all(&old), &made) {
        return None;
    }
    let facet = |face: [u32; 3]| {
        let [x, y, z] = mesh.triangle(face);
        Some((face, if f == g { f } else { surface.nearest((x + y + z) / 3.0)?.1 }))
    };
    change.made_faces = vec![facet(new[0])?, facet(new[1])?];
    Some(())
}

/// A cell with its value for the dynamic program.
type Choice = (f64, usize);

/// Adds the best cells on a fan. Returns their grade, or `None` if some sine is at most `above`.
fn triangulate<P: Space>(
    mesh: &Editable<P>,
    rules: &Rules<'_, P>,
    ([a, b], ratio, above): ([u32; 2], f64, f64),
    fan: &Fan,
    new: &mut Vec<([u32; 4], u32)>,
) -> Option<Grade> {
    let v = &fan.vertices;
    let rows = |i: usize, k: usize, j: usize| [[v[i], v[k], v[j], b], [v[i], v[j], v[k], a]];
    let grade = |i: usize, k: usize, j: usize| {
        let mut all = Grade::BEST;
        for row in rows(i, k, j) {
            all = all.and(rules.admits(&mesh.places(row), ratio)?);
        }
        (all.sine > above).then_some(all)
    };
    let n = v.len();
    let mut best: Vec<Vec<Choice>> = vec![vec![(f64::INFINITY, 0); n]; n];
    for width in 2..n {
        for i in 0..n - width {
            let j = i + width;
            best[i][j] = (f64::NEG_INFINITY, 0);
            for k in i + 1..j {
                let parts = best[i][k].0.min(best[k][j].0);
                if parts <= best[i][j].0 {
                    continue;
                }
                let value = grade(i, k, j).map_or(f64::NEG_INFINITY, |g| g.sine.min(parts));
                if value > best[i][j].0 {
                    best[i][j] = (value, k);
                }
            }
        }
    }
    let mut all = Grade::BEST;
    let mut open = vec![(0, n - 1)];
    while let Some((i, j)) = open.pop() {
        let (value, k) = best[i][j];
        if j <= i + 1 {
            continue;
        }
        if value == f64::NEG_INFINITY {
            return None;
        }
        all = all.and(grade(i, k, j)?);
        new.extend(rows(i, k, j).map(|row| (row, fan.region)));
        open.extend([(i, k), (k, j)]);
    }
    Some(all)
}

/// Returns the 2-3 flip of the face opposite a vertex of a cell.
pub(super) fn flip_face<P: Space>(
    mesh: &Editable<P>,
    rules: &Rules<'_, P>,
    cell: u32,
    slot: usize,
) -> Option<Change<P>> {
    let row = mesh.cells[cell as usize];
    let face = without(row, row[slot]);
    if mesh.faces.contains_key(&sorted(face)) {
        return None;
    }
    let other = mesh.across(cell, face)?;
    let apex = mesh.cells[other as usize].into_iter().find(|v| !face.contains(v))?;
    let old = vec![cell, other];
    let (before, worst) = measured(mesh, &old);
    let (mut grade, mut new) = (Grade::BEST, Vec::new());
    for j in (0..4).filter(|&j| j != slot) {
        let mut made = row;
        made[j] = apex;
        grade = grade.and(rules.admits(&mesh.places(made), rules.ratio(worst))?);
        new.push((made, mesh.regions[cell as usize]));
    }
    grade.is_worth(before, rules.wanted).then_some(Change::of(Kind::Flip, grade, old, new))
}
