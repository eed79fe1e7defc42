//! A mesh's quality for people: a few lines, and figures.

use septet_geometry::point::Point;
use septet_meshing::facet::Triangulate;
use septet_meshing::quality::histogram::Histogram;
use septet_meshing::quality::{Quality, SLIVER_RATIO, SLIVERS};

use crate::page::histograms::{Drawn, svg};
use septet_core::mesh::Promise;
use septet_lab::report::mesh::Judged;

/// The histograms as figures: name of the file and text of each.
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

/// A few lines for people: the promise and what came of it, the angles.
pub fn summary<P: Triangulate>(judged: &Judged<'_, P>) -> Vec<String> {
    let Judged { domain, request, mesh, quality, conformity, .. } = *judged;
    let promise = Promise::of(request.lipschitz).free;
    let promised =
        if request.remeshes(domain) { String::new() } else { format!(" of {promise:.4} promised") };
    let [free, near, above, outside] = &quality.places;
    let angle = if P::DIM == 2 { "angles" } else { "dihedral angles" };
    let verdict = match conformity.defects.len() {
        0 => "conforms".to_owned(),
        1 => "has 1 defect".to_owned(),
        n => format!("has {n} defects"),
    };
    let mut lines = vec![
        format!("septet: {} points, {} cells: the mesh {verdict}", mesh.points.len(), mesh.cells.len()),
        format!(
            "  radius-edge at most {:.4}{} ({} cells), {:.4} near the boundary ({} cells)",
            free.most.upper, promised, free.cells, near.most.upper, near.cells
        ),
    ];
    if let Some(deviation) = conformity.deviation {
        lines.push(format!(
            "  the boundary is up to {:.3e} from the surface, the surface's vertices up to {:.3e} from it",
            deviation.of_boundary, deviation.of_surface
        ));
        let [boundary, surface] = deviation.euler;
        if boundary != surface {
            lines.push(format!(
                "  the boundary has Euler characteristic {boundary}, the surface {surface}: other handles, where sheets are close"
            ));
        }
        if deviation.finer > 0 {
            lines.push(format!(
                "  {} edges of the boundary are below half the size: sheets as thin, ridges as close, or the distance need it",
                deviation.finer
            ));
        }
    }
    if above.cells > 0 {
        lines.push(format!(
            "  {} cells above facets' triangles larger than the size, radius-edge at most {:.4}",
            above.cells, above.most.upper
        ));
    }
    if outside.cells > 0 {
        lines.push(format!(
            "  {} circumcentres outside, radius-edge at most {:.4}",
            outside.cells, outside.most.upper
        ));
    }
    lines.push(format!(
        "  {angle} from {:.2} to {:.2} degrees; below {}: {} cells with radius-edge below {SLIVER_RATIO}",
        quality.angles.least, quality.angles.most, SLIVERS[1], quality.slivers[1]
    ));
    lines
}
