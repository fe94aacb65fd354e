//! The server itself.

use crate::api::http::capabilities::Capabilities;
use crate::api::http::info::{Health, ProblemType, ProblemTypes, ServiceIndex};
use crate::api::json::view::rates::RatesView;
use crate::api::openapi::operation::{Operation, Tag};
use crate::api::problem::Kind;
use serde_json::json;

/// The answer to `If-None-Match`.
const UNCHANGED: &str = "What the client has with this tag is still good.";

fn server(id: &str, summary: &str, description: &str) -> Operation {
    Operation::new(Tag::Server, id, summary, description)
}

/// `GET /`
pub fn index() -> Operation {
    server(
        "getIndex",
        "Show what this is",
        "The name of the service, and where to go on. Browsers, which prefer `text/html`, get the page for people.",
    )
    .json::<ServiceIndex>(200, "What this is.")
}

/// `GET /viewer/{part}`
pub fn page_part() -> Operation {
    let file = |text: &str| json!({"schema": {"description": text, "type": "string"}});
    let content = [
        ("text/javascript", file("A script.")),
        ("text/css", file("A style sheet.")),
        ("text/plain", file("A licence.")),
        ("image/svg+xml", file("A picture.")),
    ];
    server(
        "getPagePart",
        "Fetch a part of the page",
        "What the page at `/` is made of.",
    )
    .parameters(&["part"])
    .answer(200, "The file.", &content, &[])
    .answer(304, UNCHANGED, &[], &[])
    .problems(&[Kind::NotFound])
}

/// `GET /v1/capabilities`
pub fn capabilities() -> Operation {
    server(
        "getCapabilities",
        "Show what the server can do",
        "Bases, methods, formats and limits.",
    )
    .json::<Capabilities>(200, "What the server can do.")
}

/// `GET /v1/rates`
pub fn rates() -> Operation {
    server(
        "compareBases",
        "Compare bases",
        "How fast classical PIA converges at the same parameters with Bernstein, Said–Ball and Wang–Ball polynomials and with B-splines with knots at the data: the least eigenvalue of the collocation matrix, the rate, and how many iterations it takes by that. The normalized B-basis, Bernstein of polynomials, is the fastest of its space (Delgado, Peña 2007).",
    )
    .parameters(&["points", "parameters", "degree", "tolerance"])
    .json::<RatesView>(200, "The comparison.")
    .problems(&[Kind::InvalidRequest])
}

/// `GET /problems`
pub fn problems() -> Operation {
    server(
        "listProblems",
        "List the kinds of problems",
        "All values that the `type` of a problem object may have.",
    )
    .json::<ProblemTypes>(200, "All kinds.")
}

/// `GET /problems/{slug}`
pub fn problem() -> Operation {
    server(
        "getProblem",
        "Explain a kind of problem",
        "What the `type` of a problem object stands for.",
    )
    .parameters(&["slug"])
    .json::<ProblemType>(200, "The kind.")
    .problems(&[Kind::NotFound])
}

/// `GET /metrics`
pub fn metrics() -> Operation {
    let text = json!({"schema": {"description": "Counters, gauges and histograms in the OpenMetrics text format.", "type": "string"}});
    let content = [("application/openmetrics-text", text)];
    server(
        "getMetrics",
        "Show counters",
        "For Prometheus: counters of jobs, iterations and events; jobs that are queued and running, connections and streams that are open; how long requests take, by method and route; what the server was built from.",
    )
    .answer(200, "The counters.", &content, &[])
}

/// `GET /livez`
pub fn livez() -> Operation {
    server(
        "getLiveness",
        "Ask whether the server lives",
        "It answers while the process is alive.",
    )
    .json::<Health>(200, "It lives.")
}

/// `GET /readyz`
pub fn readyz() -> Operation {
    server(
        "getReadiness",
        "Ask whether the server takes work",
        "It answers 503 while the server stops.",
    )
    .json::<Health>(200, "It takes work.")
    .problems(&[Kind::Stopping])
}

/// `GET /openapi.json`
pub fn description() -> Operation {
    let document = json!({"schema": {"description": "An OpenAPI 3.1 document.", "type": "object"}});
    let content = [("application/json", document)];
    server("getDescription", "Describe the API", "This document.").answer(
        200,
        "The description.",
        &content,
        &[],
    )
}

/// `GET /docs`
pub fn reference() -> Operation {
    let page = json!({"schema": {"description": "A page that needs nothing from elsewhere.", "type": "string"}});
    let content = [("text/html", page)];
    server(
        "getReference",
        "Browse the API",
        "The reference of the API, for people.",
    )
    .answer(200, "The reference.", &content, &[])
    .answer(304, UNCHANGED, &[], &[])
}

/// `GET /docs/{file}`
pub fn reference_file() -> Operation {
    let file = |text: &str| json!({"schema": {"description": text, "type": "string"}});
    let content = [
        ("text/javascript", file("A script.")),
        ("text/css", file("A style sheet.")),
        ("text/plain", file("A licence.")),
    ];
    server(
        "getReferenceFile",
        "Fetch a part of the reference",
        "What the reference of the API is made of.",
    )
    .parameters(&["file"])
    .answer(200, "The file.", &content, &[])
    .answer(304, UNCHANGED, &[], &[])
    .problems(&[Kind::NotFound])
}
