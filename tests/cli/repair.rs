//! Domains as files have them: rounded, with points listed twice, edges that do not match, and several solids.

use std::path::{Path, PathBuf};

use super::{Place, code, stderr};

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/domains/files").join(name)
}

/// Checks a domain with options. Returns the exit code, the messages and the volume.
fn check(names: &[PathBuf], options: &str) -> (i32, String, f64) {
    let names: Vec<String> = names.iter().map(|path| path.display().to_string()).collect();
    let output = Place::new().run(&format!("mesh {} --check {options}", names.join(" ")));
    let talk = stderr(&output);
    let volume = talk.split("volume ").nth(1).and_then(|rest| rest.split_whitespace().next()?.parse().ok());
    (code(&output), talk, volume.unwrap_or(f64::NAN))
}

fn near(volume: f64, expected: f64, tolerance: f64) -> bool {
    (volume / expected - 1.0).abs() <= tolerance
}

/// Inputs of reported kinds: options, the volume and its tolerance, and words of the messages.
#[test]
fn files_that_are_not_exact_are_domains() {
    for (name, options, expected, tolerance, words) in [
        ("rotated-box-6.poly", "", 6.0, 1e-5, "planar only within the digits"),
        ("quad-torus.obj", "", 18.262_271_822_433_863, 1e-3, "planar only within the digits"),
        (
            "two-cubes-edge.obj",
            "",
            2.0,
            1e-9,
            "not manifold at 1 edge and 0 vertices, the first at (1, 1, 0.5)",
        ),
        ("nested-outward.stl.gz", "", 3.687_745_137_426_864, 1e-5, "corners merged"),
        ("soup.off.gz", "", 4.019_397_470_141_226, 1e-6, "points welded to equal points at 182 places"),
        ("t-junction.off", "--repair", 1.0, 1e-9, "was divided at point 8 at (0.5, 0, 1)"),
        ("pinhole.off", "--repair", 3.926_596_389_111_272_5, 1e-3, "was closed by 1 triangle"),
        ("slit-soup.off", "--repair", 1.0, 1e-9, "another facet has the same corners"),
    ] {
        let (code, talk, volume) = check(&[file(name)], options);
        assert!(code == 0 && near(volume, expected, tolerance), "{name}: {volume}: {talk}");
        assert!(talk.contains(words), "{name}: no `{words}` in: {talk}");
        assert!(talk.contains("repair: ") != options.is_empty(), "{name}: {talk}");
    }
}

#[test]
fn without_options_nothing_is_repaired() {
    for (name, options, words) in [
        ("t-junction.off", "", &["point 8 and segment 4-5 intersect", "(0.5, 0, 1)", "--repair"][..]),
        ("pinhole.off", "", &["the surface is open: edge", "--repair"]),
        ("slit-soup.off", "", &["overlap: facet 12 and facet 13 overlap at (0.3, 0.3, 0.5)", "--repair"]),
        ("rotated-box-6.poly", "--strict", &["facet 0 is not planar: point "]),
        ("two-cubes-edge.obj", "--strict", &["edge 3-7 at (1, 1, 0.5) has 4 facets: 7, 10, 18, 23"]),
        ("soup.off.gz", "--strict", &["have the same coordinates", "has 182 defects"]),
    ] {
        let (code, talk, _) = check(&[file(name)], options);
        assert_eq!(code, 3, "{name}: {talk}");
        for word in words {
            assert!(talk.contains(word), "{name}: no `{word}` in: {talk}");
        }
    }
}

/// The corners and triangles of a box, in the form of an `.stl` file.
fn solid(name: &str, low: [f64; 3], high: [f64; 3]) -> String {
    let squares = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let corner = |i: usize| -> String {
        let at = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
        format!("vertex {} {} {}\n", at(0), at(1), at(2))
    };
    let triangle = |t: [usize; 3]| {
        format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", t.map(corner).concat())
    };
    let faces = squares.map(|[a, b, c, d]| triangle([a, b, c]) + &triangle([a, c, d])).concat();
    format!("solid {name}\n{faces}endsolid {name}\n")
}

#[test]
fn solids_are_regions_of_one_domain() {
    let place = Place::new();
    let (left, right) = (solid("left", [0.; 3], [1.; 3]), solid("right", [1., 0., 0.], [3., 1., 1.]));
    let core = solid("core", [0.25; 3], [0.75; 3]);
    place.file("both.stl", left.clone() + &right + &core);
    place.file("a.stl", left).file("b.stl", right).file("c.stl", core);
    for names in ["both.stl", "a.stl b.stl c.stl"] {
        let output = place.run(&format!("mesh {names} --check"));
        let talk = stderr(&output);
        assert_eq!(code(&output), 0, "{talk}");
        assert!(talk.contains("3 components, 3 regions, volume 3\n"), "{talk}");
        assert!(
            talk.contains("each solid is a region: 1 ") && talk.contains("2 facets between two of them"),
            "{talk}"
        );
    }
    let talk = stderr(&place.good("mesh both.stl -o m.1.ele"));
    assert!(talk.contains("the mesh conforms"), "{talk}");
    // Volumes of the regions, by the attributes of the cells.
    let read = |name: &str| std::fs::read_to_string(place.path(name)).unwrap();
    let rows = |text: &str| -> Vec<Vec<f64>> {
        text.lines().skip(1).map(|l| l.split(' ').map(|w| w.parse().unwrap()).collect()).collect()
    };
    let points = rows(&read("m.1.node"));
    let mut volumes = [0.0; 4];
    for cell in rows(&read("m.1.ele")) {
        let at = |k: usize| [1, 2, 3].map(|i| points[cell[k] as usize - points[0][0] as usize][i]);
        let [a, b, c, d] = [1, 2, 3, 4].map(at);
        let minus = |p: [f64; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
        let [u, v, w] = [b, c, d].map(minus);
        let cross = |i: usize, j: usize| v[i] * w[j] - v[j] * w[i];
        let volume = u[0] * cross(1, 2) + u[1] * cross(2, 0) + u[2] * cross(0, 1);
        volumes[cell[5] as usize] += volume.abs() / 6.0;
    }
    for (volume, expected) in volumes.iter().zip([0.0, 0.875, 2.0, 0.125]) {
        assert!((volume - expected).abs() < 1e-9, "{volumes:?}");
    }
    place.fails("mesh both.stl --boundary remesh -o x.vtu", 2, &["cannot be remeshed"]);
    place.fails("mesh a.stl none.stl --check", 3, &["none.stl", "no such file"]);
    // Solids that are open are parts of one surface.
    let whole = solid("x", [0.; 3], [1.; 3]);
    let facets: Vec<&str> = whole.split_inclusive("endfacet\n").collect();
    let parts = format!("{}endsolid x\nsolid lid\n{}", facets[..2].concat(), facets[2..].concat());
    place.file("parts.stl", parts.replace("endsolid x\n", "endsolid\n"));
    let talk = stderr(&place.good("mesh parts.stl --check"));
    assert!(talk.contains("markers: 1 x, 2 lid") && talk.contains("volume 1\n"), "{talk}");
}

#[test]
fn near_points_are_welded_on_request() {
    let place = Place::new();
    let cube = solid("x", [0.; 3], [1.; 3]).replacen("vertex 1 1 1", "vertex 1 1 1.0000001", 1);
    place.file("a.stl", cube);
    let talk = place.run("mesh a.stl --check");
    assert_eq!(code(&talk), 3, "{}", stderr(&talk));
    let talk = stderr(&place.good("mesh a.stl --check --weld 1e-6"));
    assert!(
        talk.contains("1 point moved to neighbours within the weld distance") && talk.contains("volume 1"),
        "{talk}"
    );
    place.fails("mesh a.stl --check --weld 0", 2, &["positive length"]);
    place.fails("mesh a.stl --check --weld 1 --strict", 2, &["--strict", "--weld"]);
}

#[test]
fn lines_of_obj_continue() {
    let place = Place::new();
    let text =
        "v 0 0 0\nv 1 0 \\\n 0\nv 0 1 0\r\nv 0 0 1\nf 1 3 \\\r\n 2\nf 1 2 \\\n\\\n4\nf 2 3 4\nf 3 1 4\n";
    place.file("a.obj", text);
    let talk = stderr(&place.good("mesh a.obj --check"));
    assert!(talk.contains("4 points") && talk.contains("volume 0.16666666666666666\n"), "{talk}");
    place.file("b.obj", text.replace("f 3 1 4", "f 3 1 x"));
    place.fails("mesh b.obj --check", 3, &["line 12", "x"]);
}
