//! `septet mesh` as scripts see it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::{Place, code, stderr};

pub fn root(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(name)
}

fn files(directory: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(root(directory)).unwrap().map(|e| e.unwrap().path());
    let mut files: Vec<PathBuf> = entries.filter(|p| p.extension().is_some_and(|e| e != "node")).collect();
    files.sort();
    files
}

/// Returns the exit code and the messages for a domain.
fn check(path: &Path) -> (i32, String) {
    let output = Place::new().run(&format!("mesh {} --check --strict", path.display()));
    assert!(output.stdout.is_empty());
    (code(&output), stderr(&output))
}

#[test]
fn good_domains_pass_and_are_summed_up() {
    let summary = |name: &str| check(&root("domains/good").join(name)).1;
    for path in files("domains/good") {
        let (code, talk) = check(&path);
        assert_eq!(code, 0, "{}: {talk}", path.display());
        assert!(talk.contains("is a domain"), "{talk}");
    }
    for name in ["cube.poly", "cube.off", "cube.obj", "cube.ply", "cube.stl", "cube-points.smesh"] {
        let talk = summary(name);
        assert!(talk.contains("8 points, 8 corners, 12 segments, 6 facets, 1 component"), "{talk}");
        assert!(talk.contains("volume 64\n") && !talk.contains("degrees"), "{talk}");
    }
    assert!(summary("two-regions.poly").contains("7 facets, 2 components, 2 regions"));
    assert!(summary("cubic-hole.poly").contains("volume 208\n"));
    assert!(summary("slanted-box.poly").contains("volume 162\n"));
    assert!(summary("map.poly").contains("4 components, 4 regions, area 80\n"));
    let wedge = summary("wedge.poly");
    assert!(wedge.contains("facet 3 and facet 5, 10.000 degrees, at (0, 0, 0)"), "{wedge}");
    assert!(wedge.contains("segment 1-2 and facet 5, 10.000 degrees"), "{wedge}");
}

#[test]
fn each_defect_is_named_with_ids_and_place() {
    let expected = [
        ("bent.off", 1, "facet 1 is not planar: point 6 at (0, 4, 4)"),
        ("crossing-segments.poly", 1, "segment 2-3 and segment 5-6 intersect"),
        ("crossing.off", 18, "facet 2 and facet 16 intersect"),
        ("crossing.poly", 2, "facet 5 and facet 7 intersect"),
        ("degenerate.off", 4, "facet 13 has no area, at (0, 0, 0)"),
        ("doubled.off", 4, "facet 3 and facet 12 overlap"),
        ("doubled.poly", 1, "facet 1 and facet 7 overlap"),
        ("duplicate.off", 1, "points 7, 8 have the same coordinates (4, 4, 4)"),
        ("edge-of-three.off", 3, "edge 6-7 at (2, 4, 4) has 3 facets: 3, 6, 12"),
        ("facet-hole.poly", 1, "hole point 1 of facet 5 at (0, 9, 2)"),
        ("hole-on-facet.poly", 1, "hole point 1 at (4, 2, 2) lies on a segment or facet"),
        ("hole-outside.poly", 1, "hole point 1 at (9, 9, 9) lies outside"),
        ("no-length.poly", 1, "segment 2-2 has no length, at (4, 0)"),
        ("not-planar.poly", 1, "facet 2 is not planar: point 7 at (0, 4, 4)"),
        ("open.off", 3, "the surface is open: edge 1-5 at (4, 0, 2) belongs only to facet 4"),
        ("pierced.poly", 1, "segment 9-10 and facet 2 intersect"),
        ("pinched.off", 1, "point 7 at (4, 4, 4) joins 2 fans"),
        ("region-in-hole.poly", 1, "region 1 at (2.5, 3, 3) lies in a hole"),
        ("region-outside.poly", 1, "region 1 at (9, 1, 1) lies outside"),
        ("regions-together.poly", 1, "regions 1 and 2 lie in one component, 2 at (3, 3, 3)"),
        ("touching.off", 9, "point 8 and segment 4-7 intersect"),
        ("unclosed.poly", 1, "enclose only holes"),
    ];
    let mut named: Vec<&str> = expected.iter().map(|e| e.0).collect();
    named.push("no-such-point.off");
    named.sort_unstable();
    let present: Vec<_> = files("domains/bad").iter().map(|p| p.file_name().unwrap().to_owned()).collect();
    assert_eq!(present, named);
    for (name, count, words) in expected {
        let (code, talk) = check(&root("domains/bad").join(name));
        assert_eq!(code, 3, "{name}: {talk}");
        assert!(talk.contains(words), "{name}: no `{words}` in: {talk}");
        let plural = if count == 1 { "" } else { "s" };
        assert!(talk.contains(&format!("{name} has {count} defect{plural}\n")), "{name}: {talk}");
        // One line each, the summary, the help.
        assert_eq!(talk.lines().count(), count + 2, "{name}: {talk}");
    }
    let (code, talk) = check(&root("domains/bad/no-such-point.off"));
    assert!(code == 3 && talk.contains("names point 8"), "{talk}");
}

#[test]
fn defects_are_shown_to_the_quiet_and_other_files_refused() {
    let place = Place::new();
    let open = root("domains/bad/open.off");
    let talk = stderr(&place.run(&format!("mesh {} --check -q", open.display())));
    assert!(talk.contains("the surface is open"), "{talk}");
    let cube = root("domains/good/cube.off");
    assert_eq!(stderr(&place.run(&format!("mesh {} --check -q", cube.display()))), "");
    place.fails("mesh none.poly --check", 3, &["none.poly", "no such file"]);
    place.file("a.vtu", "<VTKFile/>").fails("mesh a.vtu --check", 3, &["a.vtu", ".poly"]);
    place.file("a.poly", "1 3 0 0\n0 0 0\n").fails("mesh a.poly --check", 3, &["a.poly", "line 2"]);
    place.fails("mesh a.poly", 2, &["--check"]);
}

#[test]
fn options_that_cannot_be_are_refused() {
    let place = Place::new();
    let cube = root("domains/good/cube.poly");
    place.file("cube.poly", fs::read(cube).unwrap());
    for (options, code, words) in [
        ("--check -o m.vtu", 2, &["--check", "--output"][..]),
        ("-o m.vtu --lipschitz 0.5 --radius-edge 2", 2, &["--lipschitz", "--radius-edge"]),
        ("-o m.vtu --lipschitz 1", 2, &["between 0 and 1"]),
        ("-o m.vtu --lipschitz -0.5", 2, &["between 0 and 1"]),
        ("-o m.vtu --radius-edge 1", 2, &["above 1"]),
        ("-o m.vtu --radius-edge inf", 2, &["above 1"]),
        ("-o m.vtu --size 0", 2, &["positive length"]),
        ("-o m.vtu --size 1 --min-size 2", 2, &["--min-size is larger than --size"]),
        ("-o m.vtu --min-size nan", 2, &["positive length"]),
        ("-o m.vtu --feature-angle 181", 2, &["0 to 180"]),
        ("-o m.vtu --boundary some", 2, &["exact", "remesh"]),
        ("-o m.vtu --singularity point", 2, &["--min-size"]),
        ("-o m.vtu --min-size 1 --singularity plane", 2, &["`point`, `line`"]),
        ("-o m.vtu --min-size 1 --singularity line:1,2,3", 2, &["line:X,Y"]),
        ("-o m.vtu --min-size 1 --singularity point:0,0", 2, &["the singularity has 2", "the domain has 3"]),
        ("-o m.vtu --delivery-seed 3", 2, &["--transport sim"]),
        ("-o m.vtu --workers 0", 2, &["worker"]),
        ("-o m.xyz", 2, &["m.xyz", "unknown output format"]),
        ("-o none/m.vtu", 1, &["none"]),
        ("-o cube.node -o cube.1.ele -o cube.1.node", 2, &["same file"]),
        ("-o m.vtu --json m.vtu", 2, &["same file"]),
        ("-o m.su2 --order 2", 2, &["m.su2", "linear cells", "--order"]),
        ("-o m.vtu --order 3", 2, &["--order", "1", "2"]),
        ("--order 2 --json m.json", 2, &["--order", "-o OUT"]),
        ("-o m.vtu --size-field none.txt", 3, &["none.txt", "no such file"]),
    ] {
        place.fails(&format!("mesh cube.poly {options}"), code, words);
    }
    place.file("cube.node", "0 3 0 0\n");
    place.fails("mesh cube.poly -o cube.ele", 2, &["cube.ele", "overwrite", "cube.node"]);
    place.file("f.txt", "0 0 0 1\n0 0 1 -1\n");
    place.fails("mesh cube.poly -o m.vtu --size-field f.txt", 3, &["f.txt", "line 2", "positive"]);
    place.file("f.txt", "0 0 1\n");
    place.fails(
        "mesh cube.poly -o m.vtu --size-field f.txt",
        3,
        &["the size field has 2", "the domain has 3"],
    );
}

/// Surfaces of CGAL's demos and TetGen's example.
#[test]
#[ignore = "needs the test data"]
fn surface_meshes_of_the_test_data_become_meshes() {
    for (name, expected, words) in [
        ("example.poly", 0, "28 corners, 44 segments, 22 facets, 2 components, 2 regions, volume 17.9375"),
        ("fandisk.off", 0, "6,475 points"),
        ("elephant.off", 0, "2,775 points"),
        ("rotor.off", 0, "600 points"),
        ("rotor_small.off", 0, "2,400 points"),
        ("camel.off", 3, "facet 2416 and facet 3411 intersect"),
    ] {
        let path = root("data").join(name);
        assert!(path.is_file(), "{} is missing: run tests/run --setup", path.display());
        let (code, talk) = check(&path);
        assert!(code == expected && talk.contains(words), "{name}: {code}: {talk}");
    }
}

/// Facets that are coplanar up to rounding, in many planes. Flat cells lie across them, on the hull and in notches.
#[test]
#[ignore = "needs the test data"]
fn a_rotor_is_the_same_for_one_and_three_workers() {
    let path = root("data").join("rotor_small.off");
    assert!(path.is_file(), "{} is missing: run tests/run --setup", path.display());
    let place = Place::new();
    let made = [1, 3].map(|workers| {
        let name = format!("m{workers}.vtu");
        let line = format!("mesh {} --boundary exact --workers {workers} -o {name}", path.display());
        let talk = stderr(&place.good(&line));
        assert!(talk.contains("the mesh conforms"), "{workers} workers: {talk}");
        fs::read(place.path(&name)).unwrap()
    });
    assert!(made[0] == made[1], "other bytes with three workers");
    assert!(made[0].len() > 10_000_000, "{} bytes", made[0].len());
}

/// What `-o` leaves on disk, and what stands in the report. The stage of improvement counts changes in place of points.
#[test]
fn meshes_are_written_whole_and_reported() {
    let place = Place::new();
    let cube = root("domains/good/two-regions.poly");
    place.file("a.poly", fs::read(cube).unwrap());
    fs::create_dir(place.path("case")).unwrap();
    let outputs =
        "-o m.1.ele -o m.vtu -o m.msh -o m.mesh -o m.off -o m.stl -o m.npy -o case/polyMesh -o m.exo";
    let output =
        place.good(&format!("mesh a.poly --size 1 --no-improve {outputs} --json m.json --svg figures"));
    assert!(output.stdout.is_empty());
    let talk = stderr(&output);
    assert!(talk.contains("the mesh conforms") && talk.contains(" m.vtu ("), "{talk}");
    let expected = [
        "a.poly",
        "case",
        "figures",
        "m.1.edge",
        "m.1.ele",
        "m.1.face",
        "m.1.neigh",
        "m.1.node",
        "m.exo",
        "m.json",
        "m.mesh",
        "m.msh",
        "m.npy",
        "m.off",
        "m.stl",
        "m.vtu",
    ];
    assert_eq!(place.names().iter().map(String::as_str).collect::<Vec<_>>(), expected);
    assert_eq!(fs::read_dir(place.path("case/polyMesh")).unwrap().count(), 7);
    assert!(fs::read_dir(place.path("figures")).unwrap().count() >= 5);
    assert_files_agree(&place, &place.json("m.json"));
}

/// Checks the keys and sums of a report, and that the files of `TetGen` have its counts.
fn assert_files_agree(place: &Place, json: &Value) {
    assert_eq!(json["schema"], "septet-mesh/2");
    for key in [
        "parameters",
        "domain",
        "mesh",
        "stages",
        "radius_edge",
        "features",
        "quality",
        "conformity",
        "seconds",
        "peak_rss_bytes",
        "version",
    ] {
        assert!(!json[key].is_null(), "{key}");
    }
    assert_eq!(json["parameters"]["lipschitz"], 0.5);
    assert_eq!(json["parameters"]["radius_edge"], 2.0);
    assert_eq!(json["conformity"]["passed"], true);
    let number = |value: &Value| value.as_u64().unwrap();
    let mesh = &json["mesh"];
    let by_carrier: u64 = ["corner_points", "segment_points", "facet_points", "volume_points"]
        .iter()
        .map(|k| number(&mesh[k]))
        .sum();
    assert_eq!(by_carrier, number(&mesh["points"]));
    let cells: u64 = json["radius_edge"].as_array().unwrap().iter().map(|p| number(&p["cells"])).sum();
    assert_eq!(cells, number(&mesh["cells"]));
    let placed: u64 = json["stages"].as_array().unwrap().iter().map(|s| number(&s["points"])).sum();
    assert_eq!(placed + number(&mesh["corner_points"]), number(&mesh["points"]));
    // The files are of that mesh.
    let rows = |name: &str| -> u64 {
        let text = fs::read_to_string(place.path(name)).unwrap();
        text.split_whitespace().next().unwrap().parse().unwrap()
    };
    assert_eq!(rows("m.1.node"), number(&mesh["points"]));
    assert_eq!(rows("m.1.ele"), number(&mesh["cells"]));
    assert_eq!(rows("m.1.face"), number(&mesh["faces"]));
    assert_eq!(rows("m.1.edge"), number(&mesh["edges"]));
}

/// `--radius-edge B` is another way to say L, and the files do not depend on workers and transport.
#[test]
fn files_of_meshes_do_not_depend_on_the_machine() {
    let place = Place::new();
    place.file("a.poly", fs::read(root("domains/good/dangling.poly")).unwrap());
    let made = |name: &str, options: &str| {
        place.good(&format!(
            "mesh a.poly --conforming -o {name}.1.ele -o {name}.vtu -o {name}.msh -o {name}.stl -o {name}.exo {options}"
        ));
        let files = ["1.node", "1.ele", "1.face", "1.edge", "1.neigh", "vtu", "exo", "msh", "stl"];
        files.map(|f| fs::read(place.path(&format!("{name}.{f}"))).unwrap())
    };
    let first = made("a", "--lipschitz 0.25 --workers 1 --threads 1");
    for options in [
        "--radius-edge 1.3333333333333333 --workers 5",
        "--lipschitz 0.25 --workers 64 --transport sim --delivery-seed 3",
        "--lipschitz 0.25 --workers leaves --threads 2",
    ] {
        assert!(made("b", options) == first, "{options}");
    }
    assert!(made("c", "--lipschitz 0.25 --seed 2") != first);
}

/// Nothing is written, and the code says why.
#[test]
fn meshes_that_cannot_be_made_leave_nothing() {
    let place = Place::new();
    for name in ["crossing.poly", "open.off", "not-planar.poly", "touching.off"] {
        place.file(name, fs::read(root("domains/bad").join(name)).unwrap());
        place.fails(&format!("mesh {name} -o m.vtu --json m.json"), 3, &[name, "defect"]);
    }
    place.file("cube.poly", fs::read(root("domains/good/cube.poly")).unwrap());
    let both = "mesh cube.poly -o m.vtu --lipschitz 0.5 --radius-edge 2";
    place.fails(both, 2, &["--lipschitz", "--radius-edge"]);
    for size in ["0.1", "0.05"] {
        let line = format!("mesh cube.poly -o m.vtu --json m.json --size {size} --max-memory 100M");
        place.fails(&line, 5, &["bytes of memory", "--max-memory"]);
    }
    place.good("mesh cube.poly -o m.vtu --size 1 --max-memory 1G");
}

/// Surfaces are remeshed by default, complexes are kept.
#[test]
fn surfaces_are_remeshed_by_default() {
    let place = Place::new();
    for name in ["cube.off", "cube.stl", "cube.poly"] {
        place.file(name, fs::read(root("domains/good").join(name)).unwrap());
    }
    let report = |line: &str| {
        place.good(&format!("mesh {line} --size 1 -o m.1.ele --json m.json"));
        let json = place.json("m.json");
        assert_eq!(json["conformity"]["passed"], true, "{line}");
        (json["parameters"]["boundary"].clone(), json["deviation"].clone())
    };
    for line in
        ["cube.off", "cube.stl", "cube.off --boundary remesh", "cube.off --max-distance 0.1 --improve"]
    {
        let (boundary, deviation) = report(line);
        assert_eq!(boundary, "remesh", "{line}");
        let [of_boundary, of_surface] = ["of_boundary", "of_surface"].map(|k| deviation[k].as_f64().unwrap());
        // All of a cube's ridges are kept, so there is nothing but rounding between it and its boundary.
        assert!(of_boundary < 1e-12 && of_surface < 1e-12, "{line}: {deviation}");
    }
    for line in ["cube.off --boundary exact", "cube.poly"] {
        let (boundary, deviation) = report(line);
        assert!(boundary == "exact" && deviation.is_null(), "{line}: {boundary} {deviation}");
    }
    for line in ["cube.off --boundary exact", "cube.poly"] {
        place.fails(&format!("mesh {line} --max-distance 0.1 -o n.vtu"), 2, &["--max-distance", "remesh"]);
    }
    place.fails("mesh cube.poly --boundary remesh -o n.vtu", 2, &["closed surfaces"]);
    assert!(!place.path("n.vtu").exists());
}

/// A mesh of the plane.
#[test]
fn planar_domains_become_meshes() {
    let place = Place::new();
    place.file("map.poly", fs::read(root("domains/good/map.poly")).unwrap());
    place.good("mesh map.poly --size 0.5 -o m.1.ele -o m.off --json -");
    let text = fs::read_to_string(place.path("m.1.ele")).unwrap();
    let regions: BTreeSet<&str> = text.lines().skip(1).filter_map(|l| l.rsplit(' ').next()).collect();
    assert_eq!(regions.len(), 4);
    assert!(place.path("m.1.edge").is_file() && !place.path("m.1.face").is_file());
    let rows = text.split_whitespace().next().unwrap().to_owned();
    let off = fs::read_to_string(place.path("m.off")).unwrap();
    assert_eq!(off.split_whitespace().nth(2).unwrap(), rows);
}
