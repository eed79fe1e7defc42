//! Legacy VTK files.

use super::*;
use crate::read::Place;

/// An ASCII file of four points with these cells.
pub(super) fn ascii(dataset: &str, cells: &str) -> String {
    format!(
        "# vtk DataFile Version 3.0\na title\nASCII\nDATASET {dataset}\nFIELD FieldData 1\nTIME 1 1 double\n0.5\n\
         POINTS 4 float\n0 0 0 1 0 0\n0 1 0 0.25 0.5 -2\nMETADATA\nINFORMATION 0\n\n{cells}\
         POINT_DATA 4\nSCALARS w float 1\nLOOKUP_TABLE default\n1 2 3 4\n"
    )
}

/// A binary file of a tetrahedron and a triangle.
pub(super) fn binary() -> Vec<u8> {
    let mut file =
        b"# vtk DataFile Version 2.0\nt\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n".to_vec();
    file.extend(bytes_of!(f64, to_be_bytes, CORNERS.concat()));
    file.extend(b"\nCELLS 2 9\n");
    file.extend(bytes_of!(i32, to_be_bytes, [4, 0, 1, 2, 3, 3, 0, 1, 2]));
    file.extend(b"\nCELL_TYPES 2\n");
    file.extend(bytes_of!(i32, to_be_bytes, [10, 5]));
    file.extend(b"\n");
    file
}

pub(super) const VERSION_5: &str = "# vtk DataFile Version 5.1\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n\
    0 0 0 1 0 0 0 1 0\n0.25 0.5 -2\nCELLS 3 7\nOFFSETS vtktypeint64\n0 4 7\nCONNECTIVITY vtktypeint64\n0 1 2 3 0 1 2\n\
    CELL_TYPES 2\n10\n5\n";

#[test]
fn points_and_cells_of_all_variants() {
    let grid = ascii("UNSTRUCTURED_GRID", "CELLS 2 9\n4 0 1 2 3\n3 0 1 2\nCELL_TYPES 2\n10 5\n");
    let files =
        [grid.clone().into_bytes(), grid.replace('\n', "\r\n").into_bytes(), binary(), VERSION_5.into()];
    for file in &files {
        assert_eq!(space(&good("a.vtk", file)), CORNERS);
        assert_eq!(good("-", file).points.len(), 4);
        let cells = good_cells("a.vtk", file);
        assert_eq!((cells.dimension, cells.cells.as_slice()), (3, [0, 1, 2, 3].as_slice()));
        assert!(noted(&cells.notes, "1 triangles"));
    }
    let surface = ascii("polydata", "VERTICES 1 2\n1 0\nPOLYGONS 2 8\n3 0 1 2\n3 1 3 2\n");
    assert_eq!(good_cells("a.vtk", &surface).cells, [0, 1, 2, 1, 3, 2]);
    assert_eq!(space(&good("a.vtk", ascii("POLYDATA", ""))).len(), 4);
    let quad = ascii("POLYDATA", "POLYGONS 1 5\n4 0 1 2 3\n");
    assert!(matches!(bad_cells("a.vtk", &quad), InputError::Unsupported { .. }));
    assert_eq!(good("a.vtk", &quad).points.len(), 4);
}

#[test]
fn damaged_files_are_refused() {
    let grid = ascii("UNSTRUCTURED_GRID", "CELLS 2 9\n4 0 1 2 3\n3 0 1 2\nCELL_TYPES 2\n10 5\n");
    for (from, to) in [
        ("# vtk DataFile", "# vtk"),
        ("ASCII", "ASCI"),
        ("UNSTRUCTURED_GRID", "STRUCTURED_POINTS"),
        ("DATASET", "DATA"),
        ("POINTS 4", "POINTS 3"),
        ("POINTS 4", "POINTS 5"),
        ("POINTS 4", "POINTS 99999999999999999"),
        ("POINTS 4 float", "POINTS 4 half"),
        ("POINTS 4 float", "POINTS four float"),
        ("0.25", "0,25"),
        ("0.25", "nan"),
        ("CELLS 2 9", "CELLS 2 8"),
        ("CELLS 2 9", "CELLS 3 9"),
        ("CELLS 2 9", "CELLS 1 9"),
        ("CELL_TYPES 2\n10 5\n", ""),
        ("CELL_TYPES 2\n10 5", "CELL_TYPES 1\n10"),
        ("4 0 1 2 3", "4 0 1 2 4"),
        ("4 0 1 2 3", "9 0 1 2 3"),
        ("4 0 1 2 3", "4 0 1 2 -1"),
    ] {
        assert!(grid.contains(from), "{from}");
        bad("a.vtk", grid.replacen(from, to, 1));
    }
    let whole = binary();
    // A file may have points and no cells.
    let cells = whole.windows(6).position(|w| w == b"\nCELLS").unwrap();
    for cut in (0..cells).chain(cells + 2..whole.len() - 1) {
        bad("a.vtk", &whole[..cut]);
    }
    let mut infinite = binary();
    let at = infinite.windows(8).position(|w| w == (-2.0_f64).to_be_bytes()).unwrap();
    infinite[at..at + 8].copy_from_slice(&f64::INFINITY.to_be_bytes());
    let error = bad("a.vtk", &infinite);
    assert!(
        matches!(error, InputError::NotFinite { place: Place::Byte(b), index: 3, .. } if b == at as u64),
        "{error}"
    );
}

#[test]
fn lines_of_many_sections_are_counted_once() {
    let text = ascii("POLYDATA", &"LINES 0 0\n".repeat(60_000));
    assert_eq!(good("a.vtk", &text).points.len(), 4);
    let text = ascii("POLYDATA", &format!("{}POLYGONS 1 9\n3 0 1 9 4 4 4 4 4\n", "LINES 0 0\n".repeat(3)));
    assert_eq!(bad("a.vtk", &text).line(), Some(17));
}
