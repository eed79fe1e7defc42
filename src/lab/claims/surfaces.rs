//! The surfaces of a run, and the tree that they define, recomputed from points.

use std::collections::BTreeMap;

use septet_core::Outcome;
use septet_core::result::view::SeparatorView;

use super::lab::Specimen;
use super::measure::{X, distance2, dot};
use super::reached::Division;

/// Returns the signed distance of `x` from a separator's surface, negative inside.
pub(super) fn height(separator: &SeparatorView, x: &X) -> f64 {
    let mut vector = [0.0; 3];
    vector[..separator.vector.len()].copy_from_slice(&separator.vector);
    match separator.kind {
        "sphere" => {
            let out = distance2(x, &vector).sqrt() - separator.number;
            if separator.interior == "around" { -out } else { out }
        }
        _ => dot(&vector, x) - separator.number,
    }
}

/// Returns `true` if the ball meets the surface. Distances from a large sphere are rounded, so doubtful balls count as
/// meeting it.
pub(super) fn meets(separator: &SeparatorView, x: &X, radius: f64) -> bool {
    height(separator, x).abs() <= radius * (1.0 + 1e-9) + 1e-12 * (1.0 + separator.number.abs())
}

/// The recomputed tree of a run: the points of each node that has a surface, and the leaf of each point.
pub(super) struct Tree<'a> {
    pub(super) nodes: Vec<(&'a SeparatorView, Vec<u32>)>,
    leaves: Vec<u64>,
}

impl<'a> Tree<'a> {
    pub(super) fn of(specimen: &'a Specimen) -> Tree<'a> {
        Tree::of_run(&specimen.run, &specimen.points)
    }

    pub(super) fn of_run(run: &'a Outcome, points: &[X]) -> Tree<'a> {
        let separators = run.kept.picture.as_ref().map_or(&[][..], |view| &view.separators);
        let mut leaves = vec![1u64; points.len()];
        let mut nodes = Vec::new();
        // A child has a larger node id than its parent, so parents come first.
        for separator in separators {
            let inside: Vec<u32> =
                (0u32..).zip(&leaves).filter(|(_, leaf)| **leaf == separator.node).map(|(i, _)| i).collect();
            for &i in &inside {
                let side = u64::from(height(separator, &points[i as usize]) >= 0.0);
                leaves[i as usize] = 2 * separator.node + side;
            }
            nodes.push((separator, inside));
        }
        Tree { nodes, leaves }
    }

    /// Returns the number of points of each leaf.
    pub(super) fn populations(&self) -> BTreeMap<u64, u64> {
        let mut populations = BTreeMap::new();
        for &leaf in &self.leaves {
            *populations.entry(leaf).or_default() += 1;
        }
        populations
    }

    /// Returns the tree without the points of its nodes.
    pub(super) fn division(&self) -> Division<'_, impl Fn(usize, &X) -> f64> {
        let nodes = self.nodes.iter().map(|(separator, _)| separator.node).collect();
        Division { nodes, leaves: &self.leaves, height: |at: usize, x: &X| height(self.nodes[at].0, x) }
    }

    /// Returns the surface that separates two points, if there is one.
    pub(super) fn parting(&self, i: u64, j: u64) -> Option<&'a SeparatorView> {
        let (mut a, mut b) = (self.leaves[i as usize], self.leaves[j as usize]);
        while a != b {
            if a > b { a /= 2 } else { b /= 2 }
        }
        let at = self.nodes.binary_search_by_key(&a, |(separator, _)| separator.node).ok()?;
        let leaf = self.leaves[i as usize] == a;
        (!leaf).then(|| self.nodes[at].0)
    }
}
