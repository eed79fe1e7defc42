//! Raw files.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use proptest::prelude::*;

use super::*;
use crate::read::{CoordinateType, Place, RawRows, read_from};

fn raw(text: &str) -> ReadOptions {
    ReadOptions { raw: Some(text.parse().unwrap()), ..PLAIN }
}

fn stream(data: &[u8], name: &str, options: &ReadOptions) -> Result<PointFile, InputError> {
    read_from(data, Path::new(name), None, options, &mut |_, _| ())
}

#[test]
fn raw_files_of_all_types() {
    let numbers = [1.5, -2.0, 0.25, -0.0, 4.0, 1e30];
    for (text, data, kind) in [
        ("f64", bytes_of!(f64, to_le_bytes, numbers), CoordinateType::Float64),
        ("f64be", bytes_of!(f64, to_be_bytes, numbers), CoordinateType::Float64),
        ("f32", bytes_of!(f32, to_le_bytes, numbers), CoordinateType::Float32),
        ("f32be", bytes_of!(f32, to_be_bytes, numbers), CoordinateType::Float32),
    ] {
        let large = if kind == CoordinateType::Float32 { f64::from(1e30_f32) } else { 1e30 };
        let file = good_with("a.raw", &data, &raw(&format!("{text},3")));
        assert_eq!(space(&file), [[1.5, -2.0, 0.25], [0.0, 4.0, large]], "{text}");
        assert_eq!((file.coordinate_type, file.notes.len()), (Some(kind), 0));
        let flat = good_with("a", &data, &raw(&format!("{text},2")));
        assert_eq!(plane(&flat), [[1.5, -2.0], [0.25, 0.0], [4.0, large]], "{text}");
        let kept = ReadOptions { dimension: Some(2), ..raw(&format!("{text},3")) };
        assert_eq!(plane(&good_with("-", &data, &kept)), [[1.5, -2.0], [0.0, 4.0]], "{text}");
        let more = ReadOptions { dimension: Some(3), ..raw(&format!("{text},2")) };
        assert!(matches!(bad_with("a.raw", &data, &more), InputError::MixedDimension { .. }), "{text}");
        assert_eq!(good_with("a.raw", [], &raw(&format!("{text},2"))).points, Points::Plane(Vec::new()));
    }
}

#[test]
fn a_part_of_a_row_is_refused() {
    for (text, row) in [("f64,3", 24), ("f64be,2", 16), ("f32,3", 12), ("f32,2", 8)] {
        for size in (1..3 * row).filter(|size| size % row != 0) {
            let error = bad_with("a.raw", vec![0; size], &raw(text));
            let is_named = matches!(error, InputError::PartOfRow { size: s, row: r, .. } if (s, r) == (size as u64, row as u64));
            assert!(is_named && error.exit_code() as u8 == 3, "{text} {size}: {error}");
        }
    }
    let message = bad_with("a.raw", vec![0; 100], &raw("f64,3")).to_string();
    assert!(["a.raw", "100 bytes", "24 bytes"].iter().all(|part| message.contains(part)), "{message}");
}

#[test]
fn names_and_contents_of_other_formats() {
    let corners = CORNERS.concat();
    let data = bytes_of!(f64, to_le_bytes, corners);
    for name in ["a.npy", "a.PLY.gz", "a.xyz", "a.ele"] {
        let error = stream(&data, name, &raw("f64,3")).unwrap_err();
        assert!(
            matches!(error, InputError::NotRaw { .. }) && error.exit_code() as u8 == 2,
            "{name}: {error}"
        );
    }
    for name in ["a.raw", "a.bin", "a.dat", "a", "-", "a.f64", "a.gz.raw"] {
        assert_eq!(space(&stream(&data, name, &raw("f64,3")).unwrap()), CORNERS, "{name}");
    }
    // The first coordinates look like headers of other formats.
    for head in [&b"\x1f\x8b\x08\0\0\0\0\0"[..], b"\x93NUMPY\x01\0", b"solid it", b"ply\n1234", b"#1 2 3\n4"]
    {
        let data = [head, &[0; 16]].concat();
        let file = stream(&data, "a.raw", &raw("f64,3")).unwrap();
        assert_eq!(file.points.coordinates()[0].to_bits().to_le_bytes(), head, "{head:?}");
    }
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(&data).unwrap();
    let packed = encoder.finish().unwrap();
    assert_eq!(space(&stream(&packed, "a.raw.gz", &raw("f64,3")).unwrap()), CORNERS);
    assert!(matches!(stream(&data, "a.raw.gz", &raw("f64,3")), Err(InputError::Gzip { .. })));
    let columns = ReadOptions { columns: Some(vec!["1".to_owned(), "2".to_owned()]), ..raw("f64,3") };
    assert!(matches!(bad_with("a.raw", &data, &columns), InputError::NotATable { format: "raw", .. }));
    bad_cells("a.raw", &data);
}

/// Any bits of coordinates, of which few are infinite or not a number.
fn bits() -> impl Strategy<Value = u64> {
    prop_oneof![12 => any::<f64>().prop_map(f64::to_bits), 1 => any::<u64>()]
}

proptest! {
    /// A raw file has the points, the dropped rows and the invalid rows of an array of the same numbers.
    #[test]
    fn raw_files_equal_arrays(
        numbers in proptest::collection::vec(bits(), 0..40),
        dimension in 2..=3_usize,
        is_single: bool,
        is_big: bool,
        skip_invalid: bool,
        kept in proptest::option::of(2..=3_usize),
    ) {
        let rows = numbers.len() / dimension;
        let (mut little, mut sent) = (Vec::new(), Vec::new());
        for number in &numbers[..rows * dimension] {
            let number = f64::from_bits(*number);
            let bytes = if is_single { (number as f32).to_le_bytes().to_vec() } else { number.to_le_bytes().to_vec() };
            little.extend(&bytes);
            sent.extend(bytes.iter().rev());
        }
        let (kind, width) = if is_single { ("f32", "<f4") } else { ("f64", "<f8") };
        let order = if is_big { "be" } else { "" };
        let head = format!("{{'descr': '{width}', 'fortran_order': False, 'shape': ({rows}, {dimension}), }}");
        let array = npy(&head, &little);
        let options = with(kept, skip_invalid);
        let rows: RawRows = format!("{kind}{order},{dimension}").parse().unwrap();
        let raw = ReadOptions { raw: Some(rows), ..options.clone() };
        let found = parse("a.raw", if is_big { &sent } else { &little }, &raw);
        match (found, parse("a.npy", &array, &options)) {
            (Ok(found), Ok(expected)) => prop_assert_eq!(found, expected),
            (Err(found), Err(expected)) => {
                prop_assert_eq!(found.row(), expected.row());
                let start = (array.len() - little.len()) as u64;
                let place = match expected.place() {
                    Place::Byte(at) => Place::Byte(at - start),
                    other => other,
                };
                prop_assert_eq!(found.place(), place);
            }
            (found, expected) => prop_assert!(false, "{found:?} instead of {expected:?}"),
        }
    }
}
