//! The walk along the border finds what a look at all cells finds.

use glam::{DVec2, DVec3};
use septet_geometry::incremental::insertion_order;
use septet_geometry::separator::Separator;
use septet_protocol::ids::NodeId;
use septet_protocol::message::Child;

use super::*;
use crate::config::Stop;
use crate::tree::bounds;

/// A sphere; its ball is the interior.
fn sphere<P: Point>(centre: P, radius: f64) -> Separator<P> {
    let a = 0.5 / radius;
    let mut words = [0.0; 9];
    (words[3], words[4], words[8]) = (1.0, a, a * (centre.norm2() - radius * radius));
    for i in 0..P::DIM {
        words[5 + i] = -2.0 * a * centre.coord(i);
    }
    Separator::from_array(&words).unwrap()
}

fn shared<P: Point>(separator: Separator<P>, mine: usize, points: &[P]) -> Shared<P> {
    let side = |wanted: usize| points.iter().copied().filter(move |&x| separator.side(x) == side_of(wanted));
    let boxes = [bounds(side(0)), bounds(side(1))];
    let child = Child { population: 1, first: 1, ranks: 1, leaf: true };
    Shared {
        id: NodeId::ROOT,
        first: 1,
        ranks: 2,
        leader: 1,
        split: Split { separator, boxes },
        children: [child; 2],
        mine,
        goes_on: true,
        summaries: None,
    }
}

fn unit(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 53) as f64
}

/// Random points, a grid, points on spheres, two far clusters.
fn sets<P: Point>() -> Vec<Vec<P>> {
    let mut state = 7;
    let mut random = |map: &dyn Fn(P) -> P| -> Vec<P> {
        let mut draw = || P::from_coords(&[0; 3].map(|_: i32| unit(&mut state))[..P::DIM]);
        (0..600).map(|_| map(draw())).collect()
    };
    let half = P::splat(0.5);
    let on_sphere = |x: P| half + (x - half) * (0.4 / (x - half).norm2().sqrt());
    let clusters = |x: P| if x.coord(0) < 0.5 { x * 1e-3 } else { P::splat(0.7) + x * 1e-6 };
    let rounded =
        |x: P| P::from_coords(&[0, 1, 2].map(|i| (x.coord(i % P::DIM) * 9.0).floor() / 8.0)[..P::DIM]);
    let mut all = vec![random(&|x| x), random(&on_sphere), random(&clusters), random(&rounded)];
    for points in &mut all {
        points.sort_by(septet_geometry::point::lex_cmp);
        points.dedup();
    }
    all
}

fn walks_find_all<P: Point>() {
    let middle = P::splat(0.5);
    let mut aside = P::splat(0.3);
    aside.set_coord(0, 0.6);
    let splits = [
        vec![(sphere(middle, 0.35), 0)],
        vec![(sphere(middle, 0.35), 1)],
        vec![(sphere(middle, 0.1), 1), (sphere(aside, 0.2), 1)],
        vec![(Separator::plane(0, 0.45), 0), (sphere(aside, 0.15), 1)],
        vec![(sphere(middle, 0.45), 0), (Separator::plane(P::DIM - 1, 0.5), 1), (sphere(aside, 0.3), 1)],
    ];
    let mut compared = 0;
    for (points, split) in sets::<P>().iter().flat_map(|points| splits.iter().map(move |s| (points, s))) {
        let path: Vec<Shared<P>> = split.iter().map(|&(s, mine)| shared(s, mine, points)).collect();
        let is_home = |x: &&P| path.iter().all(|s| s.split.side(**x) == s.mine);
        let home: Vec<P> = points.iter().filter(is_home).copied().collect();
        let home: Vec<P> = insertion_order(&home).into_iter().map(|i| home[i as usize]).collect();
        let Some(piece) = Piece::new(&home, home.len() as u32, &[], &Stop::default()) else { continue };
        let clear = vec![0.0; path.len() * home.len()];
        let mut border =
            Border { path: &path, piece: &piece, positions: &home, home: home.len() as u32, clear };
        let (walked, walked_unusual) = border.survey();
        let (mut ordinary, mut unusual) = (Vec::new(), Unusual::of(border.home));
        piece.each_cell(|slot, cell| {
            border.look(slot, cell, &mut ordinary, &mut unusual);
        });
        let in_order = |cells: &[Outgoing<P::Cell>]| {
            let mut rows: Vec<_> = cells.iter().map(|out| (out.cell, out.levels)).collect();
            rows.sort_unstable();
            rows
        };
        assert_eq!(in_order(&walked), in_order(&ordinary));
        let sorted = |slots: &[u32]| {
            let mut slots = slots.to_vec();
            slots.sort_unstable();
            slots
        };
        assert_eq!(sorted(&walked_unusual.slots), sorted(&unusual.slots));
        assert_eq!(walked_unusual.levels, unusual.levels);
        compared += ordinary.len() + unusual.slots.len();
    }
    assert!(compared > 3000, "{compared} cells reach out");
}

#[test]
fn walks_in_space_find_all_that_reaches_out() {
    walks_find_all::<DVec3>();
}

#[test]
fn walks_in_the_plane_find_all_that_reaches_out() {
    walks_find_all::<DVec2>();
}
