//! `.pvtu` files and their pieces.

use std::collections::BTreeMap;
use std::path::Path;

use septet_common::sets::{plane, space};
use septet_core::Outcome;
use septet_core::generate::Kind;
use septet_core::model::Points;
use septet_core::spec::{Spec, Workers};

use super::binary::words;
use super::*;
use crate::read::{CellOptions, Column, InputError, ReadOptions, read, read_cells};

/// A run of three workers over some points.
struct Run {
    points: Points,
    outcome: Outcome,
}

impl Run {
    fn over(points: Points) -> Self {
        let spec = Spec::default().with(|spec| {
            spec.machine.workers = Workers::Count(3);
            spec.tree.leaf = Some(20);
            spec.keep.owner = true;
        });
        let outcome = match &points {
            Points::Plane(points) => septet_core::triangulate(points, &spec),
            Points::Space(points) => septet_core::triangulate(points, &spec),
            Points::Higher(_) => unreachable!("sets are plane or spatial"),
        };
        Run { outcome: outcome.unwrap(), points }
    }

    fn in_space(count: u64) -> Self {
        Run::over(Points::Space(space(Kind::Uniform, count, 3)))
    }

    fn view(&self) -> MeshView<'_> {
        self.outcome.view(self.points.coordinates())
    }
}

/// The files below a directory, by their paths in it.
fn files(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if path.is_dir() {
            found.extend(files(&path).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else {
            found.insert(name, fs::read(path).unwrap());
        }
    }
    found
}

/// Writes `m.pvtu` in a directory.
fn write_to_directory(
    directory: &Path,
    run: &Run,
    options: &WriteOptions<'_>,
) -> Result<Vec<PathBuf>, OutputError> {
    write(&directory.join("m.pvtu"), &run.view(), options, &mut |_, _| {})
}

const NAMES: [&str; 4] = ["m.pieces/0000.vtu", "m.pieces/0001.vtu", "m.pieces/0002.vtu", "m.pvtu"];

#[test]
fn every_worker_has_a_piece() {
    for run in [Run::in_space(300), Run::over(Points::Plane(plane(Kind::Clusters, 300, 3)))] {
        let directory = tempfile::tempdir().unwrap();
        let values: Vec<f64> = (0..run.view().point_count()).map(|i| i as f64 / 4.0).collect();
        let columns = [Column { name: "a<b".to_owned(), values }];
        let options = WriteOptions { with_owner: true, point_data: &columns, ..WriteOptions::default() };
        let written = write_to_directory(directory.path(), &run, &options).unwrap();
        assert_eq!(written, ["m.pvtu", "m.pieces"].map(|name| directory.path().join(name)));
        let files = files(directory.path());
        assert_eq!(files.keys().collect::<Vec<_>>(), NAMES.iter().collect::<Vec<_>>());
        let list = std::str::from_utf8(&files["m.pvtu"]).unwrap();
        let declared: Vec<&str> =
            list.lines().filter_map(|l| l.trim().strip_prefix("<PDataArray ")).collect();
        let (mut cells, mut points) = (0, 0);
        for piece in &NAMES[..3] {
            assert!(list.contains(&format!("<Piece Source=\"{piece}\"/>")), "{list}");
            let (head, arrays) = vtu_arrays(&files[*piece]);
            // The list declares the arrays of every piece.
            let in_piece = head.lines().filter_map(|l| l.trim().strip_prefix("<DataArray "));
            let of_cells = ["connectivity", "offsets", "types"].map(|name| format!("Name=\"{name}\""));
            let found: Vec<String> = in_piece
                .filter(|line| !of_cells.iter().any(|name| line.contains(name)))
                .map(|line| line.split(" format=").next().unwrap().to_owned() + "/>")
                .collect();
            assert_eq!(found, declared);
            assert!(found.iter().any(|line| line.contains("home_leaf")));
            let numbers = words(&arrays["a&lt;b"]);
            for (id, value) in words(&arrays["GlobalPointIds"]).iter().zip(numbers) {
                assert_eq!(f64::from_bits(value), *id as f64 / 4.0);
            }
            points += list_of(&head, "NumberOfPoints");
            cells += list_of(&head, "NumberOfCells");
        }
        assert!(points > run.view().point_count() && cells > run.view().cell_count());
        assert!(list.contains("PointData GlobalIds=\"GlobalPointIds\"") && list.contains("GhostLevel=\"1\""));
    }
}

/// The number in the head of a piece.
fn list_of(head: &str, name: &str) -> usize {
    let value = head.split(&format!("{name}=\"")).nth(1).unwrap();
    value.split('"').next().unwrap().parse().unwrap()
}

#[test]
fn points_and_cells_are_owned_once() {
    // The coordinates have the bits of the input.
    let at = |p: glam::DVec3| if p.x < 0.3 { p.with_x(-0.0) } else { p };
    let run = Run::over(Points::Space(space(Kind::Uniform, 300, 3).into_iter().map(at).collect()));
    let directory = tempfile::tempdir().unwrap();
    write_to_directory(directory.path(), &run, &WriteOptions::default()).unwrap();
    let mesh = run.view();
    let (mut points, mut cells) = (Vec::new(), Vec::new());
    let mut rows = Vec::new();
    for (name, bytes) in files(directory.path()).iter().filter(|(name, _)| name.starts_with("m.pieces/")) {
        let (_, arrays) = vtu_arrays(bytes);
        let types = arrays["vtkGhostType"].clone();
        let ids = words(&arrays["GlobalPointIds"]);
        for (at, id) in ids.iter().enumerate() {
            let bits: Vec<u64> = words(&arrays["Points"])[3 * at..3 * at + 3].to_vec();
            let expected = &mesh.coordinates[3 * *id as usize..][..3];
            assert_eq!(bits, expected.iter().map(|c| c.to_bits()).collect::<Vec<_>>(), "{name}");
        }
        // The arrays of points and of cells have the same name; cells come last.
        let of_cells = words(&arrays["GlobalCellIds"]);
        for ((id, row), kind) in of_cells.iter().zip(words(&arrays["connectivity"]).chunks(4)).zip(types) {
            if kind == 0 {
                cells.push(*id);
                rows.push(row.iter().map(|&v| ids[v as usize]).collect::<Vec<u64>>());
            }
        }
        points.extend(ids);
    }
    assert_eq!(cells, (0..mesh.cell_count() as u64).collect::<Vec<_>>());
    rows.sort();
    assert_eq!(rows.concat(), mesh.cells);
    points.sort_unstable();
    points.dedup();
    assert_eq!(points.len(), mesh.point_count());
}

#[test]
fn pieces_do_not_depend_on_the_number_of_threads() {
    let run = Run::in_space(2000);
    let with_threads = |threads: usize| {
        let directory = tempfile::tempdir().unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| write_to_directory(directory.path(), &run, &WriteOptions::default())).unwrap();
        files(directory.path())
    };
    assert!(with_threads(1) == with_threads(2) && with_threads(1) == with_threads(5));
}

#[test]
fn a_failure_leaves_the_former_files() {
    let run = Run::in_space(60);
    let options = WriteOptions::default();
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("m.pvtu");
    write_to_directory(directory.path(), &run, &options).unwrap();
    let before = files(directory.path());
    // A mesh without a run, points of another number, and a caller that panics between two pieces.
    let error = write(&path, &kuhn(1).view(), &options, &mut |_, _| {}).unwrap_err();
    assert!(matches!(error, OutputError::NoPieces { .. }), "{error}");
    let mesh = MeshView { coordinates: &[0.0; 30], cells: &[], owner: None, owning_leaf: None, ..run.view() };
    let error = write(&path, &mesh, &options, &mut |_, _| {}).unwrap_err();
    assert!(matches!(error, OutputError::InvalidMesh { .. }), "{error}");
    let stopped =
        std::panic::catch_unwind(|| write(&path, &run.view(), &options, &mut |done, _| assert!(done == 0)));
    assert!(stopped.is_err());
    assert!(files(directory.path()) == before);
    // A directory takes the name of the list after the check.
    fs::remove_file(&path).unwrap();
    let error = write(&path, &run.view(), &options, &mut |done, _| {
        if done > 0 && !path.exists() {
            fs::create_dir(&path).unwrap();
        }
    });
    assert!(matches!(error, Err(OutputError::IsDirectory { .. })), "{error:?}");
    fs::remove_dir(&path).unwrap();
    assert!(files(directory.path()).keys().eq(&NAMES[..3]));
}

#[test]
fn obstacles_are_found_before_any_work() {
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    let options = WriteOptions { format: Some(Format::Pvtu), ..WriteOptions::default() };
    let check = |path: &Path| check_output(path, &options);
    assert_eq!(check(&at("m.pvtu")).unwrap(), Format::Pvtu);
    assert!(matches!(check(&at("m.pvtu.gz")), Err(OutputError::Compressed { .. })));
    assert!(matches!(check(&at("m\n.pvtu")), Err(OutputError::NotText { .. })));
    assert!(matches!(check(&at("none/m.pvtu")), Err(OutputError::MissingDirectory { .. })));
    fs::create_dir(at("d.pvtu")).unwrap();
    assert!(matches!(check(&at("d.pvtu")), Err(OutputError::IsDirectory { .. })));
    fs::write(at("f.pieces"), "").unwrap();
    assert!(matches!(check(&at("f.pvtu")), Err(OutputError::Obstructed { .. })));
    fs::create_dir(at("m.pieces")).unwrap();
    fs::write(at("m.pieces/0000.vtu"), "").unwrap();
    check(&at("m.pvtu")).unwrap();
    fs::write(at("m.pieces/notes.txt"), "").unwrap();
    let error = check(&at("m.pvtu")).unwrap_err();
    assert!(error.to_string().contains("notes.txt"), "{error}");
    let mut permissions = fs::metadata(at("m.pieces")).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(at("m.pieces"), permissions).unwrap();
    assert!(matches!(check(&at("m.pvtu")), Err(OutputError::NotWritable { .. })));
    let mut bytes = Vec::new();
    let error = write_to(&mut bytes, &kuhn(1).view(), &options, &mut |_, _| {}).unwrap_err();
    assert!(matches!(error, OutputError::NotOneFile) && bytes.is_empty());
    #[cfg(unix)]
    assert!(matches!(check(Path::new("/dev/null")), Err(OutputError::NotOneFile)));
}

#[test]
fn the_cells_of_a_list_of_pieces_are_read() {
    let directory = tempfile::tempdir().unwrap();
    let run = Run::in_space(60);
    write_to_directory(directory.path(), &run, &WriteOptions::default()).unwrap();
    let read_cells = |point_count: u64| {
        let options = CellOptions { point_count: Some(point_count), ..CellOptions::default() };
        read_cells(&directory.path().join("m.pvtu"), &options, &mut |_, _| {})
    };
    let cells = read_cells(60).unwrap();
    assert_eq!(cells.dimension, 3);
    let mut rows = cells.cells.as_chunks::<4>().0.to_vec();
    rows.sort_unstable();
    assert_eq!(rows.concat(), run.view().cells);
    assert!(matches!(read_cells(59), Err(InputError::OutOfRangeIndex { .. })));
    let read = |name: &str| read(&directory.path().join(name), &ReadOptions::default(), &mut |_, _| {});
    let error = read("m.pvtu").unwrap_err();
    assert!(matches!(error, InputError::Unsupported { .. }), "{error}");
    assert!(error.remedy().unwrap().to_string().contains("lists its pieces"), "{error}");
    assert!(read("m.pieces/0000.vtu").unwrap().points.len() > 20);
    fs::remove_file(directory.path().join("m.pieces/0001.vtu")).unwrap();
    assert!(read_cells(60).unwrap_err().to_string().contains("0001.vtu"));
}
