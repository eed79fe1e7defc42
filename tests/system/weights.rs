//! Points with weights: cells, hidden points and duplicates agree with a search by definition, and with CGAL.
//!
//! `SEPTET_SETS=10000 cargo test --release --test system weights::` searches 10,000 sets (default: 300). `SEPTET_SITES` is the
//! number of sites of each comparison with CGAL (default: 20,000).
//!
//! The search uses integers only, and no code of septet. It tests every simplex of sites against every site.

use std::cmp::{Ordering, Reverse};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::process::Command;

use glam::{DVec2, DVec3};
use septet_core::spec::{Repair, Spec, Workers};
use septet_core::{Outcome, simulate, triangulate};
use septet_geometry::point::{Point, Position};
use septet_geometry::site::Weighted;

use super::oracle::cgal;
use crate::common::sets::Draw;
use crate::common::transports::each_transport;
use crate::common::{assert_verified, with_workers, within};

/// Seconds after which a run of a few points has hung.
const PATIENCE: u64 = 60;

/// A site: coordinates of at most `2^20`, and a weight of at most `2^42`.
pub(super) type Site<const D: usize> = ([i64; D], i64);

/// The regular triangulation of some sites, by definition.
#[derive(Debug, PartialEq, Eq)]
struct Expected {
    /// The cells as sorted rows.
    cells: BTreeSet<Vec<u64>>,
    hidden: Vec<u64>,
    /// Pairs of a row and the first row of the same site.
    duplicates: Vec<(u64, u64)>,
}

/// Returns twice the area or six times the volume of a simplex, with its sign.
pub(super) fn volume<const D: usize>(simplex: &[&Site<D>]) -> i128 {
    let edge = |i: usize, k: usize| i128::from(simplex[i].0[k] - simplex[0].0[k]);
    let minor = |i: usize, j: usize, k: usize, l: usize| edge(i, k) * edge(j, l) - edge(i, l) * edge(j, k);
    match D {
        2 => minor(1, 2, 0, 1),
        3 => edge(1, 0) * minor(2, 3, 1, 2) - edge(1, 1) * minor(2, 3, 0, 2) + edge(1, 2) * minor(2, 3, 0, 1),
        _ => unreachable!("only the plane and space"),
    }
}

/// Compares the lift of a site with the plane through the lifts of a simplex that is not flat: greater if it is above, first
/// without and then with the perturbation.
///
/// The height of the site over the plane is a sum over the sites and the corners: height times volume of the simplex of
/// all others, with alternating signs. An infinitesimal is added to each height, larger by orders of magnitude for larger
/// positions. So the largest position with a volume decides.
pub(super) fn above<const D: usize>(simplex: &[&Site<D>], site: &Site<D>) -> [Ordering; 2] {
    let mut all = simplex.to_vec();
    all.push(site);
    let mut terms: Vec<([i64; D], i128, i128)> = Vec::new();
    for (i, &&(place, weight)) in all.iter().enumerate() {
        let others: Vec<&Site<D>> =
            all.iter().enumerate().filter(|&(j, _)| j != i).map(|(_, s)| *s).collect();
        let sign = if (i + D).is_multiple_of(2) { -1 } else { 1 };
        let height = place.iter().map(|&x| i128::from(x) * i128::from(x)).sum::<i128>() - i128::from(weight);
        terms.push((place, sign * volume(&others), height));
    }
    let turned = volume(simplex).signum();
    let unperturbed = terms.iter().map(|(_, volume, height)| volume * height).sum::<i128>() * turned;
    terms.sort_unstable_by_key(|term| Reverse(term.0));
    let decides = terms.iter().map(|&(_, volume, _)| volume * turned).find(|&volume| volume != 0);
    let exact = unperturbed.cmp(&0);
    [exact, exact.then(decides.unwrap_or(0).cmp(&0))]
}

/// Returns `true` if the closed simplex, which is not flat, contains the position of the site.
pub(super) fn contains<const D: usize>(simplex: &[&Site<D>], site: &Site<D>) -> bool {
    let turned = volume(simplex).signum();
    (0..=D).all(|slot| {
        let mut corners = simplex.to_vec();
        corners[slot] = site;
        volume(&corners).signum() != -turned
    })
}

/// Increasing rows of `size` of the `count` first numbers.
pub(super) fn rows(count: usize, size: usize) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new()];
    for _ in 0..size {
        let longer = |row: Vec<usize>| {
            let next = row.last().map_or(0, |last| last + 1);
            (next..count).map(move |i| [&row[..], &[i]].concat())
        };
        all = all.into_iter().flat_map(longer).collect();
    }
    all
}

/// Searches all simplices. Only the first of the heaviest sites at each position counts.
fn search<const D: usize>(sites: &[Site<D>]) -> Expected {
    let mut places: BTreeMap<[i64; D], Vec<usize>> = BTreeMap::new();
    for (i, (place, _)) in sites.iter().enumerate() {
        places.entry(*place).or_default().push(i);
    }
    let mut expected = Expected { cells: BTreeSet::new(), hidden: Vec::new(), duplicates: Vec::new() };
    let mut kept = Vec::new();
    for group in places.values() {
        let heaviest = group.iter().map(|&i| sites[i].1).max().expect("a group has a site");
        let first = *group.iter().find(|&&i| sites[i].1 == heaviest).expect("it has the heaviest");
        kept.push(first);
        for &i in group.iter().filter(|&&i| i != first) {
            if sites[i].1 == heaviest {
                expected.duplicates.push((i as u64, first as u64));
            } else {
                expected.hidden.push(i as u64);
            }
        }
    }
    let mut concealed = BTreeSet::new();
    for row in rows(kept.len(), D + 1) {
        let simplex: Vec<&Site<D>> = row.iter().map(|&i| &sites[kept[i]]).collect();
        if volume(&simplex) == 0 {
            continue;
        }
        let mut is_cell = true;
        for i in (0..kept.len()).filter(|i| !row.contains(i)) {
            let [exact, perturbed] = above(&simplex, &sites[kept[i]]);
            is_cell &= perturbed.is_gt();
            if exact.is_gt() && !concealed.contains(&kept[i]) && contains(&simplex, &sites[kept[i]]) {
                concealed.insert(kept[i]);
            }
        }
        if is_cell {
            let mut cell: Vec<u64> = row.iter().map(|&i| kept[i] as u64).collect();
            cell.sort_unstable();
            expected.cells.insert(cell);
        }
    }
    // The perturbation hides the same sites as the definition.
    let used: BTreeSet<u64> = expected.cells.iter().flatten().copied().collect();
    let shown = kept.iter().filter(|i| !concealed.contains(i)).map(|&i| i as u64);
    assert!(used.is_empty() || shown.collect::<BTreeSet<_>>() == used, "{sites:?}");
    expected.hidden.extend(concealed.into_iter().map(|i| i as u64));
    expected.hidden.sort_unstable();
    expected.duplicates.sort_unstable();
    expected
}

/// Returns the result of a run in the form of the search.
fn found(run: &Outcome) -> Expected {
    let sorted = |row: &[u64]| {
        let mut row = row.to_vec();
        row.sort_unstable();
        row
    };
    let cells: Vec<Vec<u64>> = run.cells().chunks_exact(run.space + 1).map(sorted).collect();
    let distinct: BTreeSet<Vec<u64>> = cells.iter().cloned().collect();
    assert_eq!(distinct.len(), cells.len(), "a cell occurs twice");
    let (hidden, duplicates) = (run.left_out.hidden.clone(), run.left_out.duplicates.clone());
    assert_eq!(run.points.hidden, Some(hidden.len() as u64));
    assert_eq!(run.points.duplicate, duplicates.len() as u64);
    let left = hidden.len() + duplicates.len();
    assert_eq!(run.points.used + left as u64, run.points.input);
    Expected { cells: distinct, hidden, duplicates }
}

fn weighted<P: Position, const D: usize>(sites: &[Site<D>]) -> Vec<Weighted<P>> {
    let site =
        |&(place, weight): &Site<D>| Weighted::new(P::from_coords(&place.map(|x| x as f64)), weight as f64);
    sites.iter().map(site).collect()
}

/// Compares runs of both commands with 1, 3 and 8 workers, and of permuted rows, with the search; over all transports if `everywhere`.
fn compare<P: Position, const D: usize>(what: &str, sites: &[Site<D>], draw: &mut Draw, everywhere: bool)
where
    Weighted<P>: Point,
{
    let mut rows: Vec<usize> = (0..sites.len()).collect();
    draw.shuffle(&mut rows);
    let permuted: Vec<Site<D>> = rows.iter().map(|&i| sites[i]).collect();
    for sites in [sites, &permuted] {
        let expected = search(sites);
        let given = weighted::<P, D>(sites);
        for workers in [1, 3, 8] {
            let spec = with_workers(Workers::Count(workers), 2);
            let label = format!("{what}, {workers} workers: {sites:?}");
            // The stars are repaired by probes, by splaying, and by gathering.
            let counting = spec.clone().with(|c| {
                c.recursion.repair = if workers == 1 { Repair::Probe } else { Repair::Splay };
                c.planted.exchange_cap = (workers == 8).then_some(1);
            });
            let (points, of, name) = (given.clone(), [spec.clone(), counting], label.clone());
            let [run, counted] = within(PATIENCE, &label, move || {
                let runs = [triangulate(&points, &of[0]), simulate(&points, &of[1])];
                runs.map(|run| run.unwrap_or_else(|e| panic!("{name}: {e}")))
            });
            assert_eq!(found(&run), expected, "{label}");
            assert_verified(&given, &run);
            assert_eq!(counted.cells(), run.cells(), "simulate, {label}");
            assert_eq!(counted.left_out, run.left_out, "simulate, {label}");
            assert_eq!(counted.points, run.points, "simulate, {label}");
            if everywhere && workers == 3 {
                for is_counted in [false, true] {
                    each_transport(|start| {
                        let other = start.run(&given, &spec, is_counted);
                        let other = other.unwrap_or_else(|e| panic!("{start:?}: {e}"));
                        assert_eq!(other.cells(), run.cells(), "{start:?}, {label}");
                        assert_eq!(other.left_out, run.left_out, "{start:?}, {label}");
                    });
                }
            }
        }
    }
}

/// The kinds of sets.
const KINDS: [&str; 11] = [
    "random",
    "random, mostly hidden",
    "grid, equal weights",
    "grid, random weights",
    "one heavy site",
    "all but the corners hidden",
    "equal positions",
    "flat",
    "lifts in one plane",
    "negative weights",
    "few sites",
];

/// Draws a set of a kind.
fn set<const D: usize>(kind: usize, draw: &mut Draw) -> Vec<Site<D>> {
    let most = if D == 2 { 20 } else { 14 };
    let mut count = draw.below(most) + 1;
    let mut number = |from: i64, to: i64| from + draw.below((to - from + 1) as usize) as i64;
    let place = |side: i64, number: &mut dyn FnMut(i64, i64) -> i64| {
        std::array::from_fn::<i64, D, _>(|_| number(0, side))
    };
    let square = |place: &[i64; D]| place.iter().map(|x| x * x).sum::<i64>();
    let heavy = number(0, count as i64 - 1);
    let (level, slope) = (number(-9, 9), number(-3, 3));
    if KINDS[kind] == "few sites" {
        count = number(0, 6) as usize;
    }
    let mut site = |i: usize| match KINDS[kind] {
        "random" => (place(1000, &mut number), number(-20_000, 20_000)),
        "random, mostly hidden" => (place(1000, &mut number), number(0, 1_000_000)),
        "grid, equal weights" => (place(2, &mut number), level),
        "grid, random weights" => (place(2, &mut number), number(0, 2)),
        "one heavy site" => {
            (place(100, &mut number), if i as i64 == heavy { 1 << 40 } else { number(-50, 50) })
        }
        "all but the corners hidden" if i < 1 << D => (std::array::from_fn(|k| 100 * (i as i64 >> k & 1)), 0),
        "all but the corners hidden" => (place(100, &mut number), number(-60_000, -40_000)),
        "equal positions" => (place(2, &mut number), number(-1, 1)),
        "flat" => {
            let mut at = place(5, &mut number);
            at[D - 1] = slope * at[0] + level;
            // In space, half of the sets are in a line.
            if level % 2 == 0 {
                at = std::array::from_fn(|k| slope * at[0] + k as i64 * at[0]);
            }
            (at, number(-3, 3))
        }
        "lifts in one plane" => {
            let at = place(4, &mut number);
            // A few sites are above or below the plane.
            let off = [0, 0, 0, 0, -1, 1][number(0, 5) as usize];
            (at, square(&at) + slope * at[0] + level + off)
        }
        "negative weights" => (place(30, &mut number), number(-700, -1)),
        "few sites" => (place(3, &mut number), number(-4, 4)),
        other => unreachable!("no set is {other}"),
    };
    (0..count).map(&mut site).collect()
}

#[test]
fn small_sets_agree_with_the_definition() {
    let sets: usize = std::env::var("SEPTET_SETS").map_or(300, |n| n.parse().expect("a number"));
    let mut hidden = 0;
    for i in 0..sets {
        let mut draw = Draw::new(4300 + i as u64);
        let kind = i / 2 % KINDS.len();
        let everywhere = i % 20 < 2;
        let what = format!("set {i}, {}", KINDS[kind]);
        if i % 2 == 0 {
            let sites = set::<2>(kind, &mut draw);
            compare::<DVec2, 2>(&what, &sites, &mut draw, everywhere);
            hidden += search(&sites).hidden.len();
        } else {
            let sites = set::<3>(kind, &mut draw);
            compare::<DVec3, 3>(&what, &sites, &mut draw, everywhere);
            hidden += search(&sites).hidden.len();
        }
    }
    assert!(hidden > sets, "{hidden} hidden sites in {sets} sets");
}

/// Returns random sites in general position. The weights are up to `spread` mean squared distances of neighbours.
fn random<P: Position>(count: usize, spread: f64, seed: u64) -> Vec<Weighted<P>> {
    let mut draw = Draw::new(seed);
    let unit = (count as f64).powf(-2.0 / P::DIM as f64);
    let mut site = |_| {
        let place = draw.point::<P>();
        Weighted::new(place, spread * unit * draw.unit())
    };
    (0..count).map(&mut site).collect()
}

/// Returns cells and hidden sites by CGAL, in the form of the search.
fn by_cgal<P: Point>(sites: &[P]) -> Expected {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("sites");
    let numbers = sites
        .iter()
        .flat_map(|site| (0..P::DIM).map(|i| site.coord(i)).chain([site.weight()]).collect::<Vec<_>>());
    let bytes: Vec<u8> = numbers.flat_map(f64::to_le_bytes).collect();
    fs::write(&file, bytes).unwrap();
    let output = Command::new(cgal("cgal_regular")).arg(P::DIM.to_string()).arg(&file).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let (cells, hidden) = text.split_once("hidden").unwrap();
    let rows = |part: &str| -> Vec<Vec<u64>> {
        let row = |line: &str| line.split(' ').map(|index| index.parse().unwrap()).collect();
        part.lines().skip(1).map(row).collect()
    };
    let hidden: Vec<u64> = rows(hidden).concat();
    Expected { cells: rows(cells).into_iter().collect(), hidden, duplicates: Vec::new() }
}

fn agrees_with_cgal<P: Position>(spec: &Spec)
where
    Weighted<P>: Point,
{
    let count: usize = std::env::var("SEPTET_SITES").map_or(20_000, |n| n.parse().expect("a number"));
    // Few sites are hidden, and about a third.
    for (spread, least, most) in [(0.3, 0.0, 0.05), (2.5, 0.25, 0.45)] {
        let sites = random::<P>(count, spread, 43);
        let expected = by_cgal(&sites);
        let share = expected.hidden.len() as f64 / count as f64;
        assert!((least..most).contains(&share), "{share} of the sites are hidden");
        let run = triangulate(&sites, spec).unwrap();
        let found = found(&run);
        println!("{}D, {count} sites, {} cells, {share} hidden", P::DIM, expected.cells.len());
        assert_eq!(found.hidden, expected.hidden);
        assert!(found == expected, "other cells than CGAL's");
        assert_verified(&sites, &run);
    }
}

#[test]
#[ignore = "needs a C++ compiler and CGAL's headers"]
fn cgal_agrees_in_general_position() {
    let spec = with_workers(Workers::Count(5), 300);
    agrees_with_cgal::<DVec2>(&spec);
    agrees_with_cgal::<DVec3>(&spec);
}
