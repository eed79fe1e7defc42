//! The fifth level: every interior facet is locally Delaunay.
//!
//! **Statement.** For each cell and neighbour, the far vertex of the neighbour is not strictly inside the
//! circumsphere of the cell. With weights, its lift is not strictly below the hyperplane through the lifts of the cell; that
//! is, it is not in conflict with the orthosphere of the cell. Interior facets correspond to the finite|finite ridges of the lifted hull ([`super`]).
//! Both cells of a facet give the same sign. If it is zero and the perturbation is required, the vertex must be
//! outside the perturbed circumsphere. In a periodic box, the neighbour is translated such that it has the facet of the cell.
//!
//! **Work.** O(1) per facet.

use std::cmp::Ordering;

use super::facets::{BROKEN, Facets};
use super::fault::Fault;
use super::place::Place;
use super::predicates::tie_inside;
use super::report::Tally;
use super::runner::Runner;
use super::soup::Soup;

/// Checks the level `empty spheres`.
pub(super) fn check<P: Place<D>, const D: usize, const N: usize>(
    soup: &Soup<P, D, N>,
    facets: &Facets,
    perturbed: bool,
    runner: &mut Runner<'_>,
) -> Tally {
    runner.each("empty spheres", soup.cells.len(), |range, tally| {
        for cell in range {
            let corners = soup.corners(cell as u32);
            for slot in 0..N {
                let facet = cell * N + slot;
                let twin = facets.twin[facet];
                let next = twin / N as u32;
                if twin < BROKEN && facet < twin as usize && !soup.is_flat(cell as u32) && !soup.is_flat(next)
                {
                    tally.checked += 1;
                    let by = soup.across(cell as u32, slot, twin);
                    let far = soup.cells[next as usize][twin as usize % N].moved(by);
                    let (cells, vertex) = ([cell as u64, next as u64], far.row as u64);
                    match soup.in_sphere(cell as u32, &corners, far) {
                        Ordering::Less => {}
                        Ordering::Greater => tally.fault(Fault::NotEmpty { cells, vertex }),
                        Ordering::Equal => {
                            tally.ties += 1;
                            if perturbed && tie_inside(&corners, &soup.place(far)) {
                                tally.fault(Fault::TieBrokenOtherwise { cells, vertex });
                            }
                        }
                    }
                }
            }
        }
    })
}
