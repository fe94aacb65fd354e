//! A collector of traces, as good or bad as a test needs it, and servers that export to it.

use std::collections::HashMap;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::{Arc, Mutex};

use axum::serve::Listener;
use opentelemetry_proto::tonic::collector::trace::v1::trace_service_server::{
    TraceService, TraceServiceServer,
};
use opentelemetry_proto::tonic::collector::trace::v1::{
    ExportTraceServiceRequest, ExportTraceServiceResponse,
};
use opentelemetry_proto::tonic::common::v1::KeyValue;
use opentelemetry_proto::tonic::common::v1::any_value::Value as Any;
use opentelemetry_proto::tonic::trace::v1::Span;
use serde_json::{Value, json};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{Duration, sleep};
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::pki_types::PrivateKeyDer;
use tokio_rustls::rustls::{self, ServerConfig};
use tokio_rustls::server::TlsStream;
use tonic::{Request, Response, Status};

use crate::program::Program;
use crate::support::eventually;

const PATH: &str = "/opentelemetry.proto.collector.trace.v1.TraceService/{call}";

/// A collector in the process of the test.
#[derive(Clone, Default)]
pub struct Collector {
    url: String,
    got: Arc<Mutex<Got>>,
    /// How long each export takes.
    pause: Duration,
}

#[derive(Default)]
struct Got {
    spans: Vec<Span>,
    resources: Vec<HashMap<String, Value>>,
}

#[tonic::async_trait]
impl TraceService for Collector {
    async fn export(
        &self,
        request: Request<ExportTraceServiceRequest>,
    ) -> Result<Response<ExportTraceServiceResponse>, Status> {
        sleep(self.pause).await;
        let mut got = self.got.lock().unwrap();
        for part in request.into_inner().resource_spans {
            got.resources
                .extend(part.resource.map(|it| attributes(&it.attributes)));
            let spans = part.scope_spans.into_iter().flat_map(|it| it.spans);
            got.spans.extend(spans);
        }
        Ok(Response::new(ExportTraceServiceResponse::default()))
    }
}

impl Collector {
    pub async fn start() -> Self {
        Self::slow(Duration::ZERO).await
    }

    /// A collector that takes so long for each export.
    pub async fn slow(pause: Duration) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let collector = Self {
            url: format!("http://{}", listener.local_addr().unwrap()),
            pause,
            ..Self::default()
        };
        collector.serve(listener);
        collector
    }

    /// A collector behind TLS, and its certificate as PEM.
    pub async fn secure() -> (Self, String) {
        let names = vec!["127.0.0.1".to_owned()];
        let made = rcgen::generate_simple_self_signed(names).unwrap();
        let key = PrivateKeyDer::try_from(made.signing_key.serialize_der()).unwrap();
        let provider = Arc::new(rustls::crypto::ring::default_provider());
        let config = ServerConfig::builder_with_provider(provider);
        let config = config.with_safe_default_protocol_versions().unwrap();
        let config = config.with_no_client_auth();
        let mut config = config
            .with_single_cert(vec![made.cert.der().clone()], key)
            .unwrap();
        config.alpn_protocols = vec![b"h2".to_vec()];
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let collector = Self {
            url: format!("https://{}", listener.local_addr().unwrap()),
            ..Self::default()
        };
        let tls = TlsAcceptor::from(Arc::new(config));
        collector.serve(Secure(listener, tls));
        (collector, made.cert.pem())
    }

    fn serve<L: Listener<Addr: std::fmt::Debug>>(&self, listener: L) {
        let service = TraceServiceServer::new(self.clone());
        let router = axum::Router::new().route_service(PATH, service);
        tokio::spawn(async move { axum::serve(listener, router).await });
    }

    /// A server that exports to it.
    pub fn server(&self, data: &Path) -> Program {
        exporting(&self.url, "", data)
    }

    /// The same with variables in its environment.
    pub fn server_with(&self, variables: &str, data: &Path) -> Program {
        exporting(&self.url, variables, data)
    }

    pub fn url(&self) -> &str {
        &self.url
    }

    pub fn spans(&self) -> Vec<Span> {
        self.got.lock().unwrap().spans.clone()
    }

    /// The attributes of all resources, one for each export.
    pub fn resources(&self) -> Vec<HashMap<String, Value>> {
        self.got.lock().unwrap().resources.clone()
    }

    /// Waits for this number of spans with this name.
    pub async fn wait_for(&self, name: &str, count: usize) -> Vec<Span> {
        let named = || {
            let spans = self.spans().into_iter();
            spans.filter(|it| it.name == name).collect::<Vec<_>>()
        };
        let what = format!("{count} spans of {name}");
        eventually(&what, async || named().len() >= count).await;
        named()
    }
}

/// Takes in connections with TLS.
struct Secure(TcpListener, TlsAcceptor);

impl Listener for Secure {
    type Io = TlsStream<TcpStream>;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Self::Io, SocketAddr) {
        loop {
            let (stream, peer) = self.0.accept().await.unwrap();
            // Clients that do not trust the certificate end the handshake.
            if let Ok(stream) = self.1.accept(stream).await {
                return (stream, peer);
            }
        }
    }

    fn local_addr(&self) -> std::io::Result<SocketAddr> {
        self.0.local_addr()
    }
}

/// A server that exports to this address, often.
pub fn exporting(url: &str, variables: &str, data: &Path) -> Program {
    let script =
        format!("export OTEL_BSP_SCHEDULE_DELAY=20 {variables}; exec \"$@\" --otlp-endpoint {url}");
    Program::in_shell(&script, data)
}

/// The attributes of a span, or of a resource.
pub fn attributes(attributes: &[KeyValue]) -> HashMap<String, Value> {
    let value = |it: &KeyValue| match it.value.as_ref()?.value.as_ref()? {
        Any::StringValue(text) => Some(json!(text)),
        Any::IntValue(number) => Some(json!(number)),
        other => panic!("an attribute is {other:?}"),
    };
    let pairs = attributes.iter();
    pairs
        .filter_map(|it| Some((it.key.clone(), value(it)?)))
        .collect()
}

/// An attribute of a span.
pub fn attribute(span: &Span, name: &str) -> Value {
    attributes(&span.attributes)
        .remove(name)
        .unwrap_or_default()
}

/// An id as headers have it.
pub fn hex(id: &[u8]) -> String {
    id.iter().map(|byte| format!("{byte:02x}")).collect()
}
