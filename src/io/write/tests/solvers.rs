//! Bytes of the formats of solvers, with the groups of a mesh of two regions.

use std::path::Path;

use super::*;
use crate::write::Order;
use septet_core::model::{Labels, Patches};

/// Two tetrahedra with a common face: regions 10 and 20, the boundary with markers 3 and 5, the common face with marker
/// 7, and an edge with marker 2.
fn labelled() -> (Sample, Labels) {
    let mut sample = no_cells(3, 5);
    sample.coordinates = vec![0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 1., 1., 1.];
    sample.cells = vec![0, 1, 2, 3, 1, 2, 3, 4];
    sample.owner = vec![0; 2];
    sample.owning_leaf = vec![0; 2];
    let labels = Labels {
        regions: vec![1, 2],
        attributes: vec![10.0, 20.0],
        faces: Patches {
            vertices: vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 4, 1, 4, 3, 2, 3, 4, 1, 2, 3],
            of: vec![0, 0, 0, 1, 1, 1, 2],
            markers: vec![3, 3, 3, 5, 5, 5, 7],
        },
        sides: vec![[1, 0], [1, 0], [1, 0], [2, 0], [2, 0], [2, 0], [1, 2]],
        edges: Patches { vertices: vec![0, 1], of: vec![0], markers: vec![2] },
        point_markers: vec![3; 5],
        sizes: vec![1.0, 2.0, 3.0, 4.0, 5.0],
        carriers: vec![[0, 0]; 5],
    };
    (sample, labels)
}

/// Writes the mesh with two regions. Returns the files by name, relative to the folder.
fn files(name: &str, order: Order) -> HashMap<String, Vec<u8>> {
    let (sample, labels) = labelled();
    let view = MeshView { labels: Some(&labels), ..sample.view() };
    let view = MeshView { owner: None, owning_leaf: None, ..view };
    let directory = tempfile::tempdir().unwrap();
    let options = WriteOptions { order, ..WriteOptions::default() };
    let path = directory.path().join(name);
    check_output(&path, &options).unwrap();
    assert_eq!(write(&path, &view, &options, &mut |_, _| {}).unwrap(), std::slice::from_ref(&path));
    let folder = if path.is_dir() { &path } else { directory.path() };
    fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap())
        .map(|e| (e.file_name().into_string().unwrap(), fs::read(e.path()).unwrap()))
        .collect()
}

fn written_text(name: &str) -> String {
    String::from_utf8(files(name, Order::One).remove(name).unwrap()).unwrap()
}

#[test]
fn inp_has_sets_and_surfaces() {
    let text = written_text("m.inp");
    let expected = "*HEADING\nseptet\n*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n5, 1, 1, 1\n\
                    *ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n2, 2, 3, 4, 5\n\
                    *ELSET, ELSET=region-10\n1\n*ELSET, ELSET=region-20\n2\n\
                    *NSET, NSET=marker-3\n1, 2, 3, 4\n*NSET, NSET=marker-5\n2, 3, 4, 5\n\
                    *NSET, NSET=marker-7\n2, 3, 4\n*NSET, NSET=segment-2\n1, 2\n\
                    *SURFACE, NAME=marker-3, TYPE=ELEMENT\n1, S4\n1, S2\n1, S1\n\
                    *SURFACE, NAME=marker-5, TYPE=ELEMENT\n2, S3\n2, S4\n2, S2\n\
                    *SURFACE, NAME=marker-7, TYPE=ELEMENT\n1, S3\n";
    assert_eq!(text, expected);
    let text = String::from_utf8(files("m.inp", Order::Two).remove("m.inp").unwrap()).unwrap();
    assert!(text.contains("TYPE=C3D10\n1, 1, 2, 3, 4, "), "{text}");
}

#[test]
fn su2_has_markers() {
    let expected = "NDIME= 3\nNELEM= 2\n10 0 1 2 3 0\n10 1 2 3 4 1\n\
                    NPOIN= 5\n0 0 0 0\n1 0 0 1\n0 1 0 2\n0 0 1 3\n1 1 1 4\n\
                    NMARK= 3\nMARKER_TAG= marker-3\nMARKER_ELEMS= 3\n5 0 2 1\n5 0 1 3\n5 0 3 2\n\
                    MARKER_TAG= marker-5\nMARKER_ELEMS= 3\n5 1 2 4\n5 1 4 3\n5 2 3 4\n\
                    MARKER_TAG= marker-7\nMARKER_ELEMS= 1\n5 1 2 3\n";
    assert_eq!(written_text("m.su2"), expected);
}

#[test]
fn bdf_has_properties() {
    let text = written_text("m.bdf");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[1..3], ["$ property 10 of CTETRA: region-10", "$ property 20 of CTETRA: region-20"]);
    let grid = lines.iter().position(|line| line.starts_with("GRID*")).unwrap();
    assert_eq!(lines[grid - 1], "BEGIN BULK");
    assert_eq!(lines[grid + 2], format!("GRID*   {:<16}{:16}{:<16}{:<16}", 2, "", "1.", "0."));
    assert_eq!(lines[grid + 3], "*       0.");
    assert_eq!(lines[grid + 10], "CTETRA  1       10      1       2       3       4       ");
    assert_eq!(lines[grid + 12], "CTRIA3  3       3       1       3       2       ");
    assert_eq!((lines.len(), lines[lines.len() - 1]), (grid + 20, "ENDDATA"));
    let text = String::from_utf8(files("m.bdf", Order::Two).remove("m.bdf").unwrap()).unwrap();
    let (first, rest) = text.split_once("CTETRA  1 ").unwrap().1.split_once('\n').unwrap();
    assert!(first.ends_with('+') && first.len() == 63 && rest.starts_with("+       "), "{first}");
}

#[test]
fn xdmf_has_elements_of_all_dimensions() {
    let text = written_text("m.xdmf");
    assert!(text.contains("TopologyType=\"Mixed\" NumberOfElements=\"10\""), "{text}");
    assert!(
        text.contains("Dimensions=\"42\" Format=\"XML\" Precision=\"8\">\n6 0 1 2 3\n6 1 2 3 4\n4 0 2 1\n")
    );
    assert!(text.contains("\n4 1 2 3\n2 2 0 1\n</DataItem>"));
    let numbers = |name: &str| {
        let rest = text.split_once(&format!("Name=\"{name}\"")).unwrap().1;
        let rest = rest.split_once("Precision=\"8\">\n").unwrap().1.split_once("</DataItem>").unwrap().0;
        super::numbers::<i64>(&rest.replace('\n', " "))
    };
    assert_eq!(numbers("region"), [10, 20, 0, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(numbers("marker"), [0, 0, 3, 3, 3, 5, 5, 5, 7, 2]);
    assert_eq!(numbers("dimension"), [3, 3, 2, 2, 2, 2, 2, 2, 2, 1]);
}

#[test]
fn msh_names_its_groups() {
    let names = "$PhysicalNames\n6\n1 2 \"segment-2\"\n2 3 \"marker-3\"\n2 5 \"marker-5\"\n2 7 \"marker-7\"\n\
                 3 10 \"region-10\"\n3 20 \"region-20\"\n$EndPhysicalNames\n";
    let text = written_text("m.msh");
    assert!(text.contains(names), "{text}");
    assert!(text.contains("$Entities\n0 1 3 2\n2 0 0 0 1 0 0 1 2 0\n3 0 0 0 1 1 1 1 3 0\n"), "{text}");
    assert!(text.contains("$Elements\n6 10 1 10\n1 2 1 1\n1 1 2\n2 3 2 3\n2 1 3 2\n"), "{text}");
    let text = written_text("m.msh22");
    assert!(text.contains(names) && text.contains("\n9 4 2 10 10 1 2 3 4\n10 4 2 20 20 2 3 4 5\n"), "{text}");
}

#[test]
fn vtu_has_elements_of_all_dimensions() {
    let (head, arrays) = vtu_arrays(&files("m.vtu", Order::One).remove("m.vtu").unwrap());
    assert!(
        head.contains("NumberOfPoints=\"5\" NumberOfCells=\"10\"") && head.contains("Scalars=\"region\"")
    );
    let words = binary::words;
    assert_eq!(words(&arrays["region"]), [10, 20, 0, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(arrays["types"], [10, 10, 5, 5, 5, 5, 5, 5, 5, 3]);
    assert_eq!(words(&arrays["offsets"]), [4, 8, 11, 14, 17, 20, 23, 26, 29, 31]);
    assert_eq!(words(&arrays["connectivity"])[29..], [0, 1]);
    assert_eq!(words(&arrays["outer_region"])[2..9], [0, 0, 0, 0, 0, 0, 2]);
    let (_, arrays) = vtu_arrays(&files("m.vtu", Order::Two).remove("m.vtu").unwrap());
    assert_eq!(arrays["types"], [24, 24, 22, 22, 22, 22, 22, 22, 22, 21]);
    // Nine edges. The middle of points 0 and 1 lies on the segment, and has the mean of their sizes.
    assert_eq!(arrays["Points"].len(), 24 * 14);
    assert_eq!(f64::from_bits(words(&arrays["size"])[5]), 1.5);
    let markers: Vec<u64> = words(&arrays["marker"]);
    assert_eq!(markers.len(), 14, "the array of points is the last of its name");
    assert_eq!(markers[5..7], [2, 3]);
}

#[test]
fn exodus_has_blocks_and_side_sets() {
    let bytes = files("m.exo", Order::One).remove("m.exo").unwrap();
    assert_eq!(bytes[..8], *b"CDF\x01\0\0\0\0");
    let holds = |part: &[u8]| bytes.windows(part.len()).any(|window| window == part);
    for name in ["region-10", "region-20", "marker-3", "marker-5", "marker-7", "segment-2", "TETRA"] {
        assert!(holds(name.as_bytes()), "{name}");
    }
    let ints = |numbers: &[i32]| numbers.iter().flat_map(|n| n.to_be_bytes()).collect::<Vec<u8>>();
    // The sides of cell 1: of the faces 0 1 3, 0 3 2 and 0 2 1.
    assert!(holds(&ints(&[1, 1, 1, 1, 3, 4])) && holds(&ints(&[1, 2, 3, 4])));
}

#[test]
fn poly_mesh_is_a_folder_of_files() {
    let files = files("polyMesh", Order::One);
    let body = |name: &str| {
        let text = String::from_utf8(files[name].clone()).unwrap();
        text.split_once("}\n\n").unwrap().1.to_owned()
    };
    assert_eq!(files.len(), 7);
    assert_eq!(
        body("faces"),
        "7\n(\n3(1 2 3)\n3(0 1 3)\n3(0 2 1)\n3(0 3 2)\n3(1 2 4)\n3(1 4 3)\n3(2 3 4)\n)\n"
    );
    assert_eq!(body("owner"), "7\n(\n0\n0\n0\n0\n1\n1\n1\n)\n");
    assert_eq!(body("neighbour"), "1\n(\n1\n)\n");
    assert!(body("boundary").contains("marker-5\n    {\n        type            patch;\n        nFaces          3;\n        startFace       4;"));
    assert!(body("cellZones").contains("region-20") && body("faceZones").contains("marker-7"));
    // A folder with another file is left alone, and so is one of a mesh if a file cannot be written.
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("polyMesh");
    let (sample, options) = (kuhn(1), WriteOptions::default());
    write(&path, &sample.view(), &options, &mut |_, _| {}).unwrap();
    write(&path, &sample.view(), &options, &mut |_, _| {}).unwrap();
    fs::write(path.join("blockMeshDict"), "").unwrap();
    for error in [
        check_output(&path, &options).map(drop).unwrap_err(),
        write(&path, &sample.view(), &options, &mut |_, _| {}).map(drop).unwrap_err(),
    ] {
        assert!(error.to_string().contains("blockMeshDict, which is not a file of a mesh"), "{error}");
    }
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1);
}

#[test]
fn dimensions_and_orders_that_a_format_lacks_are_refused_by_name() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name);
    let plane = squares(1);
    let error =
        write(&path("polyMesh"), &plane.view(), &WriteOptions::default(), &mut |_, _| {}).unwrap_err();
    assert!(matches!(error, OutputError::NotPlane { format: "polymesh", .. }), "{error}");
    let options = WriteOptions { order: Order::Two, ..WriteOptions::default() };
    for name in ["m.su2", "m.mesh", "m.ele", "m.npy", "m.off", "polyMesh"] {
        for error in [
            check_output(&path(name), &options).map(drop).unwrap_err(),
            write(&path(name), &kuhn(1).view(), &options, &mut |_, _| {}).map(drop).unwrap_err(),
        ] {
            assert!(matches!(error, OutputError::OnlyLinear { .. }), "{error}");
            assert!(error.to_string().contains(" files hold linear cells"), "{error}");
        }
    }
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
    for format in Format::ALL.iter().filter(|format| format.row().has_order_2) {
        let path = path(&format!("m.{}", format.name()));
        write(Path::new(&path), &kuhn(1).view(), &options, &mut |_, _| {}).unwrap();
    }
}
