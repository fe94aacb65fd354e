//! The description of the API is complete, and true of what requests may say.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use reqwest::Method;
use serde_json::{Value, json};

use crate::description::Description;
use crate::support::{Server, base, problem};

/// Set to write docs/openapi.json instead of comparing it: `make openapi`.
const WRITE: &str = "PIAD_WRITE_OPENAPI";

const VERBS: [&str; 3] = ["get", "post", "delete"];

#[tokio::test]
async fn the_file_is_what_a_server_says() {
    let server = Server::start().await;
    let description = Description::of(&server).await;
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("docs/openapi.json");
    let text = serde_json::to_string_pretty(&description.0).unwrap() + "\n";
    if std::env::var_os(WRITE).is_some() {
        std::fs::write(&file, &text).unwrap();
    }
    let committed = std::fs::read_to_string(file).unwrap_or_default();
    assert!(committed == text, "docs/openapi.json is old: make openapi");
}

#[tokio::test]
async fn each_operation_is_described() {
    let server = Server::start().await;
    let description = Description::of(&server).await;
    let mut ids = BTreeSet::new();
    for (path, method, operation) in description.operations() {
        assert!(VERBS.contains(&method.as_str()), "{method}");
        for field in ["summary", "description", "operationId"] {
            assert!(operation[field].is_string(), "{method} {path}: {field}");
        }
        assert!(
            ids.insert(operation["operationId"].to_string()),
            "{operation}"
        );
        let names = parameters(&description, operation);
        let in_path = path.split('/').filter_map(|part| part.strip_prefix('{'));
        for name in in_path.map(|part| part.trim_end_matches('}')) {
            assert!(names.iter().any(|it| it["name"] == name), "{path}: {name}");
        }
        let answers = operation["responses"].as_object().unwrap();
        assert!(
            answers.keys().any(|status| status.starts_with('2')),
            "{path}"
        );
        for answer in answers.values() {
            let answer = description.resolved(answer);
            assert!(answer["description"].is_string());
            assert!(answer["headers"]["X-Request-Id"].is_object());
        }
    }
}

fn parameters<'a>(description: &'a Description, operation: &Value) -> Vec<&'a Value> {
    let Some(references) = operation["parameters"].as_array() else {
        return Vec::new();
    };
    let name = |it: &Value| {
        it["$ref"]
            .as_str()
            .unwrap()
            .rsplit('/')
            .next()
            .unwrap()
            .to_owned()
    };
    let names = references.iter().map(name);
    names
        .map(|name| description.component("parameters", &name))
        .collect()
}

/// A resource that is described is served, with these methods and no others. That all that is
/// served is described is the router's business, which has one list for both.
#[tokio::test]
async fn resources_have_the_methods_that_are_described() {
    let server = Server::start().await;
    let description = Description::of(&server).await;
    for (path, resource) in description.0["paths"].as_object().unwrap() {
        let url = format!("{}{}", server.url, path.replace(['{', '}'], ""));
        let response = server
            .client
            .request(Method::PATCH, url)
            .send()
            .await
            .unwrap();
        let allow = response.headers()["allow"].to_str().unwrap().to_lowercase();
        let allowed: BTreeSet<&str> = allow.split(',').filter(|it| *it != "head").collect();
        let described = resource.as_object().unwrap().keys();
        assert_eq!(allowed, described.map(String::as_str).collect(), "{path}");
        assert_eq!(problem(response).await.0, 405);
    }
}

#[tokio::test]
async fn references_resolve_and_components_are_used() {
    let server = Server::start().await;
    let description = Description::of(&server).await;
    let mut references = BTreeSet::new();
    walk(&description.0, &mut |value| {
        references.extend(value["$ref"].as_str().map(str::to_owned));
        // Schemes are called by their names.
        let needs = value["security"].as_array().into_iter().flatten();
        let schemes = needs.flat_map(|it| it.as_object().unwrap().keys());
        let schemes = schemes.map(|name| format!("#/components/securitySchemes/{name}"));
        references.extend(schemes);
    });
    for reference in &references {
        let pointer = reference.strip_prefix('#').unwrap();
        assert!(description.0.pointer(pointer).is_some(), "{reference}");
    }
    for (section, components) in description.0["components"].as_object().unwrap() {
        // Some problems are those of jobs, or of any path.
        if section == "examples" {
            continue;
        }
        for name in components.as_object().unwrap().keys() {
            let reference = format!("#/components/{section}/{name}");
            assert!(references.contains(&reference), "{reference} is not used");
        }
    }
}

fn walk(value: &Value, see: &mut impl FnMut(&Value)) {
    see(value);
    match value {
        Value::Object(fields) => fields.values().for_each(|value| walk(value, see)),
        Value::Array(items) => items.iter().for_each(|value| walk(value, see)),
        _ => {}
    }
}

#[tokio::test]
async fn schemas_have_descriptions_and_examples() {
    let server = Server::start().await;
    let description = Description::of(&server).await;
    for (name, schema) in description.schemas() {
        assert!(schema["description"].is_string(), "{name}");
        walk(schema, &mut |part| {
            // Fields, not a field of this name.
            let Some(fields) = part["properties"].as_object() else {
                return;
            };
            for (field, schema) in fields {
                assert!(schema["description"].is_string(), "{name}: {field}");
            }
        });
        assert!(schema["examples"].is_array(), "{name} has no example");
    }
}

/// The bodies and the parameters that the description shows can be sent as they are.
#[tokio::test]
async fn examples_of_requests_are_accepted() {
    let server = Server::start().await;
    let description = Description::of(&server).await;
    let post = |path: String, body: Value| {
        let request = server.post(&path).header("prefer", "wait=100");
        async move { request.json(&body).send().await.unwrap() }
    };
    let create = &description.0["paths"]["/v1/jobs"]["post"];
    let bodies = examples(create);
    assert!(bodies.len() >= 5);
    let mut jobs = BTreeMap::new();
    for (name, body) in bodies {
        let response = post("/v1/jobs".to_owned(), body).await;
        assert_eq!(response.status(), 201, "{name}");
        let job: Value = response.json().await.unwrap();
        assert_eq!(job["state"], "converged", "{name}");
        jobs.insert(name, job);
    }
    let path = base(&jobs["curve"]);
    for (name, body) in examples(&description.0["paths"]["/v1/jobs/{id}/edits"]["post"]) {
        let response = post(format!("{path}/edits"), body).await;
        assert_eq!(response.status(), 201, "{name}");
    }
    let local = base(&jobs["local"]);
    for (template, method, operation) in description.operations() {
        let id = local.rsplit('/').next().unwrap();
        let path = template.replace("{id}", id).replace("{k}", "1");
        let path = path
            .replace("{slug}", "invalid-fit")
            .replace("{format}", "csv")
            .replace("{file}", "start.js")
            .replace("{part}", "app.js");
        if method != "get" {
            continue;
        }
        for parameter in parameters(&description, operation) {
            try_parameter(&server, &path, parameter).await;
        }
        assert_eq!(
            server.get(&path).send().await.unwrap().status(),
            200,
            "{path}"
        );
    }
}

/// An operation has one kind of answer, so that generated clients have one type for it.
#[tokio::test]
async fn what_succeeds_has_one_schema() {
    let server = Server::start().await;
    let description = Description::of(&server).await;
    for (path, method, operation) in description.operations() {
        let answers = operation["responses"].as_object().unwrap().iter();
        let succeeds = answers.filter(|(status, _)| status.starts_with('2'));
        let contents = succeeds.filter_map(|(_, answer)| answer["content"].as_object());
        let schemas = contents.flat_map(|content| content.values());
        let types = schemas.map(|it| {
            let mut schema = it["schema"].clone();
            let fields = schema.as_object_mut().unwrap();
            fields.remove("description");
            // Files are bytes, whatever they hold: some are JSON.
            if fields.get("format") == Some(&json!("binary")) {
                fields.remove("type");
            }
            schema.to_string()
        });
        let types: BTreeSet<String> = types.collect();
        assert!(types.len() <= 1, "{method} {path}: {types:?}");
    }
}

async fn try_parameter(server: &Server, path: &str, parameter: &Value) {
    let name = parameter["name"].as_str().unwrap();
    let text = match &parameter["example"] {
        Value::String(text) => text.clone(),
        Value::Array(items) => items
            .iter()
            .map(Value::to_string)
            .collect::<Vec<_>>()
            .join(","),
        other => other.to_string(),
    };
    // Some are about files of one format.
    let format = match name {
        "dots" | "style" => "/svg",
        "units" => "/step",
        "version" => "/dxf",
        "origin" => "/geojson",
        _ => "/csv",
    };
    let path = &path.replace("/csv", format);
    let request = match parameter["in"].as_str().unwrap() {
        "header" => server.get(path).header(name, &text),
        // Samples are for those who ask for samples.
        "query"
            if name == "samples" && !["/csv", "/shape"].iter().any(|end| path.ends_with(end)) =>
        {
            server.get(&format!("{path}?view=samples&samples={text}"))
        }
        "query" => server.get(&format!("{path}?{name}={text}")),
        _ => return,
    };
    let response = request.send().await.unwrap();
    assert_eq!(response.status(), 200, "{path}: {name}={text}");
}

fn examples(operation: &Value) -> Vec<(String, Value)> {
    let body = &operation["requestBody"]["content"]["application/json"];
    let examples = body["examples"].as_object().unwrap().iter();
    examples
        .map(|(name, example)| (name.clone(), example["value"].clone()))
        .collect()
}

/// What readers know stands in their errors: all fields of objects, and all names.
#[tokio::test]
async fn fields_and_names_are_those_that_are_read() {
    let server = Server::start().await;
    let description = Description::of(&server).await;
    let points = json!([[0, 0], [1, 2], [3, 1], [4, 4]]);
    let curve = |field: &str, value: Value| {
        let mut job = json!({"curve": {"points": points}});
        job["curve"][field] = value;
        job
    };
    let with = |field: &str, value: Value| {
        let mut job = curve("closed", json!(false));
        job[field] = value;
        job
    };
    let unknown = || json!({"?": 0});
    let local = |field: &str| with("method", json!({"kind": "extended", field: "?"}));
    let few = json!({"kind": "least_squares", "control_points": 3, "variant": "?"});
    let weighted = json!({"curve": {"points": points, "weights": [1, 1, 1, 1]}, "rational": "?"});
    let probes = [
        ("JobRequest", unknown()),
        ("CurveInput", json!({"curve": {"?": 0}})),
        ("SurfaceInput", json!({"surface": {"?": 0}})),
        ("Basis", curve("basis", unknown())),
        ("StopRules", with("stop", unknown())),
        ("StreamDefaults", with("stream", unknown())),
        ("BasisKind", curve("basis", json!({"kind": "?"}))),
        (
            "KnotChoice",
            curve("basis", json!({"kind": "bspline", "knots": "?"})),
        ),
        ("ParameterChoice", curve("parameters", json!("?"))),
        ("Rational", weighted),
        ("MethodKind", with("method", json!({"kind": "?"}))),
        ("ExtendedStart", local("start")),
        ("LeastSquaresVariant", with("method", few)),
        ("View", with("stream", json!({"view": "?"}))),
        ("NumberEncoding", with("stream", json!({"encoding": "?"}))),
        ("Digits", with("stream", json!({"digits": "?"}))),
        ("Pace", with("stream", json!({"pace": "?"}))),
        (
            "OnDisconnect",
            with("stream", json!({"on_disconnect": "?"})),
        ),
    ];
    for (schema, body) in probes {
        let known = known(&server, "/v1/jobs", &body).await;
        assert_eq!(known, described(&description, schema), "{schema}");
    }
    let job = server.fit(&curve("closed", json!(false))).await;
    let edits = format!("{}/edits", base(&job));
    for (schema, body) in [
        ("EditRequest", unknown()),
        ("Move", json!({"points": [{"?": 0}]})),
    ] {
        let known = known(&server, &edits, &body).await;
        assert_eq!(known, described(&description, schema), "{schema}");
    }
}

/// The names listed by an error.
async fn known(server: &Server, path: &str, body: &Value) -> BTreeSet<String> {
    let response = server.post(path).json(body).send().await.unwrap();
    let (status, problem) = problem(response).await;
    assert_eq!(status, 422, "{body}");
    let detail = problem["errors"][0]["detail"].as_str().unwrap();
    let names: Vec<&str> = match detail.split_once("expected one of ") {
        Some((_, names)) => names.split(", ").collect(),
        None => detail.split(['`', '"']).skip(1).step_by(2).collect(),
    };
    let names = names.into_iter().filter(|name| *name != "?");
    names.map(str::to_owned).collect()
}

/// The fields, or the names, of all alternatives of a schema.
fn described(description: &Description, name: &str) -> BTreeSet<String> {
    let schema = description.component("schemas", name);
    let mut names = BTreeSet::new();
    let alternatives = ["oneOf", "anyOf"].map(|key| schema[key].as_array().cloned());
    let alternatives = alternatives.into_iter().flatten().flatten();
    for alternative in alternatives.chain([schema.clone()]) {
        if let Some(fields) = alternative["properties"].as_object() {
            names.extend(fields.keys().cloned());
        }
        // The name of a kind alone is short for an object with fields.
        let short = alternative["title"] == "Name";
        if let Some(choices) = alternative["enum"].as_array().filter(|_| !short) {
            names.extend(choices.iter().map(|it| it.as_str().unwrap().to_owned()));
        }
    }
    names
}

/// Descriptions of settings say with which method they go.
#[tokio::test]
async fn methods_have_the_settings_that_capabilities_tell() {
    let server = Server::start().await;
    let description = Description::of(&server).await;
    let schema = description.component("schemas", "Method");
    let fields = schema["properties"].as_object().unwrap();
    let capabilities = server.json("/v1/capabilities").await;
    let mut reported = BTreeSet::from(["kind"]);
    let (mut owned, mut count) = (BTreeMap::new(), 0);
    for method in capabilities["methods"].as_array().unwrap() {
        let kind = method["kind"].as_str().unwrap();
        let meaning = schema["description"].as_str().unwrap();
        assert!(meaning.contains(&format!("- `{kind}`: ")), "{meaning}");
        for name in method["settings"].as_array().unwrap() {
            let name = name.as_str().unwrap();
            let setting = fields[name]["description"].as_str().unwrap();
            let (_, owners) = setting.rsplit_once("Only with ").unwrap();
            assert!(owners.contains(&format!("`{kind}`")), "{setting}");
            owned.insert(name, owners);
            reported.insert(name);
            count += 1;
        }
    }
    // And no other: each listed name is one of those above.
    let named = owned
        .values()
        .map(|owners| owners.matches(", ").count() + 1);
    assert_eq!(named.sum::<usize>(), count);
    assert_eq!(reported, fields.keys().map(String::as_str).collect());
}

/// The reference is built from this server alone, and says so to browsers.
#[tokio::test]
async fn the_reference_needs_nothing_from_elsewhere() {
    let server = Server::start().await;
    let response = server.get("/docs").send().await.unwrap();
    assert_eq!(response.status(), 200);
    let policy = response.headers()["content-security-policy"]
        .to_str()
        .unwrap();
    assert!(policy.contains("default-src 'self'"), "{policy}");
    let page = response.text().await.unwrap();
    assert!(!page.contains("//"), "{page}");
    let files = page.split('"').filter(|part| part.starts_with("docs/"));
    let mut count = 0;
    for file in files {
        let response = server.get(&format!("/{file}")).send().await.unwrap();
        assert_eq!(response.status(), 200, "{file}");
        count += 1;
    }
    assert_eq!(count, 3);
    assert_eq!(server.get("/docs/else").send().await.unwrap().status(), 404);
}

/// A path that is no text names nothing; that is a problem like others.
#[tokio::test]
async fn paths_that_are_no_text_are_not_found() {
    let server = Server::start().await;
    for path in [
        "/v1/jobs/%FF",
        "/v1/jobs/%FF/result",
        "/problems/%FF",
        "/docs/%C3",
    ] {
        let (status, _) = problem(server.get(path).send().await.unwrap()).await;
        assert_eq!(status, 404, "{path}");
    }
}

/// JSON has one kind of numbers, so that 3.0 is a whole number, as schemas see it.
#[tokio::test]
async fn whole_numbers_may_have_a_point() {
    let server = Server::start().await;
    let job = json!({
        "surface": {
            "points": crate::data::peaks(4),
            "basis": {"kind": "bspline", "degree": 2.0},
        },
        "method": {"kind": "local", "indices": [[1.0, 2e0]]},
        "stop": {"max_iterations": 20.0},
        "stream": {"every": 2.0},
    });
    let created = server.fit(&job).await;
    let input = server.json(&format!("{}/input", base(&created))).await;
    assert_eq!(input["method"]["indices"], json!([[1, 2]]));
    assert_eq!(input["stop"]["max_iterations"], 20);
    let curve = json!([[0, 0], [1, 2], [3, 1], [4, 4]]);
    let method = |count: f64| json!({"kind": "least_squares", "control_points": count});
    let job = |count| json!({"curve": {"points": curve}, "method": method(count), "stream": {"view": "samples", "samples": 9.0}});
    let parent = server.fit(&job(4.0)).await;
    server
        .assert_refused(&job(3.5), "/method/control_points", "3.5")
        .await;
    let edit = json!({"iteration": 0.0, "points": [{"index": 1.0, "point": [1, 1]}]});
    let response = server
        .post(&format!("{}/edits", base(&parent)))
        .json(&edit)
        .send();
    assert_eq!(response.await.unwrap().status(), 201);
}
