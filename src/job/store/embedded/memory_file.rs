//! Memory that a database uses as its file.

use std::io::{self, ErrorKind};
use std::sync::Arc;

use parking_lot::RwLock;
use redb::StorageBackend;

/// Bytes of a chunk. Chunks are allocated when they are first written: a database makes its file up to
/// twice as long as it needs it.
const CHUNK: usize = 256 << 10;

/// The bytes of a file. All clones are the same file, so that a database can be opened again after an
/// error. Unlike [`redb::backends::InMemoryBackend`] it is never copied when it grows.
#[derive(Clone, Debug, Default)]
pub(super) struct MemoryFile(Arc<RwLock<Chunks>>);

#[derive(Debug, Default)]
struct Chunks {
    length: usize,
    /// A chunk that was never written has zeros only.
    chunks: Vec<Option<Box<[u8]>>>,
}

impl Chunks {
    /// The position of the first of `count` bytes, if the file has all of them.
    fn position(&self, offset: u64, count: usize) -> io::Result<usize> {
        let begin = usize::try_from(offset).ok();
        let end = begin.and_then(|begin| begin.checked_add(count));
        let begin = begin.filter(|_| end.is_some_and(|end| end <= self.length));
        begin.ok_or_else(|| ErrorKind::UnexpectedEof.into())
    }
}

/// How many of `count` bytes from a position on are in the chunk of the first one.
fn within_chunk(position: usize, count: usize) -> usize {
    count.min(CHUNK - position % CHUNK)
}

impl StorageBackend for MemoryFile {
    fn len(&self) -> io::Result<u64> {
        Ok(self.0.read().length as u64)
    }

    fn read(&self, offset: u64, mut out: &mut [u8]) -> io::Result<()> {
        let content = self.0.read();
        let mut position = content.position(offset, out.len())?;
        while !out.is_empty() {
            let count = within_chunk(position, out.len());
            let (piece, rest) = out.split_at_mut(count);
            match &content.chunks[position / CHUNK] {
                Some(chunk) => piece.copy_from_slice(&chunk[position % CHUNK..][..count]),
                None => piece.fill(0),
            }
            position += count;
            out = rest;
        }
        Ok(())
    }

    fn set_len(&self, length: u64) -> io::Result<()> {
        let length = usize::try_from(length).map_err(|_| ErrorKind::FileTooLarge)?;
        let mut content = self.0.write();
        content.chunks.resize(length.div_ceil(CHUNK), None);
        // What was cut off must be zeros when the file grows again.
        if length < content.length
            && let Some(Some(chunk)) = content.chunks.get_mut(length / CHUNK)
        {
            chunk[length % CHUNK..].fill(0);
        }
        content.length = length;
        Ok(())
    }

    /// What is in memory cannot get any safer.
    fn sync_data(&self) -> io::Result<()> {
        Ok(())
    }

    fn write(&self, offset: u64, mut data: &[u8]) -> io::Result<()> {
        let mut content = self.0.write();
        let mut position = content.position(offset, data.len())?;
        while !data.is_empty() {
            let (piece, rest) = data.split_at(within_chunk(position, data.len()));
            let chunk = content.chunks[position / CHUNK]
                .get_or_insert_with(|| vec![0; CHUNK].into_boxed_slice());
            chunk[position % CHUNK..][..piece.len()].copy_from_slice(piece);
            position += piece.len();
            data = rest;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_read_as_they_were_written_across_chunks() {
        let file = MemoryFile::default();
        file.set_len(3 * CHUNK as u64 + 5).unwrap();
        let data: Vec<u8> = (0..CHUNK + 100).map(|i| i as u8 | 1).collect();
        file.write(CHUNK as u64 - 50, &data).unwrap();
        let mut read = vec![9; data.len() + 100];
        file.clone().read(CHUNK as u64 - 100, &mut read).unwrap();
        assert!(
            read[..50]
                .iter()
                .chain(&read[50 + data.len()..])
                .all(|byte| *byte == 0)
        );
        assert_eq!(read[50..][..data.len()], data);
    }

    #[test]
    fn what_was_cut_off_is_zero_when_the_file_grows_again() {
        let file = MemoryFile::default();
        file.set_len(2 * CHUNK as u64).unwrap();
        file.write(0, &vec![7; 2 * CHUNK]).unwrap();
        file.set_len(10).unwrap();
        file.set_len(2 * CHUNK as u64).unwrap();
        let mut read = vec![9; 2 * CHUNK];
        file.read(0, &mut read).unwrap();
        assert!(read[..10].iter().all(|byte| *byte == 7));
        assert!(read[10..].iter().all(|byte| *byte == 0));
    }

    #[test]
    fn bytes_beyond_the_end_are_refused() {
        let file = MemoryFile::default();
        file.set_len(100).unwrap();
        for (offset, count) in [(99, 2), (101, 0), (u64::MAX, 1)] {
            assert!(file.read(offset, &mut vec![0; count]).is_err());
            assert!(file.write(offset, &vec![0; count]).is_err());
        }
        assert!(file.write(100, &[]).is_ok());
    }
}
