//! Listeners, and their connections.

use std::fmt;
use std::io;
use std::net::{IpAddr, Ipv4Addr};
use std::task::{Context, Poll, ready};

use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpListener;
#[cfg(unix)]
pub use unix_socket::UnixSocket;

/// A port or a socket on which clients connect.
#[derive(Debug)]
pub enum Listener {
    /// A port.
    Tcp(TcpListener),
    /// A Unix domain socket.
    #[cfg(unix)]
    Unix(UnixSocket),
}

/// A connection of any transport.
pub(super) type Stream = Box<dyn Duplex>;

/// A stream to read and write.
pub(super) trait Duplex: AsyncRead + AsyncWrite + Send + Unpin {}

impl<S: AsyncRead + AsyncWrite + Send + Unpin> Duplex for S {}

/// A new connection.
pub(super) struct Incoming {
    pub(super) stream: Stream,
    /// The other end. Clients of a Unix domain socket are on this machine.
    pub(super) address: IpAddr,
    /// True if it crosses the network: it uses TLS, if there is any.
    pub(super) is_network: bool,
}

impl From<TcpListener> for Listener {
    fn from(listener: TcpListener) -> Self {
        Self::Tcp(listener)
    }
}

impl Listener {
    /// Returns true if only programs of this machine reach it.
    pub(super) fn is_local(&self) -> io::Result<bool> {
        match self {
            Self::Tcp(listener) => Ok(listener.local_addr()?.ip().to_canonical().is_loopback()),
            #[cfg(unix)]
            Self::Unix(_) => Ok(true),
        }
    }

    /// Returns true if its connections use TLS.
    pub(super) fn is_network(&self) -> bool {
        matches!(self, Self::Tcp(_))
    }

    /// The next connection.
    pub(super) fn poll_accept(&self, context: &mut Context<'_>) -> Poll<io::Result<Incoming>> {
        let is_network = self.is_network();
        let (stream, address): (Stream, _) = match self {
            Self::Tcp(listener) => {
                let (stream, address) = ready!(listener.poll_accept(context))?;
                // Events are small and must leave at once. A client that has gone is noticed soon enough.
                let _ = stream.set_nodelay(true);
                (Box::new(stream), address.ip())
            }
            #[cfg(unix)]
            Self::Unix(socket) => {
                let stream = ready!(socket.poll_accept(context))?;
                (Box::new(stream), Ipv4Addr::LOCALHOST.into())
            }
        };
        Poll::Ready(Ok(Incoming {
            stream,
            address,
            is_network,
        }))
    }
}

impl fmt::Display for Listener {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp(listener) => match listener.local_addr() {
                Ok(address) => write!(f, "{address}"),
                Err(reason) => write!(f, "{reason}"),
            },
            #[cfg(unix)]
            Self::Unix(socket) => write!(f, "unix:{}", socket.path().display()),
        }
    }
}

#[cfg(unix)]
mod unix_socket {
    use std::fs;
    use std::io;
    use std::os::unix::fs::{DirBuilderExt, FileTypeExt};
    use std::os::unix::net::UnixStream as Connection;
    use std::path::{Path, PathBuf};
    use std::task::{Context, Poll, ready};

    use tokio::net::{UnixListener, UnixStream};

    /// A Unix domain socket, whose file is removed at its end.
    #[derive(Debug)]
    pub struct UnixSocket {
        listener: UnixListener,
        path: PathBuf,
        _made: Made,
    }

    /// The directory of a socket if it was made for it, which is removed at its end.
    #[derive(Debug)]
    struct Made(Option<PathBuf>);

    impl Drop for Made {
        fn drop(&mut self) {
            if let Some(directory) = &self.0 {
                // Something else may be in it.
                let _ = fs::remove_dir(directory);
            }
        }
    }

    impl UnixSocket {
        /// Listens there. The file of a killed server is replaced; other files are not. A directory that is missing
        /// is made for this user alone, and removed at the end.
        pub(in crate::server) fn bind(path: &Path) -> io::Result<Self> {
            let path = path.to_owned();
            let made = Made(make_directory(&path)?);
            let listener = match UnixListener::bind(&path) {
                Err(reason) if reason.kind() == io::ErrorKind::AddrInUse && is_left(&path) => {
                    fs::remove_file(&path)?;
                    UnixListener::bind(&path)?
                }
                bound => bound?,
            };
            Ok(Self {
                listener,
                path,
                _made: made,
            })
        }

        pub(super) fn path(&self) -> &Path {
            &self.path
        }

        pub(super) fn poll_accept(
            &self,
            context: &mut Context<'_>,
        ) -> Poll<io::Result<UnixStream>> {
            let (stream, _) = ready!(self.listener.poll_accept(context))?;
            Poll::Ready(Ok(stream))
        }
    }

    impl Drop for UnixSocket {
        fn drop(&mut self) {
            // Another process may have removed it already.
            let _ = fs::remove_file(&self.path);
        }
    }

    /// Makes the directory of a file, not those above it, and returns its path if it was missing.
    fn make_directory(path: &Path) -> io::Result<Option<PathBuf>> {
        let directory = path.parent().filter(|it| !it.as_os_str().is_empty());
        let Some(directory) = directory.filter(|it| !it.exists()) else {
            return Ok(None);
        };
        fs::DirBuilder::new().mode(0o700).create(directory)?;
        Ok(Some(directory.to_owned()))
    }

    /// Returns true if this is a socket without a listener.
    fn is_left(path: &Path) -> bool {
        let is_socket = fs::symlink_metadata(path).is_ok_and(|it| it.file_type().is_socket());
        is_socket
            && Connection::connect(path)
                .is_err_and(|reason| reason.kind() == io::ErrorKind::ConnectionRefused)
    }
}
