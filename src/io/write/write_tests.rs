use std::collections::HashMap;
use std::fs;

use super::samples::{Sample, kuhn, no_cells, squares};
use super::*;

const NAMES: [&str; 8] = [
    "m.vtu", "m.node", "m.msh", "m.msh22", "m.msh41", "m.mesh", "m.npy", "m.off",
];

/// Writes a mesh under a name in a fresh directory; returns all files found there.
fn written(name: &str, sample: &Sample, options: &WriteOptions) -> HashMap<String, Vec<u8>> {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join(name);
    check_output(&path).unwrap();
    let mut last = (0, 0);
    let files = write(&path, &sample.view(), options, &mut |done, total| {
        assert!(done >= last.0 && done <= total);
        last = (done, total);
    });
    assert_eq!(last.0, last.1);
    let listed = files.unwrap();
    let found: HashMap<String, Vec<u8>> = fs::read_dir(directory.path())
        .unwrap()
        .map(|entry| entry.unwrap())
        .map(|e| {
            (
                e.file_name().into_string().unwrap(),
                fs::read(e.path()).unwrap(),
            )
        })
        .collect();
    assert_eq!(found.len(), listed.len());
    assert!(
        listed
            .iter()
            .all(|f| found.contains_key(f.file_name().unwrap().to_str().unwrap()))
    );
    found
}

fn one(name: &str, sample: &Sample) -> Vec<u8> {
    written(name, sample, &WriteOptions::default())
        .remove(name)
        .unwrap()
}

fn text(bytes: &[u8]) -> Vec<&str> {
    std::str::from_utf8(bytes).unwrap().lines().collect()
}

fn numbers<T: std::str::FromStr>(line: &str) -> Vec<T>
where
    T::Err: std::fmt::Debug,
{
    line.split_whitespace()
        .map(|word| word.parse().unwrap())
        .collect()
}

/// A mesh whose coordinates are awkward to print.
fn awkward(mut sample: Sample) -> Sample {
    for (i, c) in sample.coordinates.iter_mut().enumerate() {
        *c = match (*c == 0.0, i % 3) {
            (true, 0) => -0.0,
            (true, 1) => 1e-120 * (i as f64 + 0.1),
            (true, _) => -5e-324,
            _ => *c / 3.0 + i as f64 * 1e-17,
        };
    }
    sample
}

fn same_bits(lines: &[&str], sample: &Sample, skip: usize) {
    let d = sample.dimension;
    assert_eq!(lines.len() * d, sample.coordinates.len());
    for (line, point) in lines.iter().zip(sample.coordinates.chunks_exact(d)) {
        let row: Vec<f64> = numbers::<f64>(line).split_off(skip);
        for (axis, c) in point.iter().enumerate() {
            assert_eq!(row[axis].to_bits(), c.to_bits(), "{line}");
        }
    }
}

fn same_cells(lines: &[&str], sample: &Sample, skip: usize, base: u64) {
    let corners = sample.dimension + 1;
    assert_eq!(lines.len() * corners, sample.cells.len());
    for (line, cell) in lines.iter().zip(sample.cells.chunks_exact(corners)) {
        let row: Vec<u64> = numbers(line);
        let row: Vec<u64> = row[skip..skip + corners].iter().map(|v| v - base).collect();
        assert_eq!(row, cell);
    }
}

#[test]
fn tetgen_files_hold_the_mesh() {
    for base in [0, 1] {
        for sample in [awkward(kuhn(2)), awkward(squares(3))] {
            let options = WriteOptions {
                first_id: base,
                ..WriteOptions::default()
            };
            let files = written("m.ele", &sample, &options);
            let d = sample.dimension;
            assert_eq!(files.len(), d + 2);
            let (n, m) = (sample.view().point_count(), sample.view().cell_count());
            let node = text(&files["m.node"]);
            assert_eq!(node[0], format!("{n} {d} 0 0"));
            same_bits(&node[1..], &sample, 1);
            let ele = text(&files["m.ele"]);
            assert_eq!(ele[0], format!("{m} {} 0", d + 1));
            same_cells(&ele[1..], &sample, 1, base);
            for name in ["m.node", "m.ele", "m.edge", "m.neigh"] {
                let lines = text(&files[name]);
                for (row, line) in lines[1..].iter().enumerate() {
                    assert_eq!(numbers::<f64>(line)[0], row as f64 + base as f64);
                }
            }
        }
    }
}

#[test]
fn tetgen_faces_edges_and_neighbours() {
    let sample = kuhn(2);
    let files = written("m.neigh", &sample, &WriteOptions::default());
    let face = text(&files["m.face"]);
    assert_eq!((face[0], face.len()), ("48 1", 49));
    assert!(face[1..].iter().all(|line| line.ends_with(" 1")));
    let edge = text(&files["m.edge"]);
    // 27 points, 48 cells, 96 + 24 facets: by Euler 27 - e + 120 - 48 = 1.
    assert_eq!((edge[0], edge.len()), ("98 1", 99));
    assert_eq!(
        edge[1..].iter().filter(|line| line.ends_with(" 1")).count(),
        72
    );
    let neigh = text(&files["m.neigh"]);
    assert_eq!((neigh[0], neigh.len()), ("48 4", 49));
    let cell = |row: i64| &sample.cells[row as usize * 4..][..4];
    for line in &neigh[1..] {
        let row: Vec<i64> = numbers(line);
        for (i, &other) in row[1..]
            .iter()
            .enumerate()
            .filter(|(_, other)| **other >= 0)
        {
            let shared = cell(row[0]).iter().filter(|v| cell(other).contains(v));
            assert_eq!(shared.count(), 3);
            assert!(!cell(other).contains(&cell(row[0])[i]));
        }
    }
    assert_eq!(neigh.join(" ").matches("-1").count(), 48);
}

#[test]
fn in_the_plane_there_is_no_face_file() {
    let files = written("m.face", &squares(2), &WriteOptions::default());
    let mut names: Vec<_> = files.keys().map(String::as_str).collect();
    names.sort_unstable();
    assert_eq!(names, ["m.edge", "m.ele", "m.neigh", "m.node"]);
    let edge = text(&files["m.edge"]);
    assert_eq!(edge[0], "16 1");
    assert_eq!(
        edge[1..].iter().filter(|line| line.ends_with(" 1")).count(),
        8
    );
}

/// The lines between a heading and its end.
fn section<'a>(lines: &[&'a str], name: &str) -> Vec<&'a str> {
    let start = lines.iter().position(|l| *l == format!("${name}")).unwrap();
    let end = lines
        .iter()
        .position(|l| *l == format!("$End{name}"))
        .unwrap();
    lines[start + 1..end].to_vec()
}

#[test]
fn msh_22_holds_the_mesh() {
    for (sample, kind) in [(awkward(kuhn(2)), "4"), (awkward(squares(3)), "2")] {
        let bytes = one("m.msh22", &sample);
        let lines = text(&bytes);
        assert_eq!(section(&lines, "MeshFormat"), ["2.2 0 8"]);
        let nodes = section(&lines, "Nodes");
        assert_eq!(nodes[0], sample.view().point_count().to_string());
        same_bits(&nodes[1..], &sample, 1);
        let elements = section(&lines, "Elements");
        assert_eq!(elements[0], sample.view().cell_count().to_string());
        same_cells(&elements[1..], &sample, 5, 1);
        let words: Vec<&str> = elements[1].split(' ').collect();
        assert_eq!(words[..5], ["1", kind, "2", "1", "1"]);
    }
}

#[test]
fn msh_41_holds_the_mesh() {
    for (sample, kind) in [(awkward(kuhn(2)), 4), (awkward(squares(3)), 2)] {
        let bytes = one("m.msh", &sample);
        let (d, n, m) = (
            sample.dimension,
            sample.view().point_count(),
            sample.view().cell_count(),
        );
        let lines = text(&bytes);
        assert_eq!(section(&lines, "MeshFormat"), ["4.1 0 8"]);
        let entities = section(&lines, "Entities");
        assert_eq!(entities[0], if d == 3 { "0 0 0 1" } else { "0 0 1 0" });
        let entity: Vec<f64> = numbers(entities[1]);
        assert_eq!(entity.len(), 10);
        assert!(entity[1] <= entity[4] && entity[3] <= entity[6]);
        assert_eq!(entity[7..], [1.0, 1.0, 0.0]);
        let nodes = section(&lines, "Nodes");
        assert_eq!(nodes[0], format!("1 {n} 1 {n}"));
        assert_eq!(nodes[1], format!("{d} 1 0 {n}"));
        assert_eq!(nodes[2], "1");
        assert_eq!(nodes[n + 1], n.to_string());
        same_bits(&nodes[n + 2..], &sample, 0);
        let elements = section(&lines, "Elements");
        assert_eq!(elements[0], format!("1 {m} 1 {m}"));
        assert_eq!(elements[1], format!("{d} 1 {kind} {m}"));
        same_cells(&elements[2..], &sample, 1, 1);
    }
}

#[test]
fn the_msh_version_follows_option_and_name() {
    let sample = squares(1);
    let v22 = WriteOptions {
        msh: MshVersion::V22,
        ..WriteOptions::default()
    };
    let version = |name: &str, options: &WriteOptions| {
        let files = written(name, &sample, options);
        text(&files[name])[1][..3].to_owned()
    };
    assert_eq!(version("a.msh", &v22), "2.2");
    assert_eq!(version("a.msh41", &v22), "4.1");
    assert_eq!(version("a.msh2", &WriteOptions::default()), "2.2");
}

#[test]
fn medit_holds_the_mesh_and_its_hull() {
    for (sample, facet, cell, hull) in [
        (awkward(kuhn(2)), "Triangles", "Tetrahedra", 48),
        (awkward(squares(3)), "Edges", "Triangles", 12),
    ] {
        let bytes = one("m.mesh", &sample);
        let lines = text(&bytes);
        let n = sample.view().point_count();
        assert_eq!(lines[0], "MeshVersionFormatted 2");
        assert_eq!(lines[1], format!("Dimension {}", sample.dimension));
        assert_eq!(lines[2..4], ["Vertices", &n.to_string()]);
        same_bits(&lines[4..4 + n], &sample, 0);
        assert!(lines[4..4 + n].iter().all(|line| line.ends_with(" 0")));
        assert_eq!(lines[4 + n..6 + n], [facet, &hull.to_string()]);
        let rest = &lines[6 + n + hull..];
        assert_eq!(rest[0], cell);
        assert_eq!(*rest.last().unwrap(), "End");
        same_cells(&rest[2..rest.len() - 1], &sample, 0, 1);
    }
}

#[test]
fn npy_is_read_by_another_reader() {
    for (sample, shape) in [
        (kuhn(2), [48, 4]),
        (squares(3), [18, 3]),
        (no_cells(3, 2), [0, 4]),
    ] {
        let bytes = one("m.npy", &sample);
        let file = npyz::NpyFile::new(&bytes[..]).unwrap();
        assert_eq!(file.shape(), shape);
        assert_eq!(file.order(), npyz::Order::C);
        let cells: Vec<i64> = file.into_vec().unwrap();
        assert!(
            cells
                .iter()
                .map(|&c| c as u64)
                .eq(sample.cells.iter().copied())
        );
        let data = sample.cells.len() * 8;
        assert_eq!((bytes.len() - data) % 64, 0);
    }
}

#[test]
fn off_holds_the_hull_in_space() {
    let bytes = one("m.off", &kuhn(2));
    let lines = text(&bytes);
    // 26 of the 27 points: not the centre, index 13.
    assert_eq!(lines[..2], ["OFF", "26 48 0"]);
    assert_eq!(lines[2 + 12], "0 0.5 0.5");
    assert_eq!(lines[2 + 13], "1 0.5 0.5");
    let point = |i: u64| {
        let row: Vec<f64> = numbers(lines[2 + i as usize]);
        glam::DVec3::from_slice(&row)
    };
    let mut volume = 0.0;
    for line in &lines[28..] {
        let row: Vec<u64> = numbers(line);
        assert_eq!(row[0], 3);
        volume += point(row[1]).dot(point(row[2]).cross(point(row[3])));
    }
    assert!((volume / 6.0 - 1.0).abs() < 1e-12);
}

#[test]
fn off_holds_everything_in_the_plane() {
    let sample = awkward(squares(2));
    let bytes = one("m.off", &sample);
    let lines = text(&bytes);
    assert_eq!(lines[..2], ["OFF", "9 8 0"]);
    same_bits(&lines[2..11], &sample, 0);
    assert!(lines[2..11].iter().all(|line| line.ends_with(" 0")));
    same_cells(&lines[11..], &sample, 1, 0);
}

/// The head of a `.vtu` file, and the arrays as raw bytes by name.
fn vtu_arrays(bytes: &[u8]) -> (String, HashMap<String, Vec<u8>>) {
    let marker = b"encoding=\"raw\">\n   _";
    let start = bytes
        .windows(marker.len())
        .position(|w| w == marker)
        .unwrap()
        + marker.len();
    let head = String::from_utf8(bytes[..start].to_vec()).unwrap();
    let attribute = |line: &str, name: &str| {
        let value = line.split(&format!(" {name}=\"")).nth(1)?;
        value.split('"').next().map(str::to_owned)
    };
    let mut arrays = HashMap::new();
    let mut end = 0;
    for line in head.lines().filter(|line| line.contains("<DataArray")) {
        let offset: usize = attribute(line, "offset").unwrap().parse().unwrap();
        assert_eq!(offset, end);
        let at = start + offset;
        let size = u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
        end = offset + 8 + size;
        let name = attribute(line, "Name").unwrap();
        arrays.insert(name, bytes[at + 8..at + 8 + size].to_vec());
    }
    assert_eq!(&bytes[start + end..], b"\n  </AppendedData>\n</VTKFile>\n");
    (head, arrays)
}

fn words(bytes: &[u8]) -> Vec<u64> {
    bytes
        .chunks_exact(8)
        .map(|w| u64::from_le_bytes(w.try_into().unwrap()))
        .collect()
}

#[test]
fn vtu_holds_the_mesh() {
    for (sample, kind) in [(awkward(kuhn(2)), 10), (awkward(squares(3)), 5)] {
        let (head, arrays) = vtu_arrays(&one("m.vtu", &sample));
        let (d, n, m) = (
            sample.dimension,
            sample.view().point_count(),
            sample.view().cell_count(),
        );
        assert!(
            head.contains("version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"")
        );
        assert!(head.contains(&format!("NumberOfPoints=\"{n}\" NumberOfCells=\"{m}\"")));
        assert!(head.contains("PointData GlobalIds=\"GlobalPointIds\""));
        assert!(head.contains("CellData GlobalIds=\"GlobalCellIds\""));
        assert_eq!(words(&arrays["connectivity"]), sample.cells);
        let ends: Vec<u64> = (1..=m as u64).map(|i| i * (d as u64 + 1)).collect();
        assert_eq!(words(&arrays["offsets"]), ends);
        assert_eq!(arrays["types"], vec![kind; m]);
        assert_eq!(
            words(&arrays["GlobalPointIds"]),
            (0..n as u64).collect::<Vec<_>>()
        );
        assert_eq!(
            words(&arrays["GlobalCellIds"]),
            (0..m as u64).collect::<Vec<_>>()
        );
        assert_eq!(arrays["radius_edge_ratio"].len(), 8 * m);
        for (row, point) in words(&arrays["Points"])
            .chunks(3)
            .zip(sample.coordinates.chunks(d))
        {
            let mut expected = point.iter().map(|c| c.to_bits()).collect::<Vec<_>>();
            expected.resize(3, 0);
            assert_eq!(row, expected);
        }
        assert!(!arrays.contains_key("owner") && !arrays.contains_key("home_leaf"));
    }
}

#[test]
fn vtu_holds_owners_where_asked_for() {
    let sample = kuhn(1);
    let options = WriteOptions {
        with_owner: true,
        ..WriteOptions::default()
    };
    let (_, arrays) = vtu_arrays(&written("m.vtu", &sample, &options)["m.vtu"]);
    let owner: Vec<u8> = sample.owner.iter().flat_map(|o| o.to_le_bytes()).collect();
    assert_eq!(arrays["owner"], owner);
    assert_eq!(words(&arrays["home_leaf"]), sample.home_leaf);
    let ratios = words(&arrays["radius_edge_ratio"]);
    // A Kuhn tetrahedron has the diagonal of the cube as diameter of its sphere.
    let expected = 0.75f64.sqrt();
    assert!(
        ratios
            .iter()
            .all(|r| (f64::from_bits(*r) - expected).abs() < 1e-15)
    );
}

#[test]
fn meshes_without_cells_are_written_in_every_format() {
    for name in NAMES {
        for (dimension, points) in [(2, 0), (2, 3), (3, 0), (3, 4)] {
            let sample = no_cells(dimension, points);
            let files = written(name, &sample, &WriteOptions::default());
            assert!(files.values().all(|bytes| !bytes.is_empty()));
        }
    }
    let bytes = one("m.msh", &no_cells(3, 0));
    let lines = text(&bytes);
    assert_eq!(section(&lines, "Nodes"), ["0 0 0 0"]);
    assert_eq!(section(&lines, "Elements"), ["0 0 0 0"]);
    let (_, arrays) = vtu_arrays(&one("m.vtu", &no_cells(2, 3)));
    assert_eq!((arrays["Points"].len(), arrays["types"].len()), (72, 0));
}

#[test]
fn bytes_do_not_depend_on_the_number_of_threads() {
    let sample = awkward(kuhn(12));
    let options = WriteOptions {
        with_owner: true,
        ..WriteOptions::default()
    };
    let with_threads = |threads: usize, name: &str| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| written(name, &sample, &options))
    };
    for name in NAMES {
        let single = with_threads(1, name);
        assert!(single == with_threads(5, name), "{name}");
        assert!(single == with_threads(1, name), "{name}");
    }
}

#[test]
fn failures_leave_the_old_files_alone() {
    let directory = tempfile::tempdir().unwrap();
    let mut sample = squares(1);
    // The same triangle twice: no neighbours can be given.
    sample.cells = vec![0, 1, 3, 0, 1, 3];
    for name in ["m.node", "m.mesh"] {
        fs::write(directory.path().join(name), "old").unwrap();
        let path = directory.path().join(name);
        let error = write(
            &path,
            &sample.view(),
            &WriteOptions::default(),
            &mut |_, _| {},
        );
        let error = error.unwrap_err();
        assert!(matches!(error, OutputError::Topology { .. }), "{error}");
        assert!(error.to_string().contains("[0, 1]"), "{error}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
    }
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 2);
}

#[test]
fn inconsistent_meshes_are_refused_before_anything_is_written() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("m.vtu");
    let sample = squares(1);
    let good = sample.view();
    let bad = [
        MeshView {
            dimension: 4,
            ..good
        },
        MeshView {
            dimension: 0,
            ..good
        },
        MeshView {
            coordinates: &good.coordinates[1..],
            ..good
        },
        MeshView {
            coordinates: &good.coordinates[2..],
            ..good
        },
        MeshView {
            cells: &good.cells[1..],
            ..good
        },
        MeshView {
            owner: Some(&[1]),
            ..good
        },
        MeshView {
            home_leaf: Some(&[]),
            ..good
        },
    ];
    for mesh in bad {
        let error = write(&path, &mesh, &WriteOptions::default(), &mut |_, _| {}).unwrap_err();
        assert!(matches!(error, OutputError::InvalidMesh { .. }), "{error}");
    }
    let options = WriteOptions {
        first_id: 2,
        ..WriteOptions::default()
    };
    let error = write(&path, &good, &options, &mut |_, _| {}).unwrap_err();
    assert!(matches!(error, OutputError::FirstId { first_id: 2 }));
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
}

#[test]
fn check_output_looks_at_the_whole_set() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("m.ele");
    assert_eq!(check_output(&path).unwrap(), OutputFormat::TetGen);
    fs::create_dir(directory.path().join("m.neigh")).unwrap();
    let error = check_output(&path).unwrap_err();
    assert!(error.to_string().contains("m.neigh"), "{error}");
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1);
}
