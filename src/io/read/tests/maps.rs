//! Maps as domains and as break lines.

use std::fs;

use glam::DVec2;
use septet_meshing::input::Input;

use crate::read::{AnyInput, InputError, read_breaklines, read_domain};

fn read(name: &str, text: &str) -> Result<(Input<DVec2>, Vec<String>), InputError> {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join(name);
    fs::write(&path, text).unwrap();
    let file = read_domain(&path, &mut |_, _| {})?;
    let AnyInput::Plane(input) = file.input else { panic!("a map lies in the plane") };
    Ok((input, file.notes))
}

/// The area inside the domain, by the attribute of the region.
fn areas(input: &Input<DVec2>) -> Vec<(f64, f64)> {
    let domain = septet_meshing::check(input).unwrap();
    let mut areas = std::collections::BTreeMap::new();
    for component in domain.components.iter().filter(|c| c.inside) {
        let name = input.regions[component.region.unwrap() as usize].attribute;
        *areas.entry(name as u64).or_insert(0.0) +=
            component.measure / 4f64.powi(domain.simplices.frame.exponent);
    }
    areas.into_iter().map(|(name, area)| (name as f64, area)).collect()
}

const COLLECTION: &str = r#"{"type": "FeatureCollection",
  "crs": {"type": "name", "properties": {"name": "EPSG:25832"}},
  "features": [
    {"type": "Feature", "properties": {"name": "a"}, "geometry": {"type": "Polygon", "coordinates":
      [[[0, 0], [8, 0], [8, 8], [0, 8], [0, 0]], [[2, 2], [2, 4], [4, 4], [4, 2], [2, 2]]]}},
    {"type": "Feature", "properties": null, "geometry": null},
    {"type": "Feature", "properties": {}, "geometry": {"type": "MultiPolygon", "coordinates":
      [[[[8, 2, 5.5], [12, 2, 1], [8, 6, 2], [8, 2, 5.5]]], [[[20, 0], [21, 0], [21, 1]]]]}},
    {"type": "Feature", "properties": {}, "geometry": {"type": "GeometryCollection", "geometries": [
      {"type": "LineString", "coordinates": [[1, 1], [1, 7]]},
      {"type": "Point", "coordinates": [6, 6]},
      {"type": "MultiPoint", "coordinates": [[7, 7]]},
      {"type": "MultiLineString", "coordinates": [[[5, 1], [6, 1]]]}]}}]}"#;

const TEXT: &str = "SRID=25832; POLYGON ((0 0, 8 0, 8 8, 0 8, 0 0), (2 2, 2 4, 4 4, 4 2, 2 2))\nPOLYGON EMPTY;\n\
    multipolygon z (((8 2 5.5, 12 2 1, 8 6 2, 8 2 5.5)), ((20 0 0, 21 0 0, 21 1 0)))\n\
    GEOMETRYCOLLECTION (LINESTRING (1 1, 1 7), POINT (6 6), MULTIPOINT ((7 7)), MULTILINESTRING ((5 1, 6 1)))\n";

#[test]
fn features_are_regions() {
    for (name, text) in [("a.geojson", COLLECTION), ("a.json", COLLECTION), ("a.wkt", TEXT), ("a", TEXT)] {
        let (input, notes) = read(name, text).unwrap();
        assert_eq!(areas(&input), [(1.0, 60.0), (3.0, 8.5)], "{name}");
        assert_eq!((input.holes.len(), input.segments.len()), (1, 4 + 2 + 4 + 2 + 3 + 2), "{name}");
        let markers: Vec<i64> = input.segments.iter().map(|s| s.marker).collect();
        assert_eq!(markers.iter().filter(|m| **m == 4).count(), 2, "{name}");
        let all = notes.join("\n");
        assert!(all.contains("coordinate system") && all.contains("25832"), "{all}");
        assert!(all.contains("without a geometry: 1") && all.contains("closed"), "{all}");
        assert!(all.contains("heights are ignored") && all.contains("1 to 4"), "{all}");
        assert_eq!(all.contains("properties"), name.contains("json"), "{all}");
    }
}

#[test]
fn one_geometry_is_a_domain() {
    let (input, notes) =
        read("a.geojson", r#"{"type":"Polygon","coordinates":[[[0,0],[1,0],[0,1],[0,0]]]}"#).unwrap();
    assert_eq!((areas(&input), notes.len()), (vec![(1.0, 0.5)], 0));
    let (input, _) = read("a.wkt", "LINESTRING (0 0, 1 0, 0 1, 0 0)").unwrap();
    assert_eq!(septet_meshing::check(&input).unwrap().components.iter().filter(|c| c.inside).count(), 1);
}

#[test]
fn what_is_wrong_is_named() {
    for (name, text, word) in [
        ("a.geojson", "{\"type\": \"Polygon\",", "JSON"),
        ("a.geojson", "{\"coordinates\": []}", "type"),
        ("a.geojson", r#"{"type":"Polygon","coordinates":[[[0,"x"]]]}"#, "two numbers"),
        ("a.geojson", r#"{"type":"Feature","geometry":{"type":"Curve","coordinates":[]}}"#, "Curve"),
        ("a.wkt", "POLYGON ((0 0, 1 0, 0 1)", "`)`"),
        ("a.wkt", "POLYGON ((0 0, 1))", "two or three"),
        ("a.wkt", "POINT (1 2)\nCIRCLE (0 0)", "well-known text"),
    ] {
        let error = read(name, text).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
    let nested = |kind: &str| kind.repeat(1_000_000);
    let error = read("a.wkt", &nested("GEOMETRYCOLLECTION (")).unwrap_err().to_string();
    assert!(error.contains("at most 100 collections"), "{error}");
    let list = format!("{{\"type\":\"Polygon\",\"coordinates\":{}", nested("["));
    let error = read("a.geojson", &list).unwrap_err().to_string();
    assert!(error.contains("JSON") && error.len() < 1000, "{error}");
}

/// Cut and changed files cause errors at most.
#[test]
fn damaged_maps_are_survived() {
    for (name, text) in [("a.geojson", COLLECTION), ("a.wkt", TEXT)] {
        for cut in 0..text.len() {
            let _ = read(name, &text[..cut]);
            for byte in ["9", "(", ",", "[", "}", " "] {
                let _ = read(name, &[&text[..cut], byte, &text[cut + 1..]].concat());
            }
        }
    }
}

#[test]
fn lines_have_heights() {
    let place = tempfile::tempdir().unwrap();
    let lines = |name: &str, text: &str| {
        let path = place.path().join(name);
        fs::write(&path, text).unwrap();
        read_breaklines(&path, &mut |_, _| {}).map(|(shapes, _)| (shapes.edges().count(), shapes.heights))
    };
    assert_eq!(lines("a.wkt", "LINESTRING Z (0 0 1, 1 0 2, 2 0 3)").unwrap(), (2, vec![1.0, 2.0, 3.0]));
    let (count, heights) = lines("a.wkt", "LINESTRING M (0 0 1, 1 0 2)").unwrap();
    assert!(count == 1 && heights.iter().all(|z| z.is_nan()));
    let poly = "2 3 0 0\n1 0 0 5\n2 1 0 6\n1 0\n1\n2 1 2\n0\n0\n";
    assert_eq!(lines("a.poly", poly).unwrap(), (2, vec![5.0, 6.0]));
    let (count, heights) = lines("b.poly", "2 2 0 0\n0 0 0\n1 1 0\n1 0\n0 0 1\n0\n").unwrap();
    assert!(count == 1 && heights.iter().all(|z| z.is_nan()));
    assert!(lines("a.csv", "0 0\n1 1\n").unwrap_err().to_string().contains("break lines"));
}
