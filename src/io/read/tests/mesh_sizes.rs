//! Sizes on meshes.

use crate::read::{InputError, read_sizes};
use septet_core::Door;
use septet_core::mesh::field::SizeField;

fn read(name: &str, content: &str) -> Result<SizeField, InputError> {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join(name);
    std::fs::write(&path, content).unwrap();
    read_sizes(&path, &mut |_, _| {})
}

/// Returns an error with its remedy.
fn message(error: &InputError) -> String {
    let remedy = error.remedy().map_or_else(String::new, |remedy| remedy.spelled(Door::Shell));
    format!("{error}; {remedy}")
}

fn vtu(arrays: &str) -> String {
    format!(
        "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"4\" NumberOfCells=\"1\">\
         <PointData>{arrays}</PointData><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\">\
         0 0 0 4 0 0 0 4 0 0 0 4</DataArray></Points><Cells>\
         <DataArray type=\"Int64\" Name=\"connectivity\">0 1 2 3</DataArray>\
         <DataArray type=\"Int64\" Name=\"offsets\">4</DataArray>\
         <DataArray type=\"UInt8\" Name=\"types\">10</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>"
    )
}

fn array(name: &str, values: &str) -> String {
    format!("<DataArray type=\"Float64\" Name=\"{name}\">{values}</DataArray>")
}

/// The largest function of slope 1/2 below the sizes, over the linear function, is nowhere above 1.5.
fn is_close(field: &SizeField, linear: impl Fn([f64; 3]) -> f64) {
    for (i, j, k) in
        (0..=8).flat_map(|i| (0..=8 - i).flat_map(move |j| (0..=8 - i - j).map(move |k| (i, j, k))))
    {
        let x = [f64::from(i) / 2.0, f64::from(j) / 2.0, f64::from(k) / 2.0];
        let below = field
            .rows
            .iter()
            .map(|(at, size)| size + (0..3).map(|k| (x[k] - at[k]).powi(2)).sum::<f64>().sqrt() / 2.0);
        let found = below.fold(f64::INFINITY, f64::min);
        assert!(found <= 1.5 * linear(x) + 1e-12, "{x:?}: {found}");
    }
}

#[test]
fn sizes_are_linear_in_cells() {
    let field = read("a.vtu", &vtu(&array("size", "0.5 0.5 0.5 2.5"))).unwrap();
    assert_eq!(field.dimension, 3);
    is_close(&field, |x| 0.5 + x[2] / 2.0);
    assert!((50..20_000).contains(&field.rows.len()), "{}", field.rows.len());
    // Large sizes need no more points.
    assert_eq!(read("a.vtu", &vtu(&array("size", "9 9 9 9"))).unwrap().rows.len(), 4);
}

#[test]
fn the_array_of_sizes_has_its_name_or_is_the_only_one() {
    let other = array("temperature", "1 1 1 1");
    assert_eq!(read("a.vtu", &vtu(&array("h", "9 9 9 9"))).unwrap().rows.len(), 4);
    let both = format!("{other}{}", array("size", "9 9 9 9"));
    assert_eq!(read("a.vtu", &vtu(&both)).unwrap().rows[0].1, 9.0);
    let two = format!("{other}{}", array("h", "9 9 9 9"));
    for (arrays, words) in [
        (two.as_str(), "size"),
        ("", "size"),
        (&array("size", "9 9 9"), "sizes at points"),
        (&array("size", "9 9 9 0"), "positive"),
    ] {
        let error = message(&read("a.vtu", &vtu(arrays)).unwrap_err());
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn gmsh_has_sizes_as_data_of_nodes() {
    let msh = |data: &str| {
        format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n7 0 0 0\n8 1 0 0\n9 0 1 0\n$EndNodes\n\
             $Elements\n1\n1 2 2 1 1 7 8 9\n$EndElements\n{data}"
        )
    };
    let data = |name: &str, rows: &str| {
        format!("$NodeData\n1\n\"{name}\"\n1\n0.0\n3\n0\n1\n3\n{rows}$EndNodeData\n")
    };
    let field = read("a.msh", &msh(&data("any", "9 4\n7 2\n8 3\n"))).unwrap();
    assert_eq!(field.dimension, 2);
    let expected = [([0.0, 0.0, 0.0], 2.0), ([0.0, 1.0, 0.0], 4.0), ([1.0, 0.0, 0.0], 3.0)];
    assert_eq!(field.rows, expected);
    for (text, words) in [
        (msh(""), "size"),
        (msh(&data("size", "7 2\n8 3\n8 4\n")), "sizes at points"),
        (msh(&data("size", "7 2\n8 3\n5 4\n")), "node"),
        (msh(&(data("a", "7 2\n8 3\n9 4\n") + &data("b", "7 2\n8 3\n9 4\n"))), "size"),
    ] {
        let error = message(&read("a.msh", &text).unwrap_err());
        assert!(error.contains(words), "{error}");
    }
}
