//! Surface formats and meshes as points, ASCII.

use super::*;

#[test]
fn off_in_its_variants() {
    for text in [
        "OFF\n4 1 0\n0 0 0\n1 0 0\n0 1 0\n0.25 0.5 -2\n3 0 1 2\n",
        "OFF 4 1 0\n# c\n0 0 0\n\n1 0 0\n0 1 0\n0.25 0.5 -2\n3 0 1 2\n",
        "COFF\r\n4 1 0\r\n0 0 0 1 1 1 1\r\n1 0 0 1 1 1 1\r\n0 1 0 1 1 1 1\r\n0.25 0.5 -2 1 1 1 1\r\n3 0 1 2\r\n",
        "STCNOFF # c\n4 1\n0 0 0 1\n1 0 0 1\n0 1 0 1\n0.25 0.5 -2 1\n3 0 1 2\n",
        "4 1 0\n0 0 0\n1 0 0\n0 1 0\n0.25 0.5 -2\n3 0 1 2\n",
    ] {
        assert_eq!(space(&good("a.off", text)), CORNERS, "{text:?}");
    }
    let flat = "OFF 2 0 0\n1 2 0\n3 4 0\n";
    assert!(noted(&good("a.off", flat).notes, "dimension 2"));
    assert_eq!(plane(&good_with("a.off", flat, &TWO)), [[1.0, 2.0], [3.0, 4.0]]);
    assert!(matches!(bad("a.off", "4OFF\n1 0 0\n"), InputError::Unsupported { .. }));
    assert!(matches!(bad("a.off", "OFF BINARY\n"), InputError::Unsupported { .. }));
    assert!(matches!(
        bad("a.off", "OFF\n2 0 0\n0 0 0\n"),
        InputError::Truncated { expected: 2, found: 1, .. }
    ));
    assert!(matches!(bad("a.off", "OFF\n99999999999999 0 0\n0 0 0\n"), InputError::Truncated { .. }));
    assert_eq!(bad("a.off", "OFF\n1 0 0\n0 0\n").line(), Some(3));
    assert_eq!(bad("a.off", "OFF\n1 0 0\n0 0 0\n1 1 1\n").line(), Some(4));
    assert!(matches!(bad("a.off", ""), InputError::Truncated { .. }));
    assert!(matches!(bad("a.off", "FFO\n"), InputError::Syntax { .. }));
}

#[test]
fn ply_ascii() {
    let text = "ply\r\nformat ascii 1.0\r\ncomment x\r\nelement face 1\r\nproperty list uchar int v\r\nelement vertex 4\r\n\
        property list uchar int n\r\nproperty double z\r\nproperty double x\r\nproperty uchar red\r\nproperty double y\r\nend_header\r\n\
        3 0 1 2\r\n0 0 0 9 0\r\n2 5 5 0 1 9 0\r\n0 0 0 9 1\r\n0 -2 0.25 9 0.5\r\n";
    assert_eq!(space(&good("a.ply", text)), CORNERS);
    let head = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n";
    assert_eq!(plane(&good("a.ply", format!("{head}end_header\n1 2\n3 4\n"))), [[1.0, 2.0], [3.0, 4.0]]);
    let z = format!("{head}property float z\nend_header\n");
    assert_eq!(plane(&good_with("a.ply", format!("{z}1 2 3\n3 4 5\n"), &TWO)), [[1.0, 2.0], [3.0, 4.0]]);
    assert!(matches!(bad("a.ply", format!("{z}1 2 3\n")), InputError::Truncated { found: 1, .. }));
    assert_eq!(bad("a.ply", format!("{z}1 2 3\n4 5\n")).line(), Some(9));
    assert_eq!(bad("a.ply", format!("{z}1 2 3\n4 5 6\n\n7 8 9\n")).line(), Some(11));
    assert!(matches!(bad("a.ply", format!("{z}1 2 3\n4 nan 5\n")), InputError::NotFinite { index: 1, .. }));
    assert_eq!(good_with("a.ply", format!("{z}1 2 3\n4 nan 5\n"), &SKIP).source_index, Some(vec![0]));
    for header in [
        "ply\n",
        "ply\nend_header\n",
        "plyx\n",
        "ply\nformat ascii 1.0\nend_header\n",
        "ply\nformat ascii 1.0\nproperty float x\nend_header\n",
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
        "ply\nformat ascii 1.0\nelement vertex -1\n",
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty list float int x\n",
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\n",
        "ply\nnonsense\n",
    ] {
        bad("a.ply", header);
    }
}

#[test]
fn stl_and_obj() {
    let file = good("a.stl", STL_ASCII);
    assert_eq!(space(&file), CORNERS);
    assert!(noted(&file.notes, "6 facet corners merged into 4 points"), "{:?}", file.notes);
    assert!(matches!(bad("a.stl", &STL_ASCII[..STL_ASCII.len() - 12]), InputError::Truncated { .. }));
    assert_eq!(bad("a.stl", "solid\nfacet\nvertex 1 2\nendfacet\nendsolid").line(), Some(3));
    assert!(matches!(
        bad("a.stl", "solid\nfacet\nvertex 1 2 3\nendfacet\nendsolid"),
        InputError::Truncated { .. }
    ));
    assert_eq!(bad("a.stl", "solid\n1 2 3\nendsolid").line(), Some(2));
    let obj =
        "# c\r\nmtllib a\r\nv 0 0 0 1 1 1\r\nvn 1 1 1\r\nv 1 0 0\r\nv 0 1 0\r\nv 0.25 .5 -2\r\nf 1 2 3\r\n";
    let file = good("a.obj", obj);
    assert_eq!(space(&file), CORNERS);
    assert!(noted(&file.notes, "colours"));
    assert_eq!(plane(&good_with("a.obj", obj, &TWO)).len(), 4);
    assert!(matches!(bad("a.obj", "v 1 2\n"), InputError::MixedDimension { .. }));
    for (name, text, part) in [
        ("a.obj", "", "without vertices"),
        ("a.obj", "# c\nf 1 2 3\n", "without vertices"),
        ("a.stl", "solid a\nendsolid a\n", "without facets"),
    ] {
        let error = bad(name, text);
        assert!(error.exit_code() as u8 == 3 && error.to_string().contains(part), "{error}");
    }
}

#[test]
fn meshes_give_their_points() {
    for (name, text) in [("a.msh", MSH2), ("a.msh", MSH41), ("a.mesh", MEDIT)] {
        assert_eq!(space(&good(name, text)), CORNERS, "{text}");
        assert_eq!(space(&good(name, text.replace('\n', "\r\n"))), CORNERS, "{text}");
        let dropped = good_with(name, text, &TWO);
        assert_eq!(plane(&dropped).len(), 4);
        assert!(noted(&dropped.notes, "not 0 for 1 points"), "{:?}", dropped.notes);
        let nan = good_with(name, text.replace("-2", "nan").replace("1 nan", "1 -2"), &SKIP);
        assert_eq!(nan.source_index, Some(vec![0, 1, 2]), "{text}");
    }
}

#[test]
fn flat_triangle_meshes_are_plane() {
    let msh = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n\
        $Elements\n1\n1 2 0 1 2 3\n$EndElements\n";
    assert_eq!(plane(&good("a.msh", msh)).len(), 3);
    assert_eq!(space(&good_with("a.msh", msh, &THREE)).len(), 3);
    assert_eq!(space(&good("a.msh", msh.replace("0 1 0\n", "0 1 5\n"))).len(), 3);
    let bare = msh.split("$Elements").next().unwrap_or_default();
    assert!(noted(&good("a.msh", bare).notes, "dimension 2"));
    let medit = "MeshVersionFormatted 2 Dimension 2 Vertices 3 0 0 0 1 0 0 0 1 0 Triangles 1 1 2 3 0 End";
    assert_eq!(plane(&good("a.mesh", medit)), [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    assert!(matches!(bad_with("a.mesh", medit, &THREE), InputError::MixedDimension { .. }));
}

#[test]
fn damaged_meshes() {
    for (from, to) in [
        ("2.2 0 8", "2.2 1 8"),
        ("2.2 0 8", "4 0 8"),
        ("2.2 0 8", "1 0 8"),
        ("$MeshFormat", "$Nodes"),
        ("Nodes\n4", "Nodes\n5"),
        ("Nodes\n4", "Nodes\n3"),
        ("Nodes\n4", "Nodes\n100000000000000"),
        ("20 1 0 0", "10 1 0 0"),
        ("10 20 15 7", "10 20 15 8"),
        ("10 20 15 7", "10 20 15"),
        ("10 20 15 7", "10 20 15 7 7"),
        ("$EndElements", ""),
        ("Elements\n3", "Elements\n2"),
        ("$EndPhysicalNames", ""),
    ] {
        assert!(MSH2.contains(from));
        bad("a.msh", MSH2.replacen(from, to, 1));
    }
    for (from, to) in [
        ("2 4 1 4", "2 3 1 4"),
        ("2 4 1 4", "2 5 1 4"),
        ("2 4 1 4", "3 4 1 4"),
        ("2 1 0 3", "2 1 0 99999999999999"),
    ] {
        bad("a.msh", MSH41.replacen(from, to, 1));
    }
    for (from, to) in [
        ("Vertices\n4", "Vertices\n5"),
        ("Vertices\n4", "Vertices\n3"),
        ("Vertices\n4", "Vertices\n99999999999999"),
        ("1 2 3 4 0", "1 2 3 5 0"),
        ("1 2 3 4 0", "0 2 3 4 0"),
        ("Dimension\n3", "Dimension\n4"),
        ("Mesh", "Mush"),
        ("Vertices", "Vortices"),
    ] {
        bad("a.mesh", MEDIT.replacen(from, to, 1));
    }
}
