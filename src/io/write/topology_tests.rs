use super::*;
use septet_common::samples;

/// Finds facets by brute force: sorted vertices and their cells.
fn brute_facets(dimension: usize, cells: &[u64]) -> std::collections::BTreeMap<Vec<u64>, Vec<u64>> {
    let mut map = std::collections::BTreeMap::<Vec<u64>, Vec<u64>>::new();
    for (row, cell) in cells.chunks_exact(dimension + 1).enumerate() {
        for i in 0..=dimension {
            let mut key = cell.to_vec();
            key.remove(i);
            key.sort_unstable();
            map.entry(key).or_default().push(row as u64);
        }
    }
    map
}

fn agree_with_brute_force(sample: &samples::Sample) {
    let (d, n, cells) = (sample.dimension, sample.coordinates.len() / sample.dimension, &sample.cells);
    let map = brute_facets(d, cells);
    let found = adjacency(d, n, cells).unwrap();
    for (entry, &neighbour) in found.neighbours.iter().enumerate() {
        let row = entry / (d + 1);
        let mut key = cells[row * (d + 1)..(row + 1) * (d + 1)].to_vec();
        key.remove(entry % (d + 1));
        key.sort_unstable();
        let other = map[&key].iter().copied().find(|&other| other != row as u64);
        assert_eq!(neighbour, other.unwrap_or(OUTSIDE));
    }
    let hull_keys: Vec<Vec<u64>> = found
        .hull
        .chunks_exact(d)
        .map(|f| {
            let mut key = f.to_vec();
            key.sort_unstable();
            key
        })
        .collect();
    let expected: Vec<Vec<u64>> =
        map.iter().filter(|(_, rows)| rows.len() == 1).map(|(key, _)| key.clone()).collect();
    assert_eq!(hull_keys, expected);
    assert_eq!(hull(d, n, cells).unwrap(), found.hull);
    let mut edges_expected = std::collections::BTreeSet::new();
    for cell in cells.chunks_exact(d + 1) {
        for a in cell {
            edges_expected.extend(cell.iter().filter(|b| a < b).map(|b| [*a, *b]));
        }
    }
    assert_eq!(edges(d, n, cells).unwrap(), edges_expected.into_iter().collect::<Vec<_>>());
}

#[test]
fn agrees_with_brute_force() {
    agree_with_brute_force(&samples::kuhn(3));
    agree_with_brute_force(&samples::squares(5));
    agree_with_brute_force(&samples::kuhn(1));
    // More points than one batch of buckets.
    agree_with_brute_force(&samples::squares(400));
}

#[test]
fn wide_and_narrow_items_agree() {
    let s = samples::kuhn(2);
    let n = s.coordinates.len() / 3;
    let wide = facets_with::<u64>(3, n, &s.cells, true).unwrap();
    assert_eq!(wide, adjacency(3, n, &s.cells).unwrap());
    assert_eq!(edges_with::<u64>(3, n, &s.cells), edges(3, n, &s.cells).unwrap());
}

#[test]
fn hull_triangles_look_outward() {
    let s = samples::kuhn(2);
    let point = |i: u64| glam::DVec3::from_slice(&s.coordinates[3 * i as usize..]);
    let centre = glam::DVec3::splat(0.5);
    let found = hull(3, s.coordinates.len() / 3, &s.cells).unwrap();
    assert_eq!(found.len(), 3 * 48);
    for f in found.chunks_exact(3) {
        let (a, b, c) = (point(f[0]), point(f[1]), point(f[2]));
        assert!((b - a).cross(c - a).dot(a - centre) > 0.0);
        assert!(f[0] < f[1] && f[0] < f[2]);
    }
}

#[test]
fn hull_edges_have_the_inside_on_the_left() {
    let s = samples::squares(2);
    let point = |i: u64| glam::DVec2::from_slice(&s.coordinates[2 * i as usize..]);
    let found = hull(2, s.coordinates.len() / 2, &s.cells).unwrap();
    assert_eq!(found.len(), 2 * 8);
    for e in found.chunks_exact(2) {
        let (a, b) = (point(e[0]), point(e[1]));
        assert!((b - a).perp_dot(glam::DVec2::splat(0.5) - a) > 0.0);
    }
    assert_eq!(hull_edges(2, &found).len(), 8);
}

#[test]
fn every_facet_of_a_single_cell_is_hull() {
    let found = adjacency(3, 4, &[0, 1, 2, 3]).unwrap();
    assert_eq!(found.neighbours, [OUTSIDE; 4]);
    assert_eq!(found.hull, [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]);
    assert_eq!(hull_edges(3, &found.hull).len(), 6);
}

#[test]
fn no_cells_have_no_facets() {
    for n in [0, 5] {
        assert_eq!(adjacency(3, n, &[]).unwrap(), Adjacency::default());
        assert!(edges(2, n, &[]).unwrap().is_empty());
    }
}

#[test]
fn malformed_cells_are_refused() {
    let out = adjacency(3, 4, &[0, 1, 2, 4]).unwrap_err();
    assert_eq!(out, TopologyError::VertexOutOfRange { cell: 0, vertex: 4, points: 4 });
    let twice = adjacency(2, 4, &[0, 1, 2, 0, 3, 3]).unwrap_err();
    assert_eq!(twice, TopologyError::RepeatedVertex { cell: 1, vertex: 3 });
    assert_eq!(edges(2, 4, &[0, 1]).unwrap_err(), TopologyError::PartialCell { length: 2 });
    assert_eq!(edges(7, 4, &[]).unwrap_err(), TopologyError::Dimension { dimension: 7 });
    assert_eq!(adjacency(4, 4, &[]).unwrap_err(), TopologyError::Dimension { dimension: 4 });
}

#[test]
fn cells_that_are_no_manifold_are_refused() {
    let crowded = adjacency(2, 5, &[0, 1, 2, 0, 3, 1, 0, 1, 4]).unwrap_err();
    assert_eq!(crowded, TopologyError::CrowdedFacet { vertices: vec![0, 1], count: 3 });
    let same = adjacency(2, 4, &[0, 1, 2, 0, 1, 3]).unwrap_err();
    assert_eq!(same, TopologyError::SameSide { first: 0, second: 1, vertices: vec![0, 1] });
    // The same cell twice.
    assert!(adjacency(3, 4, &[0, 1, 2, 3, 0, 1, 2, 3]).is_err());
}
