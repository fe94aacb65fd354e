//! TLS: both versions of HTTP, certificates that change, clients that need one, and what is no TLS.

use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::sync::Arc;

use http_body_util::{BodyExt, Full};
use hyper::body::{Bytes, Incoming};
use hyper::{Method, Request, Response, Version};
use hyper_rustls::{HttpsConnector, HttpsConnectorBuilder};
use hyper_util::client::legacy;
use hyper_util::client::legacy::connect::HttpConnector;
use hyper_util::rt::TokioExecutor;
use rcgen::{BasicConstraints, CertificateParams, CertifiedIssuer, DnType, IsCa, KeyPair};
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use rustls::{ClientConfig, RootCertStore};
use serde_json::{Value, json};
use tempfile::TempDir;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{Duration, sleep};

use crate::data;
use crate::program::{PROGRAM, Program};
use crate::support::{PATIENCE, eventually};

/// An authority that signs certificates.
pub struct Authority(CertifiedIssuer<'static, KeyPair>);

/// A certificate and its key, as PEM.
pub struct Signed {
    certificate: String,
    key: String,
}

impl Authority {
    pub fn new() -> Self {
        let mut params = CertificateParams::default();
        params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        params
            .distinguished_name
            .push(DnType::CommonName, "an authority");
        let key = KeyPair::generate().unwrap();
        Self(CertifiedIssuer::self_signed(params, key).unwrap())
    }

    /// Signs a certificate for this machine.
    pub fn sign(&self) -> Signed {
        let key = KeyPair::generate().unwrap();
        let names = ["localhost".to_owned(), "127.0.0.1".to_owned()];
        let params = CertificateParams::new(names).unwrap();
        let signed = params.signed_by(&key, &self.0).unwrap();
        Signed {
            certificate: signed.pem(),
            key: key.serialize_pem(),
        }
    }

    fn der(&self) -> CertificateDer<'static> {
        CertificateDer::from_pem_slice(self.0.pem().as_bytes()).unwrap()
    }
}

/// A server with TLS and the files that it reads.
pub struct Secure {
    folder: TempDir,
    pub server: Program,
}

impl Secure {
    pub fn start(signed: &Signed, arguments: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        put(&folder, signed);
        let files = tls_arguments(&folder);
        let mut all: Vec<_> = files.iter().map(String::as_str).collect();
        all.extend(arguments);
        let server = Program::with(folder.path(), &all);
        Self { folder, server }
    }

    pub fn url(&self, path: &str) -> String {
        format!("https://{}{path}", self.server.address)
    }

    /// A counter of the server.
    async fn counter(&self, client: &Client, name: &str) -> u64 {
        let metrics = client.get(&self.url("/metrics")).await;
        let metrics = String::from_utf8(body(metrics).await).unwrap();
        let line = metrics.lines().find_map(|it| it.strip_prefix(name));
        line.unwrap().trim().parse().unwrap()
    }
}

fn path(folder: &TempDir, name: &str) -> PathBuf {
    folder.path().join(name)
}

/// Replaces the files of a server, the certificate first.
fn put(folder: &TempDir, signed: &Signed) {
    for (name, content) in [("cert.pem", &signed.certificate), ("key.pem", &signed.key)] {
        fs::write(path(folder, "new"), content).unwrap();
        fs::rename(path(folder, "new"), path(folder, name)).unwrap();
    }
}

fn tls_arguments(folder: &TempDir) -> [String; 4] {
    let at = |name| path(folder, name).to_str().unwrap().to_owned();
    let (certificate, key) = (at("cert.pem"), at("key.pem"));
    ["--tls-cert".into(), certificate, "--tls-key".into(), key]
}

/// Trusts authorities, and may have a certificate of its own.
pub fn trusting(authorities: &[&Authority], own: Option<&Signed>) -> ClientConfig {
    let mut roots = RootCertStore::empty();
    for authority in authorities {
        roots.add(authority.der()).unwrap();
    }
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let config = ClientConfig::builder_with_provider(provider);
    let config = config.with_safe_default_protocol_versions().unwrap();
    let config = config.with_root_certificates(roots);
    match own {
        None => config.with_no_client_auth(),
        Some(own) => {
            let chain = CertificateDer::from_pem_slice(own.certificate.as_bytes()).unwrap();
            let key = PrivateKeyDer::from_pem_slice(own.key.as_bytes()).unwrap();
            config.with_client_auth_cert(vec![chain], key).unwrap()
        }
    }
}

/// A client that trusts authorities.
#[derive(Clone)]
pub struct Client(legacy::Client<HttpsConnector<HttpConnector>, Full<Bytes>>);

impl Client {
    pub fn of(authorities: &[&Authority]) -> Self {
        Self::with(authorities, None, true)
    }

    fn with(authorities: &[&Authority], own: Option<&Signed>, is_new: bool) -> Self {
        let config = trusting(authorities, own);
        let connector = HttpsConnectorBuilder::new().with_tls_config(config);
        let connector = connector.https_only();
        let connector = match is_new {
            true => connector.enable_all_versions().build(),
            false => connector.enable_http1().build(),
        };
        Self(legacy::Client::builder(TokioExecutor::new()).build(connector))
    }

    async fn send(
        &self,
        method: Method,
        url: &str,
        accept: &str,
        body: String,
    ) -> Result<Response<Incoming>, legacy::Error> {
        let request = Request::builder()
            .method(method)
            .uri(url)
            .header("accept", accept)
            .header("content-type", "application/json");
        self.0.request(request.body(body.into()).unwrap()).await
    }

    pub async fn get(&self, url: &str) -> Response<Incoming> {
        let answer = self.send(Method::GET, url, "*/*", String::new()).await;
        answer.unwrap()
    }
}

async fn body(answer: Response<Incoming>) -> Vec<u8> {
    answer
        .into_body()
        .collect()
        .await
        .unwrap()
        .to_bytes()
        .into()
}

#[tokio::test]
async fn both_versions_of_http_come_with_tls() {
    let authority = Authority::new();
    let secure = Secure::start(&authority.sign(), &[]);
    let job = json!({"curve": {"points": data::wave(60)}, "stop": {"relative_tolerance": 1e-9}});
    let mut streams = Vec::new();
    for (is_new, version) in [(true, Version::HTTP_2), (false, Version::HTTP_11)] {
        let client = Client::with(&[&authority], None, is_new);
        let answer = client.get(&secure.url("/readyz")).await;
        assert_eq!((answer.status().as_u16(), answer.version()), (200, version));
        let url = secure.url("/v1/jobs");
        let asked = client.send(Method::POST, &url, "text/event-stream", job.to_string());
        let stream = String::from_utf8(body(asked.await.unwrap()).await).unwrap();
        assert!(stream.contains("event: end"), "{stream}");
        let iterations = stream.split_once("event: iteration").unwrap().1;
        let (iterations, _) = iterations.split_once("event: end").unwrap();
        streams.push(iterations.to_owned());
    }
    assert_eq!(streams[0], streams[1]);
}

/// Certificates are replaced while requests come on new connections, and a stream is open.
#[tokio::test(flavor = "multi_thread")]
async fn changed_certificates_are_taken_up_and_no_request_fails() {
    let (first, second) = (Authority::new(), Authority::new());
    let secure = Secure::start(&first.sign(), &[]);
    let both = Client::of(&[&first, &second]);
    let jobs = secure.url("/v1/jobs");
    let asked = both.send(
        Method::POST,
        &jobs,
        "text/event-stream",
        data::endless_job().to_string(),
    );
    let mut stream = asked.await.unwrap().into_body();
    assert!(stream.frame().await.unwrap().is_ok());

    let url = secure.url("/livez");
    let (stop, stopped) = tokio::sync::watch::channel(false);
    let load = async || {
        let mut requests = 0;
        while !*stopped.borrow() {
            // A connection of its own for each.
            let answer = Client::of(&[&first, &second]).get(&url).await;
            assert_eq!(answer.status(), 200);
            requests += 1;
        }
        requests
    };
    let serves = async |authority: &Authority| {
        let client = Client::of(&[authority]);
        let answer = client.send(Method::GET, &url, "*/*", String::new()).await;
        answer.is_ok()
    };
    let changes = async {
        // By a signal,
        put(&secure.folder, &second.sign());
        secure.server.signal("-HUP");
        eventually("the new certificate", async || serves(&second).await).await;
        assert!(!serves(&first).await);
        // not with a key of another certificate,
        let other = first.sign();
        fs::write(path(&secure.folder, "key.pem"), other.key).unwrap();
        let failed = "piad_reloads_failed_total";
        eventually("a failure", async || {
            secure.counter(&both, failed).await > 0
        })
        .await;
        assert!(serves(&second).await);
        assert!(
            secure
                .server
                .log()
                .contains("the certificates before stay in use")
        );
        // and without a signal, as soon as the two belong together.
        put(&secure.folder, &first.sign());
        eventually("the first authority", async || serves(&first).await).await;
        stop.send(true).unwrap();
    };
    let (a, b, ()) = tokio::join!(load(), load(), changes);
    assert!(a > 10 && b > 10, "{a} and {b} requests");
    // The stream has gone on.
    assert!(stream.frame().await.unwrap().is_ok());
}

#[tokio::test]
async fn clients_need_a_certificate_of_the_authority_that_is_named() {
    let (authority, of_clients) = (Authority::new(), Authority::new());
    let folder = tempfile::tempdir().unwrap();
    let file = path(&folder, "clients.pem");
    fs::write(&file, of_clients.0.pem()).unwrap();
    let arguments = ["--tls-client-ca", file.to_str().unwrap()];
    let secure = Secure::start(&authority.sign(), &arguments);
    let known = Client::with(&[&authority], Some(&of_clients.sign()), true);
    let url = secure.url("/v1/capabilities");
    assert_eq!(known.get(&url).await.status(), 200);
    for own in [None, Some(&authority.sign())] {
        for is_new in [true, false] {
            let client = Client::with(&[&authority], own, is_new);
            let answer = client.send(Method::GET, &url, "*/*", String::new()).await;
            assert!(answer.is_err(), "{answer:?}");
        }
    }
    let failed = secure
        .counter(&known, "piad_tls_handshakes_failed_total")
        .await;
    assert_eq!(failed, 4);
}

#[tokio::test]
async fn plain_connections_get_an_error_or_are_closed() {
    let secure = Secure::start(&Authority::new().sign(), &["--header-timeout", "0.5"]);
    let said = async |bytes: &[u8]| {
        let mut stream = TcpStream::connect(&secure.server.address).await.unwrap();
        stream.write_all(bytes).await.unwrap();
        let mut said = Vec::new();
        let read = tokio::time::timeout(PATIENCE, stream.read_to_end(&mut said));
        // A connection may also be reset.
        let _ = read.await.unwrap();
        String::from_utf8_lossy(&said).into_owned()
    };
    let reported = said(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n").await;
    assert!(
        reported.starts_with("HTTP/1.1 400 Bad Request\r\n"),
        "{reported}"
    );
    assert!(
        reported.ends_with("its address begins with https://\n"),
        "{reported}"
    );
    assert_eq!(said(b"\0\0\0\0").await, "");
    // Nothing, and a handshake that stops in the middle, do not stay.
    assert_eq!(said(b"").await, "");
    assert_eq!(said(b"\x16\x03\x01").await, "");
}

#[test]
fn files_that_hold_no_certificate_are_refused_at_the_start() {
    let signed = Authority::new().sign();
    let folder = tempfile::tempdir().unwrap();
    put(&folder, &signed);
    let [_, certificate, _, key] = tls_arguments(&folder);
    let other = path(&folder, "other.pem");
    fs::write(&other, Authority::new().sign().key).unwrap();
    let empty = path(&folder, "empty.pem");
    fs::write(&empty, "").unwrap();
    let (other, empty) = (other.to_str().unwrap(), empty.to_str().unwrap());
    let missing = folder.path().join("missing.pem");
    let missing = missing.to_str().unwrap();
    for (arguments, reported) in [
        (vec!["--tls-cert", missing, "--tls-key", &key], "--tls-cert"),
        (
            vec!["--tls-cert", empty, "--tls-key", &key],
            "there is no certificate in it",
        ),
        (
            vec!["--tls-cert", &certificate, "--tls-key", empty],
            "--tls-key",
        ),
        (
            vec!["--tls-cert", &certificate, "--tls-key", other],
            "keys may not be consistent",
        ),
        (
            vec![
                "--tls-cert",
                &certificate,
                "--tls-key",
                &key,
                "--tls-client-ca",
                empty,
            ],
            "--tls-client-ca",
        ),
        (vec!["--tls-cert", &certificate], "--tls-key"),
        (vec!["--tls-key", &key], "--tls-cert"),
        (vec!["--tls-client-ca", &certificate], "--tls-cert"),
    ] {
        let store = folder.path().join("data");
        let mut command = Command::new(PROGRAM);
        command
            .args(["--listen", "127.0.0.1:0", "--store"])
            .arg(store);
        let output = command.args(&arguments).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success(), "{arguments:?}");
        assert!(said.contains(reported), "{arguments:?}: {said}");
    }
}

#[tokio::test]
async fn the_health_check_takes_any_certificate() {
    let secure = Secure::start(&Authority::new().sign(), &[]);
    let health = |arguments: &[&str]| {
        let mut command = Command::new(PROGRAM);
        command.args(["health", "--listen", &secure.server.address]);
        command.args(arguments).output().unwrap()
    };
    let certificate = path(&secure.folder, "cert.pem");
    let output = health(&["--tls-cert", certificate.to_str().unwrap()]);
    assert!(output.status.success(), "{output:?}");
    let output = health(&[]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("it answers 400"), "{said}");
}

/// An idle connection is closed like one without TLS.
#[tokio::test]
async fn idle_connections_end_with_tls_too() {
    let authority = Authority::new();
    let secure = Secure::start(&authority.sign(), &["--idle-timeout", "0.3"]);
    let client = Client::of(&[&authority]);
    let answer = client.get(&secure.url("/v1/capabilities")).await;
    let limits: Value = serde_json::from_slice(&body(answer).await).unwrap();
    assert!(limits.is_object());
    let open = async || {
        let other = Client::of(&[&authority]);
        secure.counter(&other, "piad_connections_open").await
    };
    // The one that asks is the last.
    eventually("one is left", async || {
        sleep(Duration::from_millis(400)).await;
        open().await == 1
    })
    .await;
}
