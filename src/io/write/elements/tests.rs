//! Tests of elements, groups and sides.

use septet_common::samples::{kuhn, squares};

use super::*;
use crate::write::options::Order;

#[test]
fn groups_have_positive_tags_and_names() {
    let groups = Groups::of(Kind::Marker, &[3, -1, 0, 3, i64::MAX, 7]);
    let found: Vec<(String, u32)> = (0..groups.len()).map(|at| (groups.name(at), groups.tag(at))).collect();
    let expected = [
        ("marker--1", 8),
        ("marker-0", 9),
        ("marker-3", 3),
        ("marker-7", 7),
        ("marker-9223372036854775807", 10),
    ];
    assert_eq!(found, expected.map(|(name, tag)| (name.to_owned(), tag)));
    assert_eq!((groups.position(3), groups.position(-1)), (2, 0));
}

#[test]
fn regions_are_numbered_by_whole_attributes() {
    let labels = |attributes: &[f64]| Labels {
        regions: vec![1, 2, 2],
        attributes: attributes.to_vec(),
        ..Labels::default()
    };
    assert_eq!(region_numbers(&labels(&[10.0, -3.0, -3.0])), [10, -3, -3]);
    assert_eq!(region_numbers(&labels(&[10.0, 2.5, 2.5])), [1, 2, 2]);
    assert_eq!(region_numbers(&labels(&[1e10, 2.0, 2.0])), [1, 2, 2]);
}

#[test]
fn midpoints_follow_the_corners_in_the_order_of_vtk() {
    for (sample, width) in [(kuhn(2), 10), (squares(3), 6)] {
        let view = sample.view();
        let elements = Elements::of(&view, Order::Two).unwrap();
        let points = view.point_count();
        assert_eq!(elements.node_count(), points + elements.midpoints.len());
        assert!(elements.midpoints.is_sorted());
        assert_eq!((elements.cells.width, super::width(view.dimension, Order::Two)), (width, width));
        for block in [&elements.cells, &elements.faces] {
            for row in 0..block.len() {
                let corners: Vec<[f64; 3]> =
                    block.corners(row).iter().map(|&v| elements.place(v as usize)).collect();
                let nodes = &block.row(row)[corners.len()..];
                for (node, [i, j]) in nodes.iter().zip(EDGES) {
                    let middle: [f64; 3] =
                        std::array::from_fn(|k| f64::midpoint(corners[i][k], corners[j][k]));
                    assert_eq!(elements.place(*node as usize), middle);
                }
            }
        }
    }
}

#[test]
fn every_face_has_the_side_of_a_cell() {
    for sample in [kuhn(2), squares(3)] {
        let view = sample.view();
        let elements = Elements::of(&view, Order::One).unwrap();
        let sides = elements.sides();
        assert_eq!(sides.len(), elements.faces.len());
        for (row, side) in sides.into_iter().enumerate() {
            let Side { cell, opposite } = side.unwrap();
            let cell = elements.cells.corners(cell);
            let mut rest: Vec<u64> = cell.iter().copied().filter(|v| *v != cell[opposite]).collect();
            let mut face = elements.faces.corners(row).to_vec();
            rest.sort_unstable();
            face.sort_unstable();
            assert_eq!(rest, face);
        }
    }
}
