//! The description of this API in OpenAPI 3.1, and its reference for people.
//!
//! A route is added to the router together with its description: see [`resources::DescribedRoutes`].
//!
//! - [`resources`]: routes with their descriptions;
//! - [`operation`]: what one method of a resource does; `operations`: all of them;
//! - `parameters`: query parameters and headers;
//! - [`page`]: the reference.

mod operation;
pub mod operations;
pub mod page;
mod parameters;
pub mod resources;

use std::sync::{Arc, OnceLock};

use axum::Extension;
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use schemars::SchemaGenerator;
use schemars::generate::{Contract, SchemaSettings};
use serde_json::{Map, Value, json};

use crate::api::http::capabilities::Capabilities;
use crate::api::http::info::{Health, ProblemTypes, ServiceIndex};
use crate::api::json::request::edit::EditRequest;
use crate::api::json::request::job::JobRequest;
use crate::api::json::schema::plain::simplify;
use crate::api::json::view::deviation::DeviationView;
use crate::api::json::view::events::{EventLine, ServerSentEvent};
use crate::api::json::view::job::JobPage;
use crate::api::json::view::limit::LimitView;
use crate::api::json::view::points::PointsView;
use crate::api::json::view::rates::RatesView;
use crate::api::json::view::result::FitResult;
use crate::api::json::view::{examples, to_bytes};
use crate::api::problem::{Kind, Problem, ProblemBody};
use crate::config::BasePath;
use crate::model::stream::StreamSpec;
use operation::Tag;

const DESCRIPTION: &str = "\
Fits Bézier, B-spline and NURBS curves and surfaces to ordered data points by progressive iterative approximation, \
and streams every iteration.

`POST /v1/jobs` makes a fit and answers with the job, `POST /v1/jobs/stream` with the event stream of the fit. \
What a request does not say has defaults; what it says and is not understood is refused with a problem object \
(RFC 9457) that points at it. Limits of a server are told by `/v1/capabilities`.

Each operation is described with one kind of answer. Its `Accept` header may choose others: event streams instead \
of new jobs, files instead of JSON, and the messages of `proto/piad/v1/fitting.proto` (`application/x-protobuf`), \
in which jobs and edits may also be sent. Bodies may be compressed (`Content-Encoding: gzip` or `zstd`), and \
answers are for those who ask for it (`Accept-Encoding`), event streams excepted.";

/// The paths of the document, and its bytes once it has been requested.
#[derive(Clone, Debug)]
pub struct Description(Arc<(Map<String, Value>, String, OnceLock<Bytes>)>);

impl Description {
    /// The description of these paths, below one that clients see.
    pub fn new(paths: Map<String, Value>, base_path: &BasePath) -> Self {
        Self(Arc::new((paths, base_path.to_string(), OnceLock::new())))
    }

    fn bytes(&self) -> Bytes {
        let (paths, base_path, bytes) = self.0.as_ref();
        let make = || to_bytes(&document(paths.clone(), base_path));
        bytes.get_or_init(make).clone()
    }
}

/// `GET /openapi.json`
pub async fn get(Extension(description): Extension<Description>) -> Response {
    let content_type = HeaderValue::from_static("application/json");
    ([(header::CONTENT_TYPE, content_type)], description.bytes()).into_response()
}

/// The document, of which `paths` are the resources.
fn document(paths: Map<String, Value>, base_path: &str) -> Value {
    let mut paths = Value::Object(paths);
    let mut components = json!({
        "schemas": schemas(),
        "parameters": parameters::parameters(),
        "headers": parameters::headers(),
        "links": links(),
        "examples": problem_examples(),
    });
    simplify(&mut paths);
    simplify(&mut components);
    let tags = Tag::ALL.map(|(tag, text)| json!({"name": tag.name(), "description": text}));
    json!({
        "openapi": "3.1.1",
        "info": {
            "title": "piad",
            "version": env!("CARGO_PKG_VERSION"),
            "summary": env!("CARGO_PKG_DESCRIPTION"),
            "description": DESCRIPTION,
            "license": {
                "name": "MIT OR Apache-2.0",
                "identifier": env!("CARGO_PKG_LICENSE"),
            },
        },
        "servers": [{"url": base_path, "description": "This server."}],
        "tags": tags,
        "paths": paths,
        "components": components,
    })
}

/// The schemas of requests and answers. Types of both are described as requests.
fn schemas() -> Map<String, Value> {
    let mut requests = generator(Contract::Deserialize);
    requests.subschema_for::<JobRequest>();
    requests.subschema_for::<EditRequest>();
    requests.subschema_for::<StreamSpec>();
    let mut answers = generator(Contract::Serialize);
    answers.subschema_for::<JobPage<'_>>();
    answers.subschema_for::<ServerSentEvent>();
    answers.subschema_for::<EventLine>();
    answers.subschema_for::<FitResult<'_>>();
    answers.subschema_for::<PointsView>();
    answers.subschema_for::<LimitView>();
    answers.subschema_for::<DeviationView>();
    answers.subschema_for::<RatesView>();
    answers.subschema_for::<ProblemBody>();
    answers.subschema_for::<ProblemTypes>();
    answers.subschema_for::<ServiceIndex>();
    answers.subschema_for::<Health>();
    answers.subschema_for::<Capabilities>();
    let mut schemas = requests.take_definitions(true);
    for (name, schema) in answers.take_definitions(true) {
        schemas.entry(name).or_insert(schema);
    }
    schemas
}

fn generator(contract: Contract) -> SchemaGenerator {
    let settings = SchemaSettings::draft2020_12().with(|settings| {
        settings.definitions_path = "/components/schemas".into();
        settings.meta_schema = None;
        settings.contract = contract;
    });
    SchemaGenerator::new(settings)
}

/// Links from a new job to the operations that take its id.
fn links() -> Map<String, Value> {
    let link = |id: &str| {
        let mut parameters = json!({"id": "$response.body#/id"});
        if id == "getIteration" {
            parameters["k"] = json!("last");
        }
        let link = json!({
            "description": "The id of the job that was made.",
            "operationId": id,
            "parameters": parameters,
        });
        (id.to_owned(), link)
    };
    operations::WITH_A_JOB.into_iter().map(link).collect()
}

/// A problem object of each kind.
fn problem_examples() -> Map<String, Value> {
    let example = |kind: Kind| {
        let entry = kind.entry();
        let value = Problem::new(kind, entry.meaning).body(Some(examples::ID));
        let example = json!({"summary": entry.title, "value": value});
        (entry.slug.to_owned(), example)
    };
    Kind::ALL.into_iter().map(example).collect()
}
