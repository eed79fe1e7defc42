//! The insertion of a vertex into a bad cell and cells around it.
//!
//! **Statement.** A vertex is placed in the middle of the cell, of one of its edges, or of one of its faces on a facet.
//! The cells around that place form a cavity. The cavity grows across the face that makes the worst cell with the new
//! vertex, as long as this helps, but never across a face on a facet. The cells of the cavity are replaced by one cell
//! for each of its faces. Then the vertex moves to a better place ([`super::moves`]).
//! - All new cells are positive (exact sign), so the cavity is star-shaped, and they cover it.
//! - A vertex on a segment or in a facet divides its edges and faces. No other edge on a segment, and no vertex outside
//!   the volume, may lie inside the cavity. Remeshed boundaries are not divided.
//!
//! **Source.** Klingner and Shewchuk (2007).
//!
//! **Work and depth.** O(1) for a cell.

use super::change::{Change, Kind, NEW, Placed, sorted};
use super::editable::{Editable, without};
use super::moves::Fan;
use super::rules::{Rules, measured};
use super::shape::{Grade, grade};
use crate::mesh::Carrier;
use crate::space::{Space, ascending};

/// The largest number of cells that a cavity gains.
const STEPS: usize = 24;

/// The number of cavities of a cell, the best ones, whose new vertices move. Moves cost most of the time.
const MOVED: usize = 3;

/// The place of a new vertex.
struct Seed<P> {
    at: P,
    carrier: Carrier,
    /// The vertices of the cell, edge or face that contains it.
    of: Vec<u32>,
    cells: Vec<u32>,
}

/// A face of a cavity: a row of a cell, the place of the opposite vertex, and the component.
#[derive(Clone, Copy)]
struct Side {
    key: [u32; 3],
    row: [u32; 4],
    slot: usize,
    region: u32,
    cell: u32,
    sine: f64,
}

/// Returns the best insertion into a cell.
pub(super) fn insert<P: Space>(mesh: &Editable<P>, rules: &Rules<'_, P>, cell: u32) -> Option<Change<P>> {
    let seeds = seeds(mesh, rules, cell);
    let grow = |seed| {
        let (cells, sides) =
            Cavity { mesh, seed, cells: Vec::new(), sides: Vec::new() }.grow(rules.wanted)?;
        let worst = sides.iter().map(|s| s.sine).fold(f64::INFINITY, f64::min);
        keeps(mesh, seed, &cells, &sides).then_some(Grown { seed, cells, sides, worst })
    };
    let mut all: Vec<Grown<'_, P>> = seeds.iter().filter_map(grow).collect();
    // The sort is stable, so ties stay in the order of the seeds.
    all.sort_by(|a, b| b.worst.total_cmp(&a.worst));
    let changes = all.into_iter().take(MOVED).filter_map(|grown| moved(mesh, rules, grown));
    changes.reduce(|a, b| if b.grade.sine > a.grade.sine { b } else { a })
}

/// A cavity that has grown.
struct Grown<'a, P> {
    seed: &'a Seed<P>,
    cells: Vec<u32>,
    sides: Vec<Side>,
    /// The least sine of the new cells.
    worst: f64,
}

fn seeds<P: Space>(mesh: &Editable<P>, rules: &Rules<'_, P>, cell: u32) -> Vec<Seed<P>> {
    let row = mesh.cells[cell as usize];
    let middle = |of: &[u32]| {
        rules
            .snapped(of.iter().fold(P::splat(0.0), |sum, &v| sum + mesh.points[v as usize] / of.len() as f64))
    };
    let mut found =
        vec![Seed { at: middle(&row), carrier: Carrier::Volume, of: row.to_vec(), cells: vec![cell] }];
    let can_divide = rules.surface.is_none() && !rules.target.fixed;
    for (i, j) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
        let edge = ascending([row[i], row[j]]);
        let cells = mesh.around(edge);
        let wall = |&c: &u32| {
            let rest = mesh.cells[c as usize].into_iter().filter(|v| !edge.contains(v));
            rest.filter_map(|v| mesh.faces.get(&sorted([edge[0], edge[1], v])).copied()).collect::<Vec<_>>()
        };
        let mut walls: Vec<u32> = cells.iter().flat_map(wall).collect();
        walls.dedup();
        let carrier = match (mesh.edges.get(&edge), walls.as_slice()) {
            (None, []) => Carrier::Volume,
            (Some(&s), _) if can_divide => Carrier::Segment(s),
            (None, &[f]) if can_divide => Carrier::Facet(f),
            _ => continue,
        };
        found.push(Seed { at: middle(&edge), carrier, of: edge.to_vec(), cells });
    }
    for face in row.map(|v| without(row, v)) {
        if let Some(&facet) = mesh.faces.get(&sorted(face)).filter(|_| can_divide) {
            let cells = std::iter::once(cell).chain(mesh.across(cell, face)).collect();
            found.push(Seed { at: middle(&face), carrier: Carrier::Facet(facet), of: face.to_vec(), cells });
        }
    }
    found
}

/// A growing cavity.
struct Cavity<'a, P: Space> {
    mesh: &'a Editable<P>,
    seed: &'a Seed<P>,
    cells: Vec<u32>,
    sides: Vec<Side>,
}

impl<P: Space> Cavity<'_, P> {
    /// Adds a cell. Returns `false` if a face on a facet would lie inside the cavity.
    fn add(&mut self, cell: u32) -> bool {
        let row = self.mesh.cells[cell as usize];
        self.cells.push(cell);
        for (slot, &v) in row.iter().enumerate() {
            let key = sorted(without(row, v));
            let is_divided = self.seed.of.len() < 4 && self.seed.of.iter().all(|v| key.contains(v));
            if is_divided {
                continue;
            }
            if let Some(at) = self.sides.iter().position(|s| s.key == key) {
                if self.mesh.faces.contains_key(&key) {
                    return false;
                }
                self.sides.swap_remove(at);
                continue;
            }
            let mut corners = self.mesh.places(row);
            corners[slot] = self.seed.at;
            let region = self.mesh.regions[cell as usize];
            self.sides.push(Side { key, row, slot, region, cell, sine: grade(&corners).sine });
        }
        true
    }

    /// Grows the cavity. Returns its best state: cells and faces.
    fn grow(mut self, wanted: f64) -> Option<(Vec<u32>, Vec<Side>)> {
        if !self.seed.cells.iter().all(|&c| self.add(c)) {
            return None;
        }
        let mut best: Option<(f64, Vec<u32>, Vec<Side>)> = None;
        for _ in 0..STEPS {
            let worst =
                *self.sides.iter().min_by(|a, b| a.sine.total_cmp(&b.sine).then(a.key.cmp(&b.key)))?;
            if worst.sine > best.as_ref().map_or(0.0, |b| b.0) {
                best = Some((worst.sine, self.cells.clone(), self.sides.clone()));
            }
            if worst.sine > wanted || self.mesh.faces.contains_key(&worst.key) {
                break;
            }
            let Some(next) = self.mesh.across(worst.cell, worst.key) else { break };
            if self.cells.contains(&next) || !self.add(next) {
                break;
            }
        }
        best.map(|b| (b.1, b.2))
    }
}

/// Moves the new vertex of a cavity to a better place.
fn moved<P: Space>(mesh: &Editable<P>, rules: &Rules<'_, P>, grown: Grown<'_, P>) -> Option<Change<P>> {
    let Grown { seed, cells, sides, .. } = grown;
    let (before, worst) = measured(mesh, &cells);
    let rows = sides.iter().map(|s| (mesh.places(s.row), s.slot)).collect();
    let fan = Fan { cells: rows, ratio: rules.ratio(worst) };
    let size = seed.of.iter().map(|&v| mesh.sizes[v as usize]).sum::<f64>() / seed.of.len() as f64;
    let start = Placed { vertex: NEW, at: seed.at, carrier: seed.carrier, size };
    let first = fan.at(rules, seed.at, 0.0).unwrap_or(Grade { sine: 0.0, least: 0.0 });
    let ends = || [0, 1].map(|i| mesh.points[seed.of[i] as usize]);
    let place = |centre: P, d: P, step: f64| match seed.carrier {
        Carrier::Segment(_) => {
            let [p, q] = ends();
            let t = (centre + d * step - p).dot(q - p) / (q - p).norm2();
            (0.1 < t && t < 0.9).then(|| (p + (q - p) * t, seed.carrier))
        }
        Carrier::Facet(f) => {
            let n = rules.normals[f as usize];
            Some((centre + (d - n * n.dot(d)) * step, seed.carrier))
        }
        _ => Some((centre + d * step, seed.carrier)),
    };
    let (placed, grade) =
        fan.climb(rules, (start, 0.1 * size), first, place, |at, carrier| Some((at, carrier)));
    if !grade.is_worth(before, rules.wanted) {
        return None;
    }
    let row = |s: &Side| {
        let mut row = s.row;
        row[s.slot] = NEW;
        (row, s.region)
    };
    let mut change = Change::of(Kind::Insert, grade, cells, sides.iter().map(row).collect());
    change.placed = Some(placed);
    divide(mesh, seed, &mut change);
    Some(change)
}

/// Returns `true` if nothing that must remain lies inside a cavity.
fn keeps<P: Space>(mesh: &Editable<P>, seed: &Seed<P>, cells: &[u32], sides: &[Side]) -> bool {
    let is_seed = |edge: &[u32; 2]| seed.of.len() == 2 && edge.iter().all(|v| seed.of.contains(v));
    cells.iter().all(|&c| {
        let row = mesh.cells[c as usize];
        let is_vertex_kept = |&v: &u32| {
            mesh.carriers[v as usize] == Carrier::Volume || sides.iter().any(|s| s.key.contains(&v))
        };
        let edges =
            (0..4).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| ascending([row[i], row[j]]));
        let mut listed = edges.filter(|e| mesh.edges.contains_key(e) && !is_seed(e));
        row.iter().all(is_vertex_kept)
            && listed.all(|e| sides.iter().any(|s| e.iter().all(|v| s.key.contains(v))))
    })
}

/// Divides the edge and the faces that contain the new vertex.
fn divide<P: Space>(mesh: &Editable<P>, seed: &Seed<P>, change: &mut Change<P>) {
    match *seed.of.as_slice() {
        [a, b] => {
            if let Some(&segment) = mesh.edges.get(&[a, b]) {
                change.lost_edges.push([a, b]);
                change.made_edges.extend([([a, NEW], segment), ([b, NEW], segment)]);
            }
            let rest = seed.cells.iter().flat_map(|&c| mesh.cells[c as usize]);
            let mut rest: Vec<u32> = rest.filter(|&v| v != a && v != b).collect();
            rest.sort_unstable();
            rest.dedup();
            for v in rest {
                if let Some(&facet) = mesh.faces.get(&sorted([a, b, v])) {
                    change.lost_faces.push(sorted([a, b, v]));
                    change.made_faces.extend([([a, v, NEW], facet), ([b, v, NEW], facet)]);
                }
            }
        }
        [a, b, c] => {
            if let Some(&facet) = mesh.faces.get(&sorted([a, b, c])) {
                change.lost_faces.push(sorted([a, b, c]));
                change.made_faces.extend([[a, b, NEW], [b, c, NEW], [c, a, NEW]].map(|face| (face, facet)));
            }
        }
        _ => {}
    }
}
