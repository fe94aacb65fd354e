//! A file that a database may read and change, while the file itself is unchanged: writes stay in memory. So a damaged
//! file can be opened, and the database can repair it in memory, without a risk.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

use parking_lot::Mutex;
use redb::StorageBackend;

/// Bytes that are kept together.
const PAGE: u64 = 4096;

/// A file below what was written since.
#[derive(Debug)]
pub(super) struct Overlay(Mutex<Layers>);

#[derive(Debug)]
struct Layers {
    file: File,
    /// The remaining length of the file, and the total length.
    below: u64,
    length: u64,
    /// Pages that were written, by their number.
    written: BTreeMap<u64, Vec<u8>>,
}

impl Overlay {
    pub(super) fn new(file: File) -> io::Result<Self> {
        let length = file.metadata()?.len();
        Ok(Self(Mutex::new(Layers {
            file,
            below: length,
            length,
            written: BTreeMap::new(),
        })))
    }
}

impl Layers {
    fn read(&mut self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        let end = offset + out.len() as u64;
        if end > self.length {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        out.fill(0);
        if offset < self.below {
            let there = (self.below.min(end) - offset) as usize;
            self.file.seek(SeekFrom::Start(offset))?;
            self.file.read_exact(&mut out[..there])?;
        }
        for (number, page) in self.written.range(offset / PAGE..end.div_ceil(PAGE)) {
            let begin = number * PAGE;
            let (from, to) = (offset.max(begin), end.min(begin + PAGE));
            out[(from - offset) as usize..(to - offset) as usize]
                .copy_from_slice(&page[(from - begin) as usize..(to - begin) as usize]);
        }
        Ok(())
    }

    fn write(&mut self, offset: u64, data: &[u8]) -> io::Result<()> {
        let end = offset + data.len() as u64;
        for number in offset / PAGE..end.div_ceil(PAGE) {
            let begin = number * PAGE;
            let mut page = vec![0; PAGE as usize];
            let known = (self.length.saturating_sub(begin)).min(PAGE) as usize;
            self.read(begin, &mut page[..known])?;
            let (from, to) = (offset.max(begin), end.min(begin + PAGE));
            page[(from - begin) as usize..(to - begin) as usize]
                .copy_from_slice(&data[(from - offset) as usize..(to - offset) as usize]);
            self.written.insert(number, page);
        }
        self.length = self.length.max(end);
        Ok(())
    }

    /// Truncated bytes do not come back: new bytes are zero.
    fn set_length(&mut self, length: u64) {
        self.below = self.below.min(length);
        self.length = length;
        self.written.split_off(&length.div_ceil(PAGE));
        if let Some(last) = self.written.get_mut(&(length / PAGE)) {
            last[(length % PAGE) as usize..].fill(0);
        }
    }
}

impl StorageBackend for Overlay {
    fn len(&self) -> io::Result<u64> {
        Ok(self.0.lock().length)
    }

    fn read(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        self.0.lock().read(offset, out)
    }

    fn set_len(&self, length: u64) -> io::Result<()> {
        self.0.lock().set_length(length);
        Ok(())
    }

    fn sync_data(&self) -> io::Result<()> {
        Ok(())
    }

    fn write(&self, offset: u64, data: &[u8]) -> io::Result<()> {
        self.0.lock().write(offset, data)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn writes_are_visible_and_the_file_is_unchanged() {
        let mut file = tempfile::tempfile().unwrap();
        let mut expected: Vec<u8> = (0..10_000).map(|i| i as u8).collect();
        file.write_all(&expected).unwrap();
        let overlay = Overlay::new(file.try_clone().unwrap()).unwrap();
        let check = |expected: &[u8]| {
            assert_eq!(overlay.len().unwrap(), expected.len() as u64);
            for (offset, length) in [(0, expected.len()), (4000, 200), (4095, 2), (5000, 0)] {
                let mut read = vec![7; length];
                overlay.read(offset as u64, &mut read).unwrap();
                assert_eq!(read, expected[offset..][..length]);
            }
            assert!(overlay.read(expected.len() as u64, &mut [0]).is_err());
        };
        check(&expected);
        for (offset, data) in [(0, [1; 320]), (4000, [2; 320]), (9990, [3; 320])] {
            overlay.write(offset as u64, &data).unwrap();
            expected.resize(expected.len().max(offset + 320), 0);
            expected[offset..][..320].copy_from_slice(&data);
            check(&expected);
        }
        for length in [20_000, 9_000, 12_000, 6_000, 30_000] {
            overlay.set_len(length as u64).unwrap();
            expected.resize(length, 0);
            check(&expected);
        }
        assert_eq!(file.metadata().unwrap().len(), 10_000);
    }
}
