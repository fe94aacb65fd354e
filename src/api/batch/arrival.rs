//! The bytes of a body as they arrive. They are read ahead of the computation, as far as there is memory: many clients
//! read nothing of an answer until they have sent all of a body.

use std::sync::Arc;

use axum::body::Body;
use bytes::Bytes;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc};

use crate::api::app::App;
use crate::api::http::body_limits::{damaged, receive, take_memory};
use crate::api::http::coding::Coding;
use crate::api::http::unpacking::Unpacker;
use crate::api::problem::{Kind, Problem};
use crate::job::memory::Permit;
use crate::job::peer::{self, Peer};
use crate::job::scheduler::WorkLane;

/// The most bytes that are passed on at once.
pub(super) const PART: usize = 64 * 1024;

/// A body is read ahead by this part of the memory for large bodies.
const AHEAD: usize = 8;

/// Some bytes of a body; `None` at its end.
#[derive(Default)]
pub(super) struct Arrived {
    pub(super) bytes: Bytes,
    /// The memory that they take, if they were read ahead.
    _memory: Option<Permit>,
    _ahead: Option<OwnedSemaphorePermit>,
}

/// The bytes of a body, in order.
pub(super) struct Arrival {
    parts: mpsc::UnboundedReceiver<Result<Arrived, Problem>>,
    reader: tokio::task::JoinHandle<()>,
}

impl Arrival {
    /// Begins to read a body for the current peer.
    pub(super) fn begin(app: &App, body: Body, coding: Option<Coding>) -> Self {
        let (sender, parts) = mpsc::unbounded_channel();
        let ahead = app.jobs.resources().memory.bodies.bytes() / AHEAD;
        let ahead = u32::try_from(ahead).unwrap_or(u32::MAX).max(1);
        let reader = Reader {
            app: app.clone(),
            body,
            sender,
            most: ahead,
            ahead: Arc::new(Semaphore::new(ahead as usize)),
        };
        let reader = peer::spawn(async move {
            let sender = reader.sender.clone();
            let end = reader.read(coding).await;
            let _ = sender.send(end.map(|()| Arrived::default()));
        });
        Self { parts, reader }
    }

    /// The next bytes. A future that is dropped loses nothing.
    pub(super) async fn next(&mut self) -> Result<Arrived, Problem> {
        let broken = || {
            let detail = "the body could not be read any more";
            Err(Problem::new(Kind::Internal, detail))
        };
        self.parts.recv().await.unwrap_or_else(broken)
    }

    /// The next bytes if they are there already.
    pub(super) fn ready(&mut self) -> Option<Result<Arrived, Problem>> {
        self.parts.try_recv().ok()
    }
}

impl Drop for Arrival {
    fn drop(&mut self) {
        self.reader.abort();
    }
}

/// Reads a body.
struct Reader {
    app: App,
    body: Body,
    sender: mpsc::UnboundedSender<Result<Arrived, Problem>>,
    /// The most bytes that are read ahead, and how many more may be.
    most: u32,
    ahead: Arc<Semaphore>,
}

impl Reader {
    async fn read(mut self, coding: Option<Coding>) -> Result<(), Problem> {
        if let Some(coding) = coding {
            return self.unpack(coding).await;
        }
        while let Some(bytes) = self.receive().await? {
            self.pass_on(bytes).await;
        }
        Ok(())
    }

    /// Reads a compressed body.
    async fn unpack(mut self, coding: Coding) -> Result<(), Problem> {
        let damaged = |reason: String| damaged(coding, &reason);
        let mut unpacker = Unpacker::new(coding).map_err(damaged)?;
        let resources = Arc::clone(self.app.jobs.resources());
        let mut memory = None;
        take_memory(&resources.memory.bodies, &mut memory, unpacker.memory()).await?;
        while let Some(mut packed) = self.receive().await? {
            let mut more = !packed.is_empty();
            while more {
                let unpack = move || {
                    let mut bytes = Vec::new();
                    let more = unpacker.add(&mut packed, &mut bytes, PART);
                    (unpacker, packed, bytes, more)
                };
                let (bytes, done);
                (unpacker, packed, bytes, done) =
                    resources.scheduler.compute(WorkLane::Wire, unpack).await?;
                more = done.map_err(damaged)?;
                self.pass_on(bytes.into()).await;
            }
        }
        match unpacker.has_ended() {
            true => Ok(()),
            false => Err(damaged("its end is missing".to_owned())),
        }
    }

    async fn receive(&mut self) -> Result<Option<Bytes>, Problem> {
        receive(&mut self.body, self.app.config.body_timeout).await
    }

    /// Passes bytes on in parts. Without memory for a part, all before it must have been taken.
    async fn pass_on(&mut self, mut bytes: Bytes) {
        let bodies = &self.app.jobs.resources().memory.bodies;
        while !bytes.is_empty() {
            let part = bytes.split_to(bytes.len().min(PART));
            let memory = bodies.take_at_once(Peer::current(), part.len());
            let room = match memory {
                Some(_) => u32::try_from(part.len()).unwrap_or(u32::MAX),
                None => u32::MAX,
            };
            let ahead = Arc::clone(&self.ahead).acquire_many_owned(room.min(self.most));
            let ahead = ahead.await.ok();
            let _ = self.sender.send(Ok(Arrived {
                bytes: part,
                _memory: memory,
                _ahead: ahead,
            }));
        }
    }
}
