//! Hidden options of runs by several processes, for tests.

use clap::Args;
use septet_protocol::wire::PartBytes;

use super::effects::needs;
use super::errors::Failure;
use septet_core::spec::bytes;

/// Hidden options of runs by several processes.
#[derive(Debug, Args)]
pub struct HiddenArgs {
    /// Cut messages between processes into parts of at most this many bytes, for tests [default: 256M]
    #[arg(long, hide = true, value_name = "BYTES", value_parser = part_bytes)]
    pub part_bytes: Option<PartBytes>,
    /// Number the rows of the input from this number on, for tests
    #[arg(long, hide = true, value_name = "N", value_parser = clap::value_parser!(u64).range(..=MOST_FIRST_ROW))]
    pub first_row: Option<u64>,
}

/// The largest number of a first row. All rows then have signed numbers of 64 bits, as outputs need.
const MOST_FIRST_ROW: u64 = 1 << 62;

/// The smallest number of bytes of a part. Over MPI, the many parts of long messages would take minutes.
const LEAST_PART_BYTES: u64 = 32;

impl HiddenArgs {
    /// Refuses these options in a run by one process, in which they have no effect.
    pub fn refuse(&self) -> Result<(), Failure> {
        needs("--part-bytes", self.part_bytes.is_some(), "--transport processes", false)?;
        needs("--first-row", self.first_row.is_some(), "--transport processes", false)
    }
}

fn part_bytes(text: &str) -> Result<PartBytes, String> {
    let number = bytes(text)?;
    PartBytes::new(number)
        .filter(|_| number >= LEAST_PART_BYTES)
        .ok_or_else(|| format!("expected {LEAST_PART_BYTES} to 1G bytes"))
}
