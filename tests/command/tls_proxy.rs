//! A proxy in front of a server: with TLS if there is a certificate, and with connections that break.

use std::collections::VecDeque;
use std::net::TcpListener;
use std::sync::{Arc, Mutex};
use std::thread;

use rcgen::{
    BasicConstraints, Certificate, CertificateParams, CertifiedIssuer, DnType, IsCa, KeyPair,
};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, split};
use tokio::net::TcpStream;
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::ServerConfig;
use tokio_rustls::rustls::pki_types::PrivateKeyDer;

/// Says how many of the bytes that a connection has answered are passed on, if it breaks there.
pub type Break = fn(&[u8]) -> Option<usize>;

/// What has gone through a proxy.
#[derive(Default)]
pub struct Seen {
    pub asked: Vec<u8>,
    pub answered: Vec<u8>,
}

pub struct TlsProxy {
    /// Its address.
    pub url: String,
    /// The authority that has signed its certificate, as PEM.
    pub authority: String,
    seen: Arc<Mutex<Seen>>,
}

impl TlsProxy {
    /// A proxy with TLS, whose certificate is for this name, to the server at a URL.
    pub fn with_certificate_for(name: &str, server: &str) -> Self {
        let (authority, config) = certificate_for(name);
        let mut proxy = Self::open(Some(config), server, &[]);
        proxy.authority = authority;
        proxy
    }

    /// One whose certificate is that of the authority itself.
    pub fn with_authority(server: &str) -> Self {
        let issuer = authority_of("127.0.0.1");
        let mut proxy = Self::open(Some(serving(issuer.as_ref(), issuer.key())), server, &[]);
        proxy.authority = issuer.pem();
        proxy
    }

    /// One with TLS whose connections break so, one after the other.
    pub fn that_breaks(server: &str, breaks: &[Break]) -> Self {
        let (authority, config) = certificate_for("127.0.0.1");
        let mut proxy = Self::open(Some(config), server, breaks);
        proxy.authority = authority;
        proxy
    }

    /// One without TLS.
    pub fn plain_that_breaks(server: &str, breaks: &[Break]) -> Self {
        Self::open(None, server, breaks)
    }

    /// What has been asked and answered, as text.
    pub fn seen(&self) -> (String, String) {
        let seen = self.seen.lock().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (text(&seen.asked), text(&seen.answered))
    }

    fn open(config: Option<ServerConfig>, server: &str, breaks: &[Break]) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let scheme = if config.is_some() { "https" } else { "http" };
        let url = format!("{scheme}://{}", listener.local_addr().unwrap());
        let behind = server.strip_prefix("http://").unwrap().to_owned();
        let seen = Arc::<Mutex<Seen>>::default();
        let (notes, mut breaks) = (Arc::clone(&seen), VecDeque::from(breaks.to_vec()));
        let acceptor = config.map(|config| TlsAcceptor::from(Arc::new(config)));
        let serve = async move {
            listener.set_nonblocking(true).unwrap();
            let listener = tokio::net::TcpListener::from_std(listener).unwrap();
            while let Ok((client, _)) = listener.accept().await {
                let server = TcpStream::connect(&behind).await.unwrap();
                let (notes, end) = (Arc::clone(&notes), breaks.pop_front());
                match &acceptor {
                    None => drop(tokio::spawn(pass(client, server, notes, end))),
                    Some(acceptor) => {
                        // Clients that do not trust the certificate end the handshake.
                        if let Ok(client) = acceptor.accept(client).await {
                            tokio::spawn(pass(client, server, notes, end));
                        }
                    }
                }
            }
        };
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .unwrap();
        thread::spawn(move || runtime.block_on(serve));
        Self {
            url,
            authority: String::new(),
            seen,
        }
    }
}

/// Passes everything on, both ways, until one side ends or the connection is to break.
async fn pass<C: AsyncRead + AsyncWrite>(
    client: C,
    server: TcpStream,
    seen: Arc<Mutex<Seen>>,
    end: Option<Break>,
) {
    let (mut from_client, mut to_client) = split(client);
    let (mut from_server, mut to_server) = split(server);
    let there = async {
        let mut bytes = [0; 4096];
        while let Ok(count @ 1..) = from_client.read(&mut bytes).await {
            seen.lock().unwrap().asked.extend(&bytes[..count]);
            to_server.write_all(&bytes[..count]).await.unwrap();
        }
    };
    let back = async {
        let (mut bytes, mut all, mut sent) = ([0; 4096], Vec::new(), 0);
        while let Ok(count @ 1..) = from_server.read(&mut bytes).await {
            all.extend(&bytes[..count]);
            let last = end.and_then(|end| end(&all));
            let passed = &all[sent..last.unwrap_or(all.len())];
            seen.lock().unwrap().answered.extend(passed);
            if to_client.write_all(passed).await.is_err() || to_client.flush().await.is_err() {
                return;
            }
            sent = all.len();
            if last.is_some() {
                return;
            }
        }
    };
    // Both sides are closed as soon as one has ended.
    tokio::select! {
        () = there => {}
        () = back => {}
    }
}

/// An authority, and a server's certificate that it has signed for this name.
fn certificate_for(name: &str) -> (String, ServerConfig) {
    let issuer = authority_of(name);
    let (pem, key) = (issuer.pem(), KeyPair::generate().unwrap());
    let certificate = CertificateParams::new([name.to_owned()]).unwrap();
    let certificate = certificate.signed_by(&key, &issuer).unwrap();
    (pem, serving(&certificate, &key))
}

/// An authority that can sign, and could be a server of this name.
fn authority_of(name: &str) -> CertifiedIssuer<'static, KeyPair> {
    let mut params = CertificateParams::new([name.to_owned()]).unwrap();
    params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
    let called = format!("the authority of {name}");
    params.distinguished_name.push(DnType::CommonName, called);
    CertifiedIssuer::self_signed(params, KeyPair::generate().unwrap()).unwrap()
}

/// A server with this certificate.
fn serving(certificate: &Certificate, key: &KeyPair) -> ServerConfig {
    let key = PrivateKeyDer::try_from(key.serialize_der()).unwrap();
    let config = ServerConfig::builder().with_no_client_auth();
    let config = config.with_single_cert(vec![certificate.der().clone()], key);
    config.unwrap()
}
