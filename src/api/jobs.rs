//! Finding, listing, cancelling and deleting jobs, for HTTP and gRPC.

use std::sync::Arc;

use uuid::Uuid;

use super::app::App;
use super::problem::{Kind, Problem};
use crate::job::Job;
use crate::job::peer::Peer;
use crate::job::state::State;
use crate::job::store::Selection;
use crate::job::tenant::Tenant;

/// The number of jobs on a page by default.
pub(super) const DEFAULT_PAGE: usize = 50;
/// The most jobs of a page.
pub(super) const LARGEST_PAGE: usize = 1000;

/// Checks the number of jobs that a page may have.
pub(super) fn check_limit(limit: usize) -> Result<(), String> {
    match (1..=LARGEST_PAGE).contains(&limit) {
        true => Ok(()),
        false => Err(format!("{limit} does not lie between 1 and {LARGEST_PAGE}")),
    }
}

/// A page of the list, and whether there are more.
pub(super) async fn page(
    app: &App,
    state: Option<State>,
    before: Option<Uuid>,
    limit: usize,
) -> Result<(Vec<Arc<Job>>, bool), Problem> {
    let selection = Selection {
        tenant: tenant(app)?,
        state,
        before,
        // One more, which shows that there is a next page.
        limit: limit + 1,
    };
    let mut jobs = app.jobs.list(selection).await?;
    let more = jobs.len() > limit;
    jobs.truncate(limit);
    Ok((jobs, more))
}

/// Cancels a job.
pub(super) async fn end(job: &Job) -> Result<(), Problem> {
    job.request_cancel();
    let status = job.ended().await;
    if status.state == State::Cancelled {
        return Ok(());
    }
    let detail = format!("the job has already ended: it is {}", status.state);
    Err(Problem::new(Kind::AlreadyEnded, detail))
}

/// Deletes a job.
pub(super) async fn forget(app: &App, id: &str) -> Result<(), Problem> {
    // One that cannot be read can still be deleted, if it cannot be another tenant's.
    if tenant(app)?.is_some() {
        find(app, id).await?;
    }
    let existed = app.jobs.delete(job_id(id)?).await?;
    existed
        .then_some(())
        .ok_or_else(|| Problem::unknown_job(id))
}

/// The job that a path names.
pub(super) async fn find(app: &App, id: &str) -> Result<Arc<Job>, Problem> {
    let job = known(app, id).await?;
    job.ok_or_else(|| Problem::unknown_job(id))
}

/// The job with this id, if the caller may see it.
pub(super) async fn known(app: &App, id: &str) -> Result<Option<Arc<Job>>, Problem> {
    let tenant = tenant(app)?;
    let job = match Uuid::try_parse(id) {
        Ok(id) => app.jobs.find(id).await?,
        Err(_) => None,
    };
    Ok(job.filter(|job| tenant.is_none_or(|it| it == job.outline().tenant)))
}

fn job_id(id: &str) -> Result<Uuid, Problem> {
    Uuid::try_parse(id).map_err(|_| Problem::unknown_job(id))
}

/// The tenant whose jobs the caller sees; `None` (all) if the server requires no tokens.
fn tenant(app: &App) -> Result<Option<Tenant>, Problem> {
    match (&app.access, Peer::current().and_then(Peer::tenant)) {
        (None, _) => Ok(None),
        (Some(_), Some(tenant)) => Ok(Some(tenant)),
        // No resource with jobs can be reached without a token.
        (Some(_), None) => Err(Problem::new(Kind::Unauthenticated, "a token is needed")),
    }
}
