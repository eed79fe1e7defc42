//! The page of `septet report`: what it holds, and how it behaves in a browser.
//!
//! Most of these need Node.js, the packages of `tests/page/package-lock.json` (`npm ci` there) and Chromium
//! (`SEPTET_CHROMIUM`, else /usr/bin/chromium): `tests/run` installs them and runs the tests.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs septet in a directory.
fn septet(directory: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_septet"));
    command.current_dir(directory).arg("-q").args(line.split_whitespace()).output().unwrap()
}

fn good(directory: &Path, line: &str) {
    let output = septet(directory, line);
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Reports of a set in space, one in the plane, one with repaired stars, and two more sizes as a sweep.
fn reports(directory: &Path) {
    good(directory, "simulate sample:well-spaced:9000 --workers 9 --leaf 900 --json space.json");
    good(directory, "simulate sample:graded:5000,d=2 --workers 6 --json plane.json");
    good(directory, "simulate sample:uniform:3000 --workers leaves --leaf 600 --json repaired.json");
    let mut sweep = String::new();
    for n in [2000, 4000] {
        good(directory, &format!("simulate sample:well-spaced:{n} --workers 9 --view 0 --json one.json"));
        let run: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(directory.join("one.json")).unwrap()).unwrap();
        let line = serde_json::json!({
            "n": run["points"]["used"], "kind": "well-spaced", "d": 3, "workers": 9, "seed": run["seed"],
            "phases": run["phases"], "levels": run["tree"]["levels"],
        });
        sweep.push_str(&line.to_string());
        sweep.push('\n');
    }
    fs::write(directory.join("runs.jsonl"), sweep).unwrap();
}

/// Reports of a mesh in space, whose cells have workers, and of one in the plane, which was refined. Both have several regions.
fn meshes(directory: &Path) {
    let domain = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/domains/good").join(name);
    for (name, options, json) in [
        ("two-regions.poly", "--size 0.36 --conforming --no-improve --workers 5", "space-mesh.json"),
        ("map.poly", "--size 0.3 --workers 4", "plane-mesh.json"),
    ] {
        good(directory, &format!("mesh {} {options} --json {json}", domain(name).display()));
    }
}

#[test]
#[ignore = "needs Node.js and Chromium"]
fn pages_of_meshes_show_what_their_reports_say() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    meshes(place.path());
    good(place.path(), "simulate sample:uniform:3000 --workers leaves --leaf 600 --json run.json");
    good(place.path(), "report space-mesh.json -o space-mesh.html --svg figures");
    good(place.path(), "report plane-mesh.json -o plane-mesh.html");
    good(place.path(), "report run.json space-mesh.json plane-mesh.json -o both.html");
    for name in ["space-mesh.html", "plane-mesh.html", "both.html"] {
        let html = fs::read_to_string(at(name)).unwrap();
        alone(name, &html);
        for id in ["mesh-summary", "mesh", "mesh-quality", "mesh-stages", "mesh-phases"] {
            assert!(html.contains(&format!("<section id=\"{id}\"")), "{name}: {id}");
        }
        assert_eq!(html.contains("<section id=\"partition\""), name == "both.html");
    }
    assert!(fs::read_to_string(at("both.html")).unwrap().contains("plane-mesh.json"));
    let figures: Vec<String> =
        fs::read_dir(at("figures")).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    for name in ["mesh-quality-radius-edge-ratios.svg", "mesh-stages-rounds.svg", "mesh-phases-bytes.svg"] {
        assert!(figures.iter().any(|f| f == name), "no {name} in {figures:?}");
    }
    let pages = [
        ("space-mesh.html", Some("space-mesh.json")),
        ("plane-mesh.html", Some("plane-mesh.json")),
        ("both.html", Some("space-mesh.json")),
    ];
    browse(place.path(), &pages);
}

#[test]
#[ignore = "needs Node.js and Chromium"]
fn reports_of_meshes_without_a_picture_say_so() {
    let place = tempfile::tempdir().unwrap();
    let cube = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/domains/good/cube.poly");
    good(place.path(), &format!("mesh {} --size 2 --json none.json --view 0", cube.display()));
    good(place.path(), "report none.json -o none.html");
    let html = fs::read_to_string(place.path().join("none.html")).unwrap();
    assert!(html.contains("has no picture of the mesh") && html.contains("--view N"));
    assert!(!html.contains("<section id=\"mesh\"") && html.contains("<section id=\"mesh-quality\""));
    browse(place.path(), &[("none.html", None)]);
}

#[test]
fn reports_of_meshes_are_refused_by_field() {
    let place = tempfile::tempdir().unwrap();
    let cube = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/domains/good/cube.poly");
    good(
        place.path(),
        &format!("mesh {} --size 2 --conforming --no-improve --json mesh.json", cube.display()),
    );
    let whole: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(place.path().join("mesh.json")).unwrap()).unwrap();
    good(place.path(), "report mesh.json -o mesh.html");
    let refused = |spoil: &dyn Fn(&mut serde_json::Value), words: &[&str]| {
        let mut value = whole.clone();
        spoil(&mut value);
        fs::write(place.path().join("bad.json"), value.to_string()).unwrap();
        let output = septet(place.path(), "report bad.json -o x.html");
        let printed = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(3), "{printed}");
        for word in words.iter().chain(&["bad.json, line 1"]) {
            assert!(printed.contains(word), "no `{word}` in: {printed}");
        }
        assert!(!place.path().join("x.html").exists());
    };
    let remove = |pointer: &'static str, key: &'static str| {
        move |v: &mut serde_json::Value| {
            v.pointer_mut(pointer).unwrap().as_object_mut().unwrap().remove(key);
        }
    };
    let set = |pointer: &'static str, to: serde_json::Value| {
        move |v: &mut serde_json::Value| *v.pointer_mut(pointer).unwrap() = to.clone()
    };
    let pop = |pointer: &'static str| {
        move |v: &mut serde_json::Value| {
            v.pointer_mut(pointer).unwrap().as_array_mut().unwrap().pop();
        }
    };
    refused(&remove("/quality", "angles"), &["`quality`", "missing field `angles`"]);
    refused(&remove("", "conformity"), &["missing field `conformity`"]);
    refused(&set("/stages/0/rounds", "many".into()), &["`stages[0].rounds`", "\"many\""]);
    refused(&set("/quality/radius_edge/counts/3", (-1).into()), &["`quality.radius_edge.counts[3]`", "-1"]);
    refused(&set("/quality/angles/counts", serde_json::json!([])), &["`quality.angles.counts`", "no bins"]);
    refused(&set("/quality/angles/to", (-5).into()), &["`quality.angles`", "-5"]);
    refused(&set("/domain/dimension", 4.into()), &["`domain.dimension`", "expected 2 or 3"]);
    refused(&set("/view/corners/5", 99_999.into()), &["`view.corners[5]`", "99999"]);
    refused(&set("/view/corners/6", 0.5.into()), &["`view.corners[6]`", "0.5"]);
    refused(&set("/view/region/0", 7.into()), &["`view.region[0]`", "1 regions"]);
    refused(&set("/view/cells", 1.into()), &["`view.cells`", "expected"]);
    for list in ["/view/positions", "/view/corners", "/view/size", "/view/owner", "/view/low"] {
        let field = format!("`{}`", list[1..].replace('/', "."));
        refused(&pop(list), &[&field, "entries, expected"]);
    }
    refused(&set("/schema", "septet-mesh/9".into()), &["not a septet report", "septet-mesh/2"]);
}

#[test]
#[ignore = "needs Node.js and Chromium"]
fn pages_stand_alone_and_figures_are_files() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    reports(place.path());
    good(place.path(), "report space.json runs.jsonl -o space.html --svg figures");
    good(place.path(), "report plane.json -o plane.html");
    good(place.path(), "report repaired.json -o repaired.html");
    for name in ["space.html", "plane.html", "repaired.html"] {
        let html = fs::read_to_string(at(name)).unwrap();
        alone(name, &html);
        for id in ["proofs", "partition", "timeline", "traffic", "phases", "levels", "separators"] {
            assert!(html.contains(&format!("<section id=\"{id}\"")), "{name}: {id}");
        }
    }
    let html = fs::read_to_string(at("space.html")).unwrap();
    assert!(html.contains("fitted exponent") && html.contains("<section id=\"law-depth\""));
    let figures: Vec<PathBuf> = fs::read_dir(at("figures")).unwrap().map(|e| e.unwrap().path()).collect();
    assert!(figures.len() > 20);
    for figure in &figures {
        let svg = fs::read_to_string(figure).unwrap();
        assert!(svg.starts_with("<?xml") && svg.ends_with("</svg>\n"), "{}", figure.display());
        let names = figure.file_name().unwrap().to_str().unwrap();
        assert!(figure.extension().is_some_and(|e| e == "svg") && !names.contains(' '), "{names}");
    }
    browse(place.path(), &[("space.html", None), ("plane.html", None), ("repaired.html", None)]);
}

#[test]
#[ignore = "needs Node.js and Chromium"]
fn pages_of_triangulations_begin_with_the_data() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    good(place.path(), "generate uniform -n 4000 -d 2 -o a-long-name-of-a-file-with-points-of-the-plane.csv");
    good(place.path(), "triangulate sample:uniform:9000 --workers 8 --stats --json space.json");
    good(
        place.path(),
        "triangulate a-long-name-of-a-file-with-points-of-the-plane.csv --workers 6 --stats --json plane.json",
    );
    for name in ["space", "plane"] {
        good(place.path(), &format!("report {name}.json -o {name}.html"));
        let html = fs::read_to_string(at(&format!("{name}.html"))).unwrap();
        alone(name, &html);
        assert!(html.contains("The command that repeats the run"));
    }
    browse(place.path(), &[("space.html", None), ("plane.html", None)]);
}

/// A page that is not too large and refers to nothing.
fn alone(name: &str, html: &str) {
    assert!(html.len() < 4 << 20, "{name}: {} bytes", html.len());
    for reference in ["src=\"", "url(http", "@import", "href=\"http", "href=\"//"] {
        assert!(!html.contains(reference), "{name} refers to something: {reference}");
    }
}

/// Every page through `tests/page/check.mjs`, with the report of the mesh it shows.
fn browse(directory: &Path, pages: &[(&str, Option<&str>)]) {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/page");
    let chromium = std::env::var_os("SEPTET_CHROMIUM").unwrap_or_else(|| "/usr/bin/chromium".into());
    let ready = tests.join("node_modules/playwright-core").is_dir() && Path::new(&chromium).exists();
    assert!(ready, "there is no Chromium, or `npm ci` was not run in tests/page: tests/run does both");
    let shots = directory.join("shots");
    fs::create_dir(&shots).unwrap();
    for (page, report) in pages {
        let mut check = Command::new("node");
        check.arg(tests.join("check.mjs")).arg(directory.join(page)).arg(&shots);
        let output = check.args(report.map(|r| directory.join(r))).output();
        let output = output.unwrap_or_else(|e| panic!("cannot run node: {e}"));
        let printed = String::from_utf8_lossy(&output.stdout);
        let complained = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{page}: {printed}\n{complained}");
        assert!(
            printed.lines().last().unwrap_or_default().ends_with(" passed, 0 failed"),
            "{page}: {printed}"
        );
    }
}

#[test]
#[ignore = "needs Node.js"]
fn scripts_are_modules_that_parse() {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/cli/page/assets");
    let place = tempfile::tempdir().unwrap();
    let copy = place.path().join("module.mjs");
    let mut seen = 0;
    for entry in fs::read_dir(assets).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "js") {
            fs::copy(&path, &copy).unwrap();
            let output = Command::new("node").arg("--check").arg(&copy).output().unwrap();
            assert!(
                output.status.success(),
                "{}: {}",
                path.display(),
                String::from_utf8_lossy(&output.stderr)
            );
            seen += 1;
        }
    }
    assert!(seen >= 12);
}

#[test]
fn files_that_are_not_reports_are_refused_by_name() {
    let place = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(place.path().join(name), text).unwrap();
    write("torn.json", "{\"schema\": \"septet-run/2\", ");
    write("other.json", "{\"schema\": \"else/1\"}");
    write("sweep.jsonl", "{\"n\": 5, \"phases\": []}\n{\"n\": \n");
    write("script.jsonl", "{\"n\": 5, \"kind\": \"</script><b>\", \"phases\": []}\n");
    let refused = |line: &str, word: &str| {
        let output = septet(place.path(), line);
        let printed = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(3), "{line}: {printed}");
        assert!(printed.contains(word), "{line}: {printed}");
        assert!(!place.path().join("x.html").exists());
    };
    refused("report torn.json -o x.html", "torn.json, line 1: not JSON");
    refused("report other.json -o x.html", "not a septet report");
    refused("report sweep.jsonl -o x.html", "sweep.jsonl, line 2");
    refused("report absent.json -o x.html", "absent.json");
    good(place.path(), "report script.jsonl -o x.html");
    let html = fs::read_to_string(place.path().join("x.html")).unwrap();
    assert!(!html.contains("</script><b>"));
}
