//! Binary formats.

use std::io::Write;

use super::*;
use crate::read::Place;

#[test]
fn npy_of_all_kinds() {
    assert_eq!(space(&good("a.npy", npy_f8())), CORNERS);
    assert_eq!(plane(&good_with("a.npy", npy_f8(), &TWO)).len(), 4);
    let ints = [1, 2, 3, 4, 5, 6];
    let want = [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]];
    let head = |kind: &str| format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': (3, 2), }}");
    for (kind, data) in [
        ("<f8", bytes_of!(f64, to_le_bytes, ints)),
        ("<f4", bytes_of!(f32, to_le_bytes, ints)),
        ("<i8", bytes_of!(i64, to_le_bytes, ints)),
        ("<i4", bytes_of!(i32, to_le_bytes, ints)),
        ("<u2", bytes_of!(u16, to_le_bytes, ints)),
        ("|u1", bytes_of!(u8, to_le_bytes, ints)),
    ] {
        assert_eq!(plane(&good("a.npy", npy(&head(kind), &data))), want, "{kind}");
    }
    let fortran = "{\"descr\":\"<f8\",\"fortran_order\":True,\"shape\":(3,2)}";
    let data = bytes_of!(f64, to_le_bytes, [1, 3, 5, 2, 4, 6]);
    assert_eq!(plane(&good("a.npy", npy(fortran, &data))), want);
    let big = bytes_of!(f64, to_be_bytes, ints);
    assert_eq!(plane(&good("a.npy", npy(&head(">f8"), &big))), want);
    let large = bytes_of!(i64, to_le_bytes, [i64::MAX, 2, 3, 4, 5, 6]);
    assert!(noted(&good("a.npy", npy(&head("<i8"), &large)).notes, "1 integers"));
    let mut version2 = b"\x93NUMPY\x02\x00".to_vec();
    version2.extend((fortran.len() as u32).to_le_bytes());
    version2.extend(fortran.as_bytes());
    version2.extend(data);
    assert_eq!(plane(&good("a.npy", version2)), want);
}

#[test]
fn damaged_npy() {
    let file = |descr: &str, shape: &str| {
        npy(&format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}"), &[0; 48])
    };
    for (descr, shape) in [
        ("'<f8'", "(100000000000000, 3)"),
        ("'<f8'", "(18446744073709551615, 3)"),
        ("'<f8'", "(9223372036854775807, 3)"),
        ("'<f8'", "(6,)"),
        ("'<f8'", "()"),
        ("'<f8'", "(2, 3"),
        ("'<f8'", "(1, 1)"),
        ("'<f8'", "(9223372036854775807, 0)"),
        ("'<f8'", "(-1, 3)"),
        ("'<f8'", "(1, 2, 3)"),
        ("'<c16'", "(2, 3)"),
        ("'|O'", "(2, 3)"),
        ("''", "(2, 3)"),
        ("[('x', '<f8')]", "(2, 3)"),
    ] {
        bad("a.npy", file(descr, shape));
    }
    bad("a.npy", npy(&"(".repeat(60000), &[]));
    bad("a.npy", npy("{}", &[]));
    let nan = bytes_of!(f64, to_le_bytes, [0.0, 0.0, 0.0, 1.0, f64::NAN, 1.0]);
    let head = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }";
    let error = bad("a.npy", npy(head, &nan));
    let at = (10 + head.len() + 32) as u64;
    assert!(
        matches!(error, InputError::NotFinite { place: Place::Byte(b), index: 1, .. } if b == at),
        "{error}"
    );
    assert_eq!(good_with("a.npy", npy(head, &nan), &SKIP).source_index, Some(vec![0]));
    let mut longer = npy_f8();
    longer.push(0);
    assert!(noted(&good("a.npy", longer).notes, "1 bytes after"));
}

#[test]
fn ply_of_both_byte_orders() {
    for big in [false, true] {
        assert_eq!(space(&good("a.ply", ply_binary(big))), CORNERS);
    }
    let huge = |count: &str, list: &str| {
        format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {count}\n{list}property double x\nproperty double y\nproperty double z\nend_header\n0123456789"
        )
    };
    for count in ["100000000000000", "9223372036854775807", "1"] {
        assert!(matches!(bad("a.ply", huge(count, "")), InputError::Truncated { found: 0, .. }));
        bad("a.ply", huge(count, "property list int64 double n\n"));
    }
    // Elements without properties cost nothing, however many are announced.
    let hollow = "ply\nformat ascii 1.0\nelement nil 9223372036854775807\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n1 2\n";
    assert_eq!(plane(&good("a.ply", hollow)), [[1.0, 2.0]]);
    assert_eq!(plane(&good("a.ply", hollow.replace("ascii", "binary_little_endian") + "12345678")).len(), 1);
}

#[test]
fn stl_that_begins_with_solid() {
    for head in [b"solid but binary".as_slice(), b"", b"\0"] {
        let file = good("a.stl", stl_binary(head));
        assert_eq!(space(&file), CORNERS);
        assert!(noted(&file.notes, "merged into 4"));
    }
    let mut huge = stl_binary(b"x");
    huge[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(matches!(bad("a.stl", huge), InputError::Truncated { expected: 4_294_967_295, found: 2, .. }));
    let mut nan = stl_binary(b"x");
    nan[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(matches!(bad("a.stl", &nan), InputError::NotFinite { place: Place::Byte(96), index: 0, .. }));
    let file = good_with("a.stl", &nan, &SKIP);
    assert_eq!((file.skipped, file.points.len()), (1, 4));
}

fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for run in bytes.chunks(3) {
        let all = run.iter().fold(0_u32, |all, b| all << 8 | u32::from(*b)) << (8 * (3 - run.len()));
        for i in 0..4 {
            let letter = LETTERS[(all >> (18 - 6 * i)) as usize & 63];
            text.push(if i > run.len() { '=' } else { letter as char });
        }
    }
    text
}

#[test]
fn vtu_in_all_encodings() {
    let wide = "header_type='UInt64'";
    let plain = |bytes: &[u8], _: &str| base64(&[&(bytes.len() as u32).to_le_bytes(), bytes].concat());
    let apart = |bytes: &[u8], _: &str| base64(&(bytes.len() as u64).to_le_bytes()) + &base64(bytes);
    let zlib = |bytes: &[u8], _: &str| {
        let (mut blocks, mut table) = (Vec::new(), Vec::new());
        for block in bytes.chunks(32) {
            let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
            encoder.write_all(block).unwrap_or_default();
            let block = encoder.finish().unwrap_or_default();
            table.extend((block.len() as u32).to_le_bytes());
            blocks.extend(block);
        }
        let head = [table.len() as u32 / 4, 32, bytes.len() as u32 % 32].map(u32::to_le_bytes).concat();
        base64(&[head, table].concat()) + &base64(&blocks)
    };
    let ascii = vtu_inline("", "ascii", |_, text| text.to_owned());
    let files = [
        vtu_raw(false),
        vtu_raw(true),
        ascii.clone().into_bytes(),
        vtu_inline("", "binary", plain).into_bytes(),
        vtu_inline(wide, "binary", apart).into_bytes(),
        vtu_inline("compressor='vtkZLibDataCompressor'", "binary", zlib).into_bytes(),
    ];
    for file in &files {
        assert_eq!(space(&good("a.vtu", file)), CORNERS);
        assert_eq!(good_cells("a.vtu", file).cells, [0, 1, 2, 3]);
        let triangles = CellOptions { dimension: Some(2), ..CellOptions::default() };
        assert_eq!(parse_cells("a.vtu", file, &triangles).map(|c| c.cells).ok(), Some(vec![0, 1, 2]));
    }
    for (from, to) in [
        ("UnstructuredGrid'", "PolyData'"),
        ("NumberOfPoints='4'", "NumberOfPoints='5'"),
        ("NumberOfPoints='4'", "NumberOfPoints='3'"),
        ("NumberOfPoints='4'", "NumberOfPoints='x'"),
        ("NumberOfCells='2'", "NumberOfCells='9'"),
        ("4 7", "4 99"),
        ("4 7", "4 3"),
        ("0 1 2 3 0 1 2", "0 1 2 4 0 1 2"),
        ("0 1 2 3 0 1 2", "0 1 2 -1 0 1 2"),
        ("0.25", "0,25"),
        ("0.25", "nan"),
        ("NumberOfComponents='3'", "NumberOfComponents='2'"),
        ("</DataArray>", ""),
        ("byte_order", "compressor='vtkLZ4DataCompressor' byte_order"),
        ("</Piece>", "</Piece><Piece NumberOfPoints='0' NumberOfCells='0'></Piece>"),
    ] {
        assert!(ascii.contains(from));
        bad("a.vtu", ascii.replace(from, to));
    }
}

#[test]
fn vtu_appended_base64_and_places() {
    let mut appended = String::new();
    let mut offsets = Vec::new();
    vtu_inline("", "binary", |bytes, _| {
        offsets.push(appended.len());
        appended += &base64(&[&(bytes.len() as u32).to_le_bytes(), bytes].concat());
        String::new()
    });
    let array = |kind: &str, name: &str, at: usize| {
        format!(
            "<DataArray type='{kind}' Name='{name}' NumberOfComponents='{}' format='appended' offset='{}'/>",
            if at == 0 { 3 } else { 1 },
            offsets[at]
        )
    };
    let file = format!(
        "<VTKFile type='UnstructuredGrid'><UnstructuredGrid><Piece NumberOfPoints='4' NumberOfCells='2'>\
         <Points>{}</Points><Cells>{}{}{}</Cells></Piece></UnstructuredGrid>\
         <AppendedData encoding='base64'>_{appended}</AppendedData></VTKFile>",
        array("Float64", "p", 0),
        array("Int64", "connectivity", 1),
        array("Int64", "offsets", 2),
        array("UInt8", "types", 3)
    );
    assert_eq!(space(&good("a.vtu", &file)), CORNERS);
    assert_eq!(good_cells("a.vtu", &file).cells, [0, 1, 2, 3]);
    bad("a.vtu", file.replace("_YAAA", "_YAA"));

    let ascii = vtu_inline("", "ascii", |_, text| text.to_owned());
    assert_eq!(bad("a.vtu", ascii.replace("0.25", "nan")).line(), Some(3));
    assert_eq!(bad("a.vtu", ascii.replace("0.25", "0,25")).line(), Some(3));
    let mut raw = vtu_raw(true);
    let needle = (-2.0_f64).to_le_bytes();
    let at = raw.windows(8).position(|w| w == needle).unwrap_or(0);
    raw[at..at + 8].copy_from_slice(&f64::INFINITY.to_le_bytes());
    let error = bad("a.vtu", &raw);
    assert!(
        matches!(error, InputError::NotFinite { place: Place::Byte(b), index: 3, .. } if b == at as u64),
        "{error}"
    );
    assert_eq!(good_with("a.vtu", &raw, &SKIP).source_index, Some(vec![0, 1, 2]));
}
