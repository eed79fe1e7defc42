//! The insertion baseline compared with the sequential kernel, and consistency of its counts.

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::*;
use crate::incremental::Incremental;

fn sorted<C: Simplex>(cells: impl Iterator<Item = C>) -> Vec<C> {
    let mut cells: Vec<C> = cells.collect();
    for cell in &mut cells {
        cell.as_mut().sort_unstable();
    }
    cells.sort_unstable();
    cells
}

/// The cells equal those of the kernel and are positively oriented, and the counts are consistent.
fn check<P: Point>(points: &[P], seed: u64) -> Dependence<P> {
    let kernel = Incremental::new(points.to_vec()).unwrap();
    let baseline = Dependence::new(points, seed).unwrap();
    assert!(sorted(baseline.cells.iter().copied()) == sorted(kernel.cells()), "other cells");
    for cell in &baseline.cells {
        let corners: Vec<P> = cell.as_ref().iter().map(|&v| points[v as usize]).collect();
        assert_eq!(orientation(&corners), Sign::Positive);
    }
    let infinite = kernel.complex().live_cells().filter(|&c| kernel.complex().infinite_slot(c).is_some());
    assert_eq!(baseline.hull_facets, infinite.count() as u64);
    // A cell is created in the round after its later old cell was created. So the longest chain is the number of rounds
    // that create cells.
    let making = baseline.rounds.iter().filter(|r| r.cells > 0).count() as u64;
    assert_eq!(baseline.clock.chain, making);
    let total = baseline.total();
    assert!(total.cells >= baseline.cells.len() as u64 + baseline.hull_facets);
    assert!(baseline.clock.hashed <= baseline.clock.steps && baseline.clock.steps <= baseline.clock.log_scan);
    assert_eq!(baseline.rounds.last().map(|r| r.cells), Some(0));
    // Rounds wait for their slowest cell; chains do not. Both contain the steps that all cells of a round share.
    assert!(baseline.clock.steps <= total.steps && total.tests <= total.work);
    assert!(baseline.brent(1) == total.work && baseline.brent(u64::MAX) == total.steps);
    baseline
}

fn random(n: u64, seed: u64) -> impl Iterator<Item = f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..n).map(move |_| (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64)
}

fn plane(n: u64, seed: u64) -> Vec<DVec2> {
    let c: Vec<f64> = random(2 * n, seed).collect();
    c.chunks(2).map(DVec2::from_slice).collect()
}

fn space(n: u64, seed: u64) -> Vec<DVec3> {
    let c: Vec<f64> = random(3 * n, seed).collect();
    c.chunks(3).map(DVec3::from_slice).collect()
}

#[test]
fn random_points() {
    for seed in 0..4 {
        check(&plane(1500, seed), seed);
        check(&space(500, seed), seed);
    }
}

#[test]
fn ties_of_every_kind() {
    let grid: Vec<DVec3> =
        (0..343u32).map(|i| DVec3::new((i % 7).into(), (i / 7 % 7).into(), (i / 49).into())).collect();
    let flat: Vec<DVec2> = (0..400u32).map(|i| DVec2::new((i % 20).into(), (i / 20).into())).collect();
    // Most of the first points of the order are coplanar.
    let mut sheet: Vec<DVec3> = flat.iter().map(|p| p.extend(0.0)).collect();
    sheet.push(DVec3::new(3.5, 4.25, 1.0));
    for seed in 0..3 {
        check(&grid, seed);
        check(&flat, seed);
        check(&sheet, seed);
    }
}

#[test]
fn one_simplex_and_less() {
    let simplex = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let baseline = check(&simplex, 1);
    assert_eq!((baseline.cells.len(), baseline.hull_facets, baseline.clock.chain), (1, 4, 1));
    let flat = |dimension| IncrementalError::Flat { dimension };
    assert_eq!(Dependence::new(&simplex[..3], 1).unwrap_err(), flat(2));
    assert_eq!(Dependence::<DVec2>::new(&[], 1).unwrap_err(), flat(-1));
    let twice = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::X];
    let coincident = IncrementalError::Coincident { point: 3, vertex: 1 };
    assert_eq!(Dependence::new(&twice, 1).unwrap_err(), coincident);
    let infinite = [DVec2::ZERO, DVec2::new(f64::NAN, 0.0)];
    assert_eq!(Dependence::new(&infinite, 1).unwrap_err(), IncrementalError::NotFinite { point: 1 });
}

#[test]
fn counts_are_functions_of_the_set_and_the_seed() {
    let points = space(300, 7);
    let reversed: Vec<DVec3> = points.iter().rev().copied().collect();
    let (a, b) = (Dependence::new(&points, 3).unwrap(), Dependence::new(&reversed, 3).unwrap());
    assert_eq!((a.clock, &a.rounds), (b.clock, &b.rounds));
    let other = Dependence::new(&points, 4).unwrap();
    assert_ne!(a.rounds, other.rounds);
}

/// The longest chain for 2^k points grows by about the same amount with each doubling, far below any power of n. Sets
/// of 2^6 to 2^13 points in the plane have chains of 20 to 60 cells.
#[test]
fn the_chain_is_logarithmic() {
    for k in [6, 9, 12] {
        let chain = check(&plane(1 << k, 5), 5).clock.chain;
        println!("2^{k} points: a chain of {chain}");
        assert!(chain <= 6 * k, "2^{k} points: a chain of {chain}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn small_grids(cells in prop::collection::btree_set((0..4u8, 0..4u8, 0..3u8), 4..30), seed in 0..99u64) {
        let points: Vec<DVec3> =
            cells.iter().map(|&(x, y, z)| DVec3::new(x.into(), y.into(), z.into())).collect();
        match Incremental::new(points.clone()) {
            Ok(_) => drop(check(&points, seed)),
            Err(e) => prop_assert_eq!(Dependence::new(&points, seed).unwrap_err(), e),
        }
    }
}

/// The owners of points change the messages, and nothing else.
#[test]
fn messages_go_between_owners() {
    let mut draw = crate::hash::Draw::new(4);
    let points: Vec<glam::DVec3> = (0..400).map(|_| draw.point()).collect();
    let alone = Dependence::new(&points, 3).unwrap();
    let owned = |owners: u32| {
        let slab = |p: &glam::DVec3| (p.x * f64::from(owners)) as u32;
        Dependence::owned(&points, 3, &points.iter().map(slab).collect::<Vec<_>>()).unwrap()
    };
    assert_eq!((alone.traffic, owned(1).traffic), (Traffic::default(), Traffic::default()));
    let mut bytes = 0;
    for owners in [2, 4, 16] {
        let made = owned(owners);
        assert_eq!((&made.cells, &made.rounds, made.clock), (&alone.cells, &alone.rounds, alone.clock));
        let Traffic { rounds, messages, .. } = made.traffic;
        assert!(rounds <= 3 * made.rounds.len() as u64);
        assert!(messages >= rounds && messages <= rounds * u64::from(owners * (owners - 1)));
        assert!(made.traffic.bytes > bytes);
        bytes = made.traffic.bytes;
    }
}
