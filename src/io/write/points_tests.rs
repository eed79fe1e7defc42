use std::fs;

use glam::{DVec2, DVec3};

use super::*;

fn plane() -> Points {
    Points::Plane(vec![DVec2::new(0.1, -0.0), DVec2::new(1e-120, 3.0)])
}

fn space() -> Points {
    Points::Space(vec![DVec3::new(0.1, -2.5e300, 7.0), DVec3::new(1e-5, 0.0, 1.0)])
}

fn stream(format: Format, points: &Points) -> Vec<u8> {
    let mut bytes = Vec::new();
    let options = WriteOptions { first_id: 1, ..WriteOptions::default() };
    write_points_to(&mut bytes, format, points, &options, &mut |_, _| {}).unwrap();
    bytes
}

fn text(format: Format, points: &Points) -> String {
    String::from_utf8(stream(format, points)).unwrap()
}

#[test]
fn text_formats_are_plain() {
    assert_eq!(text(Format::Xyz, &plane()), "0.1 -0\n1e-120 3\n");
    assert_eq!(text(Format::Xyz, &space()), "0.1 -2.5e300 7\n1e-5 0 1\n");
    assert_eq!(text(Format::Csv, &space()), "0.1,-2.5e300,7\n1e-5,0,1\n");
    assert_eq!(text(Format::Obj, &plane()), "v 0.1 -0 0\nv 1e-120 3 0\n");
    assert_eq!(text(Format::Node, &plane()), "2 2 0 0\n1 0.1 -0\n2 1e-120 3\n");
    assert_eq!(text(Format::Off, &plane()), "OFF\n2 0 0\n0.1 -0 0\n1e-120 3 0\n");
}

#[test]
fn ply_is_binary_doubles() {
    let bytes = stream(Format::Ply, &plane());
    let head = b"end_header\n";
    let start = bytes.windows(head.len()).position(|w| w == head).unwrap() + head.len();
    assert!(bytes.starts_with(b"ply\nformat binary_little_endian 1.0\nelement vertex 2\n"));
    let values = [0.1, -0.0, 0.0, 1e-120, 3.0, 0.0];
    let expected: Vec<u8> = values.iter().flat_map(|c: &f64| c.to_le_bytes()).collect();
    assert_eq!(&bytes[start..], expected);
}

#[test]
fn vtu_points_are_vertices() {
    let bytes = stream(Format::Vtu, &space());
    let head = String::from_utf8_lossy(&bytes);
    assert!(head.contains("NumberOfPoints=\"2\" NumberOfCells=\"2\""));
    assert!(!head.contains("radius_edge_ratio"));
    let types = b"\x02\0\0\0\0\0\0\0\x01\x01\n  </AppendedData>\n</VTKFile>\n";
    assert!(bytes.ends_with(types));
}

#[test]
fn files_equal_streams_and_empty_sets_are_written() {
    let directory = tempfile::tempdir().unwrap();
    let options = WriteOptions { first_id: 1, ..WriteOptions::default() };
    let names = ["p.node", "p.xyz", "p.txt", "p.csv", "p.npy", "p.off", "p.ply", "p.vtu", "p.vtk", "p.obj"];
    for points in [plane(), space(), Points::Plane(vec![]), Points::Space(vec![])] {
        for name in names {
            let path = directory.path().join(name);
            let format = check_points_output(&path, &options).unwrap();
            let mut last = (1, 0);
            let mut report = |done, total| last = (done, total);
            let files = write_points(&path, &points, &options, &mut report).unwrap();
            assert_eq!(files, std::slice::from_ref(&path));
            assert_eq!(last.0, last.1);
            assert_eq!(fs::read(&path).unwrap(), stream(format, &points), "{name}");
        }
    }
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), names.len());
}

#[test]
fn the_path_for_standard_output_is_no_file() {
    assert_eq!(check_points_output(Path::new("-"), &WriteOptions::default()).unwrap(), Format::Xyz);
    let error = write_points(Path::new("-"), &plane(), &WriteOptions::default(), &mut |_, _| {});
    assert!(matches!(error, Err(OutputError::UnknownFormat { .. })));
}

/// A pipe without a reader.
struct Broken;

impl Write for Broken {
    fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
        Err(std::io::ErrorKind::BrokenPipe.into())
    }
    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_broken_stream_is_reported() {
    let options = WriteOptions::default();
    let format = Format::Xyz;
    let result = write_points_to(&mut Broken, format, &plane(), &options, &mut |_, _| {});
    let Err(OutputError::Stream { source }) = result else { panic!("{result:?}") };
    assert_eq!(source.kind(), std::io::ErrorKind::BrokenPipe);
}
