//! Numbers in binary files.

/// The order of the bytes of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Endian {
    Little,
    Big,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
    /// The number of bytes.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The number that bytes begin with; `None` if they are too few.
    pub(super) fn read(self, bytes: &[u8], endian: Endian) -> Option<f64> {
        let bytes = bytes.get(..self.size())?;
        let mut little = [0; 8];
        let low = little.get_mut(..bytes.len())?;
        low.copy_from_slice(bytes);
        if endian == Endian::Big {
            low.reverse();
        }
        let bits = u64::from_le_bytes(little);
        Some(match self {
            Self::I8 => f64::from(bits as i8),
            Self::I16 => f64::from(bits as i16),
            Self::I32 => f64::from(bits as i32),
            Self::I64 => bits as i64 as f64,
            Self::U8 | Self::U16 | Self::U32 | Self::U64 => bits as f64,
            Self::F32 => f64::from(f32::from_bits(bits as u32)),
            Self::F64 => f64::from_bits(bits),
        })
    }
}

/// The number at a place of a little-endian file.
pub(super) fn field(bytes: &[u8], offset: usize, kind: Scalar) -> Option<f64> {
    kind.read(bytes.get(offset..)?, Endian::Little)
}

/// The count or size at a place of a little-endian file.
pub(super) fn count_field(bytes: &[u8], offset: usize, kind: Scalar) -> Option<usize> {
    as_count(field(bytes, offset, kind)?)
}

/// The bytes of a file that are not read yet.
#[derive(Clone, Debug)]
pub(super) struct Cursor<'a> {
    rest: &'a [u8],
    endian: Endian,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(rest: &'a [u8], endian: Endian) -> Self {
        Self { rest, endian }
    }

    /// Skips this many bytes; `None` if there are fewer, and then it stays where it is.
    pub(super) fn skip(&mut self, count: usize) -> Option<()> {
        self.rest = self.rest.get(count..)?;
        Some(())
    }

    /// The next number.
    pub(super) fn number(&mut self, kind: Scalar) -> Option<f64> {
        let number = kind.read(self.rest, self.endian)?;
        self.skip(kind.size())?;
        Some(number)
    }

    /// The next number, which is a count.
    pub(super) fn count(&mut self, kind: Scalar) -> Option<usize> {
        self.number(kind).and_then(as_count)
    }

    /// The number of bytes left.
    pub(super) fn len(&self) -> usize {
        self.rest.len()
    }
}

/// A number that is a count. Counts that no file can have become the largest one.
fn as_count(number: f64) -> Option<usize> {
    (number >= 0.0 && number.fract() == 0.0).then_some(number as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_a_type_and_an_order_of_bytes() {
        let bytes = [0xff, 0xfe, 0x00, 0x01, 0x80, 0x02, 0x03, 0x04];
        for (kind, little, big) in [
            (Scalar::I8, -1.0, -1.0),
            (Scalar::U8, 255.0, 255.0),
            (Scalar::I16, -257.0, -2.0),
            (Scalar::U16, 65279.0, 65534.0),
            (Scalar::I32, 16_842_495.0, -131_071.0),
            (Scalar::U32, 16_842_495.0, 4_294_836_225.0),
        ] {
            assert_eq!(kind.read(&bytes, Endian::Little), Some(little), "{kind:?}");
            assert_eq!(kind.read(&bytes, Endian::Big), Some(big), "{kind:?}");
        }
        for endian in [Endian::Little, Endian::Big] {
            let of = |little: &[u8]| match endian {
                Endian::Little => little.to_vec(),
                Endian::Big => little.iter().rev().copied().collect(),
            };
            let read = |kind: Scalar, bytes: &[u8]| kind.read(&of(bytes), endian);
            assert_eq!(read(Scalar::F32, &1.5_f32.to_le_bytes()), Some(1.5));
            assert_eq!(read(Scalar::F64, &(-0.1_f64).to_le_bytes()), Some(-0.1));
            assert_eq!(read(Scalar::I64, &(-7_i64).to_le_bytes()), Some(-7.0));
            assert_eq!(
                read(Scalar::U64, &u64::MAX.to_le_bytes()),
                Some(2_f64.powi(64))
            );
        }
        assert_eq!(Scalar::F64.read(&bytes[1..], Endian::Little), None);
    }

    #[test]
    fn a_cursor_ends_with_its_bytes() {
        let mut cursor = Cursor::new(&[2, 0, 0xff, 0xff], Endian::Little);
        assert_eq!(cursor.count(Scalar::U16), Some(2));
        assert_eq!(cursor.clone().count(Scalar::I16), None);
        assert_eq!(cursor.skip(3), None);
        assert_eq!((cursor.len(), cursor.skip(2)), (2, Some(())));
        assert_eq!(cursor.number(Scalar::U8), None);
        assert_eq!(count_field(&[1, 0, 3, 0], 2, Scalar::U16), Some(3));
        assert_eq!(field(&[1, 0], usize::MAX, Scalar::U8), None);
    }
}
