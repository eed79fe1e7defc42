//! Reports of meshes as they are read back: what the page shows of them, and whether it fits together.

use serde::Deserialize;
use serde_json::Value;

use septet_core::mesh::view::{MOST_CELLS, MeshPicture};
use septet_lab::report::mesh::histogram::HistogramReport;

use super::super::error::PageError;

/// One mesh.
#[derive(Clone, Debug)]
pub(in crate::page) struct MeshData {
    /// The file it comes from.
    pub(in crate::page) name: String,
    /// What its report says.
    pub(in crate::page) file: MeshFile,
}

/// The part of a report that is shown.
#[derive(Clone, Debug, Deserialize)]
pub(in crate::page) struct MeshFile {
    pub(super) version: String,
    pub(in crate::page) parameters: Parameters,
    pub(in crate::page) domain: Domain,
    pub(in crate::page) mesh: Counts,
    pub(super) stages: Vec<Stage>,
    #[serde(default)]
    pub(super) phases: Vec<PhaseRow>,
    pub(super) radius_edge: Vec<PlaceRow>,
    pub(super) quality: Quality,
    pub(super) conformity: Conformity,
    #[serde(default)]
    pub(in crate::page) view: Option<MeshPicture>,
    pub(super) seconds: Seconds,
}

#[derive(Clone, Debug, Deserialize)]
pub(in crate::page) struct Parameters {
    pub(in crate::page) input: String,
    pub(super) boundary: String,
    pub(super) lipschitz: f64,
    pub(super) radius_edge: f64,
    pub(in crate::page) workers: Option<u32>,
    pub(in crate::page) seed: u64,
}

#[derive(Clone, Debug, Deserialize)]
pub(in crate::page) struct Domain {
    pub(in crate::page) dimension: usize,
    pub(super) segments: u64,
    pub(super) facets: u64,
    pub(super) components: u64,
}

#[derive(Clone, Debug, Deserialize)]
pub(in crate::page) struct Counts {
    pub(in crate::page) points: u64,
    pub(super) corner_points: u64,
    pub(super) segment_points: u64,
    pub(super) facet_points: u64,
    pub(super) volume_points: u64,
    pub(in crate::page) cells: u64,
    pub(super) faces: u64,
}

/// A stage of generation.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Stage {
    pub(super) name: String,
    pub(super) candidates: u64,
    pub(super) points: u64,
    pub(super) completion_rounds: u64,
    pub(super) set_rounds: u64,
    pub(super) rounds: u64,
    pub(super) messages: u64,
    pub(super) bytes: u64,
    pub(super) work: u64,
    pub(super) depth: u64,
    pub(super) seconds: f64,
}

/// A phase of the machine in a stage.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct PhaseRow {
    pub(super) stage: String,
    pub(super) phase: String,
    pub(super) runs: u64,
    pub(super) rounds: u64,
    pub(super) messages: u64,
    pub(super) bytes: u64,
    pub(super) work: Option<u64>,
    pub(super) depth: Option<u64>,
    pub(super) seconds: f64,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Between {
    pub(super) upper: Option<f64>,
}

/// The radius-edge ratios of cells whose circumcentres lie in one kind of place.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct PlaceRow {
    pub(super) place: String,
    pub(super) cells: u64,
    pub(super) most: Between,
    pub(super) promised: Option<f64>,
    pub(super) over: u64,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Quality {
    pub(super) radius_edge: HistogramReport,
    pub(super) angles: HistogramReport,
    pub(super) least_angles: HistogramReport,
    pub(super) largest_angles: HistogramReport,
    pub(super) length_over_size: HistogramReport,
    pub(super) size_over_local_size: Option<HistogramReport>,
    pub(super) lipschitz: f64,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Conformity {
    pub(super) passed: bool,
    pub(super) domain_measure: f64,
    pub(super) mesh_measure: f64,
    pub(super) defects: u64,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Seconds {
    pub(super) mesh_seconds: f64,
    pub(super) total_seconds: f64,
}

/// A field that is not what it should be.
type Wrong = (String, String);

/// Reads a report.
pub(in crate::page) fn read(name: &str, line: usize, value: &Value) -> Result<MeshData, PageError> {
    let wrong = |(field, why): Wrong| PageError::Field { name: name.to_owned(), line, field, why };
    let file: MeshFile = serde_path_to_error::deserialize(value)
        .map_err(|e| wrong((e.path().to_string(), e.inner().to_string())))?;
    file.check().map_err(wrong)?;
    Ok(MeshData { name: name.to_owned(), file })
}

fn expect(holds: bool, field: &str, why: impl FnOnce() -> String) -> Result<(), Wrong> {
    if holds { Ok(()) } else { Err((field.to_owned(), why())) }
}

impl MeshFile {
    /// What types do not say.
    fn check(&self) -> Result<(), Wrong> {
        let d = self.domain.dimension;
        expect(d == 2 || d == 3, "domain.dimension", || format!("{d}, expected 2 or 3"))?;
        let q = &self.quality;
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
        self.view.as_ref().map_or(Ok(()), |view| self.check_picture(view))
    }

    fn check_picture(&self, view: &MeshPicture) -> Result<(), Wrong> {
        let (d, most) = (self.domain.dimension, u64::from(MOST_CELLS));
        let same = |field: &str, found: u64, expected: u64| {
            expect(found == expected, &format!("view.{field}"), || format!("{found}, expected {expected}"))
        };
        same("points", view.points, self.mesh.points)?;
        same("cells", view.cells, self.mesh.cells)?;
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
}

/// Are all these positions in a list of that length?
fn below(field: &str, numbers: &[u32], length: usize, of: &str) -> Result<(), Wrong> {
    match numbers.iter().position(|&i| i as usize >= length) {
        None => Ok(()),
        Some(at) => {
            Err((format!("view.{field}[{at}]"), format!("{}, but there are {length} {of}", numbers[at])))
        }
    }
}

impl MeshData {
    /// What the machine took for all stages.
    pub(super) fn total(&self, of: impl Fn(&Stage) -> u64) -> u64 {
        self.file.stages.iter().map(of).sum()
    }

    /// Messages of all stages.
    pub(in crate::page) fn messages(&self) -> u64 {
        self.total(|t| t.messages)
    }

    /// Bytes of all stages.
    pub(in crate::page) fn bytes(&self) -> u64 {
        self.total(|t| t.bytes)
    }
}
