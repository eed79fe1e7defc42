//! Weights: the theorem for regular triangulations, if weights are small.
//!
//! **Statement.** Let `P` be a maximal f-spaced set, where f is L-Lipschitz. Let `N(p)` be the distance from `p` to its nearest
//! point. So `N(p) >= f(p) / (1 + L)`. Every location `c` in the domain, outside of the balls that protect its boundary, has a
//! point within `f(c)`. Let `0 <= w_p <= (omega N(p))^2` with `omega < 1`.
//! 1. No point is hidden.
//! 2. Let `A = 1 + L + L x`, where `x` is the larger solution of `x^2 = A^2 + omega^2`, and let `y` be the larger solution of
//!    `y^2 = A^2 + omega^2 (x + y)^2`. Every edge at `p` of a cell whose orthogonal sphere has its centre in this part of the domain is
//!    at most `(x + y) N(p)` long.
//!
//! So the regular triangulation is a subgraph of the density graph of `x + y`, as the Delaunay triangulation is with
//! `omega = 0`, where `x + y = 2 (1 + L) / (1 - L)`. Theorem 4.4 then holds with this alpha.
//!
//! *Proof.* 1. For all `q /= p`, the power of `q` at `p` is `|p - q|^2 - w_q >= (1 - omega^2) N(q)^2 > 0 >= -w_p`, which is that of
//! `p`. So `p` is in the interior of its own power cell. 2. Let `c` be the centre, and `r^2` the squared radius. No point conflicts, so
//! a point `q` within `f(c)` has `r^2 <= |q - c|^2 - w_q <= f(c)^2`. With distances in units of `N(p)`: if `D = |p - c|`, then
//! `f(c) <= f(p) + L D <= 1 + L + L D` and `D^2 = r^2 + w_p <= (1 + L + L D)^2 + omega^2`, so `D <= x`. Let `q` be the other end of the
//! edge and `E = |q - c|`. Then `N(q) <= |p - q| <= D + E` and `E^2 = r^2 + w_q <= A^2 + omega^2 (x + E)^2`, so `E <= y`. QED.
//!
//! **Source.** None. The proof uses no published bound.

use septet_core::generate::Kind;
use septet_core::spec::{Alpha, Graph};
use septet_geometry::hash::Draw;

use super::lab::{Lab, is_free};
use super::measure::{X, distance2, kth_nearest2, orthocentre};
use super::sample::Sample;
use super::{Claim, ClaimError, Figure, Reading, Role};

/// The largest ratios of the root of a weight to the distance of the nearest point.
const OMEGAS: [f64; 6] = [0.0, 0.1, 0.2, 0.3, 0.4, 0.45];

/// Factor by which alpha may exceed the theorem's at boundaries: an observation, as in the claim `alpha`.
const AT_BOUNDARIES: f64 = 1.25;

/// Tolerance for rounding, for bounds that can be attained.
const ROUNDING: f64 = 1e-9;

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "weights",
    role: Role::Test,
    statistics: None,
    source: "Theorems 3.2 and 4.4",
    statement: "DT(P) is a subgraph of DG_alpha(P) for an alpha of d and C alone, so that it takes O(log n) time",
    reading: Reading::AsRead {
        instead: "the regular triangulation of points with weights in [0, (omega N(p))^2], omega < 1, on f-spaced sets",
        because: "weights of any size can make any regular triangulation of the points, so no alpha suffices for all",
    },
    experiment: "Weights of 0 or (omega N(p))^2 at random, omega of 0 to 0.45: longest edge over nearest neighbour, in \
                 cells with free orthocentres and in all cells; hidden points; stars changed, rounds of splaying and points \
                 gathered, from the density graph of the second bound",
    bound: "x + y of the module `weights`, which is 2(1+L)/(1-L) for omega 0, a theorem; 1.25 times that in all cells, an \
            observation; 0 hidden points, a theorem; 0 for the repair, by Lemma 4.1. Stated before the run",
    check: weights,
}];

/// Returns the theorem's alpha.
fn alpha_of(omega: f64, lipschitz: f64) -> f64 {
    let (l, w2) = (lipschitz, omega * omega);
    let (own, rest) = (l * (1.0 + l), 1.0 - l * l);
    let x = (own + (own * own + rest * ((1.0 + l) * (1.0 + l) + w2)).sqrt()) / rest;
    let a = 1.0 + l + l * x;
    let y = (w2 * x + (w2 * w2 * x * x + (1.0 - w2) * (a * a + w2 * x * x)).sqrt()) / (1.0 - w2);
    x + y
}

/// Returns the longest edge of a cell over the distance of the nearest point of one of its ends.
fn longest_edge(row: &[u64], points: &[X], nearest2: &[f64]) -> f64 {
    let edge2 = |v: u64, w: u64| distance2(&points[v as usize], &points[w as usize]) / nearest2[v as usize];
    let all = row.iter().flat_map(|&v| row.iter().map(move |&w| edge2(v, w)));
    all.fold(0.0, f64::max).sqrt()
}

fn weights(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let n = lab.size(4000, 32_000);
    let mut figures = Vec::new();
    for kind in [Kind::WellSpaced, Kind::GradedPoint] {
        for d in [2, 3] {
            for omega in OMEGAS {
                of_omega(lab, Sample::new(kind, n, d), omega, &mut figures)?;
                if lab.has_detected(&figures) {
                    return Ok(figures);
                }
            }
        }
    }
    Ok(figures)
}

fn of_omega(lab: &mut Lab, sample: Sample, omega: f64, figures: &mut Vec<Figure>) -> Result<(), ClaimError> {
    let (seed, d) = (lab.seed(), sample.d);
    let points = lab.points(sample, seed)?;
    let spacing = lab.spacing(sample, seed)?;
    let nearest2 = kth_nearest2(&points, 1);
    let mut draw = Draw::new(seed);
    let weights: Vec<f64> =
        nearest2.iter().map(|&near2| if draw.below(2) == 0 { 0.0 } else { omega * omega * near2 }).collect();
    // A set without a spacing has no bound.
    let bound = alpha_of(omega, spacing.as_ref().map_or(f64::NAN, |s| s.lipschitz));
    let run = lab.run_with_weights((sample, seed), &weights, |spec| {
        spec.with(|c| c.recursion.graph = Graph::Density { alpha: Alpha::Value(AT_BOUNDARIES * bound) })
    })?;
    let (mut free, mut inside, mut at_all) = (0u64, 0.0f64, 0.0f64);
    for row in run.cells().chunks_exact(d + 1) {
        let corners: Vec<X> = row.iter().map(|&v| points[v as usize]).collect();
        let own: Vec<f64> = row.iter().map(|&v| weights[v as usize]).collect();
        let offset = orthocentre(&corners, &own);
        let centre = [0, 1, 2].map(|i| corners[0][i] + offset[i]);
        let longest = longest_edge(row, &points, &nearest2);
        at_all = at_all.max(longest);
        if is_free(spacing.as_ref(), d, &centre) {
            (free, inside) = (free + 1, inside.max(longest));
        }
    }
    let inside = if free == 0 { f64::NAN } else { inside };
    let gathered = run.fallback.as_ref().map_or(0, |fallback| fallback.1);
    let repair = run.stars_repaired + run.exchange_rounds + gathered;
    let hidden = run.points.hidden.map_or(f64::NAN, |hidden| hidden as f64);
    let on = format!("{} omega={omega}", sample.name());
    for (what, value, bound) in [
        (format!("alpha needed by {free} cells with free orthocentres"), inside, bound * (1.0 + ROUNDING)),
        (format!("alpha needed by all {} cells", run.cell_count()), at_all, AT_BOUNDARIES * bound),
        ("hidden points".to_string(), hidden, 0.0),
        ("stars changed, rounds of splaying and points gathered".to_string(), repair as f64, 0.0),
    ] {
        figures.push(Figure::at_most(what, &on, seed, value, bound));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_weights_alpha_is_that_of_the_delaunay_triangulation() {
        for l in [0.0, 0.2, 0.5] {
            assert!((alpha_of(0.0, l) - 2.0 * (1.0 + l) / (1.0 - l)).abs() < 1e-12);
        }
        let alphas = OMEGAS.map(|omega| alpha_of(omega, 0.2));
        assert!(alphas.is_sorted() && alphas[5] < 2.0 * alphas[0], "{alphas:?}");
    }
}
