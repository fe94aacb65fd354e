//! Floods of frames of HTTP/2, with TLS and without: they use bounded memory, and do not delay others.

use std::sync::Arc;
use std::time::Duration;

use rustls::pki_types::ServerName;
use tokio::io::{AsyncRead, AsyncWrite, AsyncWriteExt, sink};
use tokio::net::TcpStream;
use tokio::time::timeout;
use tokio_rustls::TlsConnector;

use crate::program::Program;
use crate::secure::{Authority, Secure, trusting};

const PREFACE: &[u8] = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";

/// RFC 9113, 6: kinds of frames.
const DATA: u8 = 0;
const HEADERS: u8 = 1;
const PRIORITY: u8 = 2;
const RST_STREAM: u8 = 3;
const SETTINGS: u8 = 4;
const PING: u8 = 6;
const CONTINUATION: u8 = 9;

const END_STREAM: u8 = 1;
const END_HEADERS: u8 = 4;

/// The maximum number of bytes, sent in rounds of this number of frames.
const MAX_BYTES: usize = 50_000_000;
const FRAMES: u32 = 200;

/// A server that takes nothing for so long holds back.
const PATIENCE: Duration = Duration::from_secs(2);

/// What a flood may take of the memory of a server, in bytes.
const BOUND: usize = 60_000_000;

/// A flood: whether the answers are read, whether the server must end it, and the frames of a round.
struct Flood {
    name: &'static str,
    reads: bool,
    must_end: bool,
    first: Vec<u8>,
    round: fn(u32) -> Vec<u8>,
}

fn frame(kind: u8, flags: u8, stream: u32, payload: &[u8]) -> Vec<u8> {
    let length = (payload.len() as u32).to_be_bytes();
    let mut frame = length[1..].to_vec();
    frame.extend([kind, flags]);
    frame.extend(stream.to_be_bytes());
    frame.extend(payload);
    frame
}

/// The head of a request for /livez or of one with a body, by the tables of RFC 7541.
fn head(method: u8) -> Vec<u8> {
    let mut block = vec![method, 0x86, 0x04, 6];
    block.extend(b"/livez");
    block.extend([0x41, 9]);
    block.extend(b"localhost");
    block
}

const GET: u8 = 0x82;
const POST: u8 = 0x83;

/// Stream `index` of a client.
fn stream(index: u32) -> u32 {
    2 * index + 1
}

fn floods() -> Vec<Flood> {
    let flood = |name, reads, must_end, first, round| Flood {
        name,
        reads,
        must_end,
        first,
        round,
    };
    let nothing = Vec::new;
    vec![
        // CVE-2023-44487.
        flood("rapid reset", true, true, nothing(), |round| {
            let frames = round * FRAMES..(round + 1) * FRAMES;
            let frames = frames.map(|index| {
                let open = frame(HEADERS, END_STREAM | END_HEADERS, stream(index), &head(GET));
                [open, frame(RST_STREAM, 0, stream(index), &[0, 0, 0, 8])].concat()
            });
            frames.collect::<Vec<_>>().concat()
        }),
        // CVE-2024-27316 and its kin.
        flood(
            "continuation",
            true,
            true,
            frame(HEADERS, END_STREAM, 1, &head(GET)),
            |_| {
                // A field that is never used again: name and value as they are.
                let field = [&[0, 1, b'x', 125][..], &[b'y'; 125]].concat();
                let fields = field.repeat(120);
                frame(CONTINUATION, 0, 1, &fields).repeat(FRAMES as usize / 50)
            },
        ),
        flood("pings", false, false, nothing(), |_| {
            frame(PING, 0, 0, &[7; 8]).repeat(FRAMES as usize)
        }),
        flood("settings", false, false, nothing(), |_| {
            frame(SETTINGS, 0, 0, &[0, 4, 0, 0, 0xff, 0xff]).repeat(FRAMES as usize)
        }),
        flood("priorities", true, false, nothing(), |round| {
            let frames = round * FRAMES..(round + 1) * FRAMES;
            let frames = frames.map(|index| frame(PRIORITY, 0, stream(index), &[0, 0, 0, 0, 9]));
            frames.collect::<Vec<_>>().concat()
        }),
        flood(
            "empty data",
            true,
            false,
            frame(HEADERS, END_HEADERS, 1, &head(POST)),
            |_| frame(DATA, 0, 1, &[]).repeat(FRAMES as usize),
        ),
    ]
}

/// What has become of a flood.
#[derive(Debug, PartialEq, Eq)]
enum Outcome {
    /// The server has ended the connection.
    Ended,
    /// It takes no more for now.
    HeldBack,
    /// It has taken all of it.
    Taken,
}

async fn send<T: AsyncRead + AsyncWrite + Send + 'static>(stream: T, flood: &Flood) -> Outcome {
    let (mut reading, mut writing) = tokio::io::split(stream);
    let reads = flood.reads;
    let reader = tokio::spawn(async move {
        match reads {
            true => drop(tokio::io::copy(&mut reading, &mut sink()).await),
            false => std::future::pending().await,
        }
    });
    let first = [PREFACE, &frame(SETTINGS, 0, 0, &[]), &flood.first].concat();
    let mut bytes = first;
    let (mut sent, mut round) = (0, 0);
    let outcome = loop {
        match timeout(PATIENCE, writing.write_all(&bytes)).await {
            Err(_) => break Outcome::HeldBack,
            Ok(Err(_)) => break Outcome::Ended,
            Ok(Ok(())) => {}
        }
        sent += bytes.len();
        if sent > MAX_BYTES {
            break Outcome::Taken;
        }
        bytes = (flood.round)(round);
        round += 1;
    };
    reader.abort();
    outcome
}

/// Sends a flood over one connection, while another client asks again and again.
async fn sent<T, F>(server: &Program, flood: &Flood, stream: T, ask: impl Fn() -> F)
where
    T: AsyncRead + AsyncWrite + Send + 'static,
    F: Future<Output = ()>,
{
    let before = server.memory();
    server.forget_most_memory();
    let sending = send(stream, flood);
    tokio::pin!(sending);
    let outcome = loop {
        tokio::select! {
            outcome = &mut sending => break outcome,
            () = ask() => {}
        }
    };
    ask().await;
    let grown = server.most_memory().saturating_sub(before);
    assert!(grown < BOUND, "{}: {outcome:?}, {grown} bytes", flood.name);
    if flood.must_end {
        assert_eq!(outcome, Outcome::Ended, "{}", flood.name);
    }
}

#[tokio::test]
async fn floods_without_tls_are_bounded() {
    let folder = tempfile::tempdir().unwrap();
    let server = Program::start(folder.path());
    for flood in floods() {
        let stream = TcpStream::connect(&server.address).await.unwrap();
        let ask = async || {
            let answer = timeout(PATIENCE, server.get("/livez").send()).await;
            assert_eq!(answer.unwrap().unwrap().status(), 200, "{}", flood.name);
        };
        sent(&server, &flood, stream, ask).await;
    }
}

#[tokio::test]
async fn floods_with_tls_are_bounded() {
    let authority = Authority::new();
    let secure = Secure::start(&authority.sign(), &[]);
    let mut config = trusting(&[&authority], None);
    config.alpn_protocols = vec![b"h2".to_vec()];
    let connector = TlsConnector::from(Arc::new(config));
    let client = crate::secure::Client::of(&[&authority]);
    for flood in floods() {
        let stream = TcpStream::connect(&secure.server.address).await.unwrap();
        let name = ServerName::try_from("localhost").unwrap();
        let stream = connector.connect(name, stream).await.unwrap();
        let ask = async || {
            let answer = timeout(PATIENCE, client.get(&secure.url("/livez"))).await;
            assert_eq!(answer.unwrap().status(), 200, "{}", flood.name);
        };
        sent(&secure.server, &flood, stream, ask).await;
    }
}
