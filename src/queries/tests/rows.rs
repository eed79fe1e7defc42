use septet_core::{Spec, simulate};
use septet_geometry::coordinates::Coordinates;

use super::{Draw, both, corners, made, orientation, run, whole_sets};
use crate::{Dimension, NONE, QueryError, Tessellation};

both!(rows_of_the_plane, rows_of_space, rows);

fn rows<P: Dimension + Coordinates>() {
    for points in whole_sets::<P>() {
        for workers in [1, 3] {
            let run = run(&points, workers);
            let t = Tessellation::new(&points, &run).unwrap();
            let flat = t.cells().iter().flat_map(|cell| cell.as_ref().iter().map(|&v| u64::from(v)));
            assert!(flat.eq(run.cells().iter().copied()));
            let mut hull = 0;
            for (cell, next) in t.neighbours().iter().enumerate() {
                for (slot, &next) in next.as_ref().iter().enumerate() {
                    hull += u64::from(next == NONE);
                    if next != NONE {
                        let back = t.neighbours()[next as usize].as_ref();
                        let back = back.iter().position(|&n| n as usize == cell).unwrap();
                        let facet = |cell: usize, slot: usize| {
                            let mut facet = t.cells()[cell].as_ref().to_vec();
                            facet.remove(slot);
                            facet.sort_unstable();
                            facet
                        };
                        assert_eq!(facet(cell, slot), facet(next as usize, back));
                    }
                }
            }
            assert_eq!(hull, run.hull_facets);
            // Cells without neighbours find them by their facets.
            let counted = simulate(&points, &Spec::default()).unwrap();
            assert!(!counted.shares[0].has_neighbours());
            assert_eq!(Tessellation::new(&points, &counted).unwrap().neighbours(), t.neighbours());
        }
    }
}

both!(hull_of_the_plane, hull_of_space, hull);

fn hull<P: Dimension + Coordinates>() {
    for points in whole_sets::<P>() {
        let t = made(&points);
        let hull = t.hull();
        assert_eq!(hull.len() as u64, run(&points, 1).hull_facets);
        assert!(hull.is_sorted());
        for facet in &hull {
            let mut cell: Vec<P> = facet.as_ref().iter().map(|&v| t.point(v)).collect();
            for &p in &points {
                cell.push(p);
                let side = orientation(&cell);
                assert!(if P::DIM == 2 { side >= 0 } else { side <= 0 });
                cell.pop();
            }
        }
        let around = t.vertex_neighbours();
        assert_eq!(around.len(), points.len());
        for v in 0..points.len() as u32 {
            let with = t.cells().iter().filter(|cell| cell.as_ref().contains(&v));
            let mut expected: Vec<u32> =
                with.flat_map(|cell| cell.as_ref().to_vec()).filter(|&w| w != v).collect();
            expected.sort_unstable();
            expected.dedup();
            assert_eq!(around.row(v as usize), expected);
        }
    }
}

both!(cells_of_the_plane, cells_of_space, cells);

fn cells<P: Dimension + Coordinates>() {
    for points in whole_sets::<P>() {
        let t = made(&points);
        let unit = if P::DIM == 2 { 8.0 } else { 48.0 };
        for (cell, volume) in t.cell_volumes().into_iter().enumerate() {
            let exact = orientation(&corners(&t, cell)) as f64 / unit;
            assert!((volume - exact).abs() <= 4e-15 * exact, "{volume} {exact}");
            assert!((t.shape(cell as u32).volume - exact).abs() <= 1e-12 * exact);
        }
        assert_eq!(t.shapes().least_angles.total(), t.cells().len() as u64);
        let cells = t.vertex_cells();
        for (v, &cell) in cells.iter().enumerate() {
            let has = |cell: &P::Cell| cell.as_ref().iter().any(|&w| points[w as usize] == points[v]);
            assert_eq!(cell, t.cells().iter().position(has).unwrap() as u32);
        }
    }
}

#[test]
fn other_runs_are_refused() {
    let points: Vec<glam::DVec2> = Draw(1).uniform(20);
    let run = run(&points, 1);
    let refused = Tessellation::new(&points[1..], &run).err();
    assert_eq!(refused, Some(QueryError::OtherPoints { given: 19, run: 20 }));
    let sites: Vec<_> = points.iter().map(|&p| septet_geometry::site::Weighted::new(p, 0.1)).collect();
    let weighted = septet_core::triangulate(&sites, &Spec::default()).unwrap();
    assert_eq!(Tessellation::new(&points, &weighted).err(), Some(QueryError::OtherRun));
}

#[test]
fn flat_sets_have_no_cells() {
    let line: Vec<glam::DVec3> = (0..9).map(|i| glam::DVec3::splat(f64::from(i % 7))).collect();
    let t = made(&line);
    assert_eq!((t.dimension(), t.cells().len(), t.hull().len()), (1, 0, 0));
    assert_eq!(t.duplicates(), [[7, 0], [8, 1]]);
    assert_eq!(t.locate(&line[..2]), [NONE; 2]);
    assert_eq!(t.nearest(&[glam::DVec3::new(2.4, 2.4, 2.9), glam::DVec3::splat(0.5)]), [3, 0]);
    assert_eq!(t.voronoi_volumes(), Err(QueryError::Flat { dimension: 1 }));
    let none = made::<glam::DVec2>(&[]);
    assert_eq!(
        (none.nearest(&[glam::DVec2::ONE]), none.is_empty(), none.dimension()),
        (vec![NONE], true, -1)
    );
    assert_eq!(none.alpha_filtration().facets, none.alpha_shape(1.0).unwrap().boundary);
}
