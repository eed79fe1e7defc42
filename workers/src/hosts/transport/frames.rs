//! The frames of a round, as bytes of a stream.
//!
//! A round is its head and its frames. Integers are little-endian.
//!
//! | part | bytes |
//! |---|---|
//! | head of a round | state u8, number of frames u32, checksum u64 |
//! | frame | receiver u32, length u64, checksum u64, the bytes of the message, checksum u64 |
//!
//! A checksum covers the bytes between the checksum before it and itself. A length is therefore checked before any of its
//! bytes is awaited, and memory grows with the bytes that arrive.

use std::io::{Error, ErrorKind, Read, Result, Write};

use septet_protocol::checksum::checksum;
use septet_protocol::codec::FRAME_LIMIT;
use septet_protocol::ids::Rank;

/// A frame and its receiver.
pub(super) type Frame = (Rank, Vec<u8>);

/// Writes bytes and their checksum.
fn write_sealed(to: &mut impl Write, bytes: &[u8]) -> Result<()> {
    to.write_all(bytes)?;
    to.write_all(&checksum(bytes).to_le_bytes())
}

/// Reads the checksum of some bytes.
///
/// # Errors
/// Fails with [`ErrorKind::InvalidData`] if it is not that of the bytes.
fn check(from: &mut impl Read, bytes: &[u8]) -> Result<()> {
    let mut sum = [0; 8];
    from.read_exact(&mut sum)?;
    if u64::from_le_bytes(sum) == checksum(bytes) {
        return Ok(());
    }
    Err(Error::new(ErrorKind::InvalidData, "the checksum of a frame is wrong: bytes changed on the way"))
}

/// Reads `N` bytes and their checksum.
fn read_sealed<const N: usize>(from: &mut impl Read) -> Result<[u8; N]> {
    let mut bytes = [0; N];
    from.read_exact(&mut bytes)?;
    check(from, &bytes).map(|()| bytes)
}

/// Writes a round.
pub(super) fn write_round(to: &mut impl Write, state: u8, frames: &[Frame]) -> Result<()> {
    let [a, b, c, d] = (frames.len() as u32).to_le_bytes();
    write_sealed(to, &[state, a, b, c, d])?;
    for (rank, bytes) in frames {
        let mut head = [0; 12];
        head[..4].copy_from_slice(&rank.to_le_bytes());
        head[4..].copy_from_slice(&(bytes.len() as u64).to_le_bytes());
        write_sealed(to, &head)?;
        write_sealed(to, bytes)?;
    }
    to.flush()
}

/// Reads a round: its state and its frames.
///
/// # Errors
/// Fails if the stream ends, or with [`ErrorKind::InvalidData`] if a checksum is wrong or a frame is too long.
pub(super) fn read_round(from: &mut impl Read) -> Result<(u8, Vec<Frame>)> {
    let [state, count @ ..] = read_sealed::<5>(from)?;
    let mut frames = Vec::new();
    for _ in 0..u32::from_le_bytes(count) {
        let [a, b, c, d, length @ ..] = read_sealed::<12>(from)?;
        let length = u64::from_le_bytes(length);
        if length > FRAME_LIMIT as u64 {
            return Err(Error::new(ErrorKind::InvalidData, format!("a frame of {length} bytes")));
        }
        let mut bytes = Vec::new();
        if from.by_ref().take(length).read_to_end(&mut bytes)? as u64 != length {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        check(from, &bytes)?;
        frames.push((Rank::from_le_bytes([a, b, c, d]), bytes));
    }
    Ok((state, frames))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every flipped bit of a round is refused, and so is every round that is cut.
    #[test]
    fn rounds_arrive_unchanged_or_not_at_all() {
        let frames = vec![(3, b"some bytes".to_vec()), (0, Vec::new()), (1, vec![0; 100])];
        let mut stream = Vec::new();
        write_round(&mut stream, 1, &frames).unwrap();
        assert_eq!(read_round(&mut stream.as_slice()).unwrap(), (1, frames));
        for bit in 0..8 * stream.len() {
            let mut flipped = stream.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let error = read_round(&mut flipped.as_slice()).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::InvalidData, "bit {bit}: {error}");
        }
        assert!((0..stream.len()).all(|end| read_round(&mut &stream[..end]).is_err()));
    }
}
