//! Number types of binary files.

use std::fmt;

/// The type of the coordinates in a binary file. All types are converted to doubles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CoordinateType {
    /// 32-bit floating-point numbers.
    Float32,
    /// 64-bit floating-point numbers.
    Float64,
    /// Integers of any size.
    Integer,
}

impl fmt::Display for CoordinateType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            CoordinateType::Float32 => "float32",
            CoordinateType::Float64 => "float64",
            CoordinateType::Integer => "integer",
        })
    }
}

/// The byte order of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Endian {
    Little,
    Big,
}

/// A number type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    /// Returns the type with this name in a PLY header.
    pub fn of_ply(name: &[u8]) -> Option<Scalar> {
        Some(match name {
            b"char" | b"int8" => Scalar::I8,
            b"uchar" | b"uint8" => Scalar::U8,
            b"short" | b"int16" => Scalar::I16,
            b"ushort" | b"uint16" => Scalar::U16,
            b"int" | b"int32" => Scalar::I32,
            b"uint" | b"uint32" => Scalar::U32,
            b"float" | b"float32" => Scalar::F32,
            b"double" | b"float64" => Scalar::F64,
            b"int64" => Scalar::I64,
            b"uint64" => Scalar::U64,
            _ => return None,
        })
    }

    /// Returns the type with this name in a VTK XML file.
    pub fn of_vtk(name: &str) -> Option<Scalar> {
        Some(match name {
            "Int8" => Scalar::I8,
            "UInt8" => Scalar::U8,
            "Int16" => Scalar::I16,
            "UInt16" => Scalar::U16,
            "Int32" => Scalar::I32,
            "UInt32" => Scalar::U32,
            "Int64" => Scalar::I64,
            "UInt64" => Scalar::U64,
            "Float32" => Scalar::F32,
            "Float64" => Scalar::F64,
            _ => return None,
        })
    }

    /// Returns the type with this lower-case name in a legacy VTK file.
    pub fn of_legacy_vtk(name: &[u8]) -> Option<Scalar> {
        Some(match name {
            b"char" | b"signed_char" => Scalar::I8,
            b"unsigned_char" => Scalar::U8,
            b"short" => Scalar::I16,
            b"unsigned_short" => Scalar::U16,
            // VTK writes its ids in 32 bits, whatever their size in memory is.
            b"int" | b"vtkidtype" => Scalar::I32,
            b"unsigned_int" => Scalar::U32,
            b"long" | b"vtktypeint64" => Scalar::I64,
            b"unsigned_long" | b"vtktypeuint64" => Scalar::U64,
            b"float" => Scalar::F32,
            b"double" => Scalar::F64,
            _ => return None,
        })
    }

    /// Returns the type with this `NumPy` kind and size, such as `f8`. The byte order is not part of the name.
    pub fn of_numpy(name: &[u8]) -> Option<Scalar> {
        Some(match name {
            b"i1" => Scalar::I8,
            b"u1" => Scalar::U8,
            b"i2" => Scalar::I16,
            b"u2" => Scalar::U16,
            b"i4" => Scalar::I32,
            b"u4" => Scalar::U32,
            b"i8" => Scalar::I64,
            b"u8" => Scalar::U64,
            b"f4" => Scalar::F32,
            b"f8" => Scalar::F64,
            _ => return None,
        })
    }

    /// Returns the number of bytes of a number.
    pub fn size(self) -> usize {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::I64 | Scalar::U64 | Scalar::F64 => 8,
        }
    }

    /// Returns the type of coordinates that are stored as these numbers.
    pub fn coordinate_type(self) -> CoordinateType {
        match self {
            Scalar::F32 => CoordinateType::Float32,
            Scalar::F64 => CoordinateType::Float64,
            _ => CoordinateType::Integer,
        }
    }

    pub fn is_integer(self) -> bool {
        !matches!(self, Scalar::F32 | Scalar::F64)
    }

    /// Returns the bits of a number: the first bytes of `bytes`. Missing bytes are zero.
    fn bits(self, bytes: &[u8], endian: Endian) -> u64 {
        if let (8, Some(all)) = (self.size(), bytes.first_chunk()) {
            return match endian {
                Endian::Little => u64::from_le_bytes(*all),
                Endian::Big => u64::from_be_bytes(*all),
            };
        }
        let size = self.size().min(bytes.len());
        let mut all = [0; 8];
        all[..size].copy_from_slice(&bytes[..size]);
        if endian == Endian::Big {
            all[..size].reverse();
        }
        u64::from_le_bytes(all)
    }

    /// Returns the number as a double.
    pub fn float(self, bytes: &[u8], endian: Endian) -> f64 {
        let bits = self.bits(bytes, endian);
        match self {
            Scalar::F64 => f64::from_bits(bits),
            Scalar::F32 => f64::from(f32::from_bits(bits as u32)),
            _ => self.integer(bytes, endian) as f64,
        }
    }

    /// Returns the number as an integer, rounded towards zero.
    pub fn integer(self, bytes: &[u8], endian: Endian) -> i128 {
        let bits = self.bits(bytes, endian);
        match self {
            Scalar::I8 => i128::from(bits as u8 as i8),
            Scalar::I16 => i128::from(bits as u16 as i16),
            Scalar::I32 => i128::from(bits as u32 as i32),
            Scalar::I64 => i128::from(bits as i64),
            Scalar::U8 | Scalar::U16 | Scalar::U32 | Scalar::U64 => i128::from(bits),
            Scalar::F32 => f32::from_bits(bits as u32) as i128,
            Scalar::F64 => f64::from_bits(bits) as i128,
        }
    }

    /// Returns `true` if the number is an integer that a double cannot represent.
    pub fn rounds(self, bytes: &[u8], endian: Endian) -> bool {
        matches!(self, Scalar::I64 | Scalar::U64) && {
            let exact = self.integer(bytes, endian);
            exact as f64 as i128 != exact
        }
    }
}
