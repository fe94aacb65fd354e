//! Unpacks compressed bodies (`Content-Encoding`) as they arrive, a bounded number of bytes at a time: some bytes can
//! stand for a thousand times as many.

use bytes::{Buf, Bytes};
use flate2::{Decompress, FlushDecompress, Status};
use zstd::stream::raw::{DParameter, Decoder, InBuffer, Operation, OutBuffer};

use super::coding::Coding;

/// The window of gzip, as a power of two.
const GZIP_WINDOW: u8 = 15;

/// The largest window that zstd may have on the web (RFC 9659), as a power of two.
const ZSTD_WINDOW: u32 = 23;

/// Unpacks a body.
pub(in crate::api) struct Unpacker {
    decoder: Format,
    /// True if the bytes so far form complete parts.
    ended: bool,
}

enum Format {
    Gzip(Decompress),
    Zstd(Decoder<'static>),
}

/// The result of one call.
struct Moved {
    read: usize,
    written: usize,
    /// True if a compressed part ends there; a body may have several.
    ended: bool,
}

impl Unpacker {
    pub(in crate::api) fn new(coding: Coding) -> Result<Self, String> {
        let decoder = match coding {
            Coding::Gzip => Format::Gzip(Decompress::new_gzip(GZIP_WINDOW)),
            Coding::Zstd => {
                let mut decoder = Decoder::new().map_err(|error| error.to_string())?;
                decoder
                    .set_parameter(DParameter::WindowLogMax(ZSTD_WINDOW))
                    .map_err(|error| error.to_string())?;
                Format::Zstd(decoder)
            }
        };
        let ended = false;
        Ok(Self { decoder, ended })
    }

    /// The memory that it takes.
    pub(in crate::api) fn memory(&self) -> usize {
        match self.decoder {
            Format::Gzip(_) => 0,
            Format::Zstd(_) => 1 << ZSTD_WINDOW,
        }
    }

    /// Returns true if the body may end here.
    pub(in crate::api) fn has_ended(&self) -> bool {
        self.ended
    }

    /// Moves at most `most` bytes from `packed` to `bytes`, unpacked. Returns true if there may be more to add.
    pub(in crate::api) fn add(
        &mut self,
        packed: &mut Bytes,
        bytes: &mut Vec<u8>,
        most: usize,
    ) -> Result<bool, String> {
        let mut end = bytes.len();
        let full = end + most;
        bytes.resize(full, 0);
        while end < full && !(packed.is_empty() && self.ended) {
            let room = bytes.get_mut(end..).unwrap_or_default();
            let moved = self.step(packed, room)?;
            packed.advance(moved.read);
            end += moved.written;
            self.ended = moved.ended;
            if packed.is_empty() && moved.written == 0 {
                break;
            }
        }
        bytes.truncate(end);
        Ok(end == full && !(packed.is_empty() && self.ended))
    }

    fn step(&mut self, packed: &[u8], room: &mut [u8]) -> Result<Moved, String> {
        match &mut self.decoder {
            Format::Gzip(decoder) => {
                if self.ended {
                    *decoder = Decompress::new_gzip(GZIP_WINDOW);
                }
                let (read, written) = (decoder.total_in(), decoder.total_out());
                let status = decoder.decompress(packed, room, FlushDecompress::None);
                let status = status.map_err(|_| "it is not gzip, or damaged".to_owned())?;
                Ok(Moved {
                    read: usize::try_from(decoder.total_in() - read).unwrap_or(usize::MAX),
                    written: usize::try_from(decoder.total_out() - written).unwrap_or(usize::MAX),
                    ended: status == Status::StreamEnd,
                })
            }
            Format::Zstd(decoder) => {
                let mut input = InBuffer::around(packed);
                let mut output = OutBuffer::around(room);
                let left = decoder.run(&mut input, &mut output);
                let left = left.map_err(|error| format!("it is not zstd, or damaged ({error})"))?;
                Ok(Moved {
                    read: input.pos(),
                    written: output.pos(),
                    ended: left == 0,
                })
            }
        }
    }
}
