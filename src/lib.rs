//! piad fits curves and surfaces to ordered data points by **progressive iterative approximation**
//! (PIA) and streams the geometry of every iteration.
//!
//! The data `P` are the first control points `X`; each iteration moves every control point by the difference between
//! its data point and the curve:
//!
//! ```text
//! Δ = P − B X          residual: the adjusting vectors, one per data point
//! X ← X + U Δ          update: the transform U is the method (U = I is classical PIA)
//! ```
//!
//! `B` is the collocation matrix of the basis at the parameters of the data. For totally positive
//! bases (Bernstein, B-spline) the curves converge to the interpolant.
//!
//! Requests pass down through these modules, frames pass up:
//!
//! - [`config`] — one struct: flags and `PIAD_*` variables;
//! - [`piad_fit`] — the numerics, pure and deterministic, in its own crate: problems, bases, the iteration;
//! - [`piad_files`] — readers of point files and writers of geometry files, in its own crate;
//! - [`model`] — typed requests, independent of the wire format;
//! - `proto` — the protobuf messages in which jobs are sent and stored;
//! - `job` — the life of a fit: states, shared runs, readers, the compute pool, the store;
//! - [`api`] — the wire: requests, event streams, problems (RFC 9457), gRPC;
//! - [`access`] — authorization: tokens, tenants, scopes;
//! - [`server`] — connects the modules: [`server::serve`];
//! - [`command`] — `piad fit`: from a file to files, as a client of a server in the same process;
//! - [`telemetry`] — traces of requests and jobs, for a collector;
//! - [`signals`] — signals of the operating system; `reload` — files that are reloaded when they change; `log_throttle`
//!   — rate limits of log lines;
//! - `files` — reading files with a limit of their size; `toml_text` — reading TOML; `redact` — settings without their
//!   passwords; [`terminal`] — messages for people;
//! - [`trim`] — returns unused memory to the system.

pub mod access;
pub mod api;
pub mod command;
pub mod config;
pub(crate) mod files;
pub(crate) mod job;
pub(crate) mod lines;
pub(crate) mod log_throttle;
pub mod model;
pub(crate) mod proto;
pub(crate) mod redact;
pub(crate) mod reload;
pub mod server;
pub mod signals;
pub mod telemetry;
pub mod terminal;
pub(crate) mod toml_text;
pub mod trim;
