//! The break lines of a terrain.

use std::path::{Path, PathBuf};

use septet_core::Outcome;
use septet_core::model::Points;
use septet_io::read::{SharedPoints, read_breaklines};
use septet_meshing::plane::Terrain;

use crate::errors::{Code, Failure};
use crate::input::watched;
use crate::progress::Talk;
use crate::text::counted;

/// Maximum number of crossings that are listed.
const SHOWN: usize = 20;

/// A terrain with its break lines.
pub(super) struct Breaklines {
    path: PathBuf,
    terrain: Terrain,
}

/// Reads break lines, and adds their points to those of a terrain.
fn joined(path: &Path, held: &mut SharedPoints, talk: &Talk) -> Result<Breaklines, Failure> {
    let file = path.to_owned();
    let (lines, notes) = watched(talk, move |progress| read_breaklines(&file, progress))??;
    talk.clear();
    for note in notes {
        talk.note(format!("note: {note}"));
    }
    let (Points::Plane(points), Some(heights)) = (&held.points, &held.heights) else {
        return Err(Failure::new(Code::Usage, "--breaklines needs --terrain").help("add --terrain"));
    };
    let own = points.len();
    let terrain = Terrain::new(points.clone(), heights.clone(), &lines).map_err(|none| {
        let message = format!(
            "{}: the point {} {} has no height and lies outside the terrain",
            path.display(),
            none.0.x,
            none.0.y
        );
        Failure::new(Code::Input, message).help("give its z, or end the line inside the terrain")
    })?;
    let added = terrain.points.len() - own;
    if added > 0 {
        talk.note(format!(
            "note: {} of break lines follow the rows of the input, {} with an interpolated height",
            counted(added as u64, "point"),
            terrain.interpolated
        ));
    }
    let total = own as u64 + held.skipped;
    if let Some(source) = &mut held.source_index {
        source.extend((0..added as u64).map(|i| total + i));
    }
    for column in &mut held.columns {
        column.values.resize(own + added, f64::NAN);
    }
    held.rows += added as u64;
    held.points = Points::Plane(terrain.points.clone());
    held.heights = Some(terrain.heights.clone());
    Ok(Breaklines { path: path.to_owned(), terrain })
}

impl Breaklines {
    /// Reads break lines, if there are some, and adds their points to those of a terrain.
    ///
    /// # Errors
    /// Fails if the file cannot be read, or if a point outside the terrain has no height.
    pub(super) fn join(
        path: Option<&Path>,
        held: &mut SharedPoints,
        talk: &Talk,
    ) -> Result<Option<Self>, Failure> {
        path.map(|path| joined(path, held, talk)).transpose()
    }

    /// Returns the cells of a run after the break lines are inserted.
    ///
    /// # Errors
    /// Fails if break lines cross between their points.
    pub(super) fn cells(&self, run: &Outcome, talk: &Talk) -> Result<Vec<u64>, Failure> {
        let Breaklines { path, terrain } = self;
        let rows = run.cells().chunks_exact(3).map(|c| [c[0], c[1], c[2]].map(|v| v as u32)).collect();
        let made = terrain.constrained(rows).map_err(|crossed| {
            talk.clear();
            let at = |v: u32| terrain.points[v as usize];
            for (edge, other) in crossed.iter().take(SHOWN) {
                let [a, b, c, d] = [edge[0], edge[1], other.0[0], other.0[1]].map(at);
                talk.fault(format!(
                    "the break line from {} {} to {} {} crosses the one from {} {} to {} {}",
                    a.x, a.y, b.x, b.y, c.x, c.y, d.x, d.y
                ));
            }
            let number = counted(crossed.len() as u64, "crossing");
            let message = format!("{}: {number} of break lines between their points", path.display());
            Failure::new(Code::Input, message)
                .help("add a common point to the lines listed above where they cross")
        })?;
        talk.note(format!("note: {} of break lines are kept", counted(terrain.edges.len() as u64, "edge")));
        Ok(made.into_iter().flatten().map(u64::from).collect())
    }
}
