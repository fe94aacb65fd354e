//! The events of a fit, a line of JSON each, also over connections that break.

use std::time::Duration;

use axum::body::Body;
use http_body_util::BodyExt;
use serde::Deserialize;
use serde_json::Value;
use tokio::time::sleep;

use super::client::Client;
use super::failure::Failure;
use super::request::PROGRESS;

/// How often a broken stream is taken up again without an event in between.
const ATTEMPTS: u32 = 6;

/// An event.
#[derive(Debug, Deserialize)]
#[serde(tag = "event", content = "data", rename_all = "lowercase")]
pub(super) enum Event {
    /// What does not change.
    Job(Box<JobEvent>),
    /// An iteration.
    Iteration(IterationEvent),
    /// How it ended.
    End(Box<EndEvent>),
}

/// What is said of a job.
#[derive(Debug, Deserialize)]
pub(super) struct JobEvent {
    id: String,
    pub kind: String,
    pub points: usize,
    pub control_points: Value,
    pub basis: Value,
    pub degree: Value,
    pub method: Value,
    pub predicted: Predicted,
    pub stop: Stop,
    #[serde(default)]
    pub notices: Vec<String>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Predicted {
    pub iterations: Option<usize>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Stop {
    pub tolerance: f64,
    pub max_iterations: usize,
}

#[derive(Debug, Deserialize)]
pub(super) struct Warning {
    pub detail: String,
}

/// What is said of an iteration.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct IterationEvent {
    pub iteration: usize,
    pub error: Distances,
    pub rate: Option<f64>,
    pub predicted: Option<usize>,
}

/// Distances from the data; none where they are infinite.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Distances {
    pub max: Option<f64>,
    pub rms: Option<f64>,
}

/// What is said in the end.
#[derive(Debug, Deserialize)]
pub(super) struct EndEvent {
    pub state: String,
    pub detail: Option<String>,
    pub iterations: usize,
    pub error: Option<Distances>,
    pub elapsed: Option<f64>,
    #[serde(default)]
    pub warnings: Vec<Warning>,
    pub problem: Option<Why>,
}

/// Why a job failed.
#[derive(Debug, Deserialize)]
pub(super) struct Why {
    pub detail: String,
}

/// The events of a job, in order.
pub(super) struct Events<'a> {
    client: &'a Client,
    body: Body,
    /// What has come of the next lines, and how much of that has no end of a line.
    bytes: Vec<u8>,
    searched: usize,
    last: Option<usize>,
    attempts: u32,
}

impl<'a> Events<'a> {
    /// The events in an answer.
    pub(super) fn new(client: &'a Client, body: Body) -> Self {
        Self {
            client,
            body,
            bytes: Vec::new(),
            searched: 0,
            last: None,
            attempts: 0,
        }
    }

    /// The next event.
    pub(super) async fn next(&mut self) -> Result<Event, Failure> {
        loop {
            if let Some(event) = self.take_line()? {
                self.note(&event);
                return Ok(event);
            }
            match self.body.frame().await {
                Some(Ok(frame)) => {
                    if let Ok(data) = frame.into_data() {
                        self.bytes.extend_from_slice(&data);
                    }
                }
                broken => {
                    let reason = match broken {
                        Some(Err(reason)) => reason.to_string(),
                        _ => "it ended too early".to_owned(),
                    };
                    self.resume(&reason).await?;
                }
            }
        }
    }

    fn take_line(&mut self) -> Result<Option<Event>, Failure> {
        let rest = self.bytes.get(self.searched..).unwrap_or_default();
        let Some(length) = rest.iter().position(|byte| *byte == b'\n') else {
            self.searched = self.bytes.len();
            return Ok(None);
        };
        let line: Vec<u8> = self.bytes.drain(..=self.searched + length).collect();
        self.searched = 0;
        let event = serde_json::from_slice(&line);
        let not_understood =
            |reason| Failure::Failed(format!("an event is not understood: {reason}"));
        event.map(Some).map_err(not_understood)
    }

    fn note(&mut self, event: &Event) {
        self.attempts = 0;
        match event {
            Event::Job(job) => {
                // The same one after each connection.
                let _ = self.client.job.set(format!("/v1/jobs/{}", job.id));
            }
            Event::Iteration(level) => self.last = Some(level.iteration),
            Event::End(_) => {}
        }
    }

    /// Goes on after the last iteration with another connection.
    async fn resume(&mut self, reason: &str) -> Result<(), Failure> {
        let failed = || Failure::Failed(format!("the stream of events broke off: {reason}"));
        let job = self.client.job.get().ok_or_else(failed)?;
        let last = self.last.map(|last| format!("&last_event_id={last}"));
        let path = format!("{job}/events?{PROGRESS}{}", last.unwrap_or_default());
        loop {
            if !self.client.is_remote() || self.attempts == ATTEMPTS {
                return Err(failed());
            }
            sleep(Duration::from_millis(100 << self.attempts)).await;
            self.attempts += 1;
            match self.client.get(&path, "application/x-ndjson").await {
                Ok(Ok(body)) => {
                    (self.body, self.bytes, self.searched) = (body, Vec::new(), 0);
                    return Ok(());
                }
                Ok(Err(refusal)) if refusal.status.is_client_error() => {
                    return Err(Failure::Failed(refusal.detail));
                }
                _ => {}
            }
        }
    }
}
