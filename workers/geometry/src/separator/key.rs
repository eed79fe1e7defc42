//! The identity of a draw, and its random streams.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// The parameters of a draw besides the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DrawKey {
    /// Seed of the run.
    pub seed: u64,
    /// Number of the subproblem.
    pub node: u64,
    /// Number of earlier attempts for this subproblem.
    pub attempt: u32,
}

impl DrawKey {
    /// Returns a random stream of the draw.
    pub(super) fn stream(self, stream: u64) -> ChaCha8Rng {
        let mut bytes = [0; 32];
        bytes[..8].copy_from_slice(&self.seed.to_le_bytes());
        bytes[8..16].copy_from_slice(&self.node.to_le_bytes());
        bytes[16..20].copy_from_slice(&self.attempt.to_le_bytes());
        bytes[24..].copy_from_slice(b"separate");
        let mut rng = ChaCha8Rng::from_seed(bytes);
        rng.set_stream(stream);
        rng
    }
}
