//! Tests of the readers of domains.

use glam::{DVec2, DVec3};
use septet_meshing::input::Input;

use std::fs;

use flate2::Compression;
use flate2::write::GzEncoder;
use septet_meshing::input::{DomainKind, InputSegment};
use std::io::Write;

use super::*;
use crate::read::error::InputError;
use crate::read::read_domain;

/// Writes files into a new directory and reads the first.
fn read(files: &[(&str, &[u8])]) -> Result<DomainFile, InputError> {
    let place = tempfile::tempdir().unwrap();
    for (name, content) in files {
        fs::write(place.path().join(name), content).unwrap();
    }
    read_domain(&place.path().join(files[0].0), &mut |_, _| {})
}

fn space(file: DomainFile) -> Input<DVec3> {
    match file.input {
        AnyInput::Space(input) => input,
        AnyInput::Plane(_) => panic!("a domain of the plane"),
    }
}

fn plane(file: DomainFile) -> Input<DVec2> {
    match file.input {
        AnyInput::Plane(input) => input,
        AnyInput::Space(_) => panic!("a domain of space"),
    }
}

/// Returns the error message and the remedy for a file.
fn refused(name: &str, text: &str) -> String {
    match read(&[(name, text.as_bytes())]) {
        Ok(_) => panic!("{name} was read: {text}"),
        Err(error) => {
            format!("{error}\n{}", error.remedy().map(|remedy| remedy.to_string()).unwrap_or_default())
        }
    }
}

const POINTS: &str = "4 3 1 1\n1 0 0 0 9.5 3\n2 1 0 0 9.5 4\n3 0 1 0 9.5 5\n4 0 0 1 9.5 6\n";
const REST: &str = "2 1\n2 1 7 # two polygons, a hole\n3 1 2\n3\n2 1 4\n1 0.25 0.25 0\n1\n3 1 2 4\n1\n1 2 2 2\n2\n1 .1 .1 .1 5 0.5\n2 .2 .2 .2 6 -1\n";

/// Returns the corners of the square, one per line, each after a word.
fn listed(before: &str) -> String {
    let row = |p: &[f64; 3]| format!("{before}{} {} {}\n", p[0], p[1], p[2]);
    SQUARE.iter().map(row).collect::<Vec<_>>().concat()
}

#[test]
fn poly_of_space() {
    let whole = format!("# comment\n{POINTS}\n{REST}");
    let file = read(&[("a.poly", whole.as_bytes())]).unwrap();
    assert_eq!((file.first_id, file.notes.len()), (1, 0));
    let input = space(file);
    assert_eq!(
        (input.kind, input.points.len(), &input.markers[..]),
        (DomainKind::Complex, 4, &[3, 4, 5, 6][..])
    );
    assert_eq!(input.facets.len(), 2);
    assert_eq!(input.facets[0].polygons, [vec![0, 1, 2], vec![0, 3]]);
    assert_eq!((input.facets[0].marker, input.facets[1].marker), (7, 0));
    assert_eq!(input.facets[0].holes, [DVec3::new(0.25, 0.25, 0.0)]);
    assert_eq!(input.holes, [DVec3::splat(2.0)]);
    let regions: Vec<_> = input.regions.iter().map(|r| (r.at.x, r.attribute, r.limit)).collect();
    assert_eq!(regions, [(0.1, 5.0, Some(0.5)), (0.2, 6.0, None)]);

    // The points in another file, then gzip, then a file without holes and regions.
    let rest = format!("0 3 0 0\n{REST}");
    let beside = read(&[("a.poly", rest.as_bytes()), ("a.node", POINTS.as_bytes())]).unwrap();
    assert_eq!(space(beside), input);
    let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
    packed.write_all(whole.as_bytes()).unwrap();
    assert_eq!(space(read(&[("a.poly.gz", &packed.finish().unwrap())]).unwrap()), input);
    let bare = format!("{POINTS}1\n1\n3 1 2 3\n");
    let bare = space(read(&[("a.poly", bare.as_bytes())]).unwrap());
    assert_eq!((bare.facets.len(), bare.holes.len()), (1, 0));
}

#[test]
fn smesh() {
    let text = "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n2 1\n3 0 1 2 -8\n3 0 1 3\n0\n0\n";
    let file = read(&[("a.smesh", text.as_bytes())]).unwrap();
    assert_eq!(file.first_id, 0);
    let input = space(file);
    assert_eq!(input.facets[1].polygons, [vec![0, 1, 3]]);
    assert_eq!((input.facets[0].marker, input.facets[1].marker), (-8, 0));
}

#[test]
fn poly_of_the_plane() {
    let text = "3 2 0 1\n0 0 0 1\n1 -0.0 1 1\n2 1 0 2\n3 1\n0 0 1 5\n1 1 2\n2 2 0 6\n1\n0 .3 .3\n1\n0 .1 .1 7 0.01\n";
    let file = read(&[("a.poly", text.as_bytes())]).unwrap();
    assert_eq!(file.first_id, 0);
    let input = plane(file);
    assert_eq!(input.points[1], DVec2::new(0.0, 1.0));
    assert!(input.points[1].x.is_sign_positive());
    let segment = |ends, marker| InputSegment { ends, marker };
    assert_eq!(input.segments, [segment([0, 1], 5), segment([1, 2], 0), segment([2, 0], 6)]);
    assert_eq!((input.holes.len(), input.regions[0].limit), (1, Some(0.01)));
    let beside = [("b.poly", &b"0 2 0 0\n1 0\n1 1 2\n0\n"[..]), ("b.node", &b"2 2 0 0\n1 0 0\n2 1 1\n"[..])];
    assert_eq!(plane(read(&beside).unwrap()).segments, [segment([0, 1], 0)]);
}

#[test]
fn errors_name_file_line_and_what_was_expected() {
    let with = |rest: &str| format!("{POINTS}{rest}");
    for (text, words) in [
        (String::new(), &["header"][..]),
        ("4 5 0 0\n".into(), &["line 1"]),
        ("3 3 0 0\n1 0 0 0\n2 0 0 0\n".into(), &["points", "3", "2"]),
        ("2 3 0 0\n1 0 0 0\n3 0 0 0\n".into(), &["line 3", "the point id 2"]),
        ("1 3 0 0\n1 0 0 x\n".into(), &["line 2", "x"]),
        ("1 3 0 0\n1 0 0 nan\n".into(), &["line 2", "finite"]),
        (with("1\n1\n3 1 2 5\n"), &["line 8", "5", "a point id from 1 to 4"]),
        (with("1\n1\n3 1 2 0\n"), &["line 8", "a point id from 1 to 4"]),
        (with("2\n1\n3 1 2 3\n"), &["facets"]),
        (with("1\n1\n3 1 2"), &["corners of a polygon"]),
        (with("1\n1\n3 1 2 3\n1\n"), &["holes"]),
        (with("1\n1\n3 1 2 3\n0\n1\n1 0 0 0\n"), &["line 11", "region"]),
        (with("1\n1\n3 1 2 3\n0\n0\n7\n"), &["line 11", "end of the file"]),
        (with("x\n"), &["line 6", "the number of facets"]),
    ] {
        let message = refused("a.poly", &text);
        for word in words.iter().chain([&"a.poly"]) {
            assert!(message.contains(word), "no `{word}` in: {message}");
        }
    }
    assert!(refused("a.poly", "0 3 0 0\n1\n").contains("a.node"));
    assert!(refused("a.vtu", "<VTKFile/>").contains(".vtu"));
    assert!(refused("a.dat", "\u{7f}ELF").contains("unknown format"));
}

const SQUARE: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 1.0, 0.5]];

fn faces(file: DomainFile) -> Vec<Vec<u32>> {
    let input = space(file);
    assert_eq!(input.kind, DomainKind::Surface);
    assert_eq!(input.points, SQUARE.map(DVec3::from));
    input.facets.into_iter().map(|f| f.polygons.concat()).collect()
}

#[test]
fn surfaces() {
    let rows = listed("");
    let off = format!("OFF\n4 2 0\n{rows}3 0 1 2 255 0 0\n4 0 1 2 3\n");
    assert_eq!(faces(read(&[("a.off", off.as_bytes())]).unwrap()), [vec![0, 1, 2], vec![0, 1, 2, 3]]);
    let obj = listed("v ");
    let obj = format!("o x\n{obj}vn 0 0 1\nf 1/1/1 2//1 3\nf -4 -3 -2 -1\n");
    let file = read(&[("a.obj", obj.as_bytes())]).unwrap();
    assert_eq!(file.first_id, 1);
    assert_eq!(faces(file), [vec![0, 1, 2], vec![0, 1, 2, 3]]);
    let corner = |i: usize| format!("vertex {} {} {}\n", SQUARE[i][0], SQUARE[i][1], SQUARE[i][2]);
    let facet = |t: [usize; 3]| {
        format!("facet normal 0 0 1\nouter loop\n{}endloop\nendfacet\n", t.map(corner).concat())
    };
    let stl = format!("solid x\n{}{}endsolid x\n", facet([0, 1, 2]), facet([0, 2, 3]));
    assert_eq!(faces(read(&[("a.stl", stl.as_bytes())]).unwrap()), [[0, 1, 2], [0, 2, 3]]);
    let mut binary = vec![b' '; 80];
    binary.extend(2u32.to_le_bytes());
    for t in [[0, 1, 2], [0, 2, 3]] {
        binary.extend([0; 12]);
        binary.extend(t.iter().flat_map(|&i| SQUARE[i]).flat_map(|c: f64| (c as f32).to_le_bytes()));
        binary.extend([0; 2]);
    }
    assert_eq!(faces(read(&[("a.stl", &binary)]).unwrap()), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn ply_surfaces() {
    let head = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n\
             element face 2\nproperty uchar red\nproperty list uchar int vertex_indices\nproperty list uchar float uv\n\
             end_header\n"
        )
    };
    let rows = listed("");
    let ascii = format!("{}{rows}9 3 0 1 2 1 0.5\n8 4 0 1 2 3 0\n", head("ascii"));
    let expected = [vec![0, 1, 2], vec![0, 1, 2, 3]];
    assert_eq!(faces(read(&[("a.ply", ascii.as_bytes())]).unwrap()), expected);
    for big in [false, true] {
        let mut file = head(if big { "binary_big_endian" } else { "binary_little_endian" }).into_bytes();
        let mut put = |little: &[u8]| {
            let bytes: Vec<u8> = if big { little.iter().rev().copied().collect() } else { little.to_vec() };
            file.extend(bytes);
        };
        SQUARE.as_flattened().iter().for_each(|c| put(&c.to_le_bytes()));
        for face in &expected {
            put(&[7]);
            put(&[face.len() as u8]);
            for v in face {
                put(&v.to_le_bytes());
            }
            put(&[1]);
            put(&0.5f32.to_le_bytes());
        }
        assert_eq!(faces(read(&[("a.ply", &file)]).unwrap()), expected, "{big}");
        assert!(read(&[("a.ply", &file[..file.len() - 1])]).is_err());
    }
    assert!(
        refused("a.ply", &format!("{}{rows}9 3 0 1 4 0\n8 3 0 1 2 0\n", head("ascii"))).contains("point 4")
    );
    let bare = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n";
    assert!(refused("a.ply", bare).contains("faces"));
    let flat = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nelement face 1\n\
                property list uchar int vertex_indices\nend_header\n0 0\n1 0\n0 1\n3 0 1 2\n";
    assert!(refused("a.ply", flat).contains("plane"));
}

#[test]
fn points_and_cells_are_recognised_by_content() {
    for name in ["a.poly", "a.smesh", "a.off", "a.stl", "a.dat"] {
        for points in ["0.5 0 0\n0 1 0.5\n1 0 1\n", "0.5,1\n2,3\n"] {
            let text = refused(name, points);
            assert!(
                text.contains("a table of points as a domain") && text.contains("`septet triangulate`"),
                "{text}"
            );
        }
    }
    for name in ["a.node", "a.xyz", "a.dat"] {
        let text = refused(name, POINTS);
        assert!(text.contains("as a domain") && text.contains("`septet triangulate`"), "{text}");
    }
    let text = refused("a.dat", "1 4 0\n1 1 2 3 4\n");
    assert!(text.contains("a list of cells (.ele) as a domain") && text.contains("`septet verify"), "{text}");
}
