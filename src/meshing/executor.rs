//! The computations of meshing that others run: maps over lists, and rules that a machine evaluates and charges.
//!
//! This crate starts no threads. Independent computations for the items of a list go through [`Executor::map`], which
//! the caller implements. Values are returned in the order of the items, so results do not depend on the number of
//! cores. The computations of Section 5 of the paper go through [`Evaluator::evaluate`] instead, which also counts them.

use std::convert::Infallible;

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::evaluation::{Evaluated, Evaluation, Items, Made, Map, Words, alone};
use septet_geometry::point::Point;

/// Maps a function over a list.
pub trait Executor: Sync {
    /// Returns the values of `f`, in the order of the items.
    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U>;
}

/// Maps sequentially.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sequential;

impl Executor for Sequential {
    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        items.iter().map(f).collect()
    }
}

/// A part of Section 5, which a machine charges as one of its phases.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// Trees of cells, level by level.
    Octree,
    /// The size function: its cones, and its values at sites.
    Sizes,
    /// Candidates in cells.
    Candidates,
    /// Conflicts of candidates with earlier points.
    Conflicts,
    /// Simplices that are too large, and their centres.
    Completion,
}

/// Evaluates rules.
pub trait Evaluator<P: Point> {
    /// The errors of the machine.
    type Error;

    /// Evaluates a rule, and charges it as a part of Section 5.
    ///
    /// # Errors
    /// Returns the error of the machine if it fails.
    fn evaluate(&self, part: Part, rule: &dyn Evaluation) -> Result<Evaluated, Self::Error>;
}

/// Returns the values of `f` for all items, in their order. Each item is a lane of one vector step.
///
/// # Errors
/// Returns the error of the machine if it fails.
pub fn evaluated<P: Point, M: Evaluator<P>, T: Words + Sync, U: Words>(
    machine: &M,
    part: Part,
    items: &[T],
    f: impl Fn(T, &mut Cost) -> U + Sync,
) -> Result<Vec<U>, M::Error> {
    if items.is_empty() {
        return Ok(Vec::new());
    }
    Ok(machine.evaluate(part, &Map { items, function: f })?.read())
}

/// Runs a function that counts the nodes and items of search trees that one processor visits, and charges them in
/// sequence.
pub(crate) fn in_sequence<T>(own: &mut Cost, f: impl FnOnce(&mut Sweep) -> T) -> T {
    let mut visits = own.sweep();
    let value = f(&mut visits);
    own.charge_sequence(visits);
    value
}

/// Evaluates rules with an executor, without counts.
#[derive(Clone, Copy, Debug, Default)]
pub struct Uncounted<E>(pub E);

/// The number of items of a rule per item of a map.
const CHUNK: usize = 256;

impl<P: Point, E: Executor> Evaluator<P> for Uncounted<E> {
    type Error = Infallible;

    fn evaluate(&self, _part: Part, rule: &dyn Evaluation) -> Result<Evaluated, Infallible> {
        let meter = Cost::of_subproblem(false);
        let level = |items: &Items| {
            let all: Vec<&[u64]> = items.iter().collect();
            let chunks: Vec<&[&[u64]]> = all.chunks(CHUNK).collect();
            let parts = self.0.map(&chunks, |chunk| Made::of(rule, chunk.iter().copied(), &meter));
            let mut made = Made::new(&meter);
            for part in parts {
                made.append(part);
            }
            made
        };
        Ok(alone(rule, level))
    }
}

/// Returns a value that cannot be an error.
pub(crate) fn always<T>(result: Result<T, Infallible>) -> T {
    match result {
        Ok(value) => value,
        Err(never) => match never {},
    }
}
