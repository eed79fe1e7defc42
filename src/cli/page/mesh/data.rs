//! Mesh reports: reading and checking the part that the page shows.

use serde_json::Value;

use septet_core::mesh::view::{MOST_CELLS, MeshPicture};
use septet_lab::report::mesh::{MeshReport, StageReport};

use super::super::error::PageError;

/// A mesh.
#[derive(Clone, Debug)]
pub(in crate::page) struct MeshData {
    /// Name of the file.
    pub(in crate::page) name: String,
    /// The report.
    pub(in crate::page) file: MeshReport,
}

/// The path of an invalid field, and the reason.
type Wrong = (String, String);

/// Reads a report.
pub(in crate::page) fn read(name: &str, line: usize, value: &Value) -> Result<MeshData, PageError> {
    let wrong = |(field, why): Wrong| PageError::Field { name: name.to_owned(), line, field, why };
    let file: MeshReport = serde_path_to_error::deserialize(value)
        .map_err(|e| wrong((e.path().to_string(), e.inner().to_string())))?;
    check(&file).map_err(wrong)?;
    Ok(MeshData { name: name.to_owned(), file })
}

fn expect(holds: bool, field: &str, why: impl FnOnce() -> String) -> Result<(), Wrong> {
    if holds { Ok(()) } else { Err((field.to_owned(), why())) }
}

/// Checks the conditions that the types do not express.
fn check(file: &MeshReport) -> Result<(), Wrong> {
    let d = file.domain.dimension;
    expect(d == 2 || d == 3, "domain.dimension", || format!("{d}, expected 2 or 3"))?;
    let q = &file.quality;
    let histograms = [
        ("radius_edge", Some(&q.radius_edge)),
        ("angles", Some(&q.angles)),
        ("least_angles", Some(&q.least_angles)),
        ("largest_angles", Some(&q.largest_angles)),
        ("length_over_size", Some(&q.length_over_size)),
        ("size_over_local_size", q.size_over_local_size.as_ref()),
    ];
    for (name, histogram) in histograms {
        let Some(h) = histogram else { continue };
        let field = format!("quality.{name}");
        expect(h.from < h.to, &field, || format!("bins from {} to {}", h.from, h.to))?;
        expect(!h.counts.is_empty(), &format!("{field}.counts"), || "no bins".to_owned())?;
    }
    file.view.as_ref().map_or(Ok(()), |view| check_picture(file, view))
}

fn check_picture(file: &MeshReport, view: &MeshPicture) -> Result<(), Wrong> {
    let (d, most) = (file.domain.dimension, u64::from(MOST_CELLS));
    let same = |field: &str, found: u64, expected: u64| {
        expect(found == expected, &format!("view.{field}"), || format!("{found}, expected {expected}"))
    };
    same("points", view.points, file.mesh.points)?;
    same("cells", view.cells, file.mesh.cells)?;
    expect(view.cells <= most, "view.cells", || format!("{}, at most {most} are drawn", view.cells))?;
    let (points, cells) = (view.points as usize, view.cells as usize);
    let owners = view.owner.as_ref().map_or(cells, Vec::len);
    for (field, found, expected) in [
        ("low", view.low.len(), d),
        ("high", view.high.len(), d),
        ("positions", view.positions.len(), d * points),
        ("corners", view.corners.len(), (d + 1) * cells),
        ("radius_edge", view.radius_edge.len(), cells),
        ("least_angle", view.least_angle.len(), cells),
        ("size", view.size.len(), cells),
        ("region", view.region.len(), cells),
        ("owner", owners, cells),
    ] {
        let why = || format!("{found} entries, expected {expected}");
        expect(found == expected, &format!("view.{field}"), why)?;
    }
    below("corners", &view.corners, points, "points")?;
    below("region", &view.region, view.regions.len(), "regions")
}

/// Checks that all indices are below `length`.
fn below(field: &str, numbers: &[u32], length: usize, of: &str) -> Result<(), Wrong> {
    match numbers.iter().position(|&i| i as usize >= length) {
        None => Ok(()),
        Some(at) => {
            Err((format!("view.{field}[{at}]"), format!("{}, but there are {length} {of}", numbers[at])))
        }
    }
}

impl MeshData {
    /// Returns the cost of all stages.
    pub(super) fn total(&self, of: impl Fn(&StageReport) -> u64) -> u64 {
        self.file.stages.iter().map(of).sum()
    }

    /// Returns the number of messages of all stages.
    pub(in crate::page) fn messages(&self) -> u64 {
        self.total(|t| t.messages)
    }

    /// Returns the number of bytes of all stages.
    pub(in crate::page) fn bytes(&self) -> u64 {
        self.total(|t| t.bytes)
    }
}
