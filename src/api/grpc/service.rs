//! The calls of the service. Each does the same as a REST resource, with the same code.

use std::pin::Pin;
use std::sync::Arc;

use bytes::Bytes;
use futures_util::{Stream, stream};
use prost::Message;
use tonic::{Request, Response, Status};
use uuid::Uuid;

use crate::api::app::App;
use crate::api::create_job::{self, EditOrder, Order};
use crate::api::media_type::{Framing, Language};
use crate::api::problem::{Kind, Problem};
use crate::api::proto::{edit, fields, names, request, view};
use crate::api::rates::{self, RatesRequest, WrongPart};
use crate::api::resume::{self, Start};
use crate::api::stream::encode;
use crate::api::stream::encoded::Encoded;
use crate::api::stream::feed::{Event, Feed};
use crate::api::{content, jobs};
use crate::config::Config;
use crate::job::quota::OpenStream;
use crate::job::service::creating::Accepted;
use crate::job::store::IdempotencyKey;
use crate::job::{Held, Job};
use crate::model::stream::StreamSpec;
use crate::model::stream::form::Form;
use crate::model::stream::options::{self, StreamOptions};
use crate::proto::messages as pb;
use crate::proto::messages::fitting_service_server::FittingService;
use crate::proto::stream as stream_of;

/// The service, over the jobs of an application.
#[derive(Clone)]
pub(crate) struct Service(App);

/// The events of a call.
type Events = Pin<Box<dyn Stream<Item = Result<Encoded, Status>> + Send>>;

type Reply<T> = Result<Response<T>, Status>;

impl Service {
    /// A service over these jobs.
    pub(super) fn new(app: App) -> Self {
        Self(app)
    }

    /// Creates a job, or finds the one that was created for the same key.
    async fn make(
        &self,
        input: Option<pb::JobInput>,
        key: String,
        watch: Option<&StreamSpec>,
    ) -> Result<Accepted, Problem> {
        let Self(app) = self;
        create_job::check_open(app)?;
        let input = input.ok_or_else(|| Problem::at_field("input", "it is missing"))?;
        let key = self.key(key, "/v1/jobs", &input).await?;
        if let Some(known) = create_job::known(app, key.as_ref()).await? {
            return Ok(known);
        }
        let length = input.encoded_len();
        let read = move |config: &Config| request::job(input, config).map(Into::into);
        let order = Order::new(app, length, read).await;
        let order = order.map_err(|problem| problem.within("input"))?;
        if let Some(spec) = watch {
            let wrong = |error| fields::wrong_choice(error, "stream.");
            order.check_stream(spec, Framing::Protobuf).map_err(wrong)?;
        }
        order.make(app, key).await
    }

    async fn make_edit(
        &self,
        parent: &Arc<Job>,
        message: pb::EditJobRequest,
    ) -> Result<Accepted, Problem> {
        let Self(app) = self;
        create_job::check_open(app)?;
        let edit = message
            .edit
            .ok_or_else(|| Problem::at_field("edit", "it is missing"))?;
        let path = format!("/v1/jobs/{}/edits", parent.id());
        let key = self.key(message.idempotency_key, &path, &edit).await?;
        if let Some(known) = create_job::known(app, key.as_ref()).await? {
            return Ok(known);
        }
        let within = |problem: Problem| problem.within("edit");
        let (length, owner) = (edit.encoded_len(), Arc::clone(parent));
        let read = create_job::read(app, length, move || edit::edit(edit, owner.outline()));
        let (request, layout) = read.await.map_err(within)?;
        // The call has no stream.
        if request.ephemeral == Some(true) {
            return Err(within(create_job::no_stream(&layout)));
        }
        let edit = EditOrder::new(app, parent, request, &layout).await;
        edit.map_err(within)?.order.make(app, key).await
    }

    /// The idempotency key of a request: the same as that of a REST request with the same message.
    async fn key(
        &self,
        name: String,
        path: &str,
        message: &impl Message,
    ) -> Result<Option<IdempotencyKey>, Problem> {
        if name.is_empty() {
            return Ok(None);
        }
        create_job::check_key(&name)
            .map_err(|detail| Problem::at_field("idempotency_key", detail))?;
        let body = Bytes::from(message.encode_to_vec());
        let key = create_job::key(&self.0, name, path.to_owned(), body);
        key.await.map(Some)
    }

    /// The events of a job from there on.
    fn events(
        &self,
        job: Arc<Job>,
        options: StreamOptions,
        start: Start,
        held: Held,
        open: OpenStream,
    ) -> Events {
        let feed = Feed::new(&self.0, job, options, start, held, open);
        Box::pin(stream::unfold(Some(feed), next))
    }
}

/// The next message of a stream, made when the connection has taken the one before.
async fn next(feed: Option<Feed>) -> Option<(Result<Encoded, Status>, Option<Feed>)> {
    let mut feed = feed?;
    loop {
        let (ends, event) = match feed.next().await {
            None => {
                let problem = Problem::new(Kind::Internal, "the stream was interrupted");
                return Some((Err(problem.into()), None));
            }
            Some(Event::Stopping) => {
                return Some((Err(create_job::stopping().retry_after(1).into()), None));
            }
            // Connections are kept open by HTTP/2 itself.
            Some(Event::Quiet) => continue,
            Some(event) => (matches!(event, Event::End(_)), event),
        };
        if let Some(message) = Encoded::event(event) {
            return Some((Ok(message), (!ends).then_some(feed)));
        }
    }
}

/// The form of a single requested level.
fn form(job: &Job, view: i32, samples_u: u32, samples_v: u32) -> Result<Form, Problem> {
    let options = pb::StreamOptions {
        view,
        samples_u,
        samples_v,
        ..pb::StreamOptions::default()
    };
    // The choices are fields of the request itself.
    let spec = stream_of::spec(options, "").map_err(fields::wrong)?;
    let form = options::message_form(&spec, job.outline().surface);
    form.map_err(|error| fields::wrong_choice(error, ""))
}

/// The number of an iteration; numbers beyond those of any job are cut.
fn level(number: u64) -> usize {
    usize::try_from(number).map_or(usize::MAX / 4, |number| number.min(usize::MAX / 4))
}

#[tonic::async_trait]
impl FittingService for Service {
    type FitStream = Events;
    type WatchJobStream = Events;

    async fn create_job(
        &self,
        request: Request<pb::CreateJobRequest>,
    ) -> Reply<pb::CreateJobResponse> {
        let message = request.into_inner();
        let accepted = self.make(message.input, message.idempotency_key, None);
        let Accepted { job, replayed } = accepted.await?;
        Ok(Response::new(pb::CreateJobResponse {
            job: Some(view::job(&job)),
            replayed,
        }))
    }

    async fn fit(&self, request: Request<pb::FitRequest>) -> Reply<Events> {
        let message = request.into_inner();
        let spec = stream_of::of_call(message.stream).map_err(fields::wrong)?;
        let open = self.0.open_stream().map_err(Problem::from)?;
        let accepted = self.make(message.input, message.idempotency_key, Some(&spec));
        let Accepted { job, replayed } = accepted.await?;
        let outline = job.outline();
        let defaults = outline.label.stream.as_deref();
        let options = StreamOptions::new(&spec, defaults, true, outline.surface);
        let wrong = |error| fields::wrong_choice(error, "stream.");
        let mut options = options.map_err(wrong)?;
        // A job that was created before has its own stream; only that one may cancel it.
        options.cancels &= !replayed;
        let held = job.held().await?;
        Ok(Response::new(self.events(
            job,
            options,
            Start::First,
            held,
            open,
        )))
    }

    async fn get_job(&self, request: Request<pb::GetJobRequest>) -> Reply<pb::GetJobResponse> {
        let job = jobs::find(&self.0, &request.get_ref().id).await?;
        let job = Some(view::job(&job));
        Ok(Response::new(pb::GetJobResponse { job }))
    }

    async fn list_jobs(
        &self,
        request: Request<pb::ListJobsRequest>,
    ) -> Reply<pb::ListJobsResponse> {
        let message = request.into_inner();
        let limit = match message.page_size {
            0 => jobs::DEFAULT_PAGE,
            size => size as usize,
        };
        jobs::check_limit(limit).map_err(|detail| Problem::at_field("page_size", detail))?;
        let state = names::wanted_state(message.state).map_err(fields::wrong)?;
        let before = match message.page_token.as_str() {
            "" => None,
            token => Some(Uuid::try_parse(token).map_err(|_| {
                let detail = "it is not from this server";
                Problem::at_field("page_token", detail)
            })?),
        };
        let (jobs, more) = jobs::page(&self.0, state, before, limit).await?;
        Ok(Response::new(view::page(&jobs, more)))
    }

    async fn cancel_job(
        &self,
        request: Request<pb::CancelJobRequest>,
    ) -> Reply<pb::CancelJobResponse> {
        let job = jobs::find(&self.0, &request.get_ref().id).await?;
        jobs::end(&job).await?;
        let job = Some(view::job(&job));
        Ok(Response::new(pb::CancelJobResponse { job }))
    }

    async fn delete_job(
        &self,
        request: Request<pb::DeleteJobRequest>,
    ) -> Reply<pb::DeleteJobResponse> {
        jobs::forget(&self.0, &request.get_ref().id).await?;
        Ok(Response::new(pb::DeleteJobResponse {}))
    }

    async fn edit_job(&self, request: Request<pb::EditJobRequest>) -> Reply<pb::EditJobResponse> {
        let message = request.into_inner();
        let parent = jobs::find(&self.0, &message.id).await?;
        let Accepted { job, replayed } = self.make_edit(&parent, message).await?;
        Ok(Response::new(pb::EditJobResponse {
            job: Some(view::job(&job)),
            replayed,
        }))
    }

    async fn get_iteration(&self, request: Request<pb::GetIterationRequest>) -> Reply<Encoded> {
        let message = request.into_inner();
        let job = jobs::find(&self.0, &message.id).await?;
        let form = form(&job, message.view, message.samples_u, message.samples_v)?;
        let frame = content::frame(&self.0, &job, message.iteration.map(level), None).await?;
        let bytes = encode::frame(&job, &frame, &form).await?;
        Ok(Response::new(Encoded::response(bytes)))
    }

    async fn get_result(&self, request: Request<pb::GetResultRequest>) -> Reply<Encoded> {
        let message = request.into_inner();
        let job = jobs::find(&self.0, &message.id).await?;
        let form = form(&job, message.view, message.samples_u, message.samples_v)?;
        let bytes = content::result_content(&job, form).await?;
        Ok(Response::new(Encoded::response(bytes)))
    }

    async fn get_deviation(
        &self,
        request: Request<pb::GetDeviationRequest>,
    ) -> Reply<pb::GetDeviationResponse> {
        let message = request.into_inner();
        let job = jobs::find(&self.0, &message.id).await?;
        let (frame, deviation) =
            content::deviation(&self.0, &job, message.iteration.map(level), None).await?;
        let iteration = frame.level.iteration;
        Ok(Response::new(view::deviation(
            iteration,
            deviation,
            message.list,
        )))
    }

    async fn get_input(&self, request: Request<pb::GetInputRequest>) -> Reply<Encoded> {
        let job = jobs::find(&self.0, &request.get_ref().id).await?;
        let bytes = content::input_content(&job, Language::Protobuf).await?;
        Ok(Response::new(Encoded::response(bytes)))
    }

    async fn compare_bases(
        &self,
        request: Request<pb::CompareBasesRequest>,
    ) -> Reply<pb::CompareBasesResponse> {
        let message = request.into_inner();
        let request = RatesRequest {
            points: Some(message.points as usize).filter(|points| *points > 0),
            parameters: Some(message.parameters).filter(|values| !values.is_empty()),
            degree: message.degree.map(|degree| degree as usize),
            tolerance: message.tolerance,
        };
        let wrong = |WrongPart(name, detail)| Problem::at_field(name, detail);
        let compared = rates::rates(&self.0, request, wrong).await?;
        Ok(Response::new(view::rates(&compared)))
    }

    async fn watch_job(&self, request: Request<pb::WatchJobRequest>) -> Reply<Events> {
        let message = request.into_inner();
        let job = jobs::find(&self.0, &message.id).await?;
        let spec = stream_of::of_call(message.stream).map_err(fields::wrong)?;
        let outline = job.outline();
        let defaults = outline.label.stream.as_deref();
        let surface = outline.surface;
        let options = StreamOptions::of_reader(&spec, defaults, true, surface);
        let wrong = |error| fields::wrong_choice(error, "stream.");
        let options = options.map_err(wrong)?;
        let after = message.resume_after.map(level);
        let start = after.map(|k| resume::after_iteration(&job, k));
        let start = start
            .transpose()
            .map_err(|detail| Problem::at_field("resume_after", detail))?;
        let start = start.unwrap_or(Start::First);
        let open = self.0.open_stream().map_err(Problem::from)?;
        let held = job.held().await?;
        Ok(Response::new(self.events(job, options, start, held, open)))
    }
}
