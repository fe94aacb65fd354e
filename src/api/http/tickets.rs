//! Tickets for streams: for clients that cannot send a header with their token.

use axum::Json;
use axum::extract::{Extension, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use jiff::{SignedDuration, Timestamp};
use schemars::JsonSchema;
use serde::Serialize;

use super::answer::no_store;
use super::path::InPath;
use crate::access::file::Token;
use crate::access::ticket::Ticket;
use crate::api::app::App;
use crate::api::jobs;
use crate::api::problem::{Kind, Problem};

/// A ticket for the stream of a job, for use in the query.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Ticket", example = example())]
pub(in crate::api) struct TicketView {
    /// The value of the query parameter `ticket`.
    ticket: String,
    /// The time until which it can open a stream; an open stream continues.
    expires: Timestamp,
}

fn example() -> TicketView {
    TicketView {
        ticket: "piad_ticket_AZqnpGo8fF6KVVudLF8fEAAAAABpJ4pA".to_owned(),
        expires: Timestamp::UNIX_EPOCH + SignedDuration::from_hours(500_000),
    }
}

/// `POST /v1/jobs/{id}/tickets`
pub(super) async fn make(
    State(app): State<App>,
    InPath(id): InPath<String>,
    token: Option<Extension<Token>>,
) -> Result<Response, Problem> {
    let job = jobs::find(&app, &id).await?;
    let (Some(Extension(token)), Some(access)) = (token, &app.access) else {
        let detail = "this server requires no tokens, so its streams need no tickets";
        return Err(Problem::new(Kind::NoTickets, detail));
    };
    let (ticket, expires) = Ticket::issue(&access.tickets, &token, job.id());
    let view = TicketView { ticket, expires };
    Ok(no_store((StatusCode::CREATED, Json(view)).into_response()))
}
