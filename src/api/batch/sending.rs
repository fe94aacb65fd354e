//! The bytes of the answer to a batch.

use std::sync::Arc;
use std::time::Duration;

use bytes::{BufMut, Bytes};
use tokio::sync::mpsc;
use tokio::time::timeout;

use super::answer::{self, Output};
use super::driver::Batch;
use super::settings::Settings;
use crate::api::problem::{Kind, Problem};
use crate::api::stream::sending::Outgoing;
use crate::job::scheduler::Broken;

/// An answer that is being sent.
pub(in crate::api) struct Sending {
    outgoing: Outgoing,
    /// The results of the batch; `None` after its end.
    answer: Option<mpsc::Receiver<Output>>,
    heartbeat: Duration,
    settings: Arc<Settings>,
    /// Why it has ended early, or that it has not ended.
    end: Result<(), Problem>,
}

impl Sending {
    /// The answer to a batch, whose computation begins.
    pub(in crate::api) fn begin(batch: Batch) -> Self {
        let settings = Arc::clone(batch.settings());
        let app = &settings.app;
        let mut outgoing = Outgoing::new(Arc::clone(app.jobs.resources()));
        outgoing.text().put(answer::beginning(settings.framing));
        let broken = "the batch was interrupted";
        Self {
            outgoing,
            answer: Some(batch.run()),
            heartbeat: app.config.heartbeat,
            settings,
            end: Err(Problem::new(Kind::Internal, broken)),
        }
    }

    /// The next bytes; none at the end.
    pub(in crate::api) async fn next(&mut self) -> Option<Result<Bytes, Broken>> {
        while self.outgoing.is_empty() {
            self.gather().await?;
        }
        self.outgoing.next().await
    }

    /// After the end: why it came early, if it did.
    pub(in crate::api) fn end(self) -> Result<(), Problem> {
        self.end
    }

    /// Waits for something to send, or returns that there is nothing yet; `None` after the end.
    async fn gather(&mut self) -> Option<()> {
        let framing = self.settings.framing;
        let output = match timeout(self.heartbeat, self.answer.as_mut()?.recv()).await {
            Ok(output) => output,
            Err(_) => {
                self.outgoing.text().put(answer::quiet(framing));
                return Some(());
            }
        };
        match output? {
            Output::Lines(content) => self.outgoing.push(content),
            Output::End(end) => {
                let last = answer::last(&self.settings, &end);
                self.outgoing.text().put(last);
                self.end = end.map(drop);
                self.answer = None;
            }
        }
        Some(())
    }
}
