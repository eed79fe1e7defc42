//! The rows of a generated set on each of several processes.

use std::ops::Range;

use septet_core::generate::{Request, SeparateRows};
use septet_io::read::{SharedPoints, share_points};

use super::team::Team;
use crate::errors::Failure;
use crate::input::make;
use crate::progress::Talk;

/// Generates the rows of this process, or receives them from the first process, which then generates the set. Also returns the
/// Lipschitz constant of an f-spaced set. `block` returns the rows of this process, of the given number of rows.
pub(super) fn rows(
    request: &Request,
    team: &mut Team<'_>,
    block: &dyn Fn(u64) -> Range<u64>,
    talk: &Talk,
) -> Result<(SharedPoints, Option<f64>), Failure> {
    let separate = SeparateRows::of(request).map_err(Failure::from);
    if let Some(set) = team.agree(separate)? {
        let own = block(set.count());
        let points = set.points(own.clone());
        let held = SharedPoints::of_block(points, own.start, set.count());
        return Ok((SharedPoints { notes: set.notes(request), ..held }, None));
    }
    let made = team.first_only(|| make(request, talk))?;
    let spacing = made.as_ref().and_then(|made| made.spacing);
    let spacing = team.processes.all_gather(&spacing)?.swap_remove(0);
    Ok((share_points(&mut team.processes, made.map(|made| made.points), block)?, spacing))
}
