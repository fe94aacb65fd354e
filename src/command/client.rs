//! The server of a command: one in this process, or one at a URL, with the same requests.

use std::env;
use std::error::Error;
use std::io;
use std::sync::{Arc, OnceLock};

use axum::body::Body;
use axum::http::{HeaderValue, Method, Request, Response, Uri, header};
use bytes::Bytes;
use bytesize::ByteSize;
use http_body_util::BodyExt;
use hyper_rustls::{HttpsConnector, HttpsConnectorBuilder};
use hyper_util::client::legacy;
use hyper_util::client::legacy::connect::HttpConnector;
use hyper_util::rt::TokioExecutor;
use parking_lot::Mutex;
use rustls::CertificateError;
use tower::ServiceExt;

use super::failure::Failure;
use super::refusal::Refusal;
use crate::config::{Config, Storage};
use crate::redact::redacted;
use crate::server::local::{self, Local};
use crate::telemetry::request::TRACE_PARENT;

/// The memory of the server in this process: large jobs get 5/16 of it, so that this is nearly all
/// of the machine's.
const SHARES: u64 = 3;

/// The error on a system without trusted certificates.
const NO_AUTHORITIES: &str = "there are no certificates of authorities to trust servers by: install those of the system (ca-certificates), or name a file of them in SSL_CERT_FILE";

/// The error for a certificate of an unknown authority.
const NOT_TRUSTED: &str = "its certificate is signed by an authority that is not trusted here; trusted are those of the system, or of the file that SSL_CERT_FILE names";

/// The error for a certificate such as `openssl req -x509` makes.
const AUTHORITY: &str = "its certificate is that of an authority (CA:TRUE), and not of a server: let that authority sign one for the server";

/// A server.
pub(super) struct Client {
    backend: Backend,
    /// The path of the job that is followed, once it is known.
    pub job: OnceLock<String>,
}

/// The current server, whose job an interrupt cancels.
#[derive(Default)]
pub(super) struct Current(Mutex<Option<Arc<Client>>>);

impl Current {
    /// Sets the current server.
    pub(super) fn set(&self, client: &Arc<Client>) {
        *self.0.lock() = Some(Arc::clone(client));
    }

    /// The current server, once there is one.
    pub(super) fn get(&self) -> Option<Arc<Client>> {
        self.0.lock().clone()
    }
}

enum Backend {
    InProcess(Box<Local>),
    Remote {
        client: Box<legacy::Client<HttpsConnector<HttpConnector>, Body>>,
        base: String,
        token: Option<HeaderValue>,
    },
}

impl Client {
    /// A server in this process. It listens on no port and keeps nothing on disk.
    pub(super) async fn here(many_iterations: bool) -> Result<Self, Failure> {
        let failed = |reason: io::Error| Failure::Failed(reason.to_string());
        let mut config = Config::standard();
        config.store = Storage::Memory;
        config.memory = Some(ByteSize(
            config
                .memory_bytes()
                .saturating_mul(2)
                .saturating_mul(SHARES),
        ));
        config.max_points = u32::MAX as usize;
        config.max_body = ByteSize(u64::from(u32::MAX) << 8);
        config.max_iterations = 1_000_000_000;
        if many_iterations {
            config.ring = ByteSize::gib(1);
        }
        let local = local::start(config).await.map_err(failed)?;
        Ok(Self::new(Backend::InProcess(Box::new(local))))
    }

    /// A server at a URL, which may have a path before those of the API.
    pub(super) fn there(url: &str, token: Option<&str>) -> Result<Self, Failure> {
        let shown = redacted(url);
        let wrong = |detail: &str| Failure::usage(format!("--server {shown}: {detail}"));
        let uri: Uri = url.parse().map_err(|_| wrong("it is no URL"))?;
        if !matches!(uri.scheme_str(), Some("http" | "https")) || uri.host().is_none() {
            return Err(wrong("expected a URL such as https://fits.example.org"));
        }
        let token = token.map(|token| HeaderValue::try_from(format!("Bearer {token}")));
        let token = token.transpose();
        let token = token.map_err(|_| Failure::usage("--token-file: it holds no token"))?;
        let builder = HttpsConnectorBuilder::new().with_native_roots();
        let connector = match builder {
            Ok(builder) => builder.https_or_http().enable_http1().build(),
            // Without certificates there is still plain HTTP.
            Err(_) if uri.scheme_str() == Some("http") => plain_connector(),
            Err(_) => return Err(Failure::Failed(format!("{shown}: {NO_AUTHORITIES}"))),
        };
        Ok(Self::new(Backend::Remote {
            client: Box::new(legacy::Client::builder(TokioExecutor::new()).build(connector)),
            base: url.trim_end_matches('/').to_owned(),
            token,
        }))
    }

    fn new(backend: Backend) -> Self {
        Self {
            backend,
            job: OnceLock::new(),
        }
    }

    /// Returns true if it is another process.
    pub(super) fn is_remote(&self) -> bool {
        matches!(self.backend, Backend::Remote { .. })
    }

    /// The address of a path.
    fn address(&self, path: &str) -> String {
        match &self.backend {
            Backend::InProcess(_) => path.to_owned(),
            Backend::Remote { base, .. } => format!("{base}{path}"),
        }
    }

    /// The address of a path for messages: a URL can have a password.
    pub(super) fn shown(&self, path: &str) -> String {
        match &self.backend {
            Backend::InProcess(_) => path.to_owned(),
            Backend::Remote { base, .. } => format!("{}{path}", redacted(base)),
        }
    }

    /// Posts a body; the answer is events, a line of JSON each.
    pub(super) async fn post(
        &self,
        path: &str,
        media_type: &'static str,
        body: Bytes,
    ) -> Result<Result<Body, Refusal>, Failure> {
        let request = Request::builder()
            .method(Method::POST)
            .header(header::CONTENT_TYPE, media_type)
            .header(header::CONTENT_LENGTH, body.len());
        self.send(request, path, "application/x-ndjson", body.into())
            .await
    }

    /// Gets a path.
    pub(super) async fn get(
        &self,
        path: &str,
        accept: &'static str,
    ) -> Result<Result<Body, Refusal>, Failure> {
        self.send(Request::builder(), path, accept, Body::empty())
            .await
    }

    /// Stops the job that is followed on another server; one in this process ends with it.
    pub(super) async fn cancel(&self) -> Result<(), Failure> {
        if let Some(job) = self.job.get().filter(|_| self.is_remote()) {
            let path = format!("{job}/cancel");
            let request = Request::builder().method(Method::POST);
            // A job that has ended in the meantime cannot be cancelled, which is fine.
            let _ = self.send(request, &path, "*/*", Body::empty()).await?;
        }
        Ok(())
    }

    async fn send(
        &self,
        request: axum::http::request::Builder,
        path: &str,
        accept: &'static str,
        body: Body,
    ) -> Result<Result<Body, Refusal>, Failure> {
        let request = request
            .uri(self.address(path))
            .header(header::ACCEPT, accept);
        let failed = |reason: String| Failure::Failed(format!("{}: {reason}", self.shown(path)));
        let response = match &self.backend {
            Backend::InProcess(local) => {
                let request = request.header(header::HOST, "localhost").body(body);
                let request = request.map_err(|reason| failed(reason.to_string()))?;
                let answer = local.router.clone().oneshot(request).await;
                answer.unwrap_or_else(|never| match never {})
            }
            Backend::Remote { client, token, .. } => {
                let mut request = request.body(body).map_err(|it| failed(it.to_string()))?;
                if let Some(token) = token {
                    request
                        .headers_mut()
                        .insert(header::AUTHORIZATION, token.clone());
                }
                // The parent process may have a span of its own, to which this one belongs.
                let parent = env::var("TRACEPARENT").map(HeaderValue::try_from);
                if let Ok(Ok(parent)) = parent {
                    request.headers_mut().insert(TRACE_PARENT, parent);
                }
                let answer = client.request(request).await;
                answer
                    .map_err(|reason| failed(message(&reason)))?
                    .map(Body::new)
            }
        };
        answer(response).await
    }
}

/// The body of an answer, or the error.
async fn answer(response: Response<Body>) -> Result<Result<Body, Refusal>, Failure> {
    let (parts, body) = response.into_parts();
    if parts.status.is_success() {
        return Ok(Ok(body));
    }
    let body = body.collect().await.map(|body| body.to_bytes());
    Ok(Err(Refusal::read(parts.status, &body.unwrap_or_default())))
}

/// Why a server was not reached.
fn message(error: &legacy::Error) -> String {
    match refused_certificate(error) {
        Some(CertificateError::UnknownIssuer) => NOT_TRUSTED.to_owned(),
        // The kind of a malformed certificate is known by name only.
        Some(reason) if reason.to_string().contains("CaUsedAsEndEntity") => AUTHORITY.to_owned(),
        Some(reason) => format!("its certificate is refused: {reason}"),
        None => causes(error),
    }
}

/// The error of a certificate, if that is behind an error.
fn refused_certificate<'a>(error: &'a (dyn Error + 'static)) -> Option<&'a CertificateError> {
    if let Some(rustls::Error::InvalidCertificate(reason)) = error.downcast_ref() {
        return Some(reason);
    }
    // Errors inside I/O errors are not their sources.
    let inner = error.downcast_ref().and_then(io::Error::get_ref);
    match inner {
        Some(inner) => refused_certificate(inner),
        None => error.source().and_then(refused_certificate),
    }
}

/// An error with its sources, which are more specific.
fn causes(error: &dyn Error) -> String {
    match error.source() {
        None => error.to_string(),
        Some(cause) => format!("{error}: {}", causes(cause)),
    }
}

/// A connector without trusted certificates, for plain HTTP.
fn plain_connector() -> HttpsConnector<HttpConnector> {
    let no_roots = rustls::RootCertStore::empty();
    let config = rustls::ClientConfig::builder()
        .with_root_certificates(no_roots)
        .with_no_client_auth();
    HttpsConnectorBuilder::new()
        .with_tls_config(config)
        .https_or_http()
        .enable_http1()
        .build()
}
