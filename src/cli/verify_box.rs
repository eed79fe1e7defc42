//! The periodic box of `septet verify`, and the offsets of the vertices.

use std::path::{Path, PathBuf};

use septet_core::model::Points;
use septet_core::run::periodic::check_box;
use septet_core::spec::Periodic;
use septet_io::read::{CellFile, read_offsets};
use septet_lab::report::VerifiedBox;
use septet_verify::PeriodicBox;

use super::errors::Failure;
use super::input;
use super::progress::Talk;

/// A periodic box that fits its points, and the offsets of the vertices of all cells.
pub struct PeriodicPart {
    periodic: Periodic,
    file: PathBuf,
    offsets: Vec<i32>,
}

impl PeriodicPart {
    /// Checks the box, and reads the file of the offsets. `name` is the input of the points.
    ///
    /// # Errors
    /// Fails if the box does not fit the points, or if the file has no offsets of these cells.
    pub fn of(
        (periodic, file): (Periodic, &Path),
        (points, cells): (&Points, &CellFile),
        (name, talk): (&str, &Talk),
    ) -> Result<Self, Failure> {
        check_box(points.slice(), &periodic).map_err(|error| input::placed(error, &[], name, |row| row))?;
        let (path, shape) = (file.to_owned(), (cells.cell_count(), cells.dimension));
        let offsets = input::watched(talk, move |progress| read_offsets(&path, shape, progress))??;
        Ok(PeriodicPart { periodic, file: file.to_owned(), offsets })
    }

    /// Returns the box for the verifier.
    pub fn view(&self) -> PeriodicBox<'_> {
        PeriodicBox { lengths: &self.periodic.lengths, offsets: &self.offsets }
    }

    /// Returns the box for the report.
    pub fn report(&self) -> VerifiedBox {
        let lengths = self.periodic.lengths.clone();
        VerifiedBox { lengths, offsets_file: self.file.display().to_string() }
    }
}
