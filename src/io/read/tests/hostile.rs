//! Truncated, flipped and random bytes, which must cause errors and never panics.

use std::fmt::Write as _;

use proptest::prelude::*;

use super::*;
use crate::format::Format;

/// The readers of all formats that are read by name, and of raw files.
fn all() -> Vec<ReadOptions> {
    let of = |format: &Format| ReadOptions { format: Some(*format), ..PLAIN };
    Format::ALL.iter().map(of).chain(["f64,3", "f32be,2"].map(raw)).collect()
}

fn raw(text: &str) -> ReadOptions {
    ReadOptions { raw: Some(text.parse().unwrap()), ..PLAIN }
}

fn of(format: Format) -> ReadOptions {
    ReadOptions { format: Some(format), ..PLAIN }
}

/// Reads the data in every way. Only a panic or a hang is a failure.
fn survive(reading: &ReadOptions, data: &[u8]) {
    for skip_invalid in [false, true] {
        for dimension in [None, Some(2), Some(3)] {
            let result = parse("a", data, &ReadOptions { dimension, skip_invalid, ..reading.clone() });
            if let Ok(file) = result {
                assert!(file.points.coordinates().iter().all(|c| c.is_finite()));
                assert_eq!(file.source_index.is_some(), file.skipped > 0);
                assert!(file.source_index.is_none_or(|kept| kept.len() == file.points.len()));
            }
        }
    }
    for base in [None, Some(0), Some(1)] {
        let options = CellOptions { format: reading.format, base, point_count: Some(4), dimension: None };
        if let Ok(file) = parse_cells("a", data, &options) {
            assert_eq!(file.cells.len() % (file.dimension + 1), 0);
        }
    }
}

/// Returns a valid file of each format.
fn samples() -> Vec<(ReadOptions, Vec<u8>)> {
    vec![
        (of(Format::Node), b"2 3 1 1\n1 0 0 0 5 1\n2 1 2 3 5 1\n".to_vec()),
        (of(Format::Xyz), b"x,y,z\n1,2,3\n4,5,6,7\n".to_vec()),
        (of(Format::Xyz), b"2\n\nO 0 0 0\nH 1.5 0 0\n".to_vec()),
        (of(Format::Npy), npy_f8()),
        (of(Format::Npy), npy("{'descr': '<i8', 'fortran_order': True, 'shape': (2, 3), }", &[0; 48])),
        (raw("f64,3"), bytes_of!(f64, to_le_bytes, [1, 2, 3, 4, 5, 6])),
        (raw("f32be,2"), bytes_of!(f32, to_be_bytes, [1, 2, 3, 4, 5, 6])),
        (of(Format::Off), b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n".to_vec()),
        (of(Format::Ply), ply_binary(false)),
        (of(Format::Ply), ply_binary(true)),
        (of(Format::Stl), stl_binary(b"solid")),
        (of(Format::Stl), STL_ASCII.into()),
        (of(Format::Obj), b"v 1 2 3\nv 4 5 6 1\nf 1 2\n".to_vec()),
        (of(Format::Vtu), vtu_raw(false)),
        (of(Format::Vtu), vtu_raw(true)),
        (of(Format::Vtu), vtu_inline("", "ascii", |_, text| text.to_owned()).into_bytes()),
        (of(Format::Vtk), vtk::ascii("POLYDATA", "POLYGONS 1 4\n3 0 1 2\n").into()),
        (of(Format::Vtk), vtk::binary()),
        (of(Format::Vtk), vtk::VERSION_5.into()),
        (of(Format::Msh), MSH2.into()),
        (of(Format::Msh), MSH41.into()),
        (of(Format::Medit), MEDIT.into()),
        (of(Format::Ele), b"2 4 1\n1 1 2 3 4 7\n2 1 2 3 4 7\n".to_vec()),
    ]
}

#[test]
fn every_truncation_is_survived() {
    for (format, data) in samples() {
        for cut in 0..data.len() {
            survive(&format, &data[..cut]);
        }
    }
}

/// In files that announce their size, every cut before the last byte of the last point is noticed.
#[test]
fn truncations_of_binary_files_are_noticed() {
    for (name, data, needed) in [
        ("a.npy", npy_f8(), npy_f8().len()),
        ("a.ply", ply_binary(false), ply_binary(false).len()),
        ("a.ply", ply_binary(true), ply_binary(true).len()),
        ("a.stl", stl_binary(b"x"), stl_binary(b"x").len()),
        ("a.vtu", vtu_raw(true), vtu_raw(true).len() - "\n</AppendedData>\n</VTKFile>\n".len()),
    ] {
        for cut in 0..needed {
            bad(name, &data[..cut]);
        }
        assert_eq!(good(name, &data[..needed]).points.len(), 4);
    }
}

#[test]
fn every_bit_flip_is_survived() {
    for (format, data) in samples() {
        for at in 0..data.len() {
            let mut flipped = data.clone();
            for value in [data[at] ^ 1, data[at] ^ 0x80, 0xff, b'9', b' '] {
                flipped[at] = value;
                survive(&format, &flipped);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes_are_survived(data in prop::collection::vec(any::<u8>(), 0..400)) {
        for format in all() {
            survive(&format, &data);
        }
        let _ = parse("-", &data, &PLAIN);
    }

    #[test]
    fn random_tails_are_survived(
        which in any::<prop::sample::Index>(),
        at in any::<prop::sample::Index>(),
        tail in prop::collection::vec(any::<u8>(), 0..60),
    ) {
        let samples = samples();
        let (format, data) = which.get(&samples);
        let mut data = data[..at.index(data.len())].to_vec();
        data.extend(tail);
        survive(format, &data);
    }

    #[test]
    fn random_words_are_survived(words in "([-0-9.eE,;# \n\r\t]|nan|OFF|vertex|solid|\\$Nodes|Vertices){0,120}") {
        for format in all() {
            survive(&format, words.as_bytes());
        }
    }

    #[test]
    fn written_numbers_are_read_back(points in prop::collection::vec(any::<[f64; 3]>(), 1..20)) {
        let finite: Vec<[f64; 3]> = points.into_iter().filter(|p| p.iter().all(|c| c.is_finite())).collect();
        let mut text = String::new();
        for [x, y, z] in &finite {
            let _ = writeln!(text, "{x:?} {y:e} {z}");
        }
        prop_assert_eq!(space(&good("a.xyz", text)), finite);
    }
}
