//! The result of a recovery: the components of its cells, its faces on patches and its edges.
//!
//! **Statement.** Cells that share a face outside all patches are in one component. A patch gives the components on its
//! two sides: those of its walls. Cells at the hull of the box are outside.
//!
//! **Work and depth.** `O(n log n)` for n cells.

use std::collections::BTreeMap;

use glam::DVec3;
use septet_geometry::predicates::Sign;

use super::cells::{NONE, face_of, key};
use super::facets::Kept;
use super::layout::{Part, space};
use super::recovered::{Line, Recovered};
use super::rounding::{OnPart, settle};
use super::{BOX, Lost, Recovery, apex};
use crate::domain::{Domain, Feature};
use crate::generate::CellLabels;
use crate::mesh::Carrier;
use crate::sides::Sets;
use crate::space::{Space, ascending};

impl Recovery<'_> {
    /// Returns the components on the two sides of each patch, first on the side of its apex.
    fn sides<P: Space>(&self, domain: &Domain<P>) -> Vec<(u32, [u32; 2])> {
        let label = |c: u32| if domain.components[c as usize].inside { c } else { CellLabels::OUT };
        let side = |patch: &super::layout::Patch| {
            let [a, b, c] = patch.triangles[0];
            let apex = apex(&self.points, [a, b, c]);
            let [p, n] = domain.sides.components_at(patch.wall).map(label);
            let positive = self.points.orientation([a, b, c, apex]) == Sign::Positive;
            (apex, if positive { [p, n] } else { [n, p] })
        };
        self.layout.patches.iter().map(side).collect()
    }

    /// Returns all cells with their components, in the order of their indices.
    fn labels<P: Space>(&self, domain: &Domain<P>, kept: &Kept) -> Vec<([u32; 4], u32)> {
        let of_patch = self.sides(domain);
        let last = self.cells.all().last().map_or(0, |(cell, _)| cell + 1);
        let mut sets = Sets::new(last as usize + 1);
        let mut named: Vec<Option<u32>> = vec![None; last as usize + 1];
        named[last as usize] = Some(CellLabels::OUT);
        for (cell, row) in self.cells.all() {
            for (slot, &other) in self.cells.across(cell).iter().enumerate() {
                let [a, b, c] = face_of(row, slot);
                let Some(&patch) = kept.get(&key([a, b, c])) else {
                    sets.join(cell, if other == NONE { last } else { other });
                    continue;
                };
                let (apex, labels) = of_patch[patch as usize];
                let away = self.points.orientation([a, b, c, apex]) != Sign::Positive;
                named[cell as usize] = named[cell as usize].max(Some(labels[usize::from(away)]));
            }
        }
        for i in 0..=last {
            let root = sets.find(i) as usize;
            named[root] = named[root].max(named[i as usize]);
        }
        let label = |cell: u32, sets: &mut Sets| named[sets.find(cell) as usize].unwrap_or(CellLabels::OUT);
        self.cells.all().map(|(cell, row)| (*row, label(cell, &mut sets))).collect()
    }

    /// Returns the cells inside the domain with rounded points.
    ///
    /// # Errors
    /// Returns the features of cells that rounding makes flat or inverted.
    pub(super) fn rounded<P: Space>(&self, domain: &Domain<P>, kept: &Kept) -> Result<Recovered, Lost> {
        let chains = self.subs.chains(self.layout.parts.len());
        let given = self.points.given() - BOX;
        // The corners of the box are left out.
        let short = |v: u32| if v as usize >= given { v - BOX as u32 } else { v };
        let mut carriers = self.layout.carriers.clone();
        carriers.resize(self.points.len() - BOX, Carrier::Volume);
        let (mut movable, mut edges) = (Vec::new(), Vec::new());
        for ((line, part), chain) in (0u32..).zip(&self.layout.parts).zip(&chains) {
            let chain: Vec<u32> = chain.iter().map(|&v| short(v)).collect();
            for w in chain.windows(3) {
                carriers[w[1] as usize] = part.carrier;
                movable.push(OnPart { vertex: w[1], between: [w[0], w[2]] });
            }
            edges.extend(chain.windows(2).map(|w| (ascending([w[0], w[1]]), line)));
        }
        movable.sort_unstable_by_key(|p| p.vertex);
        let inside = self.labels(domain, kept).into_iter().filter(|(_, label)| *label < CellLabels::FLAT);
        let (cells, labels): (Vec<[u32; 4]>, Vec<u32>) =
            inside.map(|(row, label)| (row.map(short), label)).unzip();
        let mut at = self.points.at.clone();
        at.drain(given..given + BOX);
        let frame = &domain.simplices.frame;
        let snapped = |p: DVec3| space(frame.snapped(P::from_coords(&p.to_array())));
        let rounded = settle(&mut at, &movable, &cells, snapped).map_err(|bad| lost(&bad, &carriers))?;
        let patches = &self.layout.patches;
        let line = |p: &Part| Line { ends: p.ends.map(short), carrier: p.carrier };
        Ok(Recovered {
            at,
            carriers,
            cells,
            labels,
            rounded,
            given: given as u32,
            faces: kept.iter().map(|(&face, &patch)| (key(face.map(short)), patch)).collect(),
            facets: patches.iter().map(|p| p.facet).collect(),
            planes: patches.iter().map(|p| p.plane(&self.layout.points)).collect(),
            lines: self.layout.parts.iter().map(line).collect(),
            edges,
            stages: Vec::new(),
        })
    }
}

/// Counts the cells at each feature that carries one of their points.
fn lost(bad: &[[u32; 4]], carriers: &[Carrier]) -> Lost {
    let mut found: BTreeMap<Feature, u32> = BTreeMap::new();
    for cell in bad {
        let on = cell.iter().filter_map(|&v| match carriers[v as usize] {
            Carrier::Corner(_) => None,
            carrier => carrier.feature(),
        });
        on.for_each(|feature| *found.entry(feature).or_default() += 1);
    }
    found
}
