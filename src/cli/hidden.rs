//! Hidden options of runs by several processes, for tests.

use clap::Args;
use septet_protocol::wire::PartBytes;

use super::effects::needs;
use super::errors::Failure;
use super::numbers::bytes;

/// Hidden options of runs by several processes.
#[derive(Debug, Args)]
pub struct HiddenArgs {
    /// Cut messages between processes into parts of at most this many bytes, for tests [default: 256M]
    #[arg(long, hide = true, value_name = "BYTES", value_parser = part_bytes)]
    pub part_bytes: Option<PartBytes>,
}

impl HiddenArgs {
    /// Refuses these options in a run by one process, in which they have no effect.
    pub fn refuse(&self) -> Result<(), Failure> {
        needs("--part-bytes", self.part_bytes.is_some(), "--transport processes", false)
    }
}

fn part_bytes(text: &str) -> Result<PartBytes, String> {
    PartBytes::new(bytes(text)?).ok_or_else(|| "expected 1 to 1G bytes".to_owned())
}
