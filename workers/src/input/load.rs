//! Reads the rows of the input and prepares them: phase `load`.
//!
//! **Statement.** After the phase, the ranks hold the distinct points of the input, in the exact range. All ranks know
//! the survey of the rows, the sum of the points' hashes, and a frame: affinely independent points that span the set.
//! The points do not depend on the blocks.
//!
//! **Frame.** The frame is the greedy basis in lexicographic order. Affine independence is a matroid, and the greedy
//! basis of a union is that of the union of the greedy bases. Ranks therefore combine their frames.
//!
//! **Rounds.** With `h` levels of the tree of all ranks (one level for at most 32 workers): `2 h` for the survey, again
//! `2 h` if the digits may not fit, one for coincident points (four if there are any), and `2 h` for the frame. An
//! exchange without messages follows the search for coincident points, and another one ends the phase. With weights, `2 h`
//! more for the largest weight.
//!
//! **Work and depth.** Vector steps over the rows (`super::rows`, `super::repeats`). No model of the paper has this
//! phase, so the ledger counts its rounds and messages only.

use septet_geometry::point::{Point, lex_cmp};
use septet_geometry::predicates::{affine_frame, smallest_outside};
use septet_protocol::ids::{COORDINATOR, Phase};
use septet_protocol::message::{Body, PointBatch, PointSum, SiteTotals, Survey, UNKNOWN_RADIUS2};
use septet_protocol::transport::TransportError;

use crate::config::Task;
use crate::input::loaded::Loaded;
use crate::input::repeats::remove_repeats;
use crate::input::source::{Rows, Source};
use crate::machine::context::Context;
use crate::machine::reduction::Reduced;

/// Number of points that one core reads in turn.
const CHUNK: usize = 1 << 14;

/// The input of a rank.
#[derive(Debug)]
pub(crate) struct Input<P> {
    loaded: Loaded,
    /// Points that span the set of all points.
    frame: PointBatch<P>,
    /// The points of this rank; empty on the coordinator.
    block: PointBatch<P>,
    is_ready: bool,
}

impl<P> Input<P> {
    /// Returns the points of all ranks, by number and sum.
    pub(crate) fn population(&self) -> PointSum {
        self.loaded.population
    }

    /// Returns `true` if the run can start: the rows are admitted, and the points span the space or the run is an
    /// independent set.
    pub(crate) fn is_ready(&self) -> bool {
        self.is_ready
    }

    /// Returns the description of the input, the frame, and the points of this rank.
    pub(crate) fn into_parts(self) -> (Loaded, PointBatch<P>, PointBatch<P>) {
        (self.loaded, self.frame, self.block)
    }
}

/// Reads the block of this rank from `source`, and prepares it together with the other ranks.
///
/// # Errors
/// See [`Context::exchange`].
pub(crate) async fn load<P: Point>(
    cx: &mut Context<P>,
    source: &dyn Source<P>,
) -> Result<Input<P>, TransportError> {
    cx.enter(Phase::Load)?;
    let rows =
        if cx.is_coordinator() { Rows::default() } else { source.block(cx.rank() - 1, cx.config().workers) };
    let mut own = rows.survey(cx, false);
    let mut survey = cx.all_reduce(own).await?;
    if !survey.fits() {
        own = rows.survey(cx, true);
        survey = cx.all_reduce(own).await?;
    }
    if !own.is_part_of(&survey) {
        let reason = "the survey of all rows does not contain those of the rank".to_string();
        return Err(TransportError::WorkerFailed { rank: cx.rank(), reason });
    }
    let mut loaded = Loaded { survey, dimension: -1, ..Loaded::default() };
    let exponent =
        survey.exponent(cx.config().task.skips_invalid()).ok().filter(|_| !survey.repeats_numbers());
    let Some(exponent) = exponent else {
        let (frame, block) = (PointBatch::default(), PointBatch::default());
        return Ok(Input { loaded, frame, block, is_ready: false });
    };
    let (mut block, refused) = rows.prepare(&own, exponent);
    loaded.refused = refused;
    (loaded.repeated, loaded.hidden) = remove_repeats(cx, &mut block, survey.rows).await?.into_parts();
    // The last exchange delivered no message, so the ranks begin a second pass of the phase.
    cx.enter(Phase::Load)?;
    let own = Spanned::of(cx, &block);
    let Spanned { population, frame } = cx.all_reduce(own).await?;
    if P::IS_WEIGHTED {
        let heaviest = block.positions.iter().map(P::weight).fold(f64::NEG_INFINITY, f64::max);
        let own = SiteTotals { heaviest, hidden: loaded.hidden.len() as u64 };
        loaded.sites = cx.all_reduce(own).await?;
    }
    cx.end_phase().await?;
    loaded.population = population;
    loaded.dimension = frame.len() as isize - 1;
    let is_ready = frame.len() == P::DIM + 1 || matches!(cx.config().task, Task::Independent { .. });
    Ok(Input { loaded, frame, block, is_ready })
}

/// Points of some ranks: their number and the sum of their hashes, and their frame.
#[derive(Clone)]
struct Spanned<P> {
    population: PointSum,
    frame: PointBatch<P>,
}

impl<P: Point> Spanned<P> {
    fn of(cx: &Context<P>, points: &PointBatch<P>) -> Self {
        let chunks: Vec<(&[u64], &[P])> =
            points.ids.chunks(CHUNK).zip(points.positions.chunks(CHUNK)).collect();
        let sum = |&(ids, at): &(&[u64], &[P])| PointSum::of(ids.iter().copied().zip(at.iter().copied()));
        let population = cx.map(&chunks, sum).into_iter().fold(PointSum::default(), PointSum::join);
        let mut frame = PointBatch::default();
        if !matches!(cx.config().task, Task::Independent { .. }) {
            for at in frame_of(cx, &points.positions) {
                frame.push(points.ids[at], points.positions[at], cx.rank(), UNKNOWN_RADIUS2);
            }
        }
        Spanned { population, frame }
    }
}

impl<P: Point> Reduced<P> for Spanned<P> {
    fn join(self, other: Self) -> Self {
        let mut points: Vec<(u64, P)> = Vec::new();
        for batch in [&self.frame, &other.frame] {
            points.extend(batch.ids.iter().copied().zip(batch.positions.iter().copied()));
        }
        points.sort_unstable_by_key(|(id, _)| *id);
        let (ids, positions): (Vec<u64>, Vec<P>) = points.into_iter().unzip();
        let mut frame = PointBatch::default();
        for at in affine_frame(&positions).1 {
            frame.push(ids[at], positions[at], COORDINATOR, UNKNOWN_RADIUS2);
        }
        Spanned { population: self.population.join(other.population), frame }
    }

    fn into_body(self) -> Body<P> {
        Body::Start { population: self.population, frame: self.frame }
    }

    fn take(body: &mut Body<P>) -> Option<Self> {
        match body {
            Body::Start { population, frame } => {
                Some(Spanned { population: *population, frame: std::mem::take(frame) })
            }
            _ => None,
        }
    }
}

impl<P: Point> Reduced<P> for SiteTotals {
    fn join(self, other: Self) -> Self {
        SiteTotals::join(self, other)
    }

    fn into_body(self) -> Body<P> {
        Body::Sites(self)
    }

    fn take(body: &mut Body<P>) -> Option<Self> {
        match body {
            Body::Sites(sites) => Some(*sites),
            _ => None,
        }
    }
}

impl<P: Point> Reduced<P> for Survey {
    fn join(self, other: Self) -> Self {
        Survey::join(self, other)
    }

    fn into_body(self) -> Body<P> {
        Body::Survey(self)
    }

    fn take(body: &mut Body<P>) -> Option<Self> {
        match body {
            Body::Survey(survey) => Some(*survey),
            _ => None,
        }
    }
}

/// Computes [`affine_frame`] by chunks. The smallest point of the set is the smallest of its chunk.
fn frame_of<P: Point>(cx: &Context<P>, points: &[P]) -> Vec<usize> {
    let chunks: Vec<(usize, &[P])> = (0..).step_by(CHUNK).zip(points.chunks(CHUNK)).collect();
    let mut frame: Vec<usize> = Vec::with_capacity(P::DIM + 1);
    while frame.len() <= P::DIM {
        let basis: Vec<P> = frame.iter().map(|&i| points[i]).collect();
        let found = cx.map(&chunks, |&(first, points)| smallest_outside(&basis, points).map(|i| first + i));
        let smaller = |a: usize, b: usize| if lex_cmp(&points[b], &points[a]).is_lt() { b } else { a };
        match found.into_iter().flatten().reduce(smaller) {
            Some(i) => frame.push(i),
            None => break,
        }
    }
    frame
}
