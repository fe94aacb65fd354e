//! The operations of the API as written in `api.json`, and as in OpenAPI.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::{Map, Value, json};

use crate::api::media_type::JSON;
use crate::api::needs::{Methods, Needs};
use crate::api::problem::Kind;

/// All that is not derived from types: `api.json`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Api {
    pub(super) description: String,
    pub(super) tags: Value,
    /// Problems of several operations, by the names of these groups.
    problems: BTreeMap<String, Vec<String>>,
    pub(super) parameters: Value,
    pub(super) headers: Value,
    pub(super) links: Map<String, Value>,
    /// The bodies of requests.
    bodies: Map<String, Value>,
    /// The content of answers, where it is not one object of JSON.
    contents: Map<String, Value>,
    operations: Vec<Operation>,
}

/// An operation.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Operation {
    path: String,
    verb: String,
    tag: String,
    /// Its operationId, the name in generated clients.
    id: String,
    summary: String,
    description: String,
    /// The names of its parameters.
    #[serde(default)]
    parameters: Vec<String>,
    /// The name of its body.
    body: Option<String>,
    /// Its answers, by their status.
    answers: BTreeMap<String, Answer>,
    /// The problems that it may return besides internal errors, or groups of them.
    problems: Vec<String>,
}

/// An answer.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Answer {
    description: String,
    /// Its headers besides the id of the request.
    #[serde(default)]
    headers: Vec<String>,
    /// The schema of an answer that is JSON.
    json: Option<String>,
    /// The name of other content.
    content: Option<String>,
    /// True if it has links to the operations on a job.
    #[serde(default)]
    links: bool,
}

impl Api {
    /// The contents of `api.json`.
    pub(super) fn read() -> serde_json::Result<Self> {
        serde_json::from_str(include_str!("api.json"))
    }

    /// The paths of the document, with the authorization of their methods, and the answers that they refer to.
    pub(super) fn paths(&self, methods: &Methods) -> (Map<String, Value>, Map<String, Value>) {
        let (mut paths, mut shared) = (Map::new(), Map::new());
        for operation in &self.operations {
            let methods = methods.get(operation.path.as_str()).into_iter().flatten();
            let mut needs = methods.filter(|(verb, _)| *verb == operation.verb);
            let needs = needs.next().map_or(Needs::Nothing, |(_, needs)| *needs);
            let resource = paths.entry(&operation.path).or_insert_with(|| json!({}));
            resource[&operation.verb] = self.operation(operation, needs, &mut shared);
        }
        (paths, shared)
    }

    fn operation(
        &self,
        operation: &Operation,
        needs: Needs,
        shared: &mut Map<String, Value>,
    ) -> Value {
        let mut object = json!({
            "tags": [operation.tag],
            "summary": operation.summary,
            "description": operation.description,
            "operationId": operation.id,
        });
        if !operation.parameters.is_empty() {
            let references = operation.parameters.iter();
            object["parameters"] = references.map(|it| reference("parameters", it)).collect();
        }
        if let Some(body) = &operation.body {
            object["requestBody"] = self.bodies.get(body).cloned().unwrap_or_default();
        }
        let answers = operation.answers.iter();
        let answers = answers.map(|(status, it)| (status.clone(), self.answer(it)));
        let mut answers: BTreeMap<String, Value> = answers.collect();
        let mut problems: BTreeMap<u16, Vec<Kind>> = BTreeMap::new();
        let mut kinds: Vec<Kind> = self.kinds(operation).collect();
        if let Needs::A(scope) = needs {
            // Servers without tokens need none.
            object["security"] = json!([{"token": [scope.name()]}, {}]);
            kinds.extend([Kind::Unauthenticated, Kind::Forbidden]);
        }
        for kind in kinds {
            let status = kind.entry().status.as_u16();
            problems.entry(status).or_default().push(kind);
        }
        for (status, kinds) in problems {
            let mut answer = problem_answer(status, &kinds);
            // A problem alone is shared by many operations.
            if let [kind] = kinds.as_slice() {
                let slug = kind.entry().slug;
                shared.insert(slug.to_owned(), answer);
                answer = reference("responses", slug);
            }
            answers.insert(status.to_string(), answer);
        }
        object["responses"] = answers.into_iter().collect();
        object
    }

    fn answer(&self, answer: &Answer) -> Value {
        let headers = answer.headers.iter().map(String::as_str);
        let mut object = json!({
            "description": answer.description,
            "headers": header_references(headers),
        });
        if let Some(schema) = &answer.json {
            object["content"] = json!({JSON: {"schema": reference("schemas", schema)}});
        }
        if let Some(content) = &answer.content {
            object["content"] = self.contents.get(content).cloned().unwrap_or_default();
        }
        if answer.links {
            let links = self.links.keys();
            let links = links.map(|id| (id.clone(), reference("links", id)));
            object["links"] = links.collect();
        }
        object
    }

    /// The problems that an operation may return.
    fn kinds<'a>(&'a self, operation: &'a Operation) -> impl Iterator<Item = Kind> + 'a {
        let names = operation.problems.iter();
        let slugs = names.flat_map(|name| match self.problems.get(name) {
            Some(group) => group.as_slice(),
            None => std::slice::from_ref(name),
        });
        let of_slug = |slug: &String| Kind::ALL.into_iter().find(|it| it.entry().slug == slug);
        slugs.filter_map(of_slug).chain([Kind::Internal])
    }

    /// The path and the method of each operation.
    #[cfg(test)]
    pub(super) fn routes(&self) -> impl Iterator<Item = (&str, &str)> {
        let operations = self.operations.iter();
        operations.map(|it| (it.path.as_str(), it.verb.as_str()))
    }
}

/// A reference to a component.
fn reference(section: &str, name: &str) -> Value {
    json!({"$ref": format!("#/components/{section}/{name}")})
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
    let waits = matches!(status, 429 | 503).then_some("Retry-After");
    json!({
        "description": lines.join("\n"),
        "headers": header_references(waits),
        "content": {
            "application/problem+json": {
                "schema": reference("schemas", "Problem"),
                "examples": examples,
            },
        },
    })
}

fn header_references<'a>(names: impl IntoIterator<Item = &'a str>) -> Map<String, Value> {
    let all = std::iter::once("X-Request-Id").chain(names);
    all.map(|name| (name.to_owned(), reference("headers", name)))
        .collect()
}
