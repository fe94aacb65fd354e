//! Receives the bodies of requests: within limits of size, from a share of the memory (separate for small and large
//! ones), and with limits on pauses and rate. Compressed ones are unpacked as they arrive, and limits hold for the
//! unpacked bytes.
//!
//! A body takes memory for its bytes as it arrives, and for the parsed request once it is complete: large ones from
//! another share, whose memory is held by no slow client.

use std::mem::take;
use std::time::{Duration, Instant};

use axum::body::{Body, HttpBody};
use axum::http::{HeaderMap, header};
use bytes::Bytes;
use http_body_util::BodyExt;
use tokio::time::timeout;

use super::coding::Coding;
use super::unpacking::Unpacker;
use crate::api::app::App;
use crate::api::problem::{Kind, Problem};
use crate::config::Config;
use crate::job::memory::{Permit, Share};
use crate::job::peer::Peer;
use crate::job::probation::LargeBody;
use crate::job::scheduler::WorkLane;

/// Bodies up to this size have a share of the memory of their own.
pub(in crate::api) const SMALL: usize = 64 * 1024;

/// A body takes memory as it arrives, and for the bytes that it is moved from as it grows.
pub(in crate::api) const ARRIVING: usize = 2;

/// The memory of parsing a body until a job is made of it: two bytes become a number of eight bytes and a parameter, or
/// a number, its line and both once more in a part of the file. `benches/http/bodies.py` measures it.
pub(in crate::api) const READING: usize = 14;

/// The number of bytes that are unpacked at a time, once there are some.
const STEP: usize = 1024 * 1024;

/// How long a body may wait for memory.
const WAIT: Duration = Duration::from_secs(10);

/// A body, and the memory that it takes.
pub(crate) struct ReceivedBody {
    /// The bytes received.
    pub bytes: Bytes,
    /// Held until the body has been read.
    pub room: Room,
}

/// The memory of a body.
#[derive(Default)]
pub(crate) struct Room {
    /// While it is small, and for parsing a small one.
    small: Option<Permit>,
    large: Option<Permit>,
    /// For parsing a large one.
    reading: Option<Permit>,
    /// A large one is read; jobs on probation do not run meanwhile.
    large_body: Option<LargeBody>,
}

/// Collects a body, and unpacks it if it is compressed. Parsing it takes some memory for each byte, and `more` for its
/// contents.
pub(crate) async fn take_in(
    app: &App,
    headers: &HeaderMap,
    body: Body,
    coding: Option<Coding>,
    more: impl FnOnce(&[u8]) -> usize,
) -> Result<ReceivedBody, Problem> {
    let limit = usize::try_from(app.config.max_body.as_u64()).unwrap_or(usize::MAX);
    let announced = headers
        .get(header::CONTENT_LENGTH)
        .and_then(|length| length.to_str().ok()?.parse::<usize>().ok());
    if announced > Some(limit) {
        return Err(too_large(limit));
    }
    let mut intake = Intake {
        app,
        limit,
        announced: announced.filter(|_| coding.is_none()).unwrap_or(usize::MAX),
        begun: Instant::now(),
        received: 0,
        bytes: Vec::new(),
        room: Room::default(),
    };
    let bytes = match coding {
        None => intake.collect(body).await?,
        Some(coding) => intake.collect_packed(body, coding).await?,
    };
    let needed = READING.saturating_mul(bytes.len());
    let needed = needed.saturating_add(more(&bytes));
    intake.take_for_reading(bytes.len(), needed).await?;
    Ok(ReceivedBody {
        bytes,
        room: intake.room,
    })
}

struct Intake<'a> {
    app: &'a App,
    limit: usize,
    /// The number of bytes by the Content-Length; the largest number if it is unknown.
    announced: usize,
    begun: Instant,
    /// The number of bytes received.
    received: usize,
    bytes: Vec<u8>,
    room: Room,
}

impl Intake<'_> {
    async fn collect(&mut self, mut body: Body) -> Result<Bytes, Problem> {
        while let Some(data) = self.receive(&mut body).await? {
            // A large body that arrives at once, as that of `piad fit` does, is not copied.
            if self.bytes.is_empty() && data.len() > SMALL && body.is_end_stream() {
                self.take_large(ARRIVING * data.len()).await?;
                return Ok(data);
            }
            self.grow(data.len()).await?;
            self.bytes.extend_from_slice(&data);
        }
        Ok(take(&mut self.bytes).into())
    }

    async fn collect_packed(&mut self, mut body: Body, coding: Coding) -> Result<Bytes, Problem> {
        let damaged = |reason: String| damaged(coding, &reason);
        let mut unpacker = Unpacker::new(coding).map_err(damaged)?;
        if unpacker.memory() > 0 {
            self.take_large(unpacker.memory()).await?;
        }
        while let Some(mut data) = self.receive(&mut body).await? {
            let mut more = !data.is_empty();
            while more {
                // One extra byte shows that there are too many.
                let left = self.limit.saturating_add(1) - self.bytes.len();
                let most = left.min(if self.bytes.is_empty() { SMALL } else { STEP });
                self.grow(most).await?;
                let mut bytes = take(&mut self.bytes);
                let small = bytes.is_empty();
                let work = move || {
                    let more = unpacker.add(&mut data, &mut bytes, most);
                    (unpacker, data, bytes, more)
                };
                let done;
                (unpacker, data, self.bytes, done) = match small {
                    true => work(),
                    false => {
                        let scheduler = &self.app.jobs.resources().scheduler;
                        scheduler.compute(WorkLane::Wire, work).await?
                    }
                };
                more = done.map_err(damaged)?;
                if self.bytes.len() > self.limit {
                    return Err(too_large(self.limit));
                }
            }
        }
        match unpacker.has_ended() {
            true => Ok(take(&mut self.bytes).into()),
            false => Err(damaged("its end is missing".to_owned())),
        }
    }

    /// The next bytes of the body as they arrive; `None` at its end.
    async fn receive(&mut self, body: &mut Body) -> Result<Option<Bytes>, Problem> {
        let Some(data) = receive(body, self.app.config.body_timeout).await? else {
            return Ok(None);
        };
        if data.len() > self.limit - self.received {
            return Err(too_large(self.limit));
        }
        self.received += data.len();
        self.check_rate()?;
        Ok(Some(data))
    }

    /// Makes room for this many more bytes. The capacity at least doubles, so that little is copied.
    async fn grow(&mut self, more: usize) -> Result<(), Problem> {
        let needed = self.bytes.len() + more;
        let capacity = self.bytes.capacity();
        if needed <= capacity {
            return Ok(());
        }
        // A client that has sent an eighth of the body is likely to send the rest.
        let wanted = match self.announced / 8 <= needed {
            true => self.announced,
            false => 2 * capacity,
        };
        let wanted = wanted.min(self.limit).max(needed);
        if wanted <= SMALL {
            self.take_small(ARRIVING * (wanted - capacity)).await?;
        } else {
            let before = if capacity > SMALL { capacity } else { 0 };
            self.take_large(ARRIVING * (wanted - before)).await?;
            self.room.small = None;
        }
        self.bytes
            .try_reserve_exact(wanted - self.bytes.len())
            .map_err(|_| busy("the server has no memory for the body"))
    }

    /// Takes memory for a small body.
    async fn take_small(&mut self, bytes: usize) -> Result<(), Problem> {
        let share = &self.app.jobs.resources().memory.requests;
        take_memory(share, &mut self.room.small, bytes).await
    }

    /// Takes memory for a large body. One larger than the whole share waits until it gets all of it.
    async fn take_large(&mut self, bytes: usize) -> Result<(), Problem> {
        let share = &self.app.jobs.resources().memory.bodies;
        take_memory(share, &mut self.room.large, bytes).await
    }

    /// Takes memory for parsing a body of this length.
    async fn take_for_reading(&mut self, length: usize, bytes: usize) -> Result<(), Problem> {
        if length <= SMALL {
            return self.take_small(bytes).await;
        }
        let share = &self.app.jobs.resources().memory.reading;
        take_memory(share, &mut self.room.reading, bytes).await?;
        let begun = timeout(WAIT, self.app.jobs.read_large_body()).await;
        self.room.large_body = Some(begun.map_err(|_| {
            busy("the server is starting a job again that was running when it crashed")
        })?);
        Ok(())
    }

    fn check_rate(&self) -> Result<(), Problem> {
        let received = self.received.max(self.bytes.len());
        check_rate(&self.app.config, self.begun, received)
    }
}

/// The next bytes of a body as they arrive, with a limit on pauses; `None` at its end.
pub(in crate::api) async fn receive(
    body: &mut Body,
    pause: Duration,
) -> Result<Option<Bytes>, Problem> {
    let frame = timeout(pause, body.frame()).await.map_err(|_| {
        let seconds = pause.as_secs_f64();
        let detail = format!("no byte of the body came for {seconds} seconds");
        Problem::new(Kind::BodyTimeout, detail)
    })?;
    let Some(frame) = frame else {
        return Ok(None);
    };
    let frame = frame.map_err(|reason| {
        let detail = format!("the body could not be read: {reason}");
        Problem::new(Kind::InvalidRequest, detail)
    })?;
    // Trailers are ignored.
    Ok(Some(frame.into_data().unwrap_or_default()))
}

/// Refuses bodies that arrive so slowly that they keep memory from others: this many bytes since then.
pub(in crate::api) fn check_rate(
    config: &Config,
    since: Instant,
    received: usize,
) -> Result<(), Problem> {
    let (rate, pause) = (config.min_body_rate, config.body_timeout);
    let passed = since.elapsed();
    let least = rate.as_u64() as f64 * passed.as_secs_f64();
    if passed > pause && (received as f64) < least {
        let detail = format!(
            "only {received} bytes of the body came in {} seconds; bodies that take this long must arrive at {rate} per second or more",
            passed.as_secs()
        );
        return Err(Problem::new(Kind::BodyTimeout, detail));
    }
    Ok(())
}

/// A compressed body is damaged.
pub(in crate::api) fn damaged(coding: Coding, reason: &str) -> Problem {
    let detail = format!("the body cannot be unpacked as {}: {reason}", coding.name());
    Problem::new(Kind::InvalidRequest, detail)
}

/// Waits a limited time for memory.
pub(in crate::api) async fn take_memory(
    share: &Share,
    room: &mut Option<Permit>,
    bytes: usize,
) -> Result<(), Problem> {
    let taken = async {
        match room {
            Some(permit) => share.extend(permit, bytes).await,
            None => *room = share.take(Peer::current(), bytes).await,
        }
    };
    timeout(WAIT, taken)
        .await
        .map_err(|_| busy("the memory for requests of this size is in use"))
}

fn too_large(limit: usize) -> Problem {
    let detail = format!("the body is larger than {limit} bytes, the limit of this server");
    Problem::new(Kind::BodyTooLarge, detail)
}

fn busy(detail: &str) -> Problem {
    Problem::new(Kind::Busy, detail).retry_after(5)
}
