//! The quality of a mesh in human-readable form: a summary and figures.

use septet_geometry::point::Point;
use septet_meshing::facet::Triangulate;
use septet_meshing::quality::histogram::Histogram;
use septet_meshing::quality::reasons::reasons;
use septet_meshing::quality::{Quality, SLIVER_RATIO, SLIVERS};

use crate::page::histograms::{Drawn, svg};
use crate::summary::row;
use crate::text::counted;
use septet_core::mesh::Promise;
use septet_lab::report::mesh::{CheckedMesh, reason_text};

/// The smallest angle, in degrees, that needs no reason.
const FAIR: f64 = 12.0;

/// Draws the histograms. Returns the file name and the SVG text of each.
pub fn figures<P: Point>(quality: &Quality<P>, promise: Promise) -> Vec<(String, String)> {
    let mut all = vec![
        (Drawn::RadiusEdge, &quality.ratios),
        (Drawn::Angles, &quality.angles),
        (Drawn::LeastAngles, &quality.least_angles),
        (Drawn::LargestAngles, &quality.largest_angles),
        (Drawn::Lengths, &quality.lengths),
    ];
    all.extend(quality.grading.as_ref().map(|grading| (Drawn::Sizes, grading)));
    let draw = |(drawn, histogram): (Drawn, &Histogram)| {
        let histogram = histogram.into();
        (format!("{}.svg", drawn.name()), svg(&drawn.bars(&histogram, promise.free)))
    };
    all.into_iter().map(draw).collect()
}

/// Formats a summary in a few lines: conformity, quality with its bound, boundary and angles. A line about a weakness
/// names the option that improves it.
pub fn summary<P: Triangulate>(checked: &CheckedMesh<'_, P>, first_id: u64) -> Vec<String> {
    let CheckedMesh { mesh, conformity, .. } = *checked;
    let state = match conformity.defects.len() {
        0 => "conforms to its domain".to_owned(),
        n => format!("has {}", counted(n as u64, "defect")),
    };
    let [points, cells] = [(mesh.points.len(), "point"), (mesh.cells.len(), "cell")];
    let [points, cells] = [points, cells].map(|(number, noun)| counted(number as u64, noun));
    let mut lines = vec![format!("septet: {points}, {cells}: the mesh {state}")];
    lines.extend(radius_edge(checked));
    lines.extend(surface(checked));
    lines.extend(angles(checked));
    lines.extend(worst(checked, first_id));
    lines
}

/// Describes the radius-edge ratios by the location of the circumcentre, and the bound.
fn radius_edge<P: Triangulate>(checked: &CheckedMesh<'_, P>) -> Vec<String> {
    let CheckedMesh { domain, request, quality, .. } = *checked;
    let [free, near, above, outside] = &quality.places;
    let bound = Promise::of(request.sizes.lipschitz).free;
    let is_bounded = !request.remeshes(domain) && !request.as_it_is && !request.is_refined(domain);
    let bound = if is_bounded { format!(", bound {bound:.2}") } else { String::new() };
    let mut parts = Vec::new();
    for (place, bound, at) in [
        (free, bound.as_str(), "away from the boundary"),
        (near, "", "near the boundary"),
        (above, "", "at boundary triangles that are larger than the local size"),
        (outside, "", "with circumcentres outside the domain"),
    ] {
        if place.cells > 0 {
            let cells = counted(place.cells, "cell");
            parts.push(format!("at most {:.2} {at} ({cells}{bound})", place.most.upper));
        }
    }
    let labels = ["radius-edge", "", "", ""];
    parts.iter().zip(labels).map(|(part, label)| row(label, part)).collect()
}

/// Describes the distance between a surface and its remeshed boundary, and other differences.
fn surface<P: Triangulate>(checked: &CheckedMesh<'_, P>) -> Vec<String> {
    let Some(deviation) = checked.conformity.deviation else { return Vec::new() };
    let mut lines = vec![row(
        "surface",
        format!(
            "the boundary is at most {:.2e} from the surface, and vertices of the surface at most {:.2e} from the boundary \
             (--max-distance)",
            deviation.of_boundary, deviation.of_surface
        ),
    )];
    let [boundary, surface] = deviation.euler;
    if boundary != surface {
        let text = format!(
            "the Euler characteristic is {boundary} for the boundary and {surface} for the surface, as thin sheets are joined; \
             reduce --size"
        );
        lines.push(row("", text));
    }
    if deviation.finer > 0 {
        let edges = counted(deviation.finer, "boundary edge");
        let text = format!(
            "{edges} shorter than half the size, because of thin sheets, close ridges or --max-distance; --min-size limits them"
        );
        lines.push(row("", text));
    }
    lines
}

/// Names the reason for the smallest angle, if it is below [`FAIR`] after an improvement.
fn worst<P: Triangulate>(checked: &CheckedMesh<'_, P>, first_id: u64) -> Option<String> {
    let CheckedMesh { domain, request, quality, .. } = *checked;
    let cell = quality.thinnest.first().filter(|cell| request.improve && cell.angles[0] < FAIR)?;
    let feature_angle = request.remeshes(domain).then_some(request.feature_angle);
    let reasons = reasons(domain, std::slice::from_ref(cell), feature_angle);
    let reason = reason_text(domain, reasons.first()?, first_id);
    let at: Vec<String> = (0..P::DIM).map(|i| format!("{:.6}", cell.at.coord(i))).collect();
    Some(row("", format!("the cell with the smallest angle is at ({}): {reason}", at.join(", "))))
}

/// Describes the range of the angles, and the slivers.
fn angles<P: Triangulate>(checked: &CheckedMesh<'_, P>) -> Vec<String> {
    let quality = checked.quality;
    let angle = if P::DIM == 2 { "angles" } else { "dihedral angles" };
    let (limit, number) = (SLIVERS[1], quality.slivers[1]);
    let mut lines = vec![row(
        "angles",
        format!("{angle} from {:.2} to {:.2} degrees", quality.angles.least, quality.angles.most),
    )];
    if P::DIM == 3 && number > 0 {
        let is_final = checked.request.improve || checked.request.as_it_is;
        let help = if is_final { "" } else { "; the mesh is as generated (--no-improve)" };
        let slivers = counted(number, "sliver");
        let text = format!(
            "{slivers}: an angle below {limit} degrees and a radius-edge ratio below {SLIVER_RATIO}{help}"
        );
        lines.push(row("", text));
    }
    lines
}
