use super::*;

#[test]
fn tetgen_files_hold_the_mesh() {
    for base in [0, 1] {
        for sample in [awkward(kuhn(2)), awkward(squares(3))] {
            let options = WriteOptions { first_id: base, ..WriteOptions::default() };
            let files = written("m.ele", &sample, &options);
            let d = sample.dimension;
            assert_eq!(files.len(), d + 2);
            let (n, m) = (sample.view().point_count(), sample.view().cell_count());
            let node = text(&files["m.node"]);
            assert_eq!(node[0], format!("{n} {d} 0 0"));
            same_bits(&node[1..], &sample, 1);
            let ele = text(&files["m.ele"]);
            assert_eq!(ele[0], format!("{m} {} 0", d + 1));
            same_cells(&ele[1..], &sample, 1, base);
            for name in ["m.node", "m.ele", "m.edge", "m.neigh"] {
                let lines = text(&files[name]);
                for (row, line) in lines[1..].iter().enumerate() {
                    assert_eq!(numbers::<f64>(line)[0], row as f64 + base as f64);
                }
            }
        }
    }
}

#[test]
fn tetgen_faces_edges_and_neighbours() {
    let sample = kuhn(2);
    let files = written("m.neigh", &sample, &WriteOptions::default());
    let face = text(&files["m.face"]);
    assert_eq!((face[0], face.len()), ("48 1", 49));
    assert!(face[1..].iter().all(|line| line.ends_with(" 1")));
    let edge = text(&files["m.edge"]);
    // 27 points, 48 cells, 96 + 24 facets: by Euler 27 - e + 120 - 48 = 1.
    assert_eq!((edge[0], edge.len()), ("98 1", 99));
    assert_eq!(edge[1..].iter().filter(|line| line.ends_with(" 1")).count(), 72);
    let neigh = text(&files["m.neigh"]);
    assert_eq!((neigh[0], neigh.len()), ("48 4", 49));
    let cell = |row: i64| &sample.cells[row as usize * 4..][..4];
    for line in &neigh[1..] {
        let row: Vec<i64> = numbers(line);
        for (i, &other) in row[1..].iter().enumerate().filter(|(_, other)| **other >= 0) {
            let shared = cell(row[0]).iter().filter(|v| cell(other).contains(v));
            assert_eq!(shared.count(), 3);
            assert!(!cell(other).contains(&cell(row[0])[i]));
        }
    }
    assert_eq!(neigh.join(" ").matches("-1").count(), 48);
}

#[test]
fn in_the_plane_there_is_no_face_file() {
    let files = written("m.face", &squares(2), &WriteOptions::default());
    let mut names: Vec<_> = files.keys().map(String::as_str).collect();
    names.sort_unstable();
    assert_eq!(names, ["m.edge", "m.ele", "m.neigh", "m.node"]);
    let edge = text(&files["m.edge"]);
    assert_eq!(edge[0], "16 1");
    assert_eq!(edge[1..].iter().filter(|line| line.ends_with(" 1")).count(), 8);
}

#[test]
fn off_holds_the_hull_in_space() {
    let bytes = one("m.off", &kuhn(2));
    let lines = text(&bytes);
    // The hull has 26 of the 27 points, all but the centre, whose index is 13.
    assert_eq!(lines[..2], ["OFF", "26 48 0"]);
    assert_eq!(lines[2 + 12], "0 0.5 0.5");
    assert_eq!(lines[2 + 13], "1 0.5 0.5");
    let point = |i: u64| {
        let row: Vec<f64> = numbers(lines[2 + i as usize]);
        glam::DVec3::from_slice(&row)
    };
    let mut volume = 0.0;
    for line in &lines[28..] {
        let row: Vec<u64> = numbers(line);
        assert_eq!(row[0], 3);
        volume += point(row[1]).dot(point(row[2]).cross(point(row[3])));
    }
    assert!((volume / 6.0 - 1.0).abs() < 1e-12);
}

#[test]
fn off_holds_everything_in_the_plane() {
    let sample = awkward(squares(2));
    let bytes = one("m.off", &sample);
    let lines = text(&bytes);
    assert_eq!(lines[..2], ["OFF", "9 8 0"]);
    same_bits(&lines[2..11], &sample, 0);
    assert!(lines[2..11].iter().all(|line| line.ends_with(" 0")));
    same_cells(&lines[11..], &sample, 1, 0);
}
