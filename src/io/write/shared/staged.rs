//! The files of a call under temporary names. Process 0 creates and renames them; the others open them by name.

use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, IntoInnerError};
use std::path::{Path, PathBuf};

use septet_protocol::wire::{Ended, Processes};

use super::fault::{SharedFault, describe};
use crate::write::error::OutputError;
use crate::write::folder::{Folder, Pieces, Placed};
use crate::write::names::pieces_path;
use crate::write::stage::{Stage, directory_of, sync};

/// The files and folders that process 0 has not yet renamed. Dropping removes them. On other processes, it is empty.
#[derive(Default)]
pub(super) struct Staged {
    pub stage: Stage,
    folders: Vec<Folder>,
}

/// The place of a process in a file that several processes write.
pub(super) struct Place {
    pub out: BufWriter<File>,
    /// Whether this process also writes the bytes outside of the shares: header, lengths and end.
    pub is_first: bool,
}

impl Staged {
    /// Creates a file, and lets every process write its ranges of bytes. `body` may seek.
    pub fn write_range(
        &mut self,
        processes: &mut Processes<'_>,
        target: &Path,
        body: impl FnOnce(&mut Place) -> io::Result<()>,
    ) -> Result<(), Ended> {
        let is_first = processes.process() == 0;
        let own = if is_first { self.stage.reserve(target) } else { Ok(String::new()) };
        let temporary = directory_of(target).join(name_of_first(processes, own)?);
        let written = write_synced(&temporary, is_first, body);
        let at = |source| OutputError::Io { path: target.to_path_buf(), source };
        processes.agree(written.map_err(|source| at(source).into()), describe)
    }

    /// Creates the folder of the pieces of a `.pvtu` file. Returns its files.
    pub fn create_folder(
        &mut self,
        processes: &mut Processes<'_>,
        path: &Path,
        pieces: u32,
    ) -> Result<Pieces, Ended> {
        let target = pieces_path(path);
        let own = if processes.process() == 0 {
            Folder::create(&target, pieces).map(|folder| {
                let name = folder.pieces().temporary().file_name().unwrap_or_default();
                let name = name.to_string_lossy().into_owned();
                self.folders.push(folder);
                name
            })
        } else {
            Ok(String::new())
        };
        let temporary: PathBuf = directory_of(&target).join(name_of_first(processes, own)?);
        Ok(Pieces::of(temporary, &target, pieces))
    }

    /// Renames folders, then files. If a rename fails, none of them is left, and former folders return.
    pub fn commit(self) -> Result<(), OutputError> {
        let placed = self.folders.into_iter().map(Folder::place).collect::<Result<Vec<Placed>, _>>()?;
        self.stage.commit()?;
        placed.into_iter().for_each(Placed::keep);
        Ok(())
    }
}

/// Returns the name that process 0 has.
fn name_of_first(processes: &mut Processes<'_>, own: Result<String, OutputError>) -> Result<String, Ended> {
    let own = processes.agree(own.map_err(SharedFault::from), describe)?;
    Ok(processes.all_gather(&own)?.swap_remove(0))
}

/// Opens a file, writes to it and waits until the bytes are on disk.
fn write_synced(
    path: &Path,
    is_first: bool,
    body: impl FnOnce(&mut Place) -> io::Result<()>,
) -> io::Result<()> {
    let file = OpenOptions::new().write(true).open(path)?;
    let mut place = Place { out: BufWriter::with_capacity(1 << 18, file), is_first };
    body(&mut place)?;
    sync(&place.out.into_inner().map_err(IntoInnerError::into_error)?)
}
