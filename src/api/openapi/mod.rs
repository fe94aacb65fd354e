//! The OpenAPI 3.1 document of this API, and its reference page.
//!
//! Operations, parameters and headers are written in `api.json`; schemas are derived from types.
//!
//! - [`resources`]: routes; a test checks that each is in the document;
//! - [`operation`]: `api.json`, and its conversion to OpenAPI;
//! - [`page`]: the reference page.

mod operation;
pub(crate) mod page;
pub(crate) mod resources;

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
use crate::api::http::tickets::TicketView;
use crate::api::json::plain::simplify;
use crate::api::json::request::batch::BatchRequest;
use crate::api::json::view::batch::{BatchEvent, BatchLine};
use crate::api::json::view::curvature::ShapeView;
use crate::api::json::view::deviation::DeviationView;
use crate::api::json::view::events::{EventLine, ServerSentEvent};
use crate::api::json::view::job::JobPage;
use crate::api::json::view::limit::LimitView;
use crate::api::json::view::points::PointsView;
use crate::api::json::view::rates::RatesView;
use crate::api::json::view::result::FitResult;
use crate::api::json::view::{examples, to_bytes};
use crate::api::needs::Methods;
use crate::api::problem::{Kind, Problem, ProblemBody};
use crate::config::BasePath;
use crate::model::edit::EditRequest;
use crate::model::job::JobRequest;
use crate::model::stream::StreamSpec;
use operation::Api;

/// The path prefix of the API, its routes, and the bytes of the document once it has been requested.
#[derive(Clone, Debug)]
pub(super) struct Description(Arc<(String, Arc<Methods>, OnceLock<Bytes>)>);

impl Description {
    /// The document of these methods below a path prefix.
    pub(super) fn new(base_path: &BasePath, methods: Arc<Methods>) -> Self {
        Self(Arc::new((base_path.to_string(), methods, OnceLock::new())))
    }

    fn bytes(&self) -> Bytes {
        let (base_path, methods, bytes) = self.0.as_ref();
        let make = || match document(base_path, methods) {
            Ok(document) => to_bytes(&document),
            Err(error) => {
                tracing::error!(%error, "the description of the API cannot be read");
                Bytes::new()
            }
        };
        bytes.get_or_init(make).clone()
    }
}

/// `GET /openapi.json`
pub(super) async fn get(Extension(description): Extension<Description>) -> Response {
    let content_type = HeaderValue::from_static("application/json");
    ([(header::CONTENT_TYPE, content_type)], description.bytes()).into_response()
}

/// The document: `api.json`, with the schemas of types.
fn document(base_path: &str, methods: &Methods) -> serde_json::Result<Value> {
    let api = Api::read()?;
    let (paths, responses) = api.paths(methods);
    let mut paths = Value::Object(paths);
    let mut components = json!({
        "schemas": schemas(),
        "parameters": api.parameters,
        "headers": api.headers,
        "responses": responses,
        "links": api.links,
        "securitySchemes": {"token": {
            "type": "http",
            "scheme": "bearer",
            "description": "A token of piad token create, if the server asks for one.",
        }},
        "examples": problem_examples(),
    });
    simplify(&mut paths);
    simplify(&mut components);
    Ok(json!({
        "openapi": "3.1.1",
        "info": {
            "title": "piad",
            "version": env!("CARGO_PKG_VERSION"),
            "summary": env!("CARGO_PKG_DESCRIPTION"),
            "description": api.description,
            "license": {
                "name": "MIT OR Apache-2.0",
                "identifier": env!("CARGO_PKG_LICENSE"),
            },
        },
        "servers": [{"url": base_path, "description": "This server."}],
        "tags": api.tags,
        "paths": paths,
        "components": components,
    }))
}

/// The schemas of requests and answers. Types used in both get the schema of requests.
fn schemas() -> Map<String, Value> {
    let mut requests = generator(Contract::Deserialize);
    requests.subschema_for::<JobRequest>();
    requests.subschema_for::<BatchRequest>();
    requests.subschema_for::<EditRequest>();
    requests.subschema_for::<StreamSpec>();
    let mut answers = generator(Contract::Serialize);
    answers.subschema_for::<JobPage<'_>>();
    answers.subschema_for::<ServerSentEvent>();
    answers.subschema_for::<EventLine>();
    answers.subschema_for::<FitResult<'_>>();
    answers.subschema_for::<BatchEvent>();
    answers.subschema_for::<BatchLine>();
    answers.subschema_for::<PointsView>();
    answers.subschema_for::<LimitView>();
    answers.subschema_for::<DeviationView>();
    answers.subschema_for::<ShapeView>();
    answers.subschema_for::<RatesView>();
    answers.subschema_for::<ProblemBody>();
    answers.subschema_for::<ProblemTypes>();
    answers.subschema_for::<ServiceIndex>();
    answers.subschema_for::<Health>();
    answers.subschema_for::<TicketView>();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::api::create_job::LONGEST_KEY;
    use crate::api::http::router::resources;
    use crate::api::jobs::{DEFAULT_PAGE, LARGEST_PAGE};
    use crate::api::parse_uint::LARGEST;
    use crate::api::rates::{USUAL_DEGREE, USUAL_POINTS};
    use crate::model::named::Named;
    use crate::model::stream::MOST_MILESTONES;
    use piad_files::export::{Dots, Format, Unit};
    use piad_fit::engine::rates::{MOST_DEGREE, MOST_POINTS};

    /// The routes and the document have the same operations.
    #[test]
    fn each_route_has_a_description() {
        let (_, served) = resources().parts();
        let served = served.iter();
        let mut served: Vec<(&str, &str)> = served
            .flat_map(|(path, verbs)| verbs.iter().map(move |(verb, _)| (*path, *verb)))
            .collect();
        let api = Api::read().unwrap();
        let mut described: Vec<_> = api.routes().collect();
        served.sort_unstable();
        described.sort_unstable();
        assert_eq!(served, described);
    }

    /// The limits in the document are those of the program.
    #[test]
    fn parameters_have_the_limits_of_the_program() {
        let api = Api::read().unwrap();
        let files = page::REFERENCE.files.iter().map(|file| file.name);
        let files: Vec<_> = files.filter(|it| *it != page::REFERENCE.root).collect();
        for (pointer, value) in [
            ("limit/schema/maximum", json!(LARGEST_PAGE)),
            ("points/schema/maximum", json!(MOST_POINTS)),
            ("degree/schema/maximum", json!(MOST_DEGREE)),
            ("every/schema/maximum", json!(LARGEST)),
            ("milestones/schema/maxItems", json!(MOST_MILESTONES)),
            ("Idempotency-Key/schema/maxLength", json!(LONGEST_KEY)),
            ("format/schema/enum", json!(Format::ALL.map(Format::name))),
            ("dots/schema/enum", json!(Dots::names())),
            ("units/schema/enum", json!(Unit::names())),
            ("file/schema/enum", json!(files)),
        ] {
            let found = api.parameters.pointer(&format!("/{pointer}"));
            assert_eq!(found, Some(&value), "{pointer}");
        }
        for (name, usual) in [
            ("limit", DEFAULT_PAGE),
            ("points", USUAL_POINTS),
            ("degree", USUAL_DEGREE),
        ] {
            let default = api.parameters.pointer(&format!("/{name}/schema/default"));
            assert_eq!(default, Some(&json!(usual)), "{name}");
        }
    }
}
