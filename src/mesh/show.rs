//! A mesh's quality for people: a few lines, and figures.

use septet_geometry::point::Point;
use septet_meshing::facet::Triangulate;
use septet_meshing::quality::{Quality, SLIVER_RATIO, SLIVERS};

use super::Promise;
use super::report::Judged;
use crate::report::page::histograms::{Bars, svg};

/// The histograms as figures: name of the file and text of each.
pub fn figures<P: Point>(quality: &Quality<P>, promise: Promise) -> Vec<(String, String)> {
    let cells = "cells";
    let of = |title, label, of, histogram, bound| Bars { title, label, of, histogram, bound };
    let mut drawn = vec![
        (
            "radius-edge",
            of(
                "Radius-edge ratios",
                "circumradius over shortest edge",
                cells,
                &quality.ratios,
                Some(promise.free),
            ),
        ),
        ("angles", of("Angles", "angle [degrees]", "angles", &quality.angles, None)),
        (
            "least-angles",
            of("Smallest angles", "smallest angle [degrees]", cells, &quality.least_angles, None),
        ),
        (
            "largest-angles",
            of("Largest angles", "largest angle [degrees]", cells, &quality.largest_angles, None),
        ),
        (
            "lengths",
            of(
                "Edges over size",
                "length over the smaller size at the ends",
                "edges",
                &quality.lengths,
                None,
            ),
        ),
    ];
    if let Some(grading) = &quality.grading {
        let label = "size over local feature size";
        drawn.push(("sizes", of("Size over local feature size", label, "points", grading, None)));
    }
    drawn.into_iter().map(|(name, bars)| (format!("{name}.svg"), svg(&bars))).collect()
}

/// A few lines for people: the promise and what came of it, the angles.
pub fn summary<P: Triangulate>(judged: &Judged<'_, P>) -> Vec<String> {
    let Judged { request, mesh, quality, conformity, deviation, .. } = *judged;
    let promise = Promise::of(request.lipschitz).free;
    let promised = if request.remeshes() { String::new() } else { format!(" of {promise:.4} promised") };
    let [free, near, outside] = &quality.places;
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
    if let Some(deviation) = deviation {
        lines.push(format!(
            "  the boundary is up to {:.3e} from the surface, the surface's vertices up to {:.3e} from it",
            deviation.of_boundary, deviation.of_surface
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
