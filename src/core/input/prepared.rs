//! The input of a run after the machine has prepared it.

use septet_geometry::range::RangeError;
use septet_protocol::message::PointSum;
use septet_workers::config::WorkerConfig;
use septet_workers::input::Loaded;
use septet_workers::share::Share;

use crate::error::{Error, incomplete};
use crate::result::run::Accounting;

/// The input of a run, as all ranks prepared it.
#[derive(Clone, Debug)]
pub(crate) struct Prepared {
    /// The rows by their use.
    pub(crate) accounting: Accounting,
    /// The distinct points.
    pub(crate) population: PointSum,
    /// Dimension of the affine hull; -1 for no points.
    pub(crate) dimension: isize,
    /// The exponent of the power of two by which coordinates were multiplied.
    pub(crate) exponent: i32,
}

impl Prepared {
    /// Joins the accounts of the shares of all ranks. The share of the coordinator comes first.
    ///
    /// # Errors
    /// Fails if a row is not finite and such rows are not skipped, if the digits of the coordinates spread too far, or
    /// if rows are missing.
    pub(crate) fn of<P>(shares: &mut [Share<P>], config: &WorkerConfig) -> Result<Self, Error> {
        let Some(Loaded { survey, population, dimension, .. }) =
            shares.first().map(|share| share.loaded.clone())
        else {
            return Err(incomplete("the machine returned no share".to_string()));
        };
        let exponent =
            survey.exponent(config.task.skips_invalid()).map_err(|error: RangeError| Error::Points(error))?;
        let (mut duplicates, mut refused) = (Vec::new(), Vec::new());
        for share in shares {
            duplicates.extend(
                std::mem::take(&mut share.loaded.repeated).into_iter().map(|[row, first]| (row, first)),
            );
            refused.append(&mut share.loaded.refused);
        }
        duplicates.sort_unstable();
        refused.sort_unstable();
        let accounting = Accounting { input: survey.rows, used: population.count, duplicates, refused };
        let counted = accounting.used + (accounting.duplicates.len() + accounting.refused.len()) as u64;
        if counted != survey.rows {
            return Err(incomplete(format!("the ranks account for {counted} of {} rows", survey.rows)));
        }
        Ok(Prepared { accounting, population, dimension, exponent })
    }

    /// Returns `true` if the points do not span a space of this dimension.
    pub(crate) fn is_flat(&self, space: usize) -> bool {
        self.dimension < space as isize
    }

    /// Returns the worker of each row if one worker holds all points: 1 for the vertices, and 0 for the other rows.
    pub(crate) fn all_of_one(&self) -> Vec<u32> {
        let mut owners = vec![1; self.accounting.input as usize];
        let rows = self.accounting.duplicates.iter().map(|&(row, _)| row);
        rows.chain(self.accounting.refused.iter().copied()).for_each(|row| owners[row as usize] = 0);
        owners
    }
}
