//! The files of a call under temporary names. Process 0 creates and renames them; the others open them by name, and their own
//! [`Staged`] is empty.

use std::fs::OpenOptions;
use std::io;
use std::path::{Path, PathBuf};

use septet_protocol::wire::{Ended, Processes};

use super::fault::{SharedFault, describe};
use crate::write::error::OutputError;
use crate::write::folder::{Folder, Pieces};
use crate::write::names::pieces_path;
use crate::write::place::Place;
use crate::write::stage::{directory_of, sync};
use crate::write::staged::Staged;

impl Staged {
    /// Creates a file, and lets every process write its ranges of bytes. `body` may seek.
    pub(super) fn write_range(
        &mut self,
        processes: &mut Processes<'_>,
        target: &Path,
        body: impl FnOnce(&mut Place<'_>) -> io::Result<()>,
    ) -> Result<(), Ended> {
        let is_first = processes.process() == 0;
        let own = if is_first { self.stage.reserve(target) } else { Ok(String::new()) };
        let temporary = directory_of(target).join(name_of_first(processes, own)?);
        let written = write_synced(&temporary, is_first, body);
        let at = |source| OutputError::Io { path: target.to_path_buf(), source };
        processes.agree(written.map_err(|source| at(source).into()), describe)
    }

    /// Creates the folder of the pieces of a `.pvtu` file. Returns its files.
    pub(super) fn create_folder(
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
    body: impl FnOnce(&mut Place<'_>) -> io::Result<()>,
) -> io::Result<()> {
    let file = OpenOptions::new().write(true).open(path)?;
    let mut place = Place::shared(file, is_first);
    body(&mut place)?;
    place.into_file()?.map_or(Ok(()), |file| sync(&file))
}
