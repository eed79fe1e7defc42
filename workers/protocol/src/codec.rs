//! The codec: the only module that converts between values and bytes.
//!
//! Headers and small fields use bincode 2 with fixed-width little-endian integers. bincode 1 has the same layout, so
//! another implementation can replace the codec. Large arrays use [`Bulk`]: a length and the raw little-endian memory
//! of plain data, copied at memory speed.
//!
//! Decoding does not trust its input:
//! 1. The length of the frame is checked first.
//! 2. The total number of bytes is limited.
//! 3. Arrays are read in steps, so a hostile length cannot allocate memory without the bytes for it.
//! 4. Trailing bytes are an error.

use bincode::config::{Configuration, Fixint, Limit, LittleEndian};
use bincode::de::read::Reader;
use bincode::de::{BorrowDecode, BorrowDecoder, Decoder};
use bincode::enc::Encoder;
use bincode::enc::write::{SizeWriter, Writer};
use bincode::error::{DecodeError, EncodeError};
use bincode::{Decode, Encode};
use bytemuck::Pod;
use thiserror::Error;

#[cfg(target_endian = "big")]
compile_error!("bulk arrays are little-endian memory: a big-endian machine needs a swap in codec.rs");

/// The largest length of a frame in bytes: 4 GiB.
pub const FRAME_LIMIT: usize = 1 << 32;

type Layout = Configuration<LittleEndian, Fixint, Limit<FRAME_LIMIT>>;

fn layout() -> Layout {
    bincode::config::standard().with_fixed_int_encoding().with_limit::<FRAME_LIMIT>()
}

/// The reason why a value does not encode or decode.
#[derive(Debug, Error)]
pub enum CodecError {
    /// The frame is longer than the protocol allows.
    #[error("a frame of {bytes} bytes is above the limit of {FRAME_LIMIT}")]
    TooLong {
        /// The length of the frame.
        bytes: usize,
    },
    /// The bytes do not decode.
    #[error("malformed message: {0}")]
    Malformed(#[from] DecodeError),
    /// The bytes decode to a value without a meaning.
    #[error("{what} is corrupt")]
    Corrupt {
        /// The value.
        what: &'static str,
    },
    /// The value does not encode.
    #[error("message cannot be encoded: {0}")]
    Unencodable(#[from] EncodeError),
    /// Bytes follow the message.
    #[error("{extra} bytes follow the message")]
    Trailing {
        /// Number of these bytes.
        extra: usize,
    },
}

/// Encodes a value.
///
/// # Errors
/// Fails if the codec rejects the value, or if its bytes exceed the limit.
pub fn encode<T: Encode>(value: &T) -> Result<Vec<u8>, CodecError> {
    Ok(bincode::encode_to_vec(value, layout())?)
}

/// Returns the exact length of the result of [`encode`].
pub fn encoded_len<T: Encode>(value: &T) -> usize {
    let mut size = SizeWriter::default();
    // Counting cannot fail, because the writer only adds lengths.
    let _ = bincode::encode_into_writer(value, &mut size, layout());
    size.bytes_written
}

/// Encodes a value into a writer.
pub(crate) fn encode_into<T: Encode>(value: &T, writer: &mut impl Writer) -> Result<(), EncodeError> {
    bincode::encode_into_writer(value, writer, layout())
}

/// Decodes a whole frame.
///
/// # Errors
/// Fails if the frame is too long, malformed or longer than its message.
pub fn decode<T: Decode<()>>(bytes: &[u8]) -> Result<T, CodecError> {
    if bytes.len() > FRAME_LIMIT {
        return Err(CodecError::TooLong { bytes: bytes.len() });
    }
    let (value, used) = bincode::decode_from_slice(bytes, layout())?;
    if used != bytes.len() {
        return Err(CodecError::Trailing { extra: bytes.len() - used });
    }
    Ok(value)
}

/// An array of plain data that is encoded as its memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bulk<T>(pub Vec<T>);

impl<T> std::ops::Deref for Bulk<T> {
    type Target = Vec<T>;
    fn deref(&self) -> &Vec<T> {
        &self.0
    }
}

impl<T> std::ops::DerefMut for Bulk<T> {
    fn deref_mut(&mut self) -> &mut Vec<T> {
        &mut self.0
    }
}

impl<T> From<Vec<T>> for Bulk<T> {
    fn from(v: Vec<T>) -> Self {
        Bulk(v)
    }
}

impl<T: Pod> Encode for Bulk<T> {
    fn encode<E: Encoder>(&self, encoder: &mut E) -> Result<(), EncodeError> {
        (self.0.len() as u64).encode(encoder)?;
        encoder.writer().write(bytemuck::cast_slice(&self.0))
    }
}

/// Number of elements that are read at a time, so that memory grows with the bytes that exist.
const STEP: usize = 1 << 16;

impl<T: Pod, Context> Decode<Context> for Bulk<T> {
    fn decode<D: Decoder<Context = Context>>(decoder: &mut D) -> Result<Self, DecodeError> {
        let len = u64::decode(decoder)?;
        let bytes = len.checked_mul(size_of::<T>() as u64).filter(|&b| b <= FRAME_LIMIT as u64);
        let bytes = bytes.ok_or(DecodeError::LimitExceeded)? as usize;
        decoder.claim_bytes_read(bytes)?;
        let len = len as usize;
        let mut all: Vec<T> = Vec::new();
        while all.len() < len {
            let at = all.len();
            all.resize(len.min(at + STEP), T::zeroed());
            decoder.reader().read(bytemuck::cast_slice_mut(&mut all[at..]))?;
        }
        Ok(Bulk(all))
    }
}

impl<'de, T: Pod, Context> BorrowDecode<'de, Context> for Bulk<T> {
    fn borrow_decode<D: BorrowDecoder<'de, Context = Context>>(decoder: &mut D) -> Result<Self, DecodeError> {
        Self::decode(decoder)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bulk_round_trips_and_bills_its_length() {
        let value = (7u32, Bulk(vec![[1.5f64, -2.0, 0.25]; 3]), Bulk::<u32>(vec![]));
        let bytes = encode(&value).unwrap();
        assert_eq!(bytes.len(), encoded_len(&value));
        assert_eq!(bytes.len(), 4 + 8 + 72 + 8);
        let back: (u32, Bulk<[f64; 3]>, Bulk<u32>) = decode(&bytes).unwrap();
        assert_eq!(back, value);
    }

    #[test]
    fn hostile_lengths_are_errors() {
        let mut bytes = encode(&Bulk(vec![1u64, 2])).unwrap();
        bytes[..8].copy_from_slice(&(1u64 << 28).to_le_bytes());
        assert!(decode::<Bulk<u64>>(&bytes).is_err());
        bytes[..8].copy_from_slice(&u64::MAX.to_le_bytes());
        assert!(decode::<Bulk<u64>>(&bytes).is_err());
        let mut long = encode(&Bulk(vec![1u64])).unwrap();
        long.push(0);
        assert!(matches!(decode::<Bulk<u64>>(&long), Err(CodecError::Trailing { extra: 1 })));
        for cut in 0..long.len() - 1 {
            assert!(decode::<Bulk<u64>>(&long[..cut]).is_err());
        }
    }
}
