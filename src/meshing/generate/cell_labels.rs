//! The component of the domain in which each cell lies.

/// The component of each cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellLabels {
    /// The component, [`CellLabels::OUT`] outside the domain, or [`CellLabels::FLAT`] for a flat cell.
    pub of: Vec<u32>,
}

impl CellLabels {
    /// Outside the domain.
    pub const OUT: u32 = u32::MAX;
    /// All vertices lie on one facet.
    pub const FLAT: u32 = u32::MAX - 1;

    /// Returns `true` if the cell is part of the mesh.
    pub fn is_inside(&self, cell: u32) -> bool {
        self.of[cell as usize] < Self::FLAT
    }
}
