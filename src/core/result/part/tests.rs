//! A small triangulation of three workers, one of which holds no points.

use super::*;

const COORDINATES: [f64; 12] = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.5];
const CELLS: [u64; 9] = [0, 1, 2, 0, 2, 3, 1, 5, 2];
/// Point 4 coincides with point 0, so it is not a vertex.
const OWNERS: [u32; 6] = [3, 1, 1, 3, 0, 1];

fn mesh(shares: Option<Shares<'_>>) -> MeshView<'_> {
    MeshView {
        dimension: 2,
        coordinates: &COORDINATES,
        cells: &CELLS,
        owner: Some(&[3, 3, 1]),
        owning_leaf: None,
        shares,
        labels: None,
    }
}

#[test]
fn parts_have_owned_points_and_cells_first() {
    let division = Division::new(mesh(Some(Shares { workers: 3, point_owner: &OWNERS }))).unwrap();
    assert_eq!(division.workers(), 3);
    let first = Part {
        dimension: 2,
        owned_points: 3,
        owned_cells: 1,
        point_ids: vec![1, 2, 5, 0, 3],
        coordinates: vec![1.0, 0.0, 1.0, 1.0, 2.0, 0.5, 0.0, 0.0, 0.0, 1.0],
        cells: vec![0, 2, 1, 3, 0, 1, 3, 1, 4],
        cell_ids: vec![0, 1, 2],
        owner: Some(vec![1, 3, 3]),
        owning_leaf: None,
    };
    assert_eq!(division.part(1), first);
    assert_eq!(division.part(2), Part { dimension: 2, owner: Some(Vec::new()), ..Part::default() });
    let last = Part {
        dimension: 2,
        owned_points: 2,
        owned_cells: 2,
        point_ids: vec![0, 3, 1, 2],
        coordinates: vec![0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0],
        cells: vec![0, 2, 3, 0, 3, 1],
        cell_ids: vec![1, 2],
        owner: Some(vec![3, 3]),
        owning_leaf: None,
    };
    assert_eq!(division.part(3), last);
}

#[test]
fn shares_that_contradict_the_mesh_are_refused() {
    let refused = |shares| Division::new(mesh(shares)).err();
    assert_eq!(refused(None), Some(DivisionError::NoShares));
    let shares = |workers, point_owner| Some(Shares { workers, point_owner });
    let few = DivisionError::Length { owners: 5, points: 6 };
    assert_eq!(refused(shares(3, &OWNERS[1..])), Some(few));
    let unknown = DivisionError::Worker { point: 0, owner: 3, workers: 2 };
    assert_eq!(refused(shares(2, &OWNERS)), Some(unknown));
    let free = DivisionError::NoWorker { point: 5 };
    assert_eq!(refused(shares(3, &[3, 1, 1, 3, 0, 0])), Some(free));
}
