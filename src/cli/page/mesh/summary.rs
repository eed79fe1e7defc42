//! The summary of a mesh as a few numbers.

use std::fmt::Write;

use septet_core::mesh::view::MOST_CELLS;
use septet_lab::report::mesh::PlaceReport;

use super::super::axes::{grouped, si};
use super::super::card::card;
use super::data::MeshData;

/// Describes a mesh in one line.
pub(in crate::page) fn headline(mesh: &MeshData) -> String {
    format!("{} cells, {}", grouped(mesh.file.mesh.cells as f64), mesh.file.parameters.input)
}

/// Appends the summary. If there is no picture, the summary gives the reason.
pub(in crate::page) fn section(mesh: &MeshData, out: &mut String) {
    let file = &mesh.file;
    out.push_str("<section id=\"mesh-summary\" aria-label=\"Summary of the mesh\">\n<dl class=\"cards\">\n");
    counts(mesh, out);
    quality(mesh, out);
    machine(mesh, out);
    out.push_str("</dl>\n");
    if file.view.is_none() {
        let _ = writeln!(
            out,
            "<p class=\"caption\">The report has no picture of the mesh. `septet mesh --json FILE --view N` adds one, for \
             meshes of at most {} cells; this mesh has {}.</p>",
            grouped(f64::from(MOST_CELLS)),
            grouped(file.mesh.cells as f64)
        );
    }
    out.push_str("</section>\n");
}

fn counts(mesh: &MeshData, out: &mut String) {
    let (file, m) = (&mesh.file, &mesh.file.mesh);
    let space = file.domain.dimension == 3;
    let say = |x: u64| grouped(x as f64);
    let facets = if space { format!("{} on facets, ", say(m.facet_points)) } else { String::new() };
    let on = format!(
        "{} corners, {} on segments, {facets}{} inside",
        say(m.corner_points),
        say(m.segment_points),
        say(m.volume_points)
    );
    card(out, "mesh points", &say(m.points), &on);
    let domain = &file.domain;
    let boundary = if space {
        format!("{} faces on {} facets", say(m.faces), say(domain.facets))
    } else {
        format!("{} edges on {} segments", say(m.faces), say(domain.segments))
    };
    let kept = format!("{boundary}, {} components", say(domain.components));
    card(out, if space { "tetrahedra" } else { "triangles" }, &say(m.cells), &kept);
    let c = &file.conformity;
    let state = if c.passed { "conforms".to_owned() } else { format!("{} defects", say(c.defects)) };
    let measure = if space { "volume" } else { "area" };
    let note = format!(
        "{measure} {} of {}, boundary {}",
        si(c.mesh_measure),
        si(c.domain_measure),
        file.parameters.boundary
    );
    card(out, "conformity", &state, &note);
}

fn quality(mesh: &MeshData, out: &mut String) {
    let file = &mesh.file;
    for place in &file.radius_edge {
        let what = match place.place.as_ref() {
            "free" => "radius-edge ratio",
            "near" => "radius-edge near the boundary",
            "above" if place.cells > 0 => "radius-edge above facets' large triangles",
            _ => continue,
        };
        let most = place.most.upper;
        let known = most.is_finite() && place.cells > 0;
        let most = if known { format!("{most:.4}") } else { "–".to_owned() };
        card(out, what, &most, &promise(place));
    }
    let (least, most) = (&file.quality.least_angles.least, &file.quality.largest_angles.most);
    let degrees = |x: &Option<f64>| x.map_or_else(|| "–".to_owned(), |x| format!("{x:.2}°"));
    let kind = if file.domain.dimension == 3 { "dihedral angles" } else { "angles" };
    card(out, kind, &format!("{} to {}", degrees(least), degrees(most)), "smallest and largest");
    let slope = format!("L = {}, the mesh's steepest edge", file.parameters.lipschitz);
    card(out, "slope of sizes", &format!("{:.4}", file.quality.lipschitz), &slope);
}

fn promise(place: &PlaceReport) -> String {
    let cells = grouped(place.cells as f64);
    match place.promised {
        Some(bound) => format!("bound {bound:.4}; {cells} cells, {} above it", place.over),
        None => format!("no bound; {cells} cells"),
    }
}

fn machine(mesh: &MeshData, out: &mut String) {
    let (file, say) = (&mesh.file, |x: u64| grouped(x as f64));
    let workers = file.settled.workers.map_or_else(|| "one a leaf".to_owned(), |p| say(u64::from(p)));
    let sent = format!("{} messages, {}B", say(mesh.messages()), si(mesh.bytes() as f64));
    card(out, "workers", &workers, &sent);
    let depth = format!("depth {}, work {}", say(mesh.total(|t| t.depth)), si(mesh.total(|t| t.work) as f64));
    card(out, "rounds of the machine", &say(mesh.total(|t| t.rounds)), &depth);
    let whole = format!(
        "{}s with reading, checking and writing; seed {}, version {}",
        si(file.seconds.total_seconds),
        file.parameters.seed,
        file.version
    );
    card(out, "measured time", &format!("{}s", si(file.seconds.mesh_seconds)), &whole);
}
