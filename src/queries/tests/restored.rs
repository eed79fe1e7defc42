//! Triangulations from rows, and planted faults in them.

use super::*;
use crate::{QueryError, RowFault};

fn rows_restore_a_triangulation<P: Dimension + Coordinates>() {
    let mut draw = Draw(8);
    let mut sets = whole_sets::<P>();
    sets.push(draw.uniform(300));
    // On a line, one point, none.
    sets.extend([vec![P::splat(1.0), P::splat(2.0), P::splat(1.0)], vec![P::splat(-0.0)], Vec::new()]);
    for points in sets {
        let t = made(&points);
        let again = Tessellation::of_cells(&points, t.cells()).unwrap();
        assert_eq!(again.neighbours(), t.neighbours());
        assert_eq!((again.duplicates(), again.dimension()), (t.duplicates(), t.dimension()));
        assert_eq!((again.vertex_cells(), again.points()), (t.vertex_cells(), t.points()));
        let queries = draw.uniform::<P>(50);
        assert_eq!(
            (again.locate(&queries), again.nearest(&queries)),
            (t.locate(&queries), t.nearest(&queries))
        );
    }
}
both!(rows_restore_triangles, rows_restore_tetrahedra, rows_restore_a_triangulation);

fn fault<P: Dimension>(points: &[P], cells: &[P::Cell]) -> RowFault {
    match Tessellation::of_cells(points, cells) {
        Err(QueryError::Row { fault, .. }) => fault,
        other => panic!("{:?}", other.err()),
    }
}

fn faults_are_found<P: Dimension + Coordinates>() {
    let mut draw = Draw(9);
    let points = draw.uniform::<P>(80);
    let t = made(&points);
    let cells = t.cells().to_vec();
    let changed = |change: &dyn Fn(&mut Vec<P::Cell>)| {
        let mut cells = cells.clone();
        change(&mut cells);
        fault(&points, &cells)
    };
    assert_eq!(changed(&|cells| cells[5].as_mut()[0] = 80), RowFault::NoPoint);
    assert_eq!(changed(&|cells| cells.swap(3, 4)), RowFault::Order);
    assert_eq!(changed(&|cells| cells[7].as_mut().rotate_left(1)), RowFault::Order);
    let turned = |at: usize| {
        let mut row = cells[at];
        row.as_mut().swap(P::DIM - 1, P::DIM);
        row
    };
    let keeps_order = |&at: &usize| cells[at - 1] < turned(at) && turned(at) < cells[at + 1];
    let at = (1..cells.len() - 1).find(keeps_order).unwrap();
    assert_eq!(changed(&|cells| cells[at] = turned(at)), RowFault::Orientation);
    let mut broken = points.clone();
    broken[cells[0].as_ref()[0] as usize] = P::splat(f64::INFINITY);
    assert_eq!(fault(&broken, &cells), RowFault::NotFinite);
    // Any missing cell leaves a gap, or a vertex without cells.
    for missing in 0..cells.len() {
        let mut fewer = cells.clone();
        fewer.remove(missing);
        match Tessellation::of_cells(&points, &fewer) {
            Err(QueryError::Row { fault: RowFault::Gap, .. } | QueryError::Unused { .. }) => {}
            other => panic!("{missing}: {:?}", other.err()),
        }
    }
    // Other points under the same cells.
    let others = draw.uniform::<P>(80);
    assert!(matches!(
        fault(&others, &cells),
        RowFault::Orientation | RowFault::NotDelaunay | RowFault::Facet
    ));
    // A new point without a cell, and a coincident one.
    let mut more = points.clone();
    more.push(P::splat(0.5));
    assert_eq!(Tessellation::of_cells(&more, &cells).unwrap_err(), QueryError::Unused { point: 80 });
    more[80] = points[3];
    assert_eq!(Tessellation::of_cells(&more, &cells).unwrap().duplicates(), [[80, 3]]);
    assert_eq!(Tessellation::of_cells(&points, &[]).unwrap_err(), QueryError::Unused { point: 0 });
    // Two copies of a triangulation beside each other.
    let mut twice = points.clone();
    twice.extend(points.iter().map(|&p| p + P::splat(9.0)));
    let moved = cells.iter().map(|row| {
        let mut row = *row;
        row.as_mut().iter_mut().for_each(|v| *v += 80);
        row
    });
    let both: Vec<P::Cell> = cells.iter().copied().chain(moved).collect();
    assert_eq!(fault(&twice, &both), RowFault::Gap);
}
both!(faults_in_triangles_are_found, faults_in_tetrahedra_are_found, faults_are_found);

/// The other diagonal of a quadrilateral.
#[test]
fn a_flipped_edge_is_not_delaunay() {
    let points = [[0.0, 0.0], [2.0, -1.0], [4.0, 0.0], [2.0, 1.0]].map(glam::DVec2::from);
    let t = made(&points);
    assert_eq!(t.cells(), [[0, 1, 3], [1, 2, 3]]);
    assert_eq!(fault(&points, &[[0, 1, 2], [0, 2, 3]]), RowFault::NotDelaunay);
    // Cells on the same side of an edge.
    let folded = [[0.0, 0.0], [4.0, 0.0], [2.0, 1.0], [2.0, 3.0]].map(glam::DVec2::from);
    assert_eq!(fault(&folded, &[[0, 1, 2], [0, 1, 3]]), RowFault::Facet);
}
