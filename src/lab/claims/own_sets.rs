//! The machine's own separator sets.

use septet_core::SetMember;

/// The sets in which the machine compares all pairs: those of leaves, and of nodes whose sets were not divided further.
/// A point that occurs in such sets below both children of a node is in the separator set `P_O` of the node.
pub(super) struct OwnSets<'a>(pub(super) &'a [SetMember]);

impl OwnSets<'_> {
    /// Returns, for each point, the nodes of the sets that contain it, in the order of the members.
    pub(super) fn nodes(&self, points: usize) -> Vec<Vec<u64>> {
        let mut nodes = vec![Vec::new(); points];
        for member in self.0 {
            nodes[member.point as usize].push(member.node);
        }
        nodes
    }
}

/// Returns the child of `ancestor` that is `node` or contains it, or `None` if `node` is not below `ancestor`.
fn child_towards(ancestor: u64, node: u64) -> Option<u64> {
    let deeper = node.ilog2().checked_sub(ancestor.ilog2() + 1)?;
    (node >> (deeper + 1) == ancestor).then_some(node >> deeper)
}

/// The position of a point at a node of the recursion.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    /// A set at the node or above contains the point, so the node does not divide the point from others.
    Undivided,
    /// The sets that contain the point lie below at most one child.
    OneSide,
    /// The point is in `P_O`: sets below both children contain it.
    Separator,
}

/// Returns the position of a point at a node, from the nodes of the sets that contain the point.
pub(super) fn place(sets: &[u64], node: u64) -> Place {
    let mut sides = [false; 2];
    for &set in sets {
        match child_towards(node, set) {
            Some(child) => sides[(child & 1) as usize] = true,
            None if set == node || child_towards(set, node).is_some() => return Place::Undivided,
            None => {}
        }
    }
    if sides == [true; 2] { Place::Separator } else { Place::OneSide }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_of_both_children_is_in_the_separator_set() {
        assert_eq!(child_towards(1, 12), Some(3));
        assert_eq!(child_towards(3, 12), Some(6));
        assert_eq!((child_towards(3, 10), child_towards(3, 3), child_towards(6, 3)), (None, None, None));
        // The sets are leaves below the node, on one side or on both.
        assert!(place(&[12, 13], 3) == Place::OneSide);
        assert!(place(&[12, 14], 3) == Place::Separator);
        assert!(place(&[12, 10], 3) == Place::OneSide);
        // The set of the node, or of an ancestor, is not divided.
        assert!(place(&[3], 3) == Place::Undivided && place(&[1], 3) == Place::Undivided);
    }
}
