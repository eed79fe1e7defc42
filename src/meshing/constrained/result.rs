//! The mesh of a recovery: the components of its cells, its faces and its edges.
//!
//! **Statement.** Cells that share a face outside all patches are in one component. A patch gives the components on its
//! two sides: those of its walls. Cells at the hull of the box are outside.
//!
//! **Work and depth.** `O(n log n)` for n cells.

use std::collections::BTreeMap;

use glam::DVec3;
use septet_geometry::point::Simplex;
use septet_geometry::predicates::Sign;

use super::cells::{NONE, face_of, key};
use super::facets::Kept;
use super::layout::{Part, space};
use super::recovered::{Line, Recovered};
use super::rounding::{OnPart, settle};
use super::{BOX, Lost, Recovery, apex};
use crate::domain::{Domain, Feature};
use crate::generate::{CellLabels, Delaunay, GeneratedMesh, Rules, Subsegment, Vertices};
use crate::mesh::Carrier;
use crate::points::conflicts::Site;
use crate::sides::Sets;
use crate::space::{Space, ascending};

/// A face of a patch, with its cell on each side.
type Sided = ([u32; 3], u32, [u32; 2]);

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

    /// Returns the component of each cell by index, and the faces of patches.
    fn labels<P: Space>(&self, domain: &Domain<P>, kept: &Kept) -> (BTreeMap<u32, u32>, Vec<Sided>) {
        let of_patch = self.sides(domain);
        let last = self.cells.all().last().map_or(0, |(cell, _)| cell + 1);
        let mut sets = Sets::new(last as usize + 1);
        let mut named: Vec<Option<u32>> = vec![None; last as usize + 1];
        named[last as usize] = Some(CellLabels::OUT);
        let mut faces: BTreeMap<[u32; 3], (u32, [u32; 2])> = BTreeMap::new();
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
                faces.entry(key([a, b, c])).or_insert((patch, [NONE; 2])).1[usize::from(away)] = cell;
            }
        }
        for i in 0..=last {
            let root = sets.find(i) as usize;
            named[root] = named[root].max(named[i as usize]);
        }
        let label = |cell: u32, sets: &mut Sets| named[sets.find(cell) as usize].unwrap_or(CellLabels::OUT);
        let labels = self.cells.all().map(|(cell, _)| (cell, label(cell, &mut sets))).collect();
        (labels, faces.into_iter().map(|(face, (patch, cells))| (face, patch, cells)).collect())
    }

    /// Returns the mesh with rounded points.
    ///
    /// # Errors
    /// Returns the features of cells that rounding makes flat or inverted.
    pub(super) fn rounded<P: Space>(
        &self,
        domain: &Domain<P>,
        kept: &Kept,
        rules: Rules<'_, P>,
    ) -> Result<Recovered<P>, Lost> {
        let (labels, faces) = self.labels(domain, kept);
        let chains = self.subs.chains(self.layout.parts.len());
        let given = self.points.given() - BOX;
        // The corners of the box are left out.
        let short = |v: u32| if v as usize >= given { v - BOX as u32 } else { v };
        let mut carriers = self.layout.carriers.clone();
        carriers.resize(self.points.len() - BOX, Carrier::Volume);
        let (mut movable, mut subsegments) = (Vec::new(), Vec::<Subsegment>::new());
        let mut edges = Vec::new();
        for ((line, part), chain) in (0u32..).zip(&self.layout.parts).zip(&chains) {
            let chain: Vec<u32> = chain.iter().map(|&v| short(v)).collect();
            for w in chain.windows(3) {
                carriers[w[1] as usize] = part.carrier;
                movable.push(OnPart { vertex: w[1], between: [w[0], w[2]] });
            }
            edges.extend(chain.windows(2).map(|w| (ascending([w[0], w[1]]), line)));
            if let Carrier::Segment(s) = part.carrier {
                subsegments.extend(chain.windows(2).map(|w| (s, [w[0], w[1]])));
            }
        }
        movable.sort_unstable_by_key(|p| p.vertex);
        subsegments.sort_unstable();
        let inside: Vec<u32> = labels.iter().filter(|l| *l.1 < CellLabels::FLAT).map(|l| *l.0).collect();
        let number: BTreeMap<u32, u32> = inside.iter().copied().zip(0..).collect();
        let rows: Vec<[u32; 4]> = inside.iter().map(|&c| self.cells.row(c).map(short)).collect();
        let mut at = self.points.at.clone();
        at.drain(given..given + BOX);
        let frame = &domain.simplices.frame;
        let snapped = |p: DVec3| space(frame.snapped(P::from_coords(&p.to_array())));
        let done = settle(&mut at, &movable, &rows, snapped).map_err(|bad| lost(&bad, &carriers))?;
        let found = faces.into_iter().filter_map(|(face, patch, cells)| {
            let cells = cells.map(|c| number.get(&c).copied().unwrap_or(u32::MAX));
            let facet = self.layout.patches[patch as usize].facet;
            let found = (facet, row::<P::Facet>(&face.map(short)), cells);
            (cells != [u32::MAX; 2]).then_some((found, patch))
        });
        let (faces, patches) = found.unzip();
        let mut vertices = Vertices { points: vec![], sizes: vec![], carriers: vec![] };
        for (p, carrier) in at.into_iter().zip(carriers) {
            let at = P::from_coords(&p.to_array());
            vertices.push(Site { at, size: rules.size.at(at) }, carrier);
        }
        let mesh = GeneratedMesh {
            vertices,
            labels: CellLabels { of: inside.iter().map(|c| labels[c]).collect() },
            faces,
            delaunay: Delaunay {
                neighbours: vec![P::Cell::splat(u32::MAX); rows.len()],
                cells: rows.iter().map(|cell| row(cell)).collect(),
            },
            subsegments,
            stages: Vec::new(),
        };
        let facets = self.layout.patches.iter().map(|p| p.facet).collect();
        let line = |p: &Part| Line { ends: p.ends.map(short), carrier: p.carrier };
        let lines = self.layout.parts.iter().map(line).collect();
        let planes = self.layout.patches.iter().map(|p| p.plane(&self.layout.points)).collect();
        Ok(Recovered { planes, lines, mesh, rounded: done, given: given as u32, patches, facets, edges })
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

fn row<S: Simplex>(vertices: &[u32]) -> S {
    let mut row = S::splat(u32::MAX);
    row.as_mut().copy_from_slice(vertices);
    row
}
