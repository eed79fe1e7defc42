//! The note on points whose affine hull has a smaller dimension than the space.

use septet_core::Door;

use super::schema::RunReport;

impl RunReport {
    /// Describes points whose affine hull has a smaller dimension than the space, in one line, in the words of a door.
    pub fn flat_note(&self, door: Door) -> String {
        let span = match self.dimension {
            -1 => "there are no points".to_owned(),
            0 => "all points coincide (dimension 0)".to_owned(),
            1 => "all points lie on a line (dimension 1)".to_owned(),
            2 => "all points lie in a plane (dimension 2)".to_owned(),
            d => format!("all points lie in an affine space of dimension {d}"),
        };
        let advice = if self.space == 3 && self.dimension == 2 {
            "; {dimension=2} triangulates x and y only"
        } else {
            ""
        };
        door.spell(&format!("{span}: no cells{advice}"))
    }
}
