//! Writes of HTTP/2 frames, several at a time.
//!
//! h2 writes each data frame by itself, and flushes it: a system call and a packet for every 16 KiB. So a large write
//! waits here for the next one, or for a flush that no write preceded.

use std::io::{self, IoSlice};
use std::pin::Pin;
use std::task::{Context, Poll, ready};

use bytes::{Buf, BytesMut};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};

/// Writes are passed on when there are this many bytes.
const PASSED_ON_BYTES: usize = 64 * 1024;

/// Writes of this many bytes are likely to be followed by others; smaller ones are passed on with their flush.
const LARGE: usize = 8 * 1024;

/// A stream that gathers large writes.
pub(super) struct GatheredWrites<S> {
    stream: S,
    gathered: BytesMut,
    /// True if there was a large write after the last flush.
    is_followed: bool,
}

impl<S: AsyncWrite + Unpin> GatheredWrites<S> {
    pub(super) fn new(stream: S) -> Self {
        Self {
            stream,
            gathered: BytesMut::new(),
            is_followed: false,
        }
    }

    /// Takes bytes, unless there are enough that cannot be passed on.
    fn gather<'a>(
        &mut self,
        context: &mut Context<'_>,
        parts: impl Iterator<Item = &'a [u8]>,
    ) -> Poll<io::Result<usize>> {
        if self.gathered.len() >= PASSED_ON_BYTES {
            ready!(self.pass_on(context))?;
        }
        let before = self.gathered.len();
        parts.for_each(|part| self.gathered.extend_from_slice(part));
        let count = self.gathered.len() - before;
        self.is_followed = count >= LARGE;
        Poll::Ready(Ok(count))
    }

    fn pass_on(&mut self, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        while !self.gathered.is_empty() {
            let stream = Pin::new(&mut self.stream);
            let count = ready!(stream.poll_write(context, &self.gathered))?;
            if count == 0 {
                return Poll::Ready(Err(io::ErrorKind::WriteZero.into()));
            }
            self.gathered.advance(count);
        }
        Poll::Ready(Ok(()))
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for GatheredWrites<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, buffer)
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for GatheredWrites<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        self.gather(context, [bytes].into_iter())
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        slices: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        self.gather(context, slices.iter().map(|slice| &**slice))
    }

    fn is_write_vectored(&self) -> bool {
        true
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        if std::mem::take(&mut self.is_followed) && self.gathered.len() < PASSED_ON_BYTES {
            // If nothing follows, the task flushes when it is polled again.
            context.waker().wake_by_ref();
            return Poll::Ready(Ok(()));
        }
        ready!(self.pass_on(context))?;
        self.gathered = BytesMut::new();
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        ready!(self.pass_on(context))?;
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use std::task::Waker;

    use super::*;

    /// The writes, call by call.
    #[derive(Default)]
    struct Calls(Vec<usize>);

    impl AsyncWrite for Calls {
        fn poll_write(
            mut self: Pin<&mut Self>,
            _: &mut Context<'_>,
            bytes: &[u8],
        ) -> Poll<io::Result<usize>> {
            self.0.push(bytes.len());
            Poll::Ready(Ok(bytes.len()))
        }

        fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
            Poll::Ready(Ok(()))
        }

        fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
            Poll::Ready(Ok(()))
        }
    }

    /// Writes and flushes these numbers of bytes; returns the writes that were passed on.
    fn passed_on(writes: &[usize]) -> Vec<usize> {
        let mut stream = GatheredWrites::new(Calls::default());
        let mut context = Context::from_waker(Waker::noop());
        for &count in writes {
            let mut stream = Pin::new(&mut stream);
            if count > 0 {
                let written = stream.as_mut().poll_write(&mut context, &vec![0; count]);
                assert!(matches!(written, Poll::Ready(Ok(all)) if all == count));
            }
            assert!(stream.poll_flush(&mut context).is_ready());
        }
        stream.stream.0
    }

    #[test]
    fn large_writes_are_passed_on_together() {
        let frame = LARGE * 2;
        assert_eq!(passed_on(&[frame, frame, frame]), Vec::<usize>::new());
        assert_eq!(passed_on(&[frame, frame, 100]), [2 * frame + 100]);
        assert_eq!(passed_on(&[frame, 0]), [frame]);
        assert_eq!(passed_on(&[100, frame, 0, 100]), [100, frame, 100]);
        let count = PASSED_ON_BYTES / frame;
        assert_eq!(passed_on(&vec![frame; count + 1]), [PASSED_ON_BYTES]);
    }
}
