//! The description of this API in OpenAPI 3.1, and its reference for people.
//!
//! Whoever adds a resource to the router describes it there: see [`resources::Resources`].
//!
//! - [`resources`]: routes with their descriptions;
//! - [`operation`]: what one method of a resource does; `operations`: all of them;
//! - `parameters`: query parameters and headers;
//! - `answers`: schemas of what the server sends; those of what it reads are beside the readers;
//! - [`page`]: the reference.

mod answers;
pub mod operation;
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
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};

use crate::api::json::request::JobRequest;
use crate::api::json::request::edit::EditRequest;
use crate::api::json::view::to_bytes;
use crate::api::problem::Kind;
use crate::model::stream::StreamSpec;
use operation::Tag;

const DESCRIPTION: &str = "\
Fits Bézier, B-spline and NURBS curves and surfaces to ordered data points by progressive iterative approximation, \
and streams every iteration.

`POST /v1/jobs` makes a fit; with `Accept: text/event-stream` its answer is the event stream of the fit. \
Requests and answers are JSON, or the messages of `proto/piad/v1/fitting.proto` (`application/x-protobuf`). \
What a request does not say has defaults; what it says and is not understood is refused with a problem object \
(RFC 9457) that points at it.

The `Accept` header chooses among the media types of an answer, and limits of a server are told by `/v1/capabilities`.";

/// The paths of the document, and its bytes when somebody has asked for them.
#[derive(Clone, Debug)]
pub struct Description(Arc<(Map<String, Value>, OnceLock<Bytes>)>);

impl Description {
    /// The description of these paths.
    pub fn new(paths: Map<String, Value>) -> Self {
        Self(Arc::new((paths, OnceLock::new())))
    }

    fn bytes(&self) -> Bytes {
        let (paths, bytes) = self.0.as_ref();
        let make = || to_bytes(&document(paths.clone()));
        bytes.get_or_init(make).clone()
    }
}

/// `GET /openapi.json`
pub async fn get(Extension(description): Extension<Description>) -> Response {
    let content_type = HeaderValue::from_static("application/json");
    ([(header::CONTENT_TYPE, content_type)], description.bytes()).into_response()
}

/// The document, of which `paths` are the resources.
fn document(paths: Map<String, Value>) -> Value {
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
        "servers": [{"url": "/", "description": "This server."}],
        "tags": tags,
        "paths": paths,
        "components": {
            "schemas": schemas(),
            "parameters": parameters::parameters(),
            "headers": parameters::headers(),
            "links": links(),
            "examples": problem_examples(),
        },
    })
}

/// The schemas of what is read and of what is sent.
fn schemas() -> Map<String, Value> {
    let settings = SchemaSettings::draft2020_12().with(|settings| {
        settings.definitions_path = "/components/schemas".into();
        settings.meta_schema = None;
    });
    let mut generator = SchemaGenerator::new(settings);
    generator.subschema_for::<JobRequest>();
    generator.subschema_for::<EditRequest>();
    generator.subschema_for::<StreamSpec>();
    let mut schemas = generator.take_definitions(true);
    schemas.extend(answers::schemas());
    schemas
}

/// The operations that take the id of a job from the job that was made.
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
        let value = json!({
            "type": format!("/problems/{}", entry.slug),
            "title": entry.title,
            "status": entry.status.as_u16(),
            "detail": entry.meaning,
            "request_id": "019aa7a4-6a3c-7c5e-8a55-5b9d2c5f1f10",
        });
        let example = json!({"summary": entry.title, "value": value});
        (entry.slug.to_owned(), example)
    };
    Kind::ALL.into_iter().map(example).collect()
}
