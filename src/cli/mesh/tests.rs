//! A mesh made by hand, through every writer, the readers and the report.

use std::fs;

use glam::DVec3;
use septet_meshing::conformity::check;
use septet_meshing::input::{DomainKind, Input, InputFacet, Region};
use septet_meshing::mesh::{Carrier, Edge, Face, OUTSIDE};
use septet_meshing::quality::quality as quality_of;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use septet_common::samples::kuhn;
use septet_core::mesh::field::SizeField;
use septet_core::mesh::labelled::Labelled;
use septet_core::mesh::run_log::RunLog;
use septet_core::mesh::{
    MeshError, MeshSpec, Promise, SingularityRequest, SingularityShape, generate, measure, sizes,
};
use septet_core::model::{MeshView, Points};
use septet_core::run::memory;
use septet_core::spec::{Transport, Workers};
use septet_io::read::{AnyInput, CellOptions, ReadOptions, read as read_points, read_cells, read_domain};
use septet_io::write::{WriteOptions, write};
use septet_lab::report::mesh::{CheckedMesh, MeshContext, MeshReport};
use septet_meshing::domain::Domain;
use septet_meshing::mesh::{Mesh, StageLine};
use septet_meshing::quality::Measure;
use septet_meshing::size::user::Singularity;

use super::show::{figures, summary};

/// The unit cube with a facet at half height; markers 10 to 16, attributes 7 below and 3 above.
fn cube() -> Domain<DVec3> {
    let corner = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
    let mut input = Input::new(DomainKind::Complex, (0..8).map(corner).collect());
    input.points.extend([[0., 0., 0.5], [1., 0., 0.5], [1., 1., 0.5], [0., 1., 0.5]].map(DVec3::from));
    let squares =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5], [8, 9, 10, 11]];
    for (i, square) in squares.into_iter().enumerate() {
        let polygons = vec![square.to_vec()];
        input.facets.push(InputFacet { polygons, holes: Vec::new(), marker: 10 + i as i64 });
    }
    let region = |z, attribute| Region { at: DVec3::new(0.3, 0.4, z), attribute, limit: None };
    input.regions.extend([region(0.2, 7.0), region(0.8, 3.0)]);
    septet_meshing::check(&input).unwrap()
}

/// Returns `true` if all points lie in the bounding box of the corners, which may be flat.
fn holds(corners: &[DVec3], points: &[DVec3]) -> bool {
    let low = corners.iter().fold(DVec3::INFINITY, |m, &p| m.min(p));
    let high = corners.iter().fold(DVec3::NEG_INFINITY, |m, &p| m.max(p));
    points.iter().all(|p| p.cmpge(low).all() && p.cmple(high).all())
}

fn segment_of(domain: &Domain<DVec3>, points: &[DVec3]) -> Option<u32> {
    let ends = |s: &septet_meshing::domain::Segment| s.ends().map(|v| domain.points()[v as usize]);
    domain.segments.iter().position(|s| holds(&ends(s), points)).map(|s| s as u32)
}

fn facet_of(domain: &Domain<DVec3>, points: &[DVec3]) -> Option<u32> {
    // The corners of a side facet lie in a plane that is normal to an axis, so their bounding box is flat.
    let corners = |f: &septet_meshing::domain::Facet| -> Vec<DVec3> {
        f.corners.iter().map(|&v| domain.points()[v as usize]).collect()
    };
    domain.facets.iter().position(|f| holds(&corners(f), points)).map(|f| f as u32)
}

fn lattice(domain: &Domain<DVec3>) -> Mesh<DVec3> {
    let sample = kuhn(2);
    let points: Vec<DVec3> = sample.coordinates.chunks_exact(3).map(DVec3::from_slice).collect();
    let carrier = |p: &DVec3| {
        let at = domain.corners.iter().position(|&v| domain.points()[v as usize] == *p);
        let corner = at.map(|c| Carrier::Corner(c as u32));
        corner
            .or_else(|| segment_of(domain, &[*p]).map(Carrier::Segment))
            .or_else(|| facet_of(domain, &[*p]).map(Carrier::Facet))
            .unwrap_or(Carrier::Volume)
    };
    let cells: Vec<[u32; 4]> =
        sample.cells.chunks_exact(4).map(|c| [0, 1, 2, 3].map(|i| c[i] as u32)).collect();
    let region = |cell: &[u32; 4]| {
        let middle = cell.iter().map(|&v| points[v as usize]).sum::<DVec3>() / 4.0;
        let wanted = if middle.z < 0.5 { 7.0 } else { 3.0 };
        let named = |c: &septet_meshing::domain::Component| {
            c.region.is_some_and(|r| domain.regions[r as usize].attribute == wanted)
        };
        domain.components.iter().position(named).unwrap() as u32
    };
    let mut mesh = Mesh {
        sizes: vec![0.5; points.len()],
        carriers: points.iter().map(carrier).collect(),
        regions: cells.iter().map(region).collect(),
        points,
        cells,
        ..Mesh::default()
    };
    let mut sides = std::collections::BTreeMap::<[u32; 3], Vec<u32>>::new();
    for (row, cell) in mesh.cells.iter().enumerate() {
        for skipped in 0..4 {
            let mut rest: Vec<u32> = (0..4).filter(|&i| i != skipped).map(|i| cell[i]).collect();
            rest.sort_unstable();
            sides.entry([rest[0], rest[1], rest[2]]).or_default().push(row as u32);
        }
    }
    for (vertices, cells) in sides {
        if let Some(facet) = facet_of(domain, &vertices.map(|v| mesh.points[v as usize])) {
            let marker = domain.facets[facet as usize].marker;
            let cells = [cells[0], cells.get(1).copied().unwrap_or(OUTSIDE)];
            mesh.faces.push(Face { vertices, facet, marker, cells });
        }
    }
    for vertices in mesh.cell_edges() {
        if let Some(segment) = segment_of(domain, &vertices.map(|v| mesh.points[v as usize])) {
            mesh.edges.push(Edge { vertices, segment, marker: 0 });
        }
    }
    mesh
}

fn request() -> MeshSpec {
    MeshSpec::default().with(|mesh| {
        mesh.conforming = true;
        mesh.sizes.most = Some(0.5);
        let m = &mut mesh.run.machine;
        (m.workers, m.threads) = (Workers::Count(2), Some(1));
        m.transport = Transport::Sim { delivery_seed: 0 };
    })
}

/// Writes a mesh under this name and returns the directory.
fn written(name: &str) -> tempfile::TempDir {
    let domain = cube();
    let mesh = lattice(&domain);
    assert_eq!(check(&domain, &mesh).defects, []);
    let place = tempfile::tempdir().unwrap();
    let labelled = Labelled::of(&domain, &mesh);
    let options = WriteOptions { first_id: 1, ..WriteOptions::default() };
    write(&place.path().join(name), &labelled.view(), &options, &mut |_, _| {}).unwrap();
    place
}

fn text(place: &tempfile::TempDir, name: &str) -> String {
    fs::read_to_string(place.path().join(name)).unwrap()
}

/// Counts the last words of all lines but the first.
fn last_words(text: &str) -> std::collections::BTreeMap<i64, usize> {
    let mut counts = std::collections::BTreeMap::new();
    for line in text.lines().skip(1) {
        let word = line.rsplit(' ').next().unwrap().parse().unwrap();
        *counts.entry(word).or_default() += 1;
    }
    counts
}

#[test]
fn every_format_reads_back() {
    let sample = kuhn(2);
    for name in ["m.vtu", "m.ele", "m.msh", "m.msh22", "m.mesh", "m.npy"] {
        let place = written(name);
        let path = place.path().join(name);
        let points = if name == "m.ele" { place.path().join("m.node") } else { path.clone() };
        if name != "m.npy" {
            let read = read_points(&points, &ReadOptions::default(), &mut |_, _| {}).unwrap();
            assert_eq!(read.points.coordinates(), sample.coordinates, "{name}");
        }
        let base = (name == "m.ele").then_some(1);
        let options =
            CellOptions { dimension: Some(3), point_count: Some(27), base, ..CellOptions::default() };
        let cells = read_cells(&path, &options, &mut |_, _| {}).unwrap();
        let sorted = |cells: &[u64]| {
            let mut rows: Vec<Vec<u64>> = cells.chunks_exact(4).map(<[u64]>::to_vec).collect();
            rows.sort();
            rows
        };
        assert_eq!(sorted(&cells.cells), sorted(&sample.cells), "{name}");
    }
}

#[test]
fn surfaces_read_back_as_the_domain() {
    for name in ["m.off", "m.stl"] {
        let place = written(name);
        let file = read_domain(&place.path().join(name), &mut |_, _| {}).unwrap();
        let AnyInput::Space(input) = file.input else { panic!() };
        assert_eq!((input.points.len(), input.facets.len()), (26, 48), "{name}");
        let domain = septet_meshing::check(&input).unwrap();
        assert_eq!((domain.measure(), domain.facets.len()), (1.0, 6));
        // Outward: the signed volume is positive.
        let triangle = |f: &InputFacet<DVec3>| [0, 1, 2].map(|i| input.points[f.polygons[0][i] as usize]);
        let volume: f64 = input.facets.iter().map(triangle).map(|[a, b, c]| a.dot(b.cross(c))).sum();
        assert!((volume / 6.0 - 1.0).abs() < 1e-12, "{name}");
    }
}

#[test]
fn the_files_of_tetgen_have_markers() {
    let place = written("m.1.ele");
    let expected = (10..17).map(|m| (m, 8)).collect();
    assert_eq!(last_words(&text(&place, "m.1.face")), expected);
    assert_eq!(text(&place, "m.1.face").lines().next(), Some("56 1"));
    assert_eq!(last_words(&text(&place, "m.1.ele")), [(3, 24), (7, 24)].into());
    assert!(text(&place, "m.1.ele").starts_with("48 4 1\n"));
    // There are two subsegments on each of the 12 horizontal edges and one on each of the 8 vertical edges.
    assert_eq!(last_words(&text(&place, "m.1.edge")), [(0, 32)].into());
    let node = text(&place, "m.1.node");
    assert!(node.starts_with("27 3 1 1\n1 0 0 0 0.5 "), "{node}");
    // The point in the middle of a facet has the marker of the facet.
    let marker = |p: &str| node.lines().find(|l| l.contains(p)).and_then(|l| l.rsplit(' ').next()).unwrap();
    assert_eq!([marker(" 0.5 0.5 0 0.5"), marker(" 0.5 0.5 0.5 0.5")], ["10", "16"]);
}

#[test]
fn gmsh_and_medit_have_groups() {
    let place = written("m.msh");
    let msh = text(&place, "m.msh");
    // The edges have one marker, the facets seven, and the regions two.
    assert!(msh.contains("$Entities\n0 1 7 2\n"), "{msh}");
    let surface = |marker: i64| msh.lines().any(|l| l.ends_with(&format!(" 1 {marker} 0")));
    assert!((10..17).all(surface) && surface(3) && surface(7));
    assert!(msh.contains("$Elements\n10 136 1 136\n"), "{msh}");
    let msh = text(&written("m.msh22"), "m.msh22");
    let tags = |kind: &str, group: &str| {
        let has = |l: &&str| {
            let words: Vec<&str> = l.split(' ').collect();
            words.len() > 5 && words[1] == kind && words[2] == "2" && words[3] == group
        };
        msh.lines().filter(has).count()
    };
    assert_eq!((tags("1", "1"), tags("2", "16"), tags("4", "7"), tags("4", "3")), (32, 8, 24, 24));
    let medit = text(&written("m.mesh"), "m.mesh");
    for (section, next, rows) in [
        ("Triangles\n56", "Edges", (10, 8)),
        ("Edges\n32", "Tetrahedra", (0, 32)),
        ("Tetrahedra\n48", "End", (7, 24)),
    ] {
        let start = medit.find(section).unwrap();
        let end = start + medit[start..].find(&format!("\n{next}")).unwrap();
        let body = medit[start..end].lines().skip(1).collect::<Vec<_>>().join("\n");
        assert_eq!(last_words(&body)[&rows.0], rows.1, "{section}");
    }
}

#[test]
fn vtu_has_arrays_and_faces() {
    let place = written("m.vtu");
    let head = |name: &str| {
        let bytes = fs::read(place.path().join(name)).unwrap();
        let end = bytes.windows(12).position(|w| w == b"AppendedData").unwrap();
        String::from_utf8(bytes[..end].to_vec()).unwrap()
    };
    let cells = head("m.vtu");
    for name in [
        "region",
        "marker",
        "dimension",
        "attribute",
        "least_angle",
        "size",
        "carrier",
        "carrier_dimension",
        "radius_edge_ratio",
        "feature",
        "inner_region",
        "outer_region",
    ] {
        assert!(cells.contains(&format!("Name=\"{name}\"")), "{name}: {cells}");
    }
    // 48 cells, 56 faces and 32 edges.
    assert!(cells.contains("NumberOfPoints=\"27\" NumberOfCells=\"136\""), "{cells}");
    // The arrays are at the offsets that the head gives.
    let bytes = fs::read(place.path().join("m.vtu")).unwrap();
    let word = |name: &str, i: usize| {
        let line = cells.lines().find(|l| l.contains(&format!("Name=\"{name}\""))).unwrap();
        let offset: usize =
            line.split("offset=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
        let mark = b"\"raw\">\n   _";
        let start = bytes.windows(mark.len()).position(|w| w == mark).unwrap() + mark.len();
        let at = start + offset + 8 + i;
        bytes[at..at + 8].try_into().map(u64::from_le_bytes).unwrap()
    };
    assert_eq!(f64::from_bits(word("size", 8 * 5)), 0.5);
    assert!(f64::from_bits(word("attribute", 0)) == 7.0 && f64::from_bits(word("attribute", 8 * 47)) == 3.0);
    // The first point is a corner, and the middle one lies on a facet.
    assert_eq!(word("carrier_dimension", 0) as u32, 0);
    assert_eq!(word("carrier_dimension", 4 * 13) as u32, 2);
    let mut angles: Vec<f64> = (0..48).map(|i| f64::from_bits(word("least_angle", 8 * i))).collect();
    angles.sort_by(f64::total_cmp);
    assert!(angles[0] > 44.9 && angles[47] < 45.1, "{angles:?}");
    assert_eq!([word("feature", 0), word("dimension", 0), word("dimension", 8 * 48)], [u64::MAX, 3, 2]);
    // A reader reads the points, and the cells without the faces.
    let read = read_points(&place.path().join("m.vtu"), &ReadOptions::default(), &mut |_, _| {}).unwrap();
    assert!(matches!(read.points, Points::Space(p) if p.len() == 27));
}

#[test]
fn faces_point_out_of_their_first_cells() {
    let domain = cube();
    let mesh = lattice(&domain);
    let labelled = Labelled::of(&domain, &mesh);
    let MeshView { labels: Some(labels), .. } = labelled.view() else { panic!() };
    for (row, face) in labels.faces.vertices.chunks_exact(3).enumerate() {
        let [a, b, c] = [0, 1, 2].map(|i| mesh.points[face[i] as usize]);
        let outside = (a + b + c) / 3.0 + (b - a).cross(c - a) * 0.1;
        assert!(face[0] < face[1] && face[0] < face[2]);
        let [inner, outer] = labels.sides[row];
        assert!(inner > 0 && (outer == 0) != domain.is_inside(outside));
        assert!(outer == 0 || inner < outer);
    }
}

#[test]
fn labels_that_do_not_fit_are_refused() {
    let domain = cube();
    let mesh = lattice(&domain);
    let labelled = Labelled::of(&domain, &mesh);
    let view = labelled.view();
    let place = tempfile::tempdir().unwrap();
    let fails = |spoil: &dyn Fn(&mut septet_core::model::Labels), word: &str| {
        let mut labels = view.labels.unwrap().clone();
        spoil(&mut labels);
        let view = MeshView { labels: Some(&labels), ..view };
        let error = write(&place.path().join("m.mesh"), &view, &WriteOptions::default(), &mut |_, _| {});
        let error = error.unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    };
    fails(&|l| l.regions.truncate(3), "regions");
    fails(&|l| l.faces.vertices[4] = 99, "face 1 has vertex 99");
    fails(&|l| l.edges.markers.truncate(3), "edges");
    fails(&|l| l.sides.truncate(3), "sides");
    assert_eq!(fs::read_dir(place.path()).unwrap().count(), 0);
}

#[test]
fn the_report_says_what_was_found() {
    let domain = cube();
    let mesh = lattice(&domain);
    let conformity = check(&domain, &mesh);
    let request = request();
    let quality = measure(&domain, &mesh, &sizes(&domain, &request).unwrap(), 3);
    let stages = [StageLine { name: "corners".into(), points: 12, ..StageLine::default() }];
    let checked = CheckedMesh {
        domain: &domain,
        request: &request,
        mesh: &mesh,
        stages: &stages,
        quality: &quality,
        conformity: &conformity,
        run_log: &RunLog::default(),
        picture: None,
    };
    let around = MeshContext { input: "cube.poly", first_id: 1, ..MeshContext::default() };
    let text = MeshReport::of(&checked, &around).to_json().unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["schema"], "septet-mesh/2");
    assert_eq!(json["parameters"]["boundary"], "exact");
    assert_eq!(json["domain"]["facets"], 7);
    assert_eq!(json["mesh"]["corner_points"], 12);
    assert_eq!(json["mesh"]["facet_points"], 3);
    assert_eq!(json["mesh"]["volume_points"], 0);
    assert_eq!(json["stages"][0]["points"], 12);
    assert_eq!(json["conformity"]["passed"], true);
    assert_eq!(json["conformity"]["mesh_boundary"], 6.0);
    let cells: u64 = (0..4).map(|i| json["radius_edge"][i]["cells"].as_u64().unwrap()).sum();
    assert_eq!(cells, 48);
    let counted = json["quality"]["radius_edge"]["counts"].as_array().unwrap();
    assert_eq!(counted.iter().map(|c| c.as_u64().unwrap()).sum::<u64>(), 48);
    let counts = [0, 1, 2, 3].map(|i| json["radius_edge"][i]["cells"].as_u64().unwrap());
    // The centres of the cubes lie in the balls of faces, whose radii are larger than the sizes there.
    assert_eq!(counts, [0, 0, 48, 0]);
    assert!(json["features"][0]["feature"].as_str().unwrap().contains(' '));
    let carried = json["radius_edge"][2]["worst"][0]["vertices"][0][1].as_str().unwrap();
    assert!(
        carried.starts_with("point ") || carried.starts_with("segment ") || carried.starts_with("facet ")
    );
    assert!(summary(&checked, 0)[0].contains("27 points, 48 cells: the mesh conforms"));
    let drawn = figures(&quality, Promise::of(0.5));
    assert_eq!(drawn.len(), 6);
    assert!(drawn[0].0 == "radius-edge.svg" && drawn[0].1.contains("bound 2.0000"));
    let place = |_: DVec3, _: f64| septet_meshing::quality::CentrePlace::Free;
    let other = Measure { place: &place, local_size: None, promised: [Some(0.5), None, None], worst: 1 };
    assert_eq!(quality_of(&domain, &mesh, &other).places[0].over, 48);
}

#[test]
fn requests_become_constraints() {
    let domain = cube();
    let place = |shape, at: &[f64]| {
        let singularity = Some(SingularityRequest { shape, at: at.to_vec() });
        let asked = request().with(|m| (m.sizes.singularity, m.sizes.least) = (singularity, Some(0.01)));
        asked.size_options(&domain)
    };
    let of = |shape, at: &[f64]| place(shape, at).unwrap().constraints.singularities;
    assert_eq!(of(SingularityShape::Point, &[]), [(Singularity::Point(DVec3::splat(0.5)), 0.01)]);
    assert_eq!(
        of(SingularityShape::Point, &[1., 2., 3.]),
        [(Singularity::Point(DVec3::new(1., 2., 3.)), 0.01)]
    );
    let Singularity::Line(p, q) = of(SingularityShape::Line, &[])[0].0 else { panic!() };
    assert!((p.x - 1.0 / 3.0).abs() < 1e-15 && (q.x - 2.0 / 3.0).abs() < 1e-15 && p.y == 0.5);
    assert!(matches!(place(SingularityShape::Point, &[1., 2.]), Err(MeshError::Dimension { found: 2, .. })));
    let field = SizeField { dimension: 2, rows: vec![([0.0; 3], 1.0)] };
    let plane = request().with(|m| m.sizes.field = Some(field.clone()));
    assert!(matches!(plane.size_options(&domain), Err(MeshError::Dimension { expected: 3, .. })));
    let space = request().with(|m| m.sizes.field = Some(SizeField { dimension: 3, ..field }));
    assert_eq!(space.size_options(&domain).unwrap().constraints.field.len(), 1);
    assert_eq!(Promise::of(0.5).free, 2.0);
    assert!(Promise::of(0.06).near.is_some_and(|g| g > 1.5 && g < 1.7), "{:?}", Promise::of(0.06));
}

#[test]
fn a_mesh_ends_when_it_is_cancelled() {
    let domain = cube();
    let cancel = Some(Arc::new(AtomicBool::new(true)));
    let fine = request().with(|m| m.sizes.most = Some(0.05));
    let cancelled = fine.clone().with(|m| m.run.control.cancel = cancel);
    let made = generate(&domain, &sizes(&domain, &fine).unwrap(), &cancelled);
    assert!(matches!(made, Err(MeshError::Run(septet_core::Error::Interrupted))), "{made:?}");
}

/// The memory that a mesh may need is estimated before any point is inserted.
#[test]
fn a_mesh_that_is_too_fine_is_refused() {
    let domain = cube();
    let limited = request().with(|m| (m.sizes.most, m.run.machine.max_memory) = (Some(1e-5), Some(1 << 28)));
    let made = generate(&domain, &sizes(&domain, &limited).unwrap(), &limited);
    let Err(MeshError::Memory { forecast, limit, .. }) = made else { panic!("{:?}", made.map(|m| m.1)) };
    assert!(forecast > limit && limit == 1 << 28);
    assert!(memory::available().is_none_or(|bytes| bytes > 0));
}
