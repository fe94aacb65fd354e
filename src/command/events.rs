//! The events of a fit, a line of JSON each, with reconnection.

use std::time::Duration;

use axum::body::Body;
use serde::Deserialize;
use serde_json::Value;
use tokio::time::sleep;

use super::client::Client;
use super::failure::Failure;
use super::request::PROGRESS;
use crate::api::batch::part_file::{Distances, Why};
use crate::lines::Lines;

/// The number of attempts to resume a broken stream without an event in between.
const ATTEMPTS: u32 = 6;

/// An event.
#[derive(Debug, Deserialize)]
#[serde(tag = "event", content = "data", rename_all = "lowercase")]
pub(super) enum Event {
    /// The description of the job.
    Job(Box<JobEvent>),
    /// An iteration.
    Iteration(IterationEvent),
    /// The end of the fit.
    End(Box<EndEvent>),
}

/// The contents of a `job` event.
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

/// The contents of an `iteration` event.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct IterationEvent {
    pub iteration: usize,
    pub error: Distances,
    pub rate: Option<f64>,
    pub predicted: Option<usize>,
}

/// The contents of an `end` event.
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

/// The events of a job, in order.
pub(super) struct Events<'a> {
    client: &'a Client,
    lines: Lines,
    last: Option<usize>,
    attempts: u32,
}

impl<'a> Events<'a> {
    /// The events in an answer.
    pub(super) fn new(client: &'a Client, body: Body) -> Self {
        Self {
            client,
            lines: Lines::new(body),
            last: None,
            attempts: 0,
        }
    }

    /// The next event.
    pub(super) async fn next(&mut self) -> Result<Event, Failure> {
        loop {
            match self.lines.next().await {
                Ok(Some(line)) => {
                    let event = serde_json::from_slice(&line).map_err(|reason| {
                        Failure::Failed(format!("an event is not understood: {reason}"))
                    })?;
                    self.note(&event);
                    return Ok(event);
                }
                Ok(None) => self.resume("it ended too early").await?,
                Err(reason) => self.resume(&reason).await?,
            }
        }
    }

    fn note(&mut self, event: &Event) {
        self.attempts = 0;
        match event {
            Event::Job(job) => {
                // Repeated after each reconnection.
                let _ = self.client.job.set(format!("/v1/jobs/{}", job.id));
            }
            Event::Iteration(level) => self.last = Some(level.iteration),
            Event::End(_) => {}
        }
    }

    /// Reconnects after the last iteration.
    async fn resume(&mut self, reason: &str) -> Result<(), Failure> {
        let failed = || Failure::Failed(format!("the event stream was interrupted: {reason}"));
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
                    self.lines = Lines::new(body);
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
