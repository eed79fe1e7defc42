//! The record of all charges, for a cost trace.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use septet_geometry::cost::Tape;
use septet_protocol::ids::Rank;
use septet_protocol::ledger::Account;

/// One charge of a rank: the calls of its meter, without prices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChargeRecord {
    /// The account.
    pub account: Account,
    /// The round in which the rank made the charge.
    pub round: u32,
    /// The calls in their order.
    pub tape: Tape,
}

/// The charges of each rank, in the order in which the rank made them.
pub type ChargesByRank = BTreeMap<Rank, Vec<ChargeRecord>>;

/// A place in the caller's process for the records of ranks. Ranks in other processes have none.
#[derive(Clone, Debug, Default)]
pub struct CostLog(Option<Arc<Mutex<ChargesByRank>>>);

impl CostLog {
    /// Creates an empty log.
    pub fn recording() -> Self {
        CostLog(Some(Arc::default()))
    }

    /// Returns `true` if ranks record their charges.
    pub fn is_recording(&self) -> bool {
        self.0.is_some()
    }

    /// Files the charges of a rank, in place of earlier charges of the same rank.
    pub(crate) fn file(&self, rank: Rank, charges: Vec<ChargeRecord>) {
        if let Some(log) = &self.0 {
            log.lock().unwrap_or_else(PoisonError::into_inner).insert(rank, charges);
        }
    }

    /// Takes the charges of all ranks. Returns `None` if ranks do not record their charges.
    pub fn take(&self) -> Option<ChargesByRank> {
        self.0.as_ref().map(|log| std::mem::take(&mut *log.lock().unwrap_or_else(PoisonError::into_inner)))
    }
}
