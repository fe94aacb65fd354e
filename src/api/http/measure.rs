//! Metrics of requests: their number and duration, by method, route and status.

use std::time::Instant;

use axum::extract::{MatchedPath, Request, State};
use axum::http::Method;
use axum::middleware::Next;
use axum::response::Response;
use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::exemplar::HistogramWithExemplars;
use prometheus_client::metrics::family::Family;
use prometheus_client::registry::{Registry, Unit};

use crate::telemetry::request::{Exemplar, RequestTrace};

/// Upper bounds of the histogram's buckets, in seconds.
const BOUNDS: [f64; 12] = [
    0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 5.0, 30.0,
];

/// Requests from the start of the server on.
#[derive(Clone, Debug)]
pub(crate) struct Requests {
    seconds: Family<Route, Seconds, fn() -> Seconds>,
    answers: Family<Answered, Counter>,
}

/// Durations; of each bucket the trace of its last request, if that is exported.
type Seconds = HistogramWithExemplars<Exemplar>;

/// The labels of a request: a finite set, which clients cannot grow.
#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Route {
    method: &'static str,
    route: String,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Answered {
    method: &'static str,
    route: String,
    status: u16,
}

impl Default for Requests {
    fn default() -> Self {
        Self {
            seconds: Family::new_with_constructor(|| Seconds::new(BOUNDS.into_iter())),
            answers: Family::default(),
        }
    }
}

impl Requests {
    /// Registers the metrics under their names.
    pub(super) fn register(&self, registry: &mut Registry) {
        registry.register_with_unit(
            "piad_http_request_duration",
            "Time from the head of a request to that of its answer, by method and route; the body of the answer, such as a stream of events, comes after it",
            Unit::Seconds,
            self.seconds.clone(),
        );
        registry.register(
            "piad_http_requests",
            "Requests answered, by method, route and status",
            self.answers.clone(),
        );
    }
}

/// Measures a request.
pub(super) async fn measure(
    State(requests): State<Requests>,
    request: Request,
    next: Next,
) -> Response {
    let begin = Instant::now();
    let method = name(request.method());
    let matched = request.extensions().get::<MatchedPath>();
    let route = matched.map_or("none", MatchedPath::as_str).to_owned();
    let response = next.run(request).await;
    let status = response.status().as_u16();
    let answered = Answered {
        method,
        route: route.clone(),
        status,
    };
    requests.answers.get_or_create(&answered).inc();
    let seconds = begin.elapsed().as_secs_f64();
    let route = Route { method, route };
    let exemplar = RequestTrace::current().and_then(|trace| trace.exemplar());
    let times = requests.seconds.get_or_create(&route);
    times.observe(seconds, exemplar, None);
    response
}

/// The name of a method; unknown ones share a label.
pub(super) fn name(method: &Method) -> &'static str {
    match *method {
        Method::GET => "GET",
        Method::HEAD => "HEAD",
        Method::POST => "POST",
        Method::PUT => "PUT",
        Method::PATCH => "PATCH",
        Method::DELETE => "DELETE",
        Method::OPTIONS => "OPTIONS",
        _ => "other",
    }
}
