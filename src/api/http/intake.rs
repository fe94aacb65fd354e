//! Receives the bodies of requests: within the limits of size, from a share of the memory, and with
//! limits on pauses and rate.

use std::time::{Duration, Instant};

use axum::body::Body;
use axum::http::{HeaderMap, header};
use bytes::Bytes;
use http_body_util::BodyExt;
use tokio::time::timeout;

use crate::api::app::App;
use crate::api::problem::{Kind, Problem};
use crate::job::memory::Permit;

/// Bodies up to this size take nothing from the share: the number of connections limits their memory.
const SMALL: usize = 64 * 1024;

/// A body takes memory twice: as bytes, and as the numbers that are read from them.
const COPIES: usize = 2;

/// How long a body may wait for memory.
const WAIT: Duration = Duration::from_secs(10);

/// A body, and the memory that it takes.
pub struct ReceivedBody {
    /// What was sent.
    pub bytes: Bytes,
    /// Held until the body has been read.
    pub room: Vec<Permit>,
}

/// Collects a body.
pub async fn take_in(app: &App, headers: &HeaderMap, body: Body) -> Result<ReceivedBody, Problem> {
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
        announced: announced.unwrap_or(usize::MAX),
        begun: Instant::now(),
        bytes: Vec::new(),
        room: Vec::new(),
    };
    intake.collect(body).await?;
    Ok(ReceivedBody {
        bytes: intake.bytes.into(),
        room: intake.room,
    })
}

struct Intake<'a> {
    app: &'a App,
    limit: usize,
    /// The Content-Length; the largest number if there is none.
    announced: usize,
    begun: Instant,
    bytes: Vec<u8>,
    room: Vec<Permit>,
}

impl Intake<'_> {
    async fn collect(&mut self, mut body: Body) -> Result<(), Problem> {
        let pause = self.app.config.body_timeout;
        loop {
            let frame = timeout(pause, body.frame()).await.map_err(|_| {
                let seconds = pause.as_secs_f64();
                let detail = format!("no byte of the body came for {seconds} seconds");
                Problem::new(Kind::BodyTimeout, detail)
            })?;
            let Some(frame) = frame else {
                return Ok(());
            };
            let frame = frame.map_err(|reason| {
                let detail = format!("the body could not be read: {reason}");
                Problem::new(Kind::InvalidRequest, detail)
            })?;
            // Trailers are ignored.
            if let Ok(data) = frame.into_data() {
                if data.len() > self.limit - self.bytes.len() {
                    return Err(too_large(self.limit));
                }
                self.grow(data.len()).await?;
                self.bytes.extend_from_slice(&data);
            }
        }
    }

    /// Makes room for so many more bytes. The capacity at least doubles, so that little is copied.
    async fn grow(&mut self, more: usize) -> Result<(), Problem> {
        let needed = self.bytes.len() + more;
        let capacity = self.bytes.capacity();
        if needed > SMALL {
            self.check_rate()?;
        }
        if needed <= capacity {
            return Ok(());
        }
        // A client that has sent an eighth of the body is likely to send the rest.
        let wanted = match self.announced / 8 <= needed {
            true => self.announced,
            false => 2 * capacity,
        };
        let wanted = wanted.max(needed);
        if wanted > SMALL {
            let before = if capacity > SMALL { capacity } else { 0 };
            self.take(COPIES * (wanted - before)).await?;
        }
        self.bytes
            .try_reserve_exact(wanted - self.bytes.len())
            .map_err(|_| busy("the server has no memory for the body"))
    }

    /// Takes memory from the share. A body that is larger than the whole share waits until it gets all
    /// of it.
    async fn take(&mut self, bytes: usize) -> Result<(), Problem> {
        let share = &self.app.jobs.resources().memory.bodies;
        let held: usize = self.room.iter().map(Permit::num_permits).sum();
        let left = share
            .bytes()
            .saturating_sub(held * crate::job::memory::PAGE);
        let permit = timeout(WAIT, share.take(bytes.min(left))).await;
        let permit = permit.map_err(|_| {
            busy("the server is taking in as many large requests as it has memory for")
        })?;
        self.room.extend(permit);
        Ok(())
    }

    /// Refuses large bodies that come so slowly that they keep memory from others.
    fn check_rate(&self) -> Result<(), Problem> {
        let (rate, pause) = (self.app.config.min_body_rate, self.app.config.body_timeout);
        let passed = self.begun.elapsed();
        let least = rate.as_u64() as f64 * passed.as_secs_f64();
        if passed > pause && (self.bytes.len() as f64) < least {
            let detail = format!(
                "only {} bytes of the body came in {} seconds; large bodies come at {rate} per second or more",
                self.bytes.len(),
                passed.as_secs()
            );
            return Err(Problem::new(Kind::BodyTimeout, detail));
        }
        Ok(())
    }
}

fn too_large(limit: usize) -> Problem {
    let detail = format!("the body is larger than {limit} bytes, the limit of this server");
    Problem::new(Kind::BodyTooLarge, detail)
}

fn busy(detail: &str) -> Problem {
    Problem::new(Kind::Busy, detail).retry_after(5)
}
