//! Removal of slivers.
//!
//! **Statement.** The quality of a cell is the smallest sine of its angles (in space: dihedral angles). While there are
//! cells below a target, the algorithm changes few cells at a time:
//! 1. it removes edges and flips faces, also in facets, and peels cells at a remeshed boundary (`flips`);
//! 2. it moves vertices, also in facets, on segments and on a remeshed surface (`moves`);
//! 3. where nothing else helps, it inserts vertices (`insert`) or merges them (`merge`).
//!
//! In the plane, vertices move, and nothing else happens.
//! - *The least angle never decreases.* A change is applied only if the least sine of its new cells is above that of
//!   the old ones. Their least angle must not be below the smaller of the target and the old least angle.
//! - *The mesh still conforms.* New cells are positive (exact sign), and they cover the old ones, except for cells that
//!   are peeled. The proof for each kind of change is in its file. [`crate::conformity`] checks the result.
//! - *It ends.* Each change raises the least sine of the cells that it replaces. The numbers of rounds and of searches
//!   are limited, because some angles of an input forbid the target.
//! - The mesh is no longer Delaunay where cells have changed. No radius-edge ratio rises above the larger of the bound
//!   and the worst previous ratio of the replaced cells.
//!
//! **Source.** Klingner and Shewchuk (2007), Freitag and Ollivier-Gooch (1997).
//!
//! **Rounds.** In each round, the best change for every bad cell is found in parallel, from the same mesh. Then the
//! changes are applied in sequence, the worst cells first. A change is left for the next round if one of its cells has
//! been changed in this round. The changes of a round therefore belong to an independent set of bad cells, and the
//! result is the same for any number of workers.
//!
//! **Work and depth.** O(1) per bad cell and round, in parallel; O(1) per applied change, in sequence.

mod change;
mod editable;
mod flips;
mod insert;
mod merge;
mod moves;
mod rules;
mod shape;
mod surface;
mod target;

use septet_geometry::range::scale;

use crate::domain::Domain;
use crate::executor::Executor;
use crate::mesh::Mesh;
use crate::space::Space;
use change::Change;
use editable::Editable;
use rules::Rules;
pub use shape::least_sine;
pub use target::{Improved, Target};

/// The largest part of the volume that the changes of a remeshed boundary may remove.
const SHRINKS: f64 = 1e-3;

/// The largest number of bad cells for which changes are searched, in all rounds together, is four times the number at
/// first, and this number. It bounds the work if the angles of the input forbid the target.
const EFFORT: usize = 2000;

/// The number of levels of changes.
const LEVELS: u8 = 2;

/// Improves a mesh of this domain in place.
pub fn improve<P: Space>(
    domain: &Domain<P>,
    mesh: &mut Mesh<P>,
    target: &Target,
    executor: &impl Executor,
) -> Improved {
    // Signs are exact in the scaled coordinates of the domain.
    let frame = domain.simplices.frame;
    let scaled = |mesh: &mut Mesh<P>, exponent: i32, way: &dyn Fn(P) -> P| {
        mesh.points.iter_mut().for_each(|p| *p = way(*p));
        mesh.sizes.iter_mut().for_each(|s| *s = scale(P::splat(*s), exponent).coord(0));
    };
    scaled(mesh, frame.exponent, &|p| frame.inward(p));
    let mut editable = Editable::new(mesh);
    let done = rounds(&Rules::new(domain, target), &mut editable, executor);
    if done.changes() > 0 {
        editable.write(domain, mesh);
    }
    scaled(mesh, -frame.exponent, &|p| frame.outward(p));
    done
}

fn rounds<P: Space>(rules: &Rules<'_, P>, mesh: &mut Editable<P>, executor: &impl Executor) -> Improved {
    let mut bad = mesh.bad(rules.wanted);
    let mut done = Improved { bad: [bad.len() as u64; 2], ..Improved::default() };
    let mut room = SHRINKS * mesh.volume();
    let mut effort = 4 * bad.len() + EFFORT;
    while done.sweeps < rules.target.sweeps {
        let failed = |c: &u32| mesh.failed[*c as usize];
        let Some(level) = bad.iter().map(failed).min().filter(|&level| level < LEVELS) else { break };
        bad.retain(|c| failed(c) == level);
        bad.truncate(effort);
        effort -= bad.len();
        if bad.is_empty() {
            break;
        }
        done.sweeps += 1;
        let found = executor.map(&bad, |&cell| propose(mesh, rules, cell, level));
        for (&cell, change) in bad.iter().zip(&found) {
            match change {
                None => mesh.failed[cell as usize] = level + 1,
                Some(change) if change.shrinks <= room && mesh.fits(change, done.sweeps) => {
                    room -= change.shrinks;
                    done.count(change.kind);
                    mesh.apply(change, done.sweeps);
                }
                Some(change) if change.shrinks > room => mesh.failed[cell as usize] = level + 1,
                Some(_) => {}
            }
        }
        bad = mesh.bad(rules.wanted);
    }
    done.bad[1] = mesh.bad(rules.wanted).len() as u64;
    done
}

/// Returns the best change for a bad cell.
fn propose<P: Space>(mesh: &Editable<P>, rules: &Rules<'_, P>, cell: u32, level: u8) -> Option<Change<P>> {
    let row = mesh.cells[cell as usize];
    let row = &row[..=P::DIM];
    let mut best: Option<Change<P>> = None;
    // The first change that reaches the target is taken.
    let mut take = |found: Option<Change<P>>| {
        let sine = |change: &Option<Change<P>>| change.as_ref().map_or(0.0, |c| c.grade.sine);
        if sine(&found) > sine(&best) {
            best = found;
        }
        sine(&best) >= rules.wanted
    };
    let edges = || (0..row.len()).flat_map(|i| (0..i).map(move |j| [row[j], row[i]]));
    if P::DIM == 3 && level == 0 {
        let _ = edges().any(|edge| take(flips::remove_edge(mesh, rules, edge)))
            || (0..row.len()).any(|slot| take(flips::flip_face(mesh, rules, cell, slot)))
            || row.iter().any(|&v| take(moves::slide(mesh, rules, v)));
    } else if level == 0 {
        let _ = row.iter().any(|&v| take(moves::slide(mesh, rules, v)));
    } else if P::DIM == 3 {
        let _ = row.iter().any(|&v| take(merge::merge(mesh, rules, v)))
            || take(insert::insert(mesh, rules, cell));
    }
    best
}
