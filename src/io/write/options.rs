//! What may be chosen about a file besides its format.

use super::error::OutputError;
use super::format::MshVersion;

/// What may be chosen about a file besides its format.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// Write who owned each cell and its home leaf, where the mesh knows them (`.vtu` only).
    pub with_owner: bool,
    /// The id of the first point and of the first cell in the files of `TetGen`: 0 or 1, as in the
    /// `.node` file the points came from.
    pub first_id: u64,
    /// The version of a file named `.msh`.
    pub msh: MshVersion,
}

pub(super) fn check_first_id(first_id: u64) -> Result<(), OutputError> {
    if first_id > 1 {
        return Err(OutputError::FirstId { first_id });
    }
    Ok(())
}
