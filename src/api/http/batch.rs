//! `POST /v1/batch`: many fits in one request, a line for each in one answer, and nothing is kept.

use std::sync::Arc;
use std::time::Duration;

use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::HeaderMap;
use axum::response::Response;
use bytes::BufMut;
use futures_util::stream;
use tokio::sync::mpsc;
use tokio::time::timeout;

use super::query::IterationQuery;
use super::request_id::REQUEST_ID;
use super::{body, coding, events, negotiate};
use crate::api::app::App;
use crate::api::batch::answer::{self, Output};
use crate::api::batch::driver::Batch;
use crate::api::batch::settings::{Forms, Settings};
use crate::api::language::{Framing, NDJSON, SSE};
use crate::api::problem::Problem;
use crate::api::stream::sending::Outgoing;
use crate::model::stream::form::Digits;
use crate::model::stream::options;

/// Fits many curves and surfaces.
pub(super) async fn batch(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    let query: IterationQuery = negotiate::query(request.uri())?;
    let headers = request.headers();
    let framing = framing(headers)?;
    let form = body::of_batch(headers)?;
    let coding = coding::of_body(headers)?;
    let request_id = headers.get(REQUEST_ID).and_then(|id| id.to_str().ok());
    let request_id = request_id.map(str::to_owned);
    let settings = Settings::new(&app, form, framing, forms(&query)?, request_id);
    let settings = Arc::new(settings);
    let batch = Batch::begin(Arc::clone(&settings), request.into_body(), coding).await?;
    let lines = Sending {
        outgoing: Outgoing::new(Arc::clone(app.jobs.resources())),
        answer: Some(batch.run()),
        heartbeat: app.config.heartbeat,
        framing,
        settings,
    };
    Ok(events::unstored(framing, lines.body()))
}

/// How lines are framed; one a line by default.
fn framing(headers: &HeaderMap) -> Result<Framing, Problem> {
    negotiate::choose(headers, &[(NDJSON, Framing::Ndjson), (SSE, Framing::Sse)])
}

/// How curves and surfaces are shown. What makes sense for neither is refused before anything is read.
fn forms(query: &IterationQuery) -> Result<Forms, Problem> {
    let of = |surface| {
        let spec = query.clone().spec(surface)?;
        let form = options::json_form(&spec, surface)?;
        if form.digits == Digits::Auto {
            let detail = "a result has all digits; rounded ones are for iterations";
            return Err(Problem::at_parameter("digits", detail));
        }
        Ok((spec, form))
    };
    let forms = Forms {
        curve: of(false),
        surface: of(true),
    };
    match (&forms.curve, &forms.surface) {
        (Err(problem), Err(_)) => Err(problem.clone()),
        _ => Ok(forms),
    }
}

/// An answer that is being sent.
struct Sending {
    outgoing: Outgoing,
    /// What comes of the batch; nothing after its end.
    answer: Option<mpsc::Receiver<Output>>,
    heartbeat: Duration,
    framing: Framing,
    settings: Arc<Settings>,
}

impl Sending {
    fn body(mut self) -> Body {
        let beginning = answer::beginning(self.framing);
        self.outgoing.text().put(beginning);
        Body::from_stream(stream::unfold(self, |mut sending| async move {
            while sending.outgoing.is_empty() {
                sending.gather().await?;
            }
            let bytes = sending.outgoing.next().await?;
            Some((bytes, sending))
        }))
    }

    /// Waits for something to send, or says that there is nothing yet; nothing after the end.
    async fn gather(&mut self) -> Option<()> {
        let output = match timeout(self.heartbeat, self.answer.as_mut()?.recv()).await {
            Ok(output) => output,
            Err(_) => {
                self.outgoing.text().put(answer::quiet(self.framing));
                return Some(());
            }
        };
        match output? {
            Output::Lines(content) => self.outgoing.push(content),
            Output::End(end) => {
                self.outgoing.text().put(answer::last(&self.settings, end));
                self.answer = None;
            }
        }
        Some(())
    }
}
