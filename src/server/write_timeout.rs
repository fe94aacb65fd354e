//! A byte stream that records its activity, and on which writes have a timeout.

use std::io::{self, IoSlice};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};

use bytes::Bytes;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, ReadBuf};
use tokio::time::{Duration, Sleep, sleep};

use super::idle_tracking::Activity;

/// A stream of bytes that records its activity. Writing fails when the other side has read nothing for `limit`.
pub(super) struct TimedStream<S> {
    stream: S,
    activity: Arc<Activity>,
    limit: Duration,
    /// Received bytes to be read again.
    unread: Bytes,
    /// The timeout while the other side reads nothing.
    stalled: Option<Pin<Box<Sleep>>>,
    /// After everything is written: how long further input is ignored.
    closing: Option<Pin<Box<Sleep>>>,
    /// The number of bytes ignored.
    ignored: usize,
}

/// The time, and the number of bytes of input, for which input is ignored before the connection is closed.
const IGNORING: Duration = Duration::from_secs(2);
const MOST_IGNORED: usize = 64 << 20;

impl<S> TimedStream<S> {
    pub(super) fn new(stream: S, activity: Arc<Activity>, limit: Duration) -> Self {
        Self {
            stream,
            activity,
            limit,
            unread: Bytes::new(),
            stalled: None,
            closing: None,
            ignored: 0,
        }
    }

    /// The bytes to read next, before new input.
    pub(super) fn unread(&mut self, bytes: Bytes) {
        self.unread = bytes;
    }

    /// Returns true if the input begins with these bytes, as soon as that is known; `None` if there is no more input.
    /// The bytes are read again later. A future that is dropped loses nothing.
    pub(super) async fn begins_with(&mut self, bytes: &[u8]) -> Option<bool>
    where
        S: AsyncRead + Unpin,
    {
        loop {
            let known = self.unread.len().min(bytes.len());
            if self.unread[..known] != bytes[..known] {
                return Some(false);
            }
            if known == bytes.len() {
                return Some(true);
            }
            let mut room = [0; 64];
            let count = self
                .receive(&mut room)
                .await
                .ok()
                .filter(|&count| count > 0)?;
            self.unread = [&self.unread, &room[..count]].concat().into();
        }
    }

    /// Reads from the connection itself.
    async fn receive(&mut self, room: &mut [u8]) -> io::Result<usize>
    where
        S: AsyncRead + Unpin,
    {
        let count = self.stream.read(room).await?;
        if count > 0 {
            self.activity.read();
        }
        Ok(count)
    }

    /// The outcome of an attempt to write; an error if it is pending and the timeout has passed.
    fn in_time<T>(
        &mut self,
        attempt: Poll<io::Result<T>>,
        context: &mut Context<'_>,
    ) -> Poll<io::Result<T>> {
        self.activity.set_blocked(attempt.is_pending());
        if attempt.is_ready() {
            self.stalled = None;
            return attempt;
        }
        let limit = self.limit;
        let stalled = self.stalled.get_or_insert_with(|| Box::pin(sleep(limit)));
        stalled.as_mut().poll(context).map(|()| {
            let reason = format!("the client has read nothing for {limit:?}");
            Err(io::Error::new(io::ErrorKind::TimedOut, reason))
        })
    }

    /// Reads and discards what the other side still sends, for a short time. If the connection were reset
    /// in the middle, the client's system could discard the answer before it is read.
    fn ignore(&mut self, context: &mut Context<'_>) -> Poll<()>
    where
        S: AsyncRead + Unpin,
    {
        let closing = self
            .closing
            .get_or_insert_with(|| Box::pin(sleep(IGNORING)));
        let mut room = [0; 8192];
        while self.ignored < MOST_IGNORED && closing.as_mut().poll(context).is_pending() {
            let mut buffer = ReadBuf::new(&mut room);
            let read = ready!(Pin::new(&mut self.stream).poll_read(context, &mut buffer));
            if read.is_err() || buffer.filled().is_empty() {
                break;
            }
            self.ignored += buffer.filled().len();
        }
        Poll::Ready(())
    }

    fn written(
        &mut self,
        attempt: Poll<io::Result<usize>>,
        context: &mut Context<'_>,
    ) -> Poll<io::Result<usize>> {
        if let Poll::Ready(Ok(bytes)) = attempt {
            self.activity.wrote(bytes);
        }
        self.in_time(attempt, context)
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for TimedStream<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        if !self.unread.is_empty() {
            let count = self.unread.len().min(buffer.remaining());
            buffer.put_slice(&self.unread.split_to(count));
            return Poll::Ready(Ok(()));
        }
        let before = buffer.filled().len();
        let read = Pin::new(&mut self.stream).poll_read(context, buffer);
        if buffer.filled().len() > before {
            self.activity.read();
        }
        read
    }
}

impl<S: AsyncRead + AsyncWrite + Unpin> AsyncWrite for TimedStream<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let attempt = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.written(attempt, context)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        slices: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let attempt = Pin::new(&mut self.stream).poll_write_vectored(context, slices);
        self.written(attempt, context)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        let attempt = Pin::new(&mut self.stream).poll_flush(context);
        // A flush does not reset the timeout of bytes that could not be written.
        match self.stalled.is_some() && attempt.is_ready() {
            true => attempt,
            false => self.in_time(attempt, context),
        }
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        if self.closing.is_none() {
            let attempt = Pin::new(&mut self.stream).poll_shutdown(context);
            ready!(self.in_time(attempt, context))?;
        }
        if self.activity.is_cut_short() {
            ready!(self.ignore(context));
        }
        Poll::Ready(Ok(()))
    }
}
