//! Formats of other programs: archives, polygons, binary meshes, streams.

use std::io::Write;

use super::*;
use crate::read::CoordinateType;

/// The points of the files.
const WANT: [[f64; 3]; 4] = [[0.5, 0.0, 1.0], [1.0, 0.25, 0.0], [0.0, 1.0, 0.0], [0.25, 0.5, -2.0]];

fn doubles() -> Vec<u8> {
    WANT.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect()
}

/// The bytes of an array of the points.
fn array() -> Vec<u8> {
    npy("{'descr': '<f8', 'fortran_order': False, 'shape': (4, 3), }", &doubles())
}

/// An archive of members, each with its method.
fn archive(members: &[(&str, &[u8], u16)]) -> Vec<u8> {
    let (mut bytes, mut directory) = (Vec::new(), Vec::new());
    for (name, data, method) in members {
        let mut packed = data.to_vec();
        if *method == 8 {
            let mut deflate = flate2::write::DeflateEncoder::new(Vec::new(), flate2::Compression::fast());
            deflate.write_all(data).unwrap();
            packed = deflate.finish().unwrap();
        }
        let local = bytes.len() as u32;
        let mut crc = flate2::Crc::new();
        crc.update(data);
        let sizes = [crc.sum(), packed.len() as u32, data.len() as u32].map(u32::to_le_bytes).concat();
        let lengths = (name.len() as u16).to_le_bytes();
        let method = method.to_le_bytes();
        bytes.extend([b"PK\x03\x04\x14\0\0\0", &method[..], &[0; 4], &sizes, &lengths, &[4, 0]].concat());
        bytes.extend([name.as_bytes(), &[9, 9, 0, 0], &packed].concat());
        directory.extend([b"PK\x01\x02\x14\0\x14\0\0\0", &method[..], &[0; 4], &sizes, &lengths].concat());
        directory.extend([&[0; 12][..], &local.to_le_bytes(), name.as_bytes()].concat());
    }
    let (start, count) = ((bytes.len() as u32).to_le_bytes(), (members.len() as u16).to_le_bytes());
    let size = (directory.len() as u32).to_le_bytes();
    bytes.extend(directory);
    bytes.extend([b"PK\x05\x06\0\0\0\0", &count[..], &count, &size, &start, &[0, 0]].concat());
    bytes
}

#[test]
fn archives_of_arrays() {
    let (points, other) =
        (array(), npy("{'descr': '<i8', 'fortran_order': False, 'shape': (1, 3), }", &[0; 24]));
    for members in [
        &[("arr_0.npy", &points[..], 0)][..],
        &[("arr_0.npy", &points, 8)],
        &[("cells.npy", &other, 8), ("points.npy", &points, 8)],
    ] {
        let weighted = good_with("a.npz", archive(members), &weights::weights("3"));
        assert_eq!((weighted.points.dimension(), weighted.weights.map(|all| all.len())), (2, Some(4)));
        for name in ["a.npz", "a.dat"] {
            assert_eq!(space(&good(name, archive(members))), WANT);
        }
    }
    let several = archive(&[("a.npy", &points, 0), ("b.npy", &points, 0)]);
    let message = report(&bad("a.npz", &several));
    assert!(message.contains("(a, b)") && message.contains("`points`"), "{message}");
    assert!(bad("a.npz", archive(&[])).to_string().contains("without arrays"));
    assert!(bad("a.npz", archive(&[("a.npy", &points, 9)])).to_string().contains("compression 9"));
    let whole = archive(&[("a.npy", &points, 8)]);
    for end in 0..whole.len() {
        bad("a.npz", &whole[..end]);
    }
    for at in 0..whole.len() {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x41;
        let _ = parse("a.npz", damaged, &PLAIN);
    }
}

#[test]
fn damaged_members_are_named() {
    let points = array();
    for method in [0, 8] {
        let whole = archive(&[("arr_0.npy", &points, method)]);
        let directory = whole.windows(4).position(|w| w == b"PK\x01\x02").unwrap();
        // A byte of the data, and the size and the CRC-32 in the directory.
        for at in [directory - 3, directory + 16, directory + 24] {
            let mut damaged = whole.clone();
            damaged[at] ^= 0x05;
            let error = bad("a.npz", damaged);
            assert!(matches!(error, InputError::Malformed { .. }), "{error}");
            assert!(error.to_string().contains("arr_0"), "{error}");
        }
    }
}

#[test]
fn structured_arrays() {
    let row = |i: usize| {
        let [x, y, z] = WANT[i];
        [
            &(i as i32).to_le_bytes()[..],
            &z.to_be_bytes(),
            b"name",
            &x.to_le_bytes(),
            &(y as f32).to_le_bytes(),
        ]
        .concat()
    };
    let data: Vec<u8> = (0..4).flat_map(row).collect();
    let head = "{'descr': [('id', '<i4'), ('Z', '>f8'), ('n', 'S4'), ('x', '<f8'), ('y', '<f4')], \
                'fortran_order': False, 'shape': (4,), }";
    let file = good("a.npy", npy(head, &data));
    assert_eq!((space(&file), file.coordinate_type), (WANT.to_vec(), Some(CoordinateType::Float64)));
    assert!(noted(&file.notes, "2 further fields"), "{:?}", file.notes);
    let narrow = "{'descr': [('x', '<f4'), ('y', '<f8')], 'fortran_order': False, 'shape': (1,), }";
    for (head, kind) in
        [(narrow.to_owned(), CoordinateType::Float64), (narrow.replace("f8", "f4"), CoordinateType::Float32)]
    {
        assert_eq!(good("a.npy", npy(&head, &[0; 12])).coordinate_type, Some(kind), "{head}");
    }
    assert_eq!(plane(&good_with("a.npy", npy(head, &data), &TWO))[3], [0.25, 0.5]);
    for (from, to, part) in [
        ("'x'", "'u'", "(id, z, u, y)"),
        ("'n', 'S4'", "'n', 'O4'", "the type 'O4'"),
        ("'<f8')", "'<f8', (1,))", "an array itself"),
        ("('id', '<i4')", "('id', [('a', '<i4')])", "nested"),
        ("('y', '<f4')]", "('y', '<f4'), y", "\"y, "),
        ("('y', '<f4')]", "('y', '<f4')", "the end of the list of fields"),
        ("[(", "[[(", "the end of the list of fields"),
    ] {
        let error = bad("a.npy", npy(&head.replace(from, to), &data));
        assert!(error.to_string().contains(part), "{error}");
    }
    assert!(matches!(bad("a.npy", npy(head, &data[1..])), InputError::Truncated { .. }));
}

#[test]
fn other_shapes_are_named() {
    for (shape, parts) in [
        ("(3, 12)", ["(3, 12)", "a.T"]),
        ("(2, 99)", ["(2, 99)", "a.T"]),
        ("(12, 7)", ["(12, 7)", "supported: 2 to 6"]),
        ("(5,)", ["(5,)", "columns"]),
    ] {
        let head = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
        let message = report(&bad("a.npy", npy(&head, &[0; 2000])));
        assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    }
}

#[test]
fn polygons_of_vtk() {
    let text = "<?xml version='1.0'?>\n<VTKFile type='PolyData'><PolyData>\
        <Piece NumberOfPoints='4' NumberOfVerts='1' NumberOfPolys='2'>\
        <PointData><DataArray type='Float64' Name='connectivity'>9 9 9 9</DataArray></PointData>\
        <Points><DataArray type='Float64' NumberOfComponents='3'>0.5 0 1 1 0.25 0 0 1 0 0.25 0.5 -2</DataArray></Points>\
        <Verts><DataArray type='Int64' Name='connectivity'>0</DataArray>\
        <DataArray type='Int64' Name='offsets'>1</DataArray></Verts>\
        <Polys><DataArray type='Int64' Name='connectivity'>0 1 2 0 2 3</DataArray>\
        <DataArray type='Int64' Name='offsets'>3 6</DataArray></Polys></Piece></PolyData></VTKFile>";
    for name in ["a.vtp", "a.dat", "a.txt", "a.vtu"] {
        assert_eq!(space(&good(name, text)), WANT, "{name}");
    }
    assert_eq!(good_cells("a.vtp", text).cells, [0, 1, 2, 0, 2, 3]);
    let quads = text
        .replace("0 1 2 0 2 3", "0 1 2 3")
        .replace("3 6", "4")
        .replace("NumberOfPolys='2'", "NumberOfPolys='1'");
    assert!(matches!(bad_cells("a.vtp", quads), InputError::Unsupported { .. }));
    // Strips are cells that are not read.
    let strips = text.replace("NumberOfPolys", "NumberOfStrips='1' NumberOfPolys").replace(
        "</Piece>",
        "<Strips><DataArray type='Int64' Name='connectivity'>0 1 2 3</DataArray>\
        <DataArray type='Int64' Name='offsets'>4</DataArray></Strips></Piece>",
    );
    assert_eq!(space(&good("a.vtp", &strips)), WANT);
    let error = bad_cells("a.vtp", strips);
    assert!(error.to_string().contains("a triangle strip"), "{error}");
    assert_eq!(error.line(), Some(2));
    assert_eq!(
        good_cells("a.vtp", text.replace("NumberOfPolys", "NumberOfStrips='0' NumberOfPolys")).cells.len(),
        6
    );
    let error = bad("a.gpx", "<?xml version='1.0'?><gpx><wpt lat='1' lon='2'/></gpx>");
    assert!(matches!(error, InputError::UnknownFormat { .. }), "{error}");
}

#[test]
fn off_is_a_stream() {
    let numbers = "0.5 0 1 1 0.25 0 0 1 0 0.25 0.5 -2";
    for text in [
        format!("OFF\n4 2 0\n{numbers}\n3 0 1 2 3 0 2 3\n"),
        format!("OFF4 2 0\n{}\n3 0 1 2\n3 0 2 3\n", numbers.replace(" 1 1", " 1\n1")),
        format!("OFF 4\n2 0\n{}\n3\n0 1 2 3 0 2\n3\n", numbers.replace(' ', "\n")).replace("4\n2", "4 2"),
    ] {
        assert_eq!(space(&good("a.off", &text)), WANT, "{text}");
        assert_eq!(space(&good("a.txt", &text)), WANT, "{text}");
        assert_eq!(good_cells("a.off", &text).cells, [0, 1, 2, 0, 2, 3], "{text}");
    }
    bad("a.off", "OFF12\n");
    bad("a.off", "OFFx 1 0 0\n0 0 0\n");
}

/// A binary file of Gmsh of a version, in either byte order.
fn gmsh(version: &str, big: bool) -> Vec<u8> {
    let int = |n: i32| if big { n.to_be_bytes() } else { n.to_le_bytes() }.to_vec();
    let size = |n: u64| if big { n.to_be_bytes() } else { n.to_le_bytes() }.to_vec();
    let double = |c: f64| if big { c.to_be_bytes() } else { c.to_le_bytes() }.to_vec();
    let point = |p: &[f64; 3]| p.iter().flat_map(|c| double(*c)).collect::<Vec<u8>>();
    let mut file = format!("$MeshFormat\n{version} 1 8\n").into_bytes();
    file.extend(int(1));
    file.extend(b"\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"box\"\n$EndPhysicalNames\n$Nodes\n");
    if version == "2.2" {
        file.extend(b"4\n");
        WANT.iter().zip(10..).for_each(|(p, tag)| file.extend([int(tag), point(p)].concat()));
        file.extend(b"\n$EndNodes\n$Elements\n3\n");
        file.extend([1_i32, 1, 2].map(int).concat());
        file.extend([7_i32, 0, 0, 10, 11].map(int).concat());
        file.extend([4_i32, 2, 2].map(int).concat());
        for tag in [8, 9] {
            file.extend([tag, 0, 0, 10, 11, 12, 13].map(int).concat());
        }
    } else {
        file.extend([1_u64, 4, 10, 13].map(size).concat());
        file.extend([int(2), int(1), int(1), size(4)].concat());
        (10..14).for_each(|tag| file.extend(size(tag)));
        for p in &WANT {
            file.extend([point(p), double(0.5), double(0.5)].concat());
        }
        file.extend(b"\n$EndNodes\n$Elements\n");
        file.extend([1_u64, 2, 8, 9].map(size).concat());
        file.extend([int(3), int(1), int(4), size(2)].concat());
        for tag in [8, 9] {
            file.extend([tag, 10, 11, 12, 13].map(size).concat());
        }
    }
    file.extend(b"\n$EndElements\n");
    file
}

#[test]
fn binary_files_of_gmsh() {
    for version in ["2.2", "4.1"] {
        for big in [false, true] {
            let file = gmsh(version, big);
            assert_eq!(space(&good("a.msh", &file)), WANT, "{version}");
            assert_eq!(good_cells("a.msh", &file).cells, [0, 1, 2, 3, 0, 1, 2, 3]);
            for end in 0..file.len() {
                let _ = parse("a.msh", &file[..end], &PLAIN);
            }
            for at in 0..file.len() {
                let mut damaged = file.clone();
                damaged[at] ^= 0x90;
                let _ = parse("a.msh", damaged, &PLAIN);
            }
        }
    }
    for (mark, section) in [("$Nodes\n4", "Nodes"), ("$Elements\n3", "Elements")] {
        let mut short = gmsh("2.2", false);
        let at = short.windows(mark.len()).position(|w| w == mark.as_bytes()).unwrap();
        short[at + mark.len() - 1] = if section == "Nodes" { b'3' } else { b'1' };
        let error = bad_cells("a.msh", &short).to_string();
        assert!(error.contains(&format!("more bytes in ${section}")), "{error}");
    }
    let mut more = gmsh("2.2", true);
    let end = more.windows(9).position(|w| w == b"$EndNodes").unwrap();
    more.splice(end..end, [b'$'; 28]);
    let error = bad("a.msh", &more).to_string();
    assert!(error.contains("more bytes in $Nodes"), "{error}");
    assert!(matches!(bad("a.msh", "$MeshFormat\n4.0 1 8\n"), InputError::Unsupported { .. }));
}

#[test]
fn text_in_utf16() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.csv");
    let units = "\u{feff}x;y\r\n1,5;2\r\n".encode_utf16();
    std::fs::write(&path, units.flat_map(u16::to_le_bytes).collect::<Vec<u8>>()).unwrap();
    let file = crate::read::read(&path, &PLAIN, &mut |_, _| {}).unwrap();
    assert_eq!(plane(&file), [[1.5, 2.0]]);
}

/// Returns the points of a scan in `tests/reports/scans`.
fn scan(name: &str) -> Result<PointFile, InputError> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/reports/scans"));
    crate::read::read(&folder.join(name), &PLAIN, &mut |_, _| {})
}

#[cfg(feature = "las")]
#[test]
fn laser_scans_have_scale_and_offset() {
    for name in ["laspy-12.las", "laspy-14.laz"] {
        let points = space(&scan(name).unwrap());
        assert_eq!(points.len(), 12, "{name}");
        assert_eq!(points[0], [0.001 * 625.0 + 100.0, 0.001 * 897.0 + 200.0, 0.01 * 78.0], "{name}");
    }
}

#[cfg(not(feature = "las"))]
#[test]
fn laser_scans_need_their_feature() {
    assert!(scan("laspy-12.las").unwrap_err().to_string().contains("feature `las`"));
}
