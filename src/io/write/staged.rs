//! Outputs under temporary names: files, and folders of pieces.

use std::path::PathBuf;

use super::error::OutputError;
use super::folder::{Folder, Placed};
use super::stage::Stage;

/// Files and folders that are not yet renamed. Dropping removes them.
#[derive(Default)]
pub(super) struct Staged {
    pub stage: Stage,
    pub folders: Vec<Folder>,
}

impl Staged {
    /// Renames folders, then files, and returns the files and the folders. If a rename fails, none of them is left, and
    /// former folders return.
    pub fn commit(self) -> Result<Vec<PathBuf>, OutputError> {
        let targets: Vec<PathBuf> =
            self.folders.iter().map(|folder| folder.pieces().target().to_path_buf()).collect();
        let placed = self.folders.into_iter().map(Folder::place).collect::<Result<Vec<Placed>, _>>()?;
        let mut files = self.stage.commit()?;
        placed.into_iter().for_each(Placed::keep);
        files.extend(targets);
        Ok(files)
    }
}
