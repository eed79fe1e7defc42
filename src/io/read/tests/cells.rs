//! Cell lists.

use super::*;

fn with(base: Option<u64>, point_count: Option<u64>) -> CellOptions {
    CellOptions { base, point_count, ..CellOptions::default() }
}

#[test]
fn ele_of_either_base() {
    let one = good_cells("a.ele", "2 4 1\n1 1 2 3 4 7\n2 2 3 4 5 7\n# end\n");
    assert_eq!(
        (one.dimension, one.first_id, one.cells.as_slice()),
        (3, 1, [0, 1, 2, 3, 1, 2, 3, 4].as_slice())
    );
    let zero = good_cells("a.ele", "1 3 0\r\n0 0 1 2\r\n");
    assert_eq!((zero.dimension, zero.first_id, zero.cells.as_slice()), (2, 0, [0, 1, 2].as_slice()));
    let given = parse_cells("a.ele", "1 3 0\n1 0 1 2\n", &with(Some(0), Some(3)));
    assert_eq!(given.map(|c| c.cells).ok(), Some(vec![0, 1, 2]));
    let ten = good_cells("a.ele", "1 10 0\n0 0 1 2 3 4 5 6 7 8 9\n");
    assert_eq!((ten.cells.as_slice(), ten.notes.len()), ([0, 1, 2, 3].as_slice(), 1));
    assert_eq!(good_cells("a.ele", "0 4 0\n").cell_count(), 0);
}

#[test]
fn damaged_ele() {
    let error = parse_cells("a.ele", "1 3 0\n1 1 2 4\n", &with(None, Some(3))).expect_err("out of range");
    assert!(
        matches!(error, InputError::OutOfRangeIndex { value: 4, first: 1, limit: Some(3), cell: 0, .. }),
        "{error}"
    );
    assert_eq!(error.line(), Some(2));
    assert!(matches!(bad_cells("a.ele", "1 3 0\n1 0 1 2\n"), InputError::OutOfRangeIndex { value: 0, .. }));
    assert!(matches!(bad_cells("a.ele", "2 3 0\n1 1 2 3\n"), InputError::Truncated { .. }));
    assert!(matches!(bad_cells("a.ele", "1 3 0\n1 1 2 3\n2 1 2 3\n"), InputError::Count { .. }));
    assert!(matches!(bad_cells("a.ele", "1 5 0\n"), InputError::Syntax { line: 1, .. }));
    assert!(matches!(bad_cells("a.ele", "1 3 0\n1 1 2\n"), InputError::Syntax { line: 2, .. }));
    assert!(matches!(bad_cells("a.ele", "1 3 0\n1 1 2 3.5\n"), InputError::Syntax { line: 2, .. }));
    assert!(matches!(bad_cells("a.ele", "99999999999999 3 0\n1 1 2 3\n"), InputError::Truncated { .. }));
    assert!(matches!(bad_cells("a.ele", "1 3 0\n-9223372036854775808 1 2 3\n"), InputError::Syntax { .. }));
}

#[test]
fn npy_cells() {
    let head = |kind: &str| format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': (2, 3), }}");
    let flat = [0, 1, 2, 2, 1, 3];
    for (kind, data) in [
        ("<i8", bytes_of!(i64, to_le_bytes, flat)),
        ("<i4", bytes_of!(i32, to_le_bytes, flat)),
        ("<u8", bytes_of!(u64, to_le_bytes, flat)),
        ("<u4", bytes_of!(u32, to_le_bytes, flat)),
    ] {
        let cells = good_cells("a.npy", npy(&head(kind), &data));
        assert_eq!((cells.dimension, cells.cells), (2, vec![0, 1, 2, 2, 1, 3]));
        let error =
            parse_cells("a.npy", npy(&head(kind), &data), &with(None, Some(3))).expect_err("out of range");
        assert!(matches!(error, InputError::OutOfRangeIndex { value: 3, cell: 1, .. }), "{error}");
        let solid = CellOptions { dimension: Some(3), ..CellOptions::default() };
        assert!(parse_cells("a.npy", npy(&head(kind), &data), &solid).is_err());
    }
    let data = bytes_of!(i64, to_le_bytes, [0, 1, 2, 2, 1, -1]);
    assert!(matches!(
        bad_cells("a.npy", npy(&head("<i8"), &data)),
        InputError::OutOfRangeIndex { value: -1, .. }
    ));
    assert!(matches!(bad_cells("a.npy", npy_f8()), InputError::Unsupported { .. }));
}

#[test]
fn meshes_give_their_cells() {
    for (name, text, first) in [("a.msh", MSH2, 10), ("a.msh", MSH41, 1), ("a.mesh", MEDIT, 1)] {
        let cells = good_cells(name, text);
        assert_eq!((cells.dimension, cells.cells.as_slice()), (3, [0, 1, 2, 3].as_slice()), "{text}");
        assert_eq!(cells.first_id, first);
        assert!(noted(&cells.notes, "1 triangles"));
        let flat = CellOptions { dimension: Some(2), ..CellOptions::default() };
        assert_eq!(parse_cells(name, text, &flat).map(|c| c.cells).ok(), Some(vec![0, 1, 2]));
    }
    let quads = MEDIT.replace("End", "Quadrilaterals 1 1 2 3 4 0\nEnd");
    assert!(matches!(bad_cells("a.mesh", &quads), InputError::Unsupported { .. }));
    assert_eq!(good("a.mesh", quads).points.len(), 4);
    assert!(matches!(
        bad_cells("a.msh", MSH2.replace("1 15 2 0 1 10", "1 8 2 0 1 10 20 15")),
        InputError::Unsupported { .. }
    ));
}

#[test]
fn off_triangles() {
    let cells = good_cells("a.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 2 1 0 255 0 0\n");
    assert_eq!((cells.dimension, cells.cells), (2, vec![0, 1, 2, 2, 1, 0]));
    assert!(matches!(bad_cells("a.off", "OFF\n1 1 0\n0 0 0\n3 0 0 1\n"), InputError::OutOfRangeIndex { .. }));
    assert!(matches!(bad_cells("a.off", "OFF\n1 1 0\n0 0 0\n4 0 0 0 0\n"), InputError::Syntax { .. }));
    assert!(matches!(bad_cells("a.off", "OFF\n1 2 0\n0 0 0\n3 0 0 0\n"), InputError::Truncated { .. }));
    assert!(matches!(bad_cells("a.off", "OFF\n99999999999999 2 0\n0 0 0\n"), InputError::Truncated { .. }));
}

#[test]
fn files_of_the_wrong_kind() {
    assert!(matches!(bad_cells("a.node", "0 3\n"), InputError::Unsupported { .. }));
    assert!(matches!(bad("a.ele", "0 3\n"), InputError::Unsupported { .. }));
    assert!(matches!(bad_cells("a.xyz", "1 2 3\n"), InputError::Unsupported { .. }));
}

/// A tetrahedron with one facet, and a square in the plane with one segment.
const DOMAINS: [&str; 2] = [
    "# a domain\n4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n1 0\n1 0\n3 1 2 3\n0\n0\n",
    "4 2 0 0\n0 0 0\n1 1 0\n2 1 1\n3 0 1\n1 1\n0 0 1 5\n0\n",
];

#[test]
fn domains_are_recognised_by_content() {
    for domain in DOMAINS {
        for name in ["a.poly", "a.smesh", "a.node", "a.txt", "a.dat", "-"] {
            let Err(error) = parse(name, domain, &PLAIN) else { panic!("{name} has points") };
            let end = "a domain (.poly) as points is not supported\nmesh it with `septet mesh`";
            assert!(report(&error).ends_with(end), "{error}");
            let Err(error) = parse_cells(name, domain, &CellOptions::default()) else {
                panic!("{name} has cells")
            };
            assert!(error.to_string().contains("a domain (.poly) as cells"), "{error}");
        }
    }
    let only_facets = "0 3 0 0\n1 0\n1\n3 1 2 3\n0\n0\n";
    assert!(report(&bad("a.poly", only_facets)).contains("septet mesh"));
    // A point too many is not a list of facets.
    assert!(matches!(bad("a.node", "1 2\n1 0.5 0\n2 1 0.5\n"), InputError::Count { .. }));
}

#[test]
fn cells_and_points_are_recognised_by_content() {
    let cells = "2 4 1\n0 0 1 2 3 7\n1 1 2 3 4 7\n";
    for name in ["a.ele", "a.txt", "a.node", "a.dat", "a"] {
        let text = report(&bad(name, cells));
        assert!(
            text.contains("a list of cells (.ele) as points") && text.contains("septet verify"),
            "{text}"
        );
    }
    assert_eq!(good_cells("a.dat", cells).cells, good_cells("a.ele", cells).cells);
    // A header with the width of its rows is a row of a table.
    assert_eq!(good("a.txt", "3 4 0\n0 1 2\n1 2 3\n").points.len(), 3);
    for (name, points) in [("a.xyz", "0 0\n1 0\n"), ("a.dat", "0.5,0\n1,0\n"), ("a.node", "1 2 0 0\n1 0 0\n")]
    {
        let text = report(&bad_cells(name, points));
        assert!(text.contains("a table of points as cells") && text.contains("septet triangulate"), "{text}");
    }
}
