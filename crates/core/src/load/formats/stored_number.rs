//! Numbers as recorders store them.

/// A type of number, stored in its own size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StoredNumber {
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

impl StoredNumber {
    /// Bytes it takes.
    pub(crate) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The number at the start of `bytes`, least significant byte first; `None` where they end before it does.
    pub(crate) fn read(self, bytes: &[u8]) -> Option<f64> {
        macro_rules! little {
            ($type:ty) => {
                <$type>::from_le_bytes(*bytes.first_chunk()?) as f64
            };
        }
        Some(match self {
            Self::I8 => little!(i8),
            Self::U8 => little!(u8),
            Self::I16 => little!(i16),
            Self::U16 => little!(u16),
            Self::I32 => little!(i32),
            Self::U32 => little!(u32),
            Self::I64 => little!(i64),
            Self::U64 => little!(u64),
            Self::F32 => little!(f32),
            Self::F64 => little!(f64),
        })
    }
}
