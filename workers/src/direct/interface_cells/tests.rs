//! Tests that the filters do not skip a cell that must be sent.

use std::collections::HashMap;

use glam::{DVec2, DVec3};
use septet_geometry::hash::Draw;
use septet_geometry::incremental::insertion_order;
use septet_geometry::separator::Separator;
use septet_protocol::ids::NodeId;
use septet_protocol::message::Child;

use super::*;
use crate::config::Stop;
use crate::state::subdomain::Group;
use crate::state::tree::bounds;

/// Returns a sphere whose interior is its ball.
pub(in crate::direct) fn sphere<P: Point>(centre: P, radius: f64) -> Separator<P> {
    let a = 0.5 / radius;
    let mut words = [0.0; 9];
    (words[3], words[4], words[8]) = (1.0, a, a * (centre.norm2() - radius * radius));
    for i in 0..P::DIM {
        words[5 + i] = -2.0 * a * centre.coord(i);
    }
    Separator::from_array(&words).unwrap()
}

pub(in crate::direct) fn shared<P: Point>(separator: Separator<P>, mine: usize, points: &[P]) -> Shared<P> {
    let side = |wanted: usize| points.iter().copied().filter(move |&x| separator.side(x) == side_of(wanted));
    let boxes = [bounds(side(0)), bounds(side(1))];
    let child = Child { population: 1, first: 1, ranks: 1, leaf: true };
    let group = Group { node: NodeId::ROOT, leader: 1, child: Child { ranks: 2, ..child } };
    Shared::new(group, Split::new(separator, boxes), [child; 2], mine, 1)
}

/// Returns random points, points on a sphere, two distant clusters, and points of a grid.
pub(in crate::direct) fn sets<P: Point>() -> Vec<Vec<P>> {
    let mut draw = Draw::new(7);
    let mut random = |map: &dyn Fn(P) -> P| -> Vec<P> { (0..600).map(|_| map(draw.point())).collect() };
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

/// Returns a bit for each vertex whose halo ball does not contain the conflict region, enlarged by a factor.
fn beyond<P: Point>(region: &ConflictRegion<P>, larger: f64, cell: &P::Cell, margins: &[Margin]) -> u8 {
    let is_inside = |&v: &u32| match *region {
        _ if v as usize >= margins.len() => true,
        ConflictRegion::Ball { radius, .. } => 2.0 * radius * larger <= margins[v as usize].sent,
        _ => false,
    };
    cell.as_ref().iter().enumerate().fold(0, |sent, (i, v)| sent | u8::from(!is_inside(v)) << i)
}

/// Compares the scan with a test of the conflict region of every cell. Returns the number of outgoing cells.
fn compare<P: Point>(
    path: &[Shared<P>],
    triangulation: &SubdomainTriangulation<P>,
    points: &[P],
    margins: &[Margin],
) -> usize {
    let mut scanned = Vec::new();
    InterfaceCells::new(path, triangulation, points, margins).scan(|out| scanned.push(out));
    let found: HashMap<P::Cell, (u64, u8)> =
        scanned.iter().map(|out| (out.cell, (out.levels, out.sent))).collect();
    assert_eq!(found.len(), scanned.len());
    let mut number = 0;
    triangulation.each_cell(|_, cell| {
        let region =
            crate::direct::subdomain_triangulation::conflict_region::<P>(cell, 0.0, |v| points[v as usize]);
        let met = |s: &Shared<P>| reaches(s.split(), &region, 1 - s.mine());
        let levels = (0..path.len()).fold(0, |levels, i| levels | u64::from(met(&path[i])) << i);
        // The kernel's sphere may be slightly larger, never smaller.
        let [least, most] = [1.0 - 1e-9, 1.01].map(|larger| beyond(&region, larger, cell, margins));
        let (at, sent) = found.get(cell).copied().unwrap_or((0, 0));
        assert_eq!(sent & !most, 0);
        if levels != 0 && least != 0 {
            assert_eq!((at & levels, sent & least), (levels, least));
            number += 1;
        }
    });
    assert!(scanned.len() <= number + number / 10 + 3, "{} for {number}", scanned.len());
    number
}

fn all_are_found<P: Point>() {
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
        let is_owned = |x: &&P| path.iter().all(|s| s.split().side(**x) == s.mine());
        let owned: Vec<P> = points.iter().filter(is_owned).copied().collect();
        let owned: Vec<P> = insertion_order(&owned).into_iter().map(|i| owned[i as usize]).collect();
        // Every ninth point of the other workers is a ghost.
        let ghosts: Vec<P> = points.iter().filter(|x| !is_owned(x)).copied().step_by(9).collect();
        let all: Vec<P> = owned.iter().chain(&ghosts).copied().collect();
        let others: Vec<u32> = (owned.len() as u32..all.len() as u32).collect();
        for others in [&[], &others[..]] {
            let Some(triangulation) =
                SubdomainTriangulation::new(&all, (owned.len() as u32, 0.0), others, 0, &Stop::default())
            else {
                continue;
            };
            let mut draw = Draw::new(5);
            for most in [0.0, 0.3, 1.5] {
                let margin = |x: &P| {
                    let clear = path.iter().map(|s| s.split().separator().clearance(*x));
                    let free = clear.fold(f64::INFINITY, f64::min);
                    // Halo balls are empty, small or large. The free radius of some points is 0.
                    let sent = most * draw.unit();
                    Margin { free: if sent > most / 2.0 { free } else { 0.0 }, sent }
                };
                let layer: Vec<Margin> = owned.iter().map(margin).collect();
                compared += compare(&path, &triangulation, &all, &layer);
            }
        }
    }
    assert!(compared > 3000, "{compared} outgoing cells");
}

#[test]
fn all_outgoing_cells_are_found_in_space() {
    all_are_found::<DVec3>();
}

#[test]
fn all_outgoing_cells_are_found_in_the_plane() {
    all_are_found::<DVec2>();
}
