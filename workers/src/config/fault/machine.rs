//! Faults of the machine: the phases ask for them where they act.

use std::panic::panic_any;

use septet_geometry::hash::mix;
use septet_geometry::hull::LargeStars;
use septet_geometry::point::{Point, dist2};
use septet_geometry::separator::{Ablation, Separator};
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::transport::TransportError;

use super::Fault;

impl Fault {
    /// Returns `true` if the fault leaves the node unsplit.
    pub(crate) fn refuses(self, node: NodeId) -> bool {
        matches!(self, Fault::RefuseSplit { first, last } if (first..=last).contains(&node))
    }

    /// Returns `true` if the fault rejects the separator of this attempt.
    pub(crate) fn refuses_draw(self, node: NodeId, attempt: u32) -> bool {
        let Fault::RefuseDraws { every } = self else { return false };
        let mixed = (node.0 ^ u64::from(attempt).rotate_left(40)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let mixed = (mixed ^ (mixed >> 32)).wrapping_mul(0xD6E8_FEB8_6659_FD93);
        (mixed >> 32).is_multiple_of(u64::from(every))
    }

    /// Returns the part of the draw that separators lack, if any.
    pub(crate) fn ablation(self) -> Option<Ablation> {
        if let Fault::Ablate(ablation) = self { Some(ablation) } else { None }
    }

    /// Returns the separator that replaces a drawn one, if this fault replaces separators.
    pub(crate) fn separator<P: Point>(self, samples: &[P]) -> Option<Separator<P>> {
        if self != Fault::SmallSphere {
            return None;
        }
        let centre = *samples.first()?;
        let mut distances: Vec<f64> = samples.iter().map(|&x| dist2(x, centre)).collect();
        distances.sort_unstable_by(f64::total_cmp);
        // The squared radius is midway between those of the last sample inside and of the first sample outside.
        let inside = (distances.len() / 20).max(1);
        let radius = (0.5 * (distances[inside - 1] + distances.get(inside)?)).sqrt();
        let n = P::DIM.max(3);
        let mut words = vec![0.0; Separator::<P>::WORDS];
        for (i, word) in words.iter_mut().enumerate().take(P::DIM) {
            *word = centre.coord(i);
        }
        (words[n], words[n + 1], words[2 * n + 2]) = (1.0, 0.5 / radius, -0.5 * radius);
        Separator::from_array(&words)
    }

    /// Returns `true` if the fault forces the split to be accepted: [`Fault::SmallSphere`], if no side is empty.
    pub(crate) fn accepts(self, inside: u64, outside: u64) -> bool {
        self == Fault::SmallSphere && inside > 0 && outside > 0
    }

    /// Returns the factor by which the fault multiplies the distance that the edges of a point may reach. It is infinite
    /// if every point goes to every leaf.
    pub(crate) fn spread(self) -> f64 {
        match self {
            Fault::Flood => f64::INFINITY,
            Fault::FarGhosts { factor } => factor.value(),
            _ => 1.0,
        }
    }

    /// Returns `true` if the fault drops the answers to the cells that ask for a point in their circumsphere.
    pub(crate) fn drops_answers(self) -> bool {
        self == Fault::BlindProbes
    }

    /// Returns the rank of the neighbour to which the balls of an overlap graph extend if it should be `k`.
    pub(crate) fn ball_order(self, k: u32) -> u32 {
        if self == Fault::FirstBall { 1 } else { k }
    }

    /// Returns how local hulls with many candidates are built.
    pub(crate) fn large_stars(self) -> LargeStars {
        if self == Fault::SlowHub { LargeStars::ByDistance } else { LargeStars::AtRandom }
    }

    /// Returns `true` if the fault keeps the point in its own leaf under the rule `ghost`.
    pub(crate) fn keeps_home<P: Point>(self, x: P) -> bool {
        self == Fault::HalfGhosts && is_in_half(x)
    }

    /// Returns `true` if the fault removes the point from all separator sets.
    pub(crate) fn removes<P: Point>(self, x: P) -> bool {
        self == Fault::HalfSeparators && is_in_half(x)
    }

    /// Makes a worker fail or panic if the fault strikes it in this phase.
    pub(crate) fn strike(self, worker: Rank, now: Phase) -> Result<(), TransportError> {
        match self {
            Fault::DieAt { rank, phase } if rank == worker && phase == now => {
                let reason = format!("it ended at the beginning of phase {}", now.name());
                Err(TransportError::WorkerFailed { rank, reason })
            }
            Fault::PanicAt { rank, phase } if rank == worker && phase == now => {
                panic_any(format!("it panicked at the beginning of phase {}", now.name()))
            }
            _ => Ok(()),
        }
    }
}

/// Returns `true` for about half of all points. The result depends on the coordinates only.
fn is_in_half<P: Point>(x: P) -> bool {
    let hash = (0..P::DIM).fold(0, |h, i| mix(h, x.coord(i).to_bits()));
    hash >> 63 == 0
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::config::fault::Factor;

    #[test]
    fn draws_are_refused_by_node_and_attempt() {
        let refused = |every: u32, attempt: u32| {
            (1..=1000).filter(|&n| Fault::RefuseDraws { every }.refuses_draw(NodeId(n), attempt)).count()
        };
        assert_eq!(refused(1, 0), 1000);
        for attempt in 0..8 {
            assert!((400..600).contains(&refused(2, attempt)), "attempt {attempt}");
            assert!((260..400).contains(&refused(3, attempt)), "attempt {attempt}");
        }
        assert!(!Fault::HalveAlpha.refuses_draw(NodeId::ROOT, 0));
    }

    #[test]
    fn half_of_the_points_are_held_back() {
        let points: Vec<DVec2> = (0..1000).map(|i| DVec2::new(f64::from(i), 0.5)).collect();
        let home = points.iter().filter(|&&x| Fault::HalfGhosts.keeps_home(x)).count();
        assert!((400..600).contains(&home), "{home}");
        assert_eq!(home, points.iter().filter(|&&x| Fault::HalfSeparators.removes(x)).count());
        assert!(!points.iter().any(|&x| Fault::HalfGhosts.removes(x) || Fault::HalfSeparators.keeps_home(x)));
    }

    #[test]
    fn points_spread_by_a_factor() {
        assert_eq!(Fault::Flood.spread(), f64::INFINITY);
        assert_eq!(Fault::FarGhosts { factor: Factor::new(3.0).unwrap() }.spread(), 3.0);
        assert_eq!(Fault::HalfGhosts.spread(), 1.0);
    }

    #[test]
    fn one_fault_builds_large_stars_by_distance() {
        assert_eq!(Fault::SlowHub.large_stars(), LargeStars::ByDistance);
        assert_eq!(Fault::Flood.large_stars(), LargeStars::default());
    }

    #[test]
    fn balls_stay_at_the_first_neighbour() {
        assert_eq!((Fault::FirstBall.ball_order(8), Fault::Flood.ball_order(8)), (1, 8));
    }
}
