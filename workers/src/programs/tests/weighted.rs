//! Regular triangulations by machines of several workers, compared with the sequential kernel.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use septet_geometry::hash::Draw;
use septet_geometry::incremental::Incremental;
use septet_geometry::point::{Point, Position, Vector};
use septet_geometry::site::Weighted;

use super::cells;
use crate::config::{Fault, GraphRules, Repair, Task, WorkerConfig};
use crate::hosts::host::{Job, Unwatched};
use crate::hosts::transport::{TransportKind, machine};
use crate::input::{Rows, Source};
use crate::partition::leader::Plan;
use crate::share::Share;

struct Whole<'a, P>(&'a [P]);

impl<P: Point> Source<P> for Whole<'_, P> {
    fn block(&self, block: u32, blocks: u32) -> Rows<P> {
        Rows::of_whole(0, self.0, &[], block, blocks)
    }
}

/// How the sites are triangulated.
#[derive(Clone, Copy, Debug)]
enum Way {
    Directly,
    /// By stars, which are repaired.
    ByStars(Repair),
    /// By stars, which rank 0 gathers.
    ByGathering,
}

const WAYS: [Way; 4] =
    [Way::Directly, Way::ByStars(Repair::Probe), Way::ByStars(Repair::Splay), Way::ByGathering];

fn run<P: Point>(sites: &[P], workers: u32, way: Way, fault: Option<Fault>) -> Vec<Share<P>> {
    let task = Task::Delaunay { skips_invalid: false };
    let plain = WorkerConfig { task, workers, fault, ..WorkerConfig::plain() };
    let config = match way {
        Way::Directly => WorkerConfig { counted: false, ..plain },
        Way::ByStars(repair) => {
            let graph = GraphRules { repair, ..plain.graph };
            WorkerConfig { counted: true, graph, ..plain }
        }
        Way::ByGathering => {
            let graph = GraphRules { exchange_cap: Some(0), ..plain.graph };
            WorkerConfig { counted: true, graph, ..plain }
        }
    };
    let job = Job { config: Arc::new(config), source: &Whole(sites), plan: &Plan::new() };
    machine::<P>(TransportKind::Channel { threads: 2 })
        .run(&job, &mut Unwatched)
        .expect("a machine without faults")
}

/// Random sites or nodes of a grid, with weights of up to `spread` squared distances of neighbours, or one heavy site.
fn sites<P: Position>(n: usize, is_grid: bool, spread: Option<f64>) -> Vec<Weighted<P>> {
    let mut draw = Draw::new(n as u64);
    let side = (n as f64).powf(1.0 / P::DIM as f64).ceil();
    let mut found = BTreeSet::new();
    let mut all = Vec::new();
    while all.len() < n {
        let mut x = draw.point::<P>() * side;
        if is_grid {
            for i in 0..P::DIM {
                x.set_coord(i, x.coord(i).floor());
            }
        }
        let key: Vec<u64> = (0..P::DIM).map(|i| x.coord(i).to_bits()).collect();
        if found.insert(key) || (is_grid && found.len() > n / 3) {
            let heavy = if all.len() == n / 2 { side * side } else { 0.0 };
            all.push(Weighted::new(x, spread.map_or(heavy, |spread| spread * draw.unit())));
        }
    }
    all
}

/// Returns the rows of the kernel, which has no coincident sites, as sorted ids; and the hidden rows.
fn expected<P: Position>(sites: &[Weighted<P>]) -> (Vec<Vec<u64>>, BTreeSet<u64>) {
    let place = |i: &usize| (0..P::DIM).map(|k| sites[*i].coord(k).to_bits()).collect::<Vec<u64>>();
    let mut order: Vec<usize> = (0..sites.len()).collect();
    order.sort_by(|a, b| {
        let heavier = sites[*b].weight().total_cmp(&sites[*a].weight());
        place(a).cmp(&place(b)).then(heavier).then(a.cmp(b))
    });
    let mut hidden = BTreeSet::new();
    let mut kept = Vec::new();
    for equal in order.chunk_by(|a, b| place(a) == place(b)) {
        kept.push(equal[0]);
        let is_lighter = |&&i: &&usize| sites[i].weight() < sites[equal[0]].weight();
        hidden.extend(equal.iter().filter(is_lighter).map(|&i| i as u64));
    }
    let dt = Incremental::new(kept.iter().map(|&i| sites[i]).collect()).unwrap();
    hidden.extend((0u32..).zip(&kept).filter(|(v, _)| dt.is_hidden(*v)).map(|(_, &i)| i as u64));
    let row = |cell: <Weighted<P> as Point>::Cell| {
        let mut row: Vec<u64> = cell.as_ref().iter().map(|&v| kept[v as usize] as u64).collect();
        row.sort_unstable();
        row
    };
    let mut rows: Vec<Vec<u64>> = dt.cells().map(row).collect();
    rows.sort_unstable();
    (rows, hidden)
}

fn machines_agree_with_the_kernel<P: Position>(n: usize) {
    let mut covered = 0;
    for (set, spread) in [Some(0.0), Some(0.3), Some(3.0), None].into_iter().enumerate() {
        for is_grid in [false, true] {
            let sites = sites::<P>(n, is_grid, spread);
            let (rows, hidden) = expected(&sites);
            for workers in [1, 2, 3, 16] {
                let way = WAYS[(workers as usize + set) % WAYS.len()];
                let what =
                    format!("{} dimensions, grid {is_grid}, {spread:?}, {workers} workers, {way:?}", P::DIM);
                let shares = run(&sites, workers, way, None);
                assert!(cells(&shares) == rows, "{what}");
                let lists =
                    shares.iter().flat_map(|share| share.loaded.hidden.iter().chain(&share.piece.hidden));
                let found: BTreeSet<u64> = lists.copied().collect();
                assert!(found == hidden, "{what}: {} of {} hidden", found.len(), hidden.len());
                let counted = shares[0].loaded.sites.hidden + shares[0].certified.sites.hidden;
                assert_eq!(counted, hidden.len() as u64, "{what}");
                covered += shares[0].certified.sites.hidden;
            }
        }
    }
    assert!(covered > 100, "{covered} sites are hidden");
}

#[test]
fn machines_agree_with_the_kernel_in_the_plane() {
    machines_agree_with_the_kernel::<DVec2>(1500);
}

#[test]
fn machines_agree_with_the_kernel_in_space() {
    machines_agree_with_the_kernel::<DVec3>(1500);
}

/// A star that is spoilt in each pass is found.
#[test]
fn a_spoilt_star_fails_the_certificate() {
    let sites = sites::<DVec2>(600, false, Some(1.0));
    for way in WAYS {
        let shares = run(&sites, 3, way, Some(Fault::SpoilStar { rank: 2 }));
        let merged = shares[0].certified.totals.merged;
        assert!(merged.disagreements > 0, "{way:?}: {merged:?}");
        assert!(shares.iter().all(|share| share.piece.rows.is_empty()));
    }
}
