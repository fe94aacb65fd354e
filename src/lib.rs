//! piad fits curves and surfaces to ordered data points by **progressive iterative approximation**
//! (PIA) and streams the geometry of every iteration.
//!
//! The data `P` are the first control points `X`; then every control point moves by the difference
//! between its data point and the curve, again and again:
//!
//! ```text
//! Δ = P − B X          residual: the adjusting vectors, one per data point
//! X ← X + U Δ          update: the transform U is the method (U = I is classical PIA)
//! ```
//!
//! `B` is the collocation matrix of the basis at the parameters of the data. For totally positive
//! bases (Bernstein, B-spline) the curves converge to the interpolant.
//!
//! A request flows down through the modules, frames flow up:
//!
//! - [`config`] — one struct: flags and `PIAD_*` variables;
//! - [`piad_fit`] — the numerics, pure and deterministic, in a crate of their own: problems, bases, the one loop;
//! - [`piad_files`] — files of points in, files of geometry out, likewise;
//! - [`model`] — what clients ask for, typed and without a wire;
//! - `proto` — the messages of the contract, in which jobs travel and are stored;
//! - `job` — a fit as a thing that lives: states, shared runs, readers, the compute pool, the store;
//! - [`api`] — what goes over the wire: requests, event streams, problems (RFC 9457), gRPC;
//! - [`access`] — who may do what: tokens, tenants, scopes;
//! - [`server`] — binds them together: [`server::serve`];
//! - [`command`] — `piad fit`: from a file to files, as a client of a server inside of the process;
//! - [`telemetry`] — traces of requests and jobs, for a collector;
//! - [`signals`] — of the operating system; `reload` — files that are read again when they change;
//!   `log_throttle` — log lines about what happens often;
//! - `files` — reading files whose size has a limit; `toml_text` — reading TOML; `redact` — settings without their
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
