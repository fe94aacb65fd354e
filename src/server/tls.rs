//! TLS for connections from the network, with certificates that are reloaded when they change.

use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parking_lot::Mutex;
use rustls::crypto::ring;
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use rustls::server::{Acceptor, WebPkiClientVerifier};
use rustls::{RootCertStore, ServerConfig};
use tokio::io::{AsyncReadExt, AsyncWriteExt, copy, sink};
use tokio_rustls::LazyConfigAcceptor;

use super::listener::Stream;
use crate::config::TlsFiles;
use crate::reload::{Reload, Seen};

/// The first byte of each TLS connection.
const HANDSHAKE: u8 = 0x16;

/// The number of bytes read of a request without TLS, so that the client gets the answer.
const IGNORED: u64 = 64 << 10;

/// The TLS configuration.
pub(super) struct Tls {
    files: TlsFiles,
    loaded: Mutex<Loaded>,
}

struct Loaded {
    config: Arc<ServerConfig>,
    /// The state of the files then.
    seen: Seen,
}

impl Tls {
    /// Loads the files.
    pub(super) fn load(files: TlsFiles) -> io::Result<Self> {
        let loaded = Mutex::new(Loaded::from(&files).map_err(io::Error::other)?);
        Ok(Self { files, loaded })
    }

    /// Performs the handshake with a client.
    pub(super) async fn accept(&self, mut stream: Stream) -> io::Result<Stream> {
        let mut first = [0];
        stream.read_exact(&mut first).await?;
        if first != [HANDSHAKE] {
            return Err(refuse_plain(stream, first).await);
        }
        let mut acceptor = Acceptor::default();
        acceptor.read_tls(&mut first.as_slice())?;
        let handshake = LazyConfigAcceptor::new(acceptor, stream).await?;
        let config = Arc::clone(&self.loaded.lock().config);
        Ok(Box::new(handshake.into_stream(config).await?))
    }
}

impl Reload for Tls {
    const WHAT: &'static str = "certificates";

    fn load_again(&self, anyway: bool) -> Result<bool, String> {
        let seen = Seen::of(self.files.all());
        if !anyway && self.loaded.lock().seen == seen {
            return Ok(false);
        }
        let loaded = Loaded::from(&self.files);
        let mut current = self.loaded.lock();
        // Errors of files are reported once.
        current.seen = seen;
        *current = loaded?;
        Ok(true)
    }
}

/// Answers plain HTTP on a TLS port with an error.
async fn refuse_plain(mut stream: Stream, first: [u8; 1]) -> io::Error {
    if first[0].is_ascii_uppercase() {
        let body = "This server speaks HTTPS: its address begins with https://\n";
        let answer = format!(
            "HTTP/1.1 400 Bad Request\r\nContent-Type: text/plain\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{body}",
            body.len()
        );
        let sent = stream.write_all(answer.as_bytes()).await;
        if sent.is_ok() && stream.shutdown().await.is_ok() {
            let _ = copy(&mut stream.take(IGNORED), &mut sink()).await;
        }
    }
    io::Error::new(io::ErrorKind::InvalidData, "it does not begin with TLS")
}

impl TlsFiles {
    fn all(&self) -> impl Iterator<Item = &PathBuf> {
        [&self.certificate, &self.key]
            .into_iter()
            .chain(&self.clients)
    }
}

impl Loaded {
    fn from(files: &TlsFiles) -> Result<Self, String> {
        let seen = Seen::of(files.all());
        let provider = Arc::new(ring::default_provider());
        let builder = ServerConfig::builder_with_provider(Arc::clone(&provider));
        let builder = builder.with_safe_default_protocol_versions();
        let builder = builder.map_err(|reason| reason.to_string())?;
        let builder = match &files.clients {
            None => builder.with_no_client_auth(),
            Some(path) => {
                let mut authorities = RootCertStore::empty();
                for authority in certificates("--tls-client-ca", path)? {
                    let added = authorities.add(authority);
                    added.map_err(wrong("--tls-client-ca", path))?;
                }
                let verifier =
                    WebPkiClientVerifier::builder_with_provider(authorities.into(), provider);
                let verifier = verifier.build().map_err(wrong("--tls-client-ca", path))?;
                builder.with_client_cert_verifier(verifier)
            }
        };
        let chain = certificates("--tls-cert", &files.certificate)?;
        let key =
            PrivateKeyDer::from_pem_file(&files.key).map_err(wrong("--tls-key", &files.key))?;
        let config = builder.with_single_cert(chain, key);
        let mut config = config.map_err(wrong("--tls-cert", &files.certificate))?;
        config.alpn_protocols = vec![b"h2".to_vec(), b"http/1.1".to_vec()];
        let config = Arc::new(config);
        Ok(Self { config, seen })
    }
}

/// The certificates in a file, of which there is at least one.
fn certificates(flag: &str, path: &Path) -> Result<Vec<CertificateDer<'static>>, String> {
    let all = CertificateDer::pem_file_iter(path).and_then(Iterator::collect);
    let all: Vec<_> = all.map_err(wrong(flag, path))?;
    match all.is_empty() {
        true => Err(wrong(flag, path)("there is no certificate in it")),
        false => Ok(all),
    }
}

fn wrong<E: Display>(flag: &str, path: &Path) -> impl Fn(E) -> String {
    move |reason| format!("{flag} {path:?}: {reason}")
}
