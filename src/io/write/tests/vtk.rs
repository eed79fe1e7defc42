//! Legacy VTK files, data of points, compression and streams, through the readers.

use std::io::Read;

use super::*;
use crate::read::{CellOptions, Column, ReadOptions, read, read_cells};

fn columns(points: usize) -> Vec<Column> {
    let values = (0..points).map(|i| i as f64 / 4.0).collect();
    vec![Column { name: "mass <g> & \"more\"".to_owned(), values }]
}

fn unpacked(bytes: &[u8]) -> Vec<u8> {
    let mut whole = Vec::new();
    flate2::read::GzDecoder::new(bytes).read_to_end(&mut whole).unwrap();
    whole
}

#[test]
fn vtk_files_are_read_back() {
    for sample in [awkward(kuhn(2)), awkward(squares(3))] {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("m.vtk");
        let data = columns(sample.view().point_count());
        let options = WriteOptions { with_owner: true, point_data: &data, ..WriteOptions::default() };
        write(&path, &sample.view(), &options, &mut |_, _| {}).unwrap();
        let wanted = ReadOptions { dimension: Some(sample.dimension), ..ReadOptions::default() };
        let points = read(&path, &wanted, &mut |_, _| {}).unwrap().points;
        let positive: Vec<u64> = sample.coordinates.iter().map(|c| (c + 0.0).to_bits()).collect();
        assert_eq!(points.coordinates().iter().map(|c| c.to_bits()).collect::<Vec<_>>(), positive);
        let cells = read_cells(&path, &CellOptions::default(), &mut |_, _| {}).unwrap();
        assert_eq!((cells.dimension, cells.cells), (sample.dimension, sample.cells.clone()));
        let head = String::from_utf8_lossy(&fs::read(&path).unwrap()).into_owned();
        assert!(head.starts_with("# vtk DataFile Version 3.0\n"));
        assert!(head.contains("mass%20<g>%20&%20%22more%22 1 ") && head.contains("radius_edge_ratio 1 "));
    }
}

#[test]
fn data_of_points_are_arrays_of_a_vtu_file() {
    let sample = kuhn(1);
    let count = sample.view().point_count();
    let data = columns(count);
    let options = WriteOptions { point_data: &data, ..WriteOptions::default() };
    let bytes = written("m.vtu", &sample, &options).remove("m.vtu").unwrap();
    let (head, arrays) = vtu_arrays(&bytes);
    assert!(head.contains("Name=\"mass &lt;g&gt; &amp; &quot;more&quot;\""), "{head}");
    let expected: Vec<u8> = data[0].values.iter().flat_map(|v| v.to_le_bytes()).collect();
    assert!(arrays.values().any(|array| *array == expected));
    let short = columns(count - 1);
    let options = WriteOptions { point_data: &short, ..WriteOptions::default() };
    let path = tempfile::tempdir().unwrap().path().join("m.vtu");
    let error = write(&path, &sample.view(), &options, &mut |_, _| {}).unwrap_err();
    assert!(matches!(error, OutputError::InvalidMesh { .. }), "{error}");
}

#[test]
fn compressed_files_hold_the_same_bytes() {
    let sample = kuhn(2);
    for name in ["m.vtu", "m.vtk", "m.msh", "m.mesh", "m.npy", "m.off", "m.stl"] {
        assert_eq!(unpacked(&one(&format!("{name}.gz"), &sample)), one(name, &sample), "{name}");
    }
    let plain = written("m.1.ele", &sample, &WriteOptions::default());
    let zipped = written("m.1.ele.gz", &sample, &WriteOptions::default());
    assert_eq!(zipped.len(), plain.len());
    for (name, bytes) in plain {
        assert_eq!(unpacked(&zipped[&format!("{name}.gz")]), bytes, "{name}");
    }
}

#[test]
fn streams_receive_the_bytes_of_files() {
    let sample = kuhn(2);
    for name in ["vtu", "vtk", "msh", "mesh", "npy", "off", "stl"] {
        let options = WriteOptions { format: Some(name.parse().unwrap()), ..WriteOptions::default() };
        let mut bytes = Vec::new();
        write_to(&mut bytes, &sample.view(), &options, &mut |_, _| {}).unwrap();
        assert_eq!(bytes, one(&format!("m.{name}"), &sample), "{name}");
        // The format in the options overrides the extension.
        assert_eq!(written("m.unknown", &sample, &options)["m.unknown"], bytes, "{name}");
    }
    let set = WriteOptions { format: Some(Format::Node), ..WriteOptions::default() };
    for (options, expected) in [(set, "several files"), (WriteOptions::default(), "unknown output format")] {
        let error = write_to(&mut Vec::new(), &sample.view(), &options, &mut |_, _| {}).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
}
