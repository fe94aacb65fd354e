//! Asking a server whether it is ready.

use std::io;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use axum::http::{Request, header};
use bytes::Bytes;
use http_body_util::Empty;
use hyper::client::conn::http1;
use hyper_util::rt::TokioIo;
use rustls::client::danger::{HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier};
use rustls::crypto::{CryptoProvider, ring, verify_tls12_signature, verify_tls13_signature};
use rustls::pki_types::{CertificateDer, ServerName, UnixTime};
use rustls::{ClientConfig, DigitallySignedStruct, Error, SignatureScheme};
use tokio::net::UnixStream;
use tokio::time::timeout;
use tokio_rustls::TlsConnector;

use super::listener::Stream;
use crate::config::listen::Listen;

/// Asks the server at this address, perhaps behind TLS, whether it is ready; the error says why not.
pub async fn probe(listen: &Listen, is_secure: bool, limit: Duration) -> Result<(), String> {
    match timeout(limit, ask(listen, is_secure)).await {
        Err(_) => Err(format!("no answer within {limit:?}")),
        Ok(answer) => answer,
    }
}

async fn ask(listen: &Listen, is_secure: bool) -> Result<(), String> {
    let (stream, host) = match listen {
        Listen::Unix(path) => (connect(path).await, "localhost".to_owned()),
        Listen::Tcp(host) => {
            let host = host.reached_at();
            let stream = host.connect().await.map(|it| Box::new(it) as Stream);
            let stream = match stream {
                Ok(stream) if is_secure => encrypted(stream).await,
                stream => stream,
            };
            (stream, host.to_string())
        }
    };
    let stream = TokioIo::new(stream.map_err(|reason| reason.to_string())?);
    let message = |reason: hyper::Error| reason.to_string();
    let (mut requests, connection) = http1::handshake(stream).await.map_err(message)?;
    tokio::spawn(connection);
    let request = Request::get("/readyz").header(header::HOST, host);
    let request = request.body(Empty::<Bytes>::new());
    let request = request.map_err(|reason| reason.to_string())?;
    let answer = requests.send_request(request).await.map_err(message)?;
    match answer.status().is_success() {
        true => Ok(()),
        false => Err(format!("it answers {}", answer.status())),
    }
}

#[cfg(unix)]
async fn connect(path: &Path) -> io::Result<Stream> {
    Ok(Box::new(UnixStream::connect(path).await?))
}

#[cfg(not(unix))]
async fn connect(_: &Path) -> io::Result<Stream> {
    Err(io::ErrorKind::Unsupported.into())
}

async fn encrypted(stream: Stream) -> io::Result<Stream> {
    let provider = Arc::new(ring::default_provider());
    let config = ClientConfig::builder_with_provider(Arc::clone(&provider));
    let config = config.with_safe_default_protocol_versions();
    let verifier = Arc::new(AnyCertificate(provider));
    let config = config.map_err(io::Error::other)?.dangerous();
    let config = config.with_custom_certificate_verifier(verifier);
    let connector = TlsConnector::from(Arc::new(config.with_no_client_auth()));
    let name = ServerName::try_from("localhost").map_err(io::Error::other)?;
    Ok(Box::new(connector.connect(name, stream).await?))
}

/// Accepts any certificate, as the probe sends no secrets. The server's certificate is for its public name.
#[derive(Debug)]
struct AnyCertificate(Arc<CryptoProvider>);

impl ServerCertVerifier for AnyCertificate {
    fn verify_server_cert(
        &self,
        _: &CertificateDer<'_>,
        _: &[CertificateDer<'_>],
        _: &ServerName<'_>,
        _: &[u8],
        _: UnixTime,
    ) -> Result<ServerCertVerified, Error> {
        Ok(ServerCertVerified::assertion())
    }

    fn verify_tls12_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signed: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        let algorithms = &self.0.signature_verification_algorithms;
        verify_tls12_signature(message, certificate, signed, algorithms)
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signed: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        let algorithms = &self.0.signature_verification_algorithms;
        verify_tls13_signature(message, certificate, signed, algorithms)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        self.0.signature_verification_algorithms.supported_schemes()
    }
}
