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

#[test]
fn obj_and_ply_hold_the_surface_of_off() {
    for sample in [kuhn(2), awkward(squares(2))] {
        let off = one("m.off", &sample);
        let off: Vec<&str> = text(&off).split_off(2);
        let obj = one("m.obj", &sample);
        let (points, faces): (Vec<&str>, Vec<&str>) =
            text(&obj).into_iter().skip(1).partition(|line| line.starts_with('v'));
        assert!(points.iter().zip(&off).all(|(line, other)| line[2..] == **other));
        let zero = |line: &str| numbers::<u64>(&line[2..]).iter().map(|id| id - 1).collect::<Vec<u64>>();
        let triangles = |line: &&str| numbers::<u64>(&line[2..]);
        let triangles: Vec<Vec<u64>> = off[points.len()..].iter().map(triangles).collect();
        assert_eq!(faces.iter().map(|line| zero(line)).collect::<Vec<_>>(), triangles);
        let ply = one("m.ply", &sample);
        let end = ply.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        let head = format!("element vertex {}", points.len());
        assert!(text(&ply[..end]).contains(&head.as_str()));
        let (vertices, rows) = ply[end..].split_at(24 * points.len());
        let first: Vec<f64> = numbers(off[0]);
        let bits = first[0].to_le_bytes();
        assert_eq!(vertices[..8], bits);
        let row = |row: &[u8]| {
            assert_eq!(row[0], 3);
            row[1..].chunks_exact(4).map(|c| u64::from(u32::from_le_bytes(c.try_into().unwrap()))).collect()
        };
        assert_eq!(rows.chunks_exact(13).map(row).collect::<Vec<Vec<u64>>>(), triangles);
    }
}
