//! The rounds of every independent set that generation takes.

use glam::DVec2;
use septet_geometry::evaluation::{Evaluated, Evaluation};
use septet_geometry::incremental::IncrementalError;
use septet_geometry::point::Point;
use septet_meshing::domain::Domain;
use septet_meshing::executor::{Evaluator, Part};
use septet_meshing::facet::Triangulate;
use septet_meshing::generate::{Alone, Delaunay, MeshMachine, Rules, generate};
use septet_meshing::points::conflicts::Site;
use septet_meshing::points::independent::Independent;

use super::domains::{self, AnyDomain, Problem};
use super::request;

/// One processor, and the candidates and rounds of each set it took.
struct Watched {
    alone: Alone,
    sets: Vec<(usize, usize)>,
}

impl<P: Point> Evaluator<P> for Watched {
    type Error = IncrementalError;

    fn evaluate(&self, part: Part, rule: &dyn Evaluation) -> Result<Evaluated, Self::Error> {
        Evaluator::<P>::evaluate(&self.alone, part, rule)
    }
}

impl<P: Point> MeshMachine<P> for Watched {
    fn independent(&mut self, sites: &[Site<P>], fixed: usize) -> Result<Independent, Self::Error> {
        let set = self.alone.independent(sites, fixed)?;
        self.sets.push((sites.len() - fixed, set.rounds()));
        Ok(set)
    }

    fn delaunay(&mut self, points: &[P]) -> Result<Delaunay<P::Cell>, Self::Error> {
        self.alone.delaunay(points)
    }

    fn planar(&mut self, sets: &[Vec<DVec2>]) -> Result<Vec<Vec<[u32; 3]>>, Self::Error> {
        MeshMachine::<P>::planar(&mut self.alone, sets)
    }

    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        MeshMachine::<P>::map(&self.alone, items, f)
    }
}

fn watch<P: Triangulate>(domain: &Domain<P>, problem: &Problem, lipschitz: f64, seed: u64) {
    let size = septet_core::mesh::sizes(domain, &request(lipschitz, Some(problem.size))).unwrap();
    let at = |x| size.at(x);
    let rules = Rules { size: &at, lipschitz, seed, most: 1 << 20 };
    let mut machine = Watched { alone: Alone { seed }, sets: Vec::new() };
    generate(domain, rules, &mut machine).unwrap();
    assert!(machine.sets.len() > 3, "{}: {} sets", problem.name, machine.sets.len());
    for &(candidates, rounds) in &machine.sets {
        let most = (candidates as f64).log2() + 2.0;
        assert!(rounds as f64 <= most, "{}: {rounds} rounds for {candidates} candidates", problem.name);
    }
    let largest = machine.sets.iter().max().unwrap();
    println!("{}: {} sets, the largest {largest:?}", problem.name, machine.sets.len());
}

#[test]
fn each_set_has_at_most_log2_rounds_and_two() {
    let problems = [domains::cube(), domains::cubic_hole(), domains::plate(), domains::airfoil()];
    for problem in &problems {
        for (lipschitz, seed) in [(0.12, 1), (0.25, 1), (0.25, 2), (0.5, 3)] {
            match &problem.domain {
                AnyDomain::Plane(domain) => watch(domain, problem, lipschitz, seed),
                AnyDomain::Space(domain) => watch(domain, problem, lipschitz, seed),
            }
        }
    }
}
