//! Answers are compressed for clients that ask for it (`Accept-Encoding`).
//!
//! Numbers as text become less than half as long. Event streams stay as they are: their events would
//! wait for each other in the compressor. The work is done on the compute pool, while the next piece of
//! the answer is being made.

use std::io::{self, Write};

use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::Response;
use bytes::Bytes;
use flate2::Compression;
use flate2::write::GzEncoder;
use futures_util::stream;
use http_body::Body as _;
use http_body_util::BodyExt;
use zstd::stream::raw::CParameter;
use zstd::stream::write::Encoder as ZstdEncoder;

use super::coding::{self, Coding};
use crate::api::app::App;
use crate::job::scheduler::WorkLane;

/// Shorter answers fit into a packet as they are.
const LEAST: u64 = 1024;

/// What is compressed at a time, so that others get their turn on the compute pool.
const PART: usize = 256 * 1024;

/// Parts up to this size are compressed where they are sent.
const AT_ONCE: usize = 8 * 1024;

/// Above these levels digits of numbers take much longer and become hardly shorter.
const GZIP_LEVEL: u32 = 4;
const ZSTD_LEVEL: i32 = 1;

/// zstd looks for repetitions within 2¹⁸ bytes, which bounds the memory of an answer: numbers have none
/// that are further apart.
const ZSTD_WINDOW: u32 = 18;

/// Compresses the answer if the client takes that and it is worth it.
pub(super) async fn pack(State(app): State<App>, request: Request, next: Next) -> Response {
    let coding = coding::choose(request.headers(), &[Coding::Zstd, Coding::Gzip]);
    let mut response = next.run(request).await;
    if !is_worth_it(&response) {
        return response;
    }
    let headers = response.headers_mut();
    headers.append(header::VARY, HeaderValue::from_static("accept-encoding"));
    let Some(coding) = coding else {
        return response;
    };
    let Ok(encoder) = Encoder::new(coding) else {
        return response;
    };
    headers.remove(header::CONTENT_LENGTH);
    let name = HeaderValue::from_static(coding.name());
    headers.insert(header::CONTENT_ENCODING, name);
    response.map(|body| packed(app, encoder, body))
}

/// Whether an answer is long enough, and neither compressed yet, nor an event stream or one of gRPC,
/// which compresses by itself.
fn is_worth_it(response: &Response) -> bool {
    let headers = response.headers();
    let text = |name| {
        let value: Option<&HeaderValue> = headers.get(name);
        value.and_then(|value| value.to_str().ok()).unwrap_or("")
    };
    let length = response.body().size_hint();
    let short = length.upper().is_some_and(|length| length < LEAST);
    let bodiless = [StatusCode::NO_CONTENT, StatusCode::NOT_MODIFIED].contains(&response.status());
    let media_type = text(header::CONTENT_TYPE);
    // Files with a tag have their compressed forms.
    let ready = [header::CONTENT_ENCODING, header::ETAG];
    !short
        && !bodiless
        && !ready.iter().any(|name| headers.contains_key(name))
        && !text(header::CACHE_CONTROL).contains("no-transform")
        && !media_type.is_empty()
        && !media_type.starts_with("application/grpc")
}

/// Bytes on their way through a compressor.
struct Packing {
    app: App,
    body: Body,
    /// What has come of the body and is not compressed yet.
    unpacked: Bytes,
    /// Until the end.
    encoder: Option<Encoder>,
}

fn packed(app: App, encoder: Encoder, body: Body) -> Body {
    let packing = Packing {
        app,
        body,
        unpacked: Bytes::new(),
        encoder: Some(encoder),
    };
    Body::from_stream(stream::try_unfold(packing, |mut packing| async move {
        let bytes = packing.next().await?;
        Ok::<_, axum::Error>(bytes.map(|bytes| (bytes, packing)))
    }))
}

impl Packing {
    /// The next compressed bytes; none at the end.
    async fn next(&mut self) -> Result<Option<Bytes>, axum::Error> {
        while let Some(encoder) = self.encoder.take() {
            if self.unpacked.is_empty() {
                let Some(frame) = self.body.frame().await.transpose()? else {
                    let last = encoder.finish().map_err(axum::Error::new)?;
                    return Ok(Some(last.into()));
                };
                // Answers have no trailers.
                self.unpacked = frame.into_data().unwrap_or_default();
            }
            let bytes = self.advance(encoder).await?;
            if !bytes.is_empty() {
                return Ok(Some(bytes));
            }
        }
        Ok(None)
    }

    /// Compresses a part, and takes what has come out.
    async fn advance(&mut self, mut encoder: Encoder) -> Result<Bytes, axum::Error> {
        let part = self.unpacked.split_to(self.unpacked.len().min(PART));
        let small = part.len() <= AT_ONCE;
        let work = move || {
            let bytes = encoder.add(&part)?;
            Ok::<_, io::Error>((encoder, bytes))
        };
        let done = match small {
            true => work(),
            false => {
                let scheduler = &self.app.jobs.resources().scheduler;
                let done = scheduler.compute(WorkLane::Wire, work).await;
                done.map_err(axum::Error::new)?
            }
        };
        let (encoder, bytes) = done.map_err(axum::Error::new)?;
        self.encoder = Some(encoder);
        Ok(bytes.into())
    }
}

/// A compressor.
enum Encoder {
    Gzip(GzEncoder<Vec<u8>>),
    Zstd(ZstdEncoder<'static, Vec<u8>>),
}

impl Encoder {
    fn new(coding: Coding) -> io::Result<Self> {
        Ok(match coding {
            Coding::Gzip => Self::Gzip(GzEncoder::new(Vec::new(), Compression::new(GZIP_LEVEL))),
            Coding::Zstd => {
                let mut encoder = ZstdEncoder::new(Vec::new(), ZSTD_LEVEL)?;
                encoder.set_parameter(CParameter::WindowLog(ZSTD_WINDOW))?;
                Self::Zstd(encoder)
            }
        })
    }

    /// Adds bytes, and gives what has come out so far.
    fn add(&mut self, bytes: &[u8]) -> io::Result<Vec<u8>> {
        match self {
            Self::Gzip(encoder) => {
                encoder.write_all(bytes)?;
                Ok(std::mem::take(encoder.get_mut()))
            }
            Self::Zstd(encoder) => {
                encoder.write_all(bytes)?;
                Ok(std::mem::take(encoder.get_mut()))
            }
        }
    }

    /// The last bytes.
    fn finish(self) -> io::Result<Vec<u8>> {
        match self {
            Self::Gzip(encoder) => encoder.finish(),
            Self::Zstd(encoder) => encoder.finish(),
        }
    }
}
