//! The description of an operation: its parameters, its body and its answers.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde_json::{Map, Value, json};

use crate::api::language::JSON;
use crate::api::problem::{Kind, ProblemBody};

/// The groups of operations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tag {
    /// Making, listing, stopping and deleting jobs.
    Jobs,
    /// Event streams.
    Events,
    /// Iterations and results.
    Geometry,
    /// The server itself.
    Server,
}

impl Tag {
    /// All tags with their descriptions.
    pub(super) const ALL: [(Self, &'static str); 4] = [
        (
            Self::Jobs,
            "Fits: create, edit, list, show, cancel and delete them.",
        ),
        (Self::Events, "Every iteration of a fit as an event."),
        (
            Self::Geometry,
            "Curves and surfaces of single iterations, as JSON, messages and files.",
        ),
        (Self::Server, "What the server can do, and how it is."),
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Jobs => "jobs",
            Self::Events => "events",
            Self::Geometry => "geometry",
            Self::Server => "server",
        }
    }
}

/// The description of an operation.
#[derive(Clone, Debug)]
pub struct Operation {
    object: Map<String, Value>,
    answers: BTreeMap<u16, Value>,
    problems: Vec<Kind>,
}

impl Operation {
    /// An operation; `id` is what clients in other languages call it.
    pub fn new(tag: Tag, id: &str, summary: &str, description: &str) -> Self {
        let mut object = Map::new();
        object.insert("tags".to_owned(), json!([tag.name()]));
        object.insert("summary".to_owned(), json!(summary));
        object.insert("description".to_owned(), json!(description));
        object.insert("operationId".to_owned(), json!(id));
        Self {
            object,
            answers: BTreeMap::new(),
            problems: Vec::new(),
        }
    }

    /// The parameters: names of components.
    pub fn parameters(mut self, names: &[&str]) -> Self {
        let references = names.iter().map(|name| reference("parameters", name));
        self.object
            .insert("parameters".to_owned(), references.collect());
        self
    }

    /// The body: JSON with this schema and these examples.
    pub fn body<T: JsonSchema>(mut self, examples: Value) -> Self {
        let json = json!({"schema": schema_of::<T>(), "examples": examples});
        let body = json!({"description": "JSON.", "required": true, "content": {JSON: json}});
        self.object.insert("requestBody".to_owned(), body);
        self
    }

    /// The body: a text, as CSV or plain.
    pub fn text_body(mut self, description: &str, example: &str) -> Self {
        let text = json!({"schema": {"type": "string"}, "example": example});
        let content = json!({"text/csv": text, "text/plain": text});
        let body = json!({"description": description, "required": true, "content": content});
        self.object.insert("requestBody".to_owned(), body);
        self
    }

    /// An answer with content of these media types, and these headers besides the id of the request.
    pub fn answer(
        mut self,
        status: u16,
        description: &str,
        content: &[(&str, Value)],
        headers: &[&str],
    ) -> Self {
        let mut answer = json!({"description": description, "headers": header_references(headers)});
        if !content.is_empty() {
            let content = content.iter().map(|(name, value)| (*name, value.clone()));
            answer["content"] = content.collect();
        }
        self.answers.insert(status, answer);
        self
    }

    /// An answer that is a JSON object, and never anything else.
    pub fn json<T: JsonSchema>(self, status: u16, description: &str) -> Self {
        self.answer(status, description, &[json_of::<T>()], &[])
    }

    /// Links to operations on the job in an answer.
    pub(super) fn links(mut self, status: u16, ids: &[&str]) -> Self {
        let links = ids
            .iter()
            .map(|id| ((*id).to_owned(), reference("links", id)));
        if let Some(answer) = self.answers.get_mut(&status) {
            answer["links"] = links.collect();
        }
        self
    }

    /// The problems that it may answer, besides internal errors.
    pub fn problems(mut self, kinds: &[Kind]) -> Self {
        self.problems.extend(kinds);
        self
    }

    /// The operation as the specification has it.
    pub(super) fn object(mut self) -> Value {
        self.problems.push(Kind::Internal);
        let mut groups: BTreeMap<u16, Vec<Kind>> = BTreeMap::new();
        for kind in self.problems {
            let status = kind.entry().status.as_u16();
            groups.entry(status).or_default().push(kind);
        }
        for (status, kinds) in groups {
            self.answers.insert(status, problem_answer(status, &kinds));
        }
        let answers = self.answers.into_iter();
        let answers = answers.map(|(status, answer)| (status.to_string(), answer));
        self.object
            .insert("responses".to_owned(), answers.collect());
        Value::Object(self.object)
    }
}

/// A reference to a component.
fn reference(section: &str, name: &str) -> Value {
    json!({"$ref": format!("#/components/{section}/{name}")})
}

/// A reference to the schema of a type.
pub fn schema_of<T: JsonSchema>() -> Value {
    reference("schemas", &T::schema_name())
}

/// JSON of this schema as the content of an answer.
pub fn json_of<T: JsonSchema>() -> (&'static str, Value) {
    (JSON, json!({"schema": schema_of::<T>()}))
}

/// All problems with the same status.
fn problem_answer(status: u16, kinds: &[Kind]) -> Value {
    let lines = kinds.iter().map(|kind| {
        let entry = kind.entry();
        format!("- `/problems/{}`: {}", entry.slug, entry.meaning)
    });
    let lines: Vec<String> = lines.collect();
    let examples = kinds.iter().map(|kind| {
        let slug = kind.entry().slug;
        (slug.to_owned(), reference("examples", slug))
    });
    let examples: Map<String, Value> = examples.collect();
    let headers: &[&str] = match status {
        429 | 503 => &["Retry-After"],
        _ => &[],
    };
    json!({
        "description": lines.join("\n"),
        "headers": header_references(headers),
        "content": {
            "application/problem+json": {
                "schema": schema_of::<ProblemBody>(),
                "examples": examples,
            },
        },
    })
}

fn header_references(names: &[&str]) -> Map<String, Value> {
    let all = ["X-Request-Id"].iter().chain(names);
    all.map(|name| ((*name).to_owned(), reference("headers", name)))
        .collect()
}
