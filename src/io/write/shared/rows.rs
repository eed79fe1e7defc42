//! The table of rows on every process.

use std::borrow::Cow;

use septet_protocol::codec::Bulk;
use septet_protocol::wire::{Ended, Processes, WireError};

use super::counts::Counts;
use super::fault::{describe, fits};
use super::mesh::SharedMesh;
use crate::read::Column;
use crate::write::row_table::RowTable;

/// Returns the numbers in the input of the rows of all processes, if rows were dropped, and the columns of process 0.
pub(super) fn gather<'a>(
    processes: &mut Processes<'_>,
    mesh: &SharedMesh<'a>,
    counts: &Counts,
    columns: &[Column],
) -> Result<RowTable<'a>, Ended> {
    let names: Vec<String> = columns.iter().map(|column| column.name.clone()).collect();
    let names = processes.all_gather(&names)?.swap_remove(0);
    let rows = counts.row_count();
    let words = names.len() + usize::from(mesh.dropped > 0);
    // Process 0 holds a copy for each process while they travel.
    let copies = u64::from(processes.processes());
    processes.agree(fits((rows as u64).saturating_mul(8 * words as u64 * copies)), describe)?;
    let source = if mesh.dropped > 0 {
        let own = Bulk(mesh.source_index.unwrap_or_default().to_vec());
        Some(Cow::Owned(processes.all_gather(&own)?.into_iter().flat_map(|source| source.0).collect()))
    } else {
        None
    };
    let mut table = RowTable {
        first: counts.rows.start,
        source,
        heights: mesh.heights.map(Cow::Borrowed),
        columns: Cow::default(),
    };
    for (at, name) in names.into_iter().enumerate() {
        let own = columns.get(at).map_or_else(Vec::new, |column| column.values.clone());
        let values = processes.all_gather(&Bulk(own))?.swap_remove(0).0;
        if values.len() != rows {
            let reason = format!("a column has {} of {rows} values", values.len());
            return Err(WireError::Corrupt { process: 0, reason }.into());
        }
        table.columns.to_mut().push(Column { name, values });
    }
    Ok(table)
}
