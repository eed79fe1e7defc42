//! Outside checkers that share no code with septet: Qhull (scipy), exact integers in Python, CGAL.
//!
//! `SEPTET_PYTHON` names an interpreter with numpy and scipy; CGAL's driver is compiled by `c++` against
//! CGAL's headers. `tests/run` installs both, and runs these tests, which a plain `cargo test` ignores.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, PoisonError};

use crate::common::sets::{plane, space};
use crate::common::{base, check, coordinates};
use glam::{DVec2, DVec3};
use septet_core::generate::Kind;
use septet_core::model::Points;
use septet_core::spec::Workers;
use septet_core::{Outcome, Spec};
use septet_geometry::point::Point;

/// A checker's file.
pub fn source(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/oracle").join(name)
}

/// The interpreter.
pub fn python() -> OsString {
    std::env::var_os("SEPTET_PYTHON")
        .expect("SEPTET_PYTHON must name a Python interpreter with numpy and scipy: tests/run makes one")
}

/// A driver of CGAL, compiled once.
pub fn cgal(name: &str) -> PathBuf {
    static COMPILER: Mutex<()> = Mutex::new(());
    let _one_at_a_time = COMPILER.lock().unwrap_or_else(PoisonError::into_inner);
    let text = fs::read(source(&format!("{name}.cpp"))).unwrap();
    let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join("oracle");
    fs::create_dir_all(&place).unwrap();
    let (program, of) = (place.join(name), place.join(format!("{name}.cpp")));
    if program.is_file() && fs::read(&of).is_ok_and(|old| old == text) {
        return program;
    }
    let mut compiler = Command::new("c++");
    compiler.args(["-std=c++17", "-O2", "-DNDEBUG", "-frounding-math", "-o"]).arg(&program);
    compiler.arg(source(&format!("{name}.cpp"))).args(["-lmpfr", "-lgmp"]);
    let output = compiler.output().unwrap_or_else(|e| panic!("{compiler:?}: {e}"));
    let complaint: String = String::from_utf8_lossy(&output.stderr).chars().take(2000).collect();
    assert!(output.status.success(), "{name} does not compile (libcgal-dev): {complaint}");
    fs::write(of, text).unwrap();
    program
}

/// Runs a checker on points and cells; it says what it found.
pub fn run_checker<P: Point>(mut command: Command, points: &[P], run: &Outcome, general: bool, what: &str) {
    let directory = tempfile::tempdir().unwrap();
    let file = |name: &str| directory.path().join(name);
    let bytes: Vec<u8> = coordinates(points).iter().flat_map(|c| c.to_le_bytes()).collect();
    fs::write(file("points"), bytes).unwrap();
    let bytes: Vec<u8> = run.cells().iter().flat_map(|c| c.to_le_bytes()).collect();
    fs::write(file("cells"), bytes).unwrap();
    command.arg(P::DIM.to_string()).arg(file("points")).arg(file("cells"));
    if general {
        command.arg("general");
    }
    let output = command.output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    let said = String::from_utf8_lossy(&output.stdout);
    println!("{what}, {}D, {} points: {}", P::DIM, points.len(), said.trim());
    let complained = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.starts_with("ok "), "{what}: {said}{complained}");
}

fn five_workers() -> Spec {
    base().with(|c| {
        c.machine.workers = Workers::Count(5);
        c.tree.leaf = Some(300);
    })
}

fn by_script<P: Point>(script: &str, points: &[P], what: &str) {
    let mut command = Command::new(python());
    command.arg(source(script));
    run_checker(command, points, &check(points, &five_workers()), false, what);
}

fn by_cgal<P: Point>(points: &[P], general: bool, what: &str) {
    run_checker(Command::new(cgal("cgal_check")), points, &check(points, &five_workers()), general, what);
}

#[test]
#[ignore = "needs Python with numpy and scipy"]
fn cells_agree_with_qhull() {
    // Not the clusters: Qhull's rounding is coarser than the smallest of them.
    for kind in [Kind::Uniform, Kind::Poisson, Kind::Ball, Kind::Jittered] {
        by_script("scipy_check.py", &space(kind, 5000, 21), kind.name());
        by_script("scipy_check.py", &plane(kind, 10_000, 21), kind.name());
    }
}

#[test]
#[ignore = "needs Python with numpy and scipy"]
fn cells_agree_with_exact_integer_arithmetic() {
    for kind in [Kind::Uniform, Kind::Grid, Kind::Fcc, Kind::Sphere, Kind::Slab, Kind::GradedPoint] {
        by_script("exact_check.py", &space(kind, 700, 22), kind.name());
        by_script("exact_check.py", &plane(kind, 1500, 22), kind.name());
    }
    by_script("exact_check.py", &space(Kind::MomentCurve, 100, 0), "moment curve");
    let moved: Vec<DVec3> = space(Kind::Grid, 343, 0).iter().map(|p| *p * 0.1 + 1e6).collect();
    by_script("exact_check.py", &moved, "grid far away");
    let twice: Vec<DVec2> = (0..2).flat_map(|_| plane(Kind::Uniform, 300, 1)).collect();
    by_script("exact_check.py", &twice, "every point twice");
}

#[test]
#[ignore = "needs a C++ compiler and CGAL's headers"]
fn cgal_agrees_in_general_position() {
    use Kind::{Ball, Clusters, GradedPoint, Line, Poisson, Slab, Uniform};
    for kind in [Uniform, Poisson, Ball, Clusters, Slab, Line] {
        by_cgal(&space(kind, 10_000, 23), true, kind.name());
        by_cgal(&plane(kind, 10_000, 23), true, kind.name());
    }
    // These have edges and faces of the cube, with ties on them.
    for kind in [GradedPoint, Kind::WellSpaced] {
        by_cgal(&space(kind, 5000, 23), false, kind.name());
        by_cgal(&plane(kind, 10_000, 23), false, kind.name());
    }
}

#[test]
#[ignore = "needs a C++ compiler and CGAL's headers"]
fn cgal_agrees_where_points_tie() {
    by_cgal(&space(Kind::Grid, 8000, 0), false, "grid");
    by_cgal(&space(Kind::Fcc, 8000, 0), false, "fcc");
    by_cgal(&space(Kind::Sphere, 10_000, 24), false, "sphere");
    by_cgal(&plane(Kind::Grid, 10_000, 0), false, "grid");
    by_cgal(&plane(Kind::Sphere, 10_000, 24), false, "circle");
    by_cgal(&space(Kind::MomentCurve, 300, 0), false, "moment curve");
    let scaled: Vec<DVec3> = space(Kind::Uniform, 2000, 25).iter().map(|p| *p * 1e-40).collect();
    by_cgal(&scaled, true, "scaled by 1e-40");
}

#[test]
#[ignore = "needs a C++ compiler, CGAL's headers and the test data"]
fn cgal_agrees_on_real_data() {
    for (name, points) in crate::common::data::all() {
        match points {
            Points::Plane(points) => by_cgal(&points, false, &name),
            Points::Space(points) => by_cgal(&points, false, &name),
            Points::Higher(_) => unreachable!("the data are in the plane and in space"),
        }
    }
}
