//! A second account of work and depth, from the cost trace of a run.
//!
//! **Statement.** A cost trace lists calls of primitives without prices. Each row names the rows that must end before
//! it starts. [`fold`] prices the rows, adds up the work of each phase, and finds the longest paths. The results equal
//! the counts of the ledger, phase by phase ([`Accounts::differences`]).
//!
//! **Independence.** This module reads only the text of the trace. It has its own list of prices and of the phases in
//! each total, and shares no code with the ledger or with the meters of the machine.
//!
//! **Limits.** Both accounts use the calls and the numbers of items that the ranks record. In a vector step whose items
//! have their own calls (`lanes`), the machine also chooses the longest lane, by the prices of its own meters. The fold
//! checks only that the calls of this lane occur among the calls of all lanes. If the machine prices the deepest lane
//! too low, it may therefore choose another lane, and the fold does not find this fault.
//!
//! **Checks.** Every row except the first names an earlier row, and every row except the last is named by a later one.
//! The fold therefore rejects a trace without one of its rows. It also rejects a trace in which the only reference from
//! a row, or the only reference to a row, is missing.

mod clock;
mod compare;
mod error;
mod price;
mod row;
mod totals;

use std::io::BufRead;

pub use compare::{Difference, ReportedCounts, ReportedPhase, ReportedRun, ReportedTotal, ReportedTotals};
pub use error::{AccountError, ReportError};
pub use row::SCHEMA;
pub use totals::{Accounts, PhaseAccount, TotalAccount};

use clock::Clocks;
use row::{Header, Row};

/// Prices a cost trace, given as JSON lines, and finds its longest paths.
///
/// # Errors
/// Fails if the text is not a complete cost trace, or if a count is above the largest 64-bit number.
pub fn fold(mut text: impl BufRead) -> Result<Accounts, AccountError> {
    let (mut line, mut number) = (String::new(), 0);
    let mut next = || {
        line.clear();
        number += 1;
        let read =
            text.read_line(&mut line).map_err(|source| AccountError::Unreadable { line: number, source })?;
        Ok::<_, AccountError>((read > 0).then(|| (number, line.trim_end().to_owned())))
    };
    let Some((_, first)) = next()? else { return Err(AccountError::Empty) };
    let header = Header::parse(&first)?;
    let mut clocks = Clocks::default();
    while let Some((number, text)) = next()? {
        clocks.add(&Row::parse(number, &text)?)?;
    }
    clocks.finish(&header)
}

#[cfg(test)]
mod tests;
