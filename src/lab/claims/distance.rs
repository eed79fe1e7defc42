//! Repair of the stars of surfaces: the rounds of tell and probe.
//!
//! A wrong cell of a surface is a ball that reaches its other side. Splaying walks there from star to star, in a number of rounds
//! that grows with n. A probe finds a point there at once.

use septet_core::generate::Kind;
use septet_core::spec::{Graph, Neighbours};

use super::lab::Lab;
use super::sample::Sample;
use super::{Claim, ClaimError, Figure, Reading, Role};

/// The numbers of points.
const SIZES: [u64; 4] = [1000, 2000, 4000, 8000];

/// Nearest neighbours of the supergraph.
const K: u32 = 20;

/// The bound on the rounds, over log2 n.
const ROUNDS: f64 = 1.2;

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "distance",
    role: Role::Test,
    statistics: None,
    source: "Section 4.1",
    statement: "from G with degrees up to D_2, DT(P) takes O(T_CH(D_2)) with n processors, for any n",
    reading: Reading::AsRead {
        instead: "stars that G does not determine are repaired in a number of rounds that grows like log n",
        because: "nearest neighbours on a surface do not reach its other side, so G lacks edges of DT(P)",
    },
    experiment: "Rounds of repair over log2 n, on bodies of 1 to 8 thousand points, from 20 nearest neighbours",
    bound: "1.2: a descent finds a point on the other side in one round; on scans outside of the machine, 0.6 to 0.9",
    check: distance,
}];

fn distance(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let seed = lab.seed();
    let mut figures = Vec::new();
    for n in SIZES {
        let sample = Sample::new(Kind::Body, n, 3);
        let run = lab.run(sample, seed, |spec| {
            spec.with(|c| c.recursion.graph = Graph::Knn { k: Neighbours::Count(K) })
        })?;
        let rounds = run.exchange_rounds as f64 / (n as f64).log2();
        let what = format!("rounds of repair, {}, over log2 n", run.exchange_rounds);
        figures.push(Figure::at_most(what, sample.name(), seed, rounds, ROUNDS));
    }
    Ok(figures)
}
