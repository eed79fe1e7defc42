use super::*;

/// The lines between a heading and its end.
pub(super) fn section<'a>(lines: &[&'a str], name: &str) -> Vec<&'a str> {
    let start = lines.iter().position(|l| *l == format!("${name}")).unwrap();
    let end = lines.iter().position(|l| *l == format!("$End{name}")).unwrap();
    lines[start + 1..end].to_vec()
}

#[test]
fn msh_22_holds_the_mesh() {
    for (sample, kind) in [(awkward(kuhn(2)), "4"), (awkward(squares(3)), "2")] {
        let bytes = one("m.msh22", &sample);
        let lines = text(&bytes);
        assert_eq!(section(&lines, "MeshFormat"), ["2.2 0 8"]);
        let nodes = section(&lines, "Nodes");
        assert_eq!(nodes[0], sample.view().point_count().to_string());
        same_bits(&nodes[1..], &sample, 1);
        let elements = section(&lines, "Elements");
        assert_eq!(elements[0], sample.view().cell_count().to_string());
        same_cells(&elements[1..], &sample, 5, 1);
        let words: Vec<&str> = elements[1].split(' ').collect();
        assert_eq!(words[..5], ["1", kind, "2", "1", "1"]);
    }
}

#[test]
fn msh_41_holds_the_mesh() {
    for (sample, kind) in [(awkward(kuhn(2)), 4), (awkward(squares(3)), 2)] {
        let bytes = one("m.msh", &sample);
        let (d, n, m) = (sample.dimension, sample.view().point_count(), sample.view().cell_count());
        let lines = text(&bytes);
        assert_eq!(section(&lines, "MeshFormat"), ["4.1 0 8"]);
        let entities = section(&lines, "Entities");
        assert_eq!(entities[0], if d == 3 { "0 0 0 1" } else { "0 0 1 0" });
        let entity: Vec<f64> = numbers(entities[1]);
        assert_eq!(entity.len(), 10);
        assert!(entity[1] <= entity[4] && entity[3] <= entity[6]);
        assert_eq!(entity[7..], [1.0, 1.0, 0.0]);
        let nodes = section(&lines, "Nodes");
        assert_eq!(nodes[0], format!("1 {n} 1 {n}"));
        assert_eq!(nodes[1], format!("{d} 1 0 {n}"));
        assert_eq!(nodes[2], "1");
        assert_eq!(nodes[n + 1], n.to_string());
        same_bits(&nodes[n + 2..], &sample, 0);
        let elements = section(&lines, "Elements");
        assert_eq!(elements[0], format!("1 {m} 1 {m}"));
        assert_eq!(elements[1], format!("{d} 1 {kind} {m}"));
        same_cells(&elements[2..], &sample, 1, 1);
    }
}

#[test]
fn the_msh_version_follows_option_and_name() {
    let sample = squares(1);
    let v22 = WriteOptions { msh: MshVersion::V22, ..WriteOptions::default() };
    let version = |name: &str, options: &WriteOptions| {
        let files = written(name, &sample, options);
        text(&files[name])[1][..3].to_owned()
    };
    assert_eq!(version("a.msh", &v22), "2.2");
    assert_eq!(version("a.msh41", &v22), "4.1");
    assert_eq!(version("a.msh2", &WriteOptions::default()), "2.2");
}

#[test]
fn medit_holds_the_mesh_and_its_hull() {
    for (sample, facet, cell, hull) in
        [(awkward(kuhn(2)), "Triangles", "Tetrahedra", 48), (awkward(squares(3)), "Edges", "Triangles", 12)]
    {
        let bytes = one("m.mesh", &sample);
        let lines = text(&bytes);
        let n = sample.view().point_count();
        assert_eq!(lines[0], "MeshVersionFormatted 2");
        assert_eq!(lines[1], format!("Dimension {}", sample.dimension));
        assert_eq!(lines[2..4], ["Vertices", &n.to_string()]);
        same_bits(&lines[4..4 + n], &sample, 0);
        assert!(lines[4..4 + n].iter().all(|line| line.ends_with(" 0")));
        assert_eq!(lines[4 + n..6 + n], [facet, &hull.to_string()]);
        let rest = &lines[6 + n + hull..];
        assert_eq!(rest[0], cell);
        assert_eq!(*rest.last().unwrap(), "End");
        same_cells(&rest[2..rest.len() - 1], &sample, 0, 1);
    }
}
