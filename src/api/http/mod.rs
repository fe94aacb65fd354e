//! The HTTP resources.
//!
//! - [`router`]: the resources and their addresses;
//! - [`create`]: creating jobs and edits; [`jobs`]: list, get, cancel, delete; [`events`]: streams;
//! - [`fit`]: one request, one answer, and nothing is stored; [`batch`]: the same for many fits;
//! - [`geometry`]: inputs, single iterations and results; [`export`]: as files; [`file_name`]: the names of these;
//! - [`points`]: files of points as bodies;
//! - [`authorize`]: authorization; [`tickets`]: for streams of clients without headers;
//! - [`capabilities`]: capabilities and limits; [`info`]: links, health, metrics, the catalogue of problems;
//!   [`measure`]: durations of requests; [`trace`]: their spans;
//! - [`page`]: the viewer; [`assets`]: files for browsers that are part of the program;
//! - [`path`]: parameters in a path; [`query`]: the query of streams, iterations and results; [`negotiate`]: `Accept`,
//!   `Prefer` and the other headers that choose an answer;
//! - [`body`]: a request body by its media type; [`body_limits`]: its arrival, with limits of size, memory and time;
//!   [`unpacking`]: decompression;
//! - [`answer`]: answers, small and large; [`render`]: problems as answers; [`newline`]: the end of JSON;
//!   [`compression`]: compression of answers; [`coding`]: content codings;
//! - [`cors`]: what browsers let pages of other origins do; [`host`]: checks of the requested host;
//!   [`request_id`]: the ids of requests; [`overload`]: answers on connections beyond the limits.

mod answer;
pub(crate) mod assets;
pub(in crate::api) mod authorize;
mod base_path;
mod batch;
mod body;
pub(crate) mod body_limits;
pub(crate) mod capabilities;
pub(crate) mod coding;
mod compression;
pub(crate) mod cors;
mod create;
pub(crate) mod events;
mod export;
mod file_name;
mod fit;
mod geometry;
pub(crate) mod host;
pub(crate) mod info;
pub(crate) mod jobs;
pub(crate) mod measure;
pub(crate) mod negotiate;
mod newline;
pub(crate) mod overload;
mod page;
pub(crate) mod path;
mod points;
pub(crate) mod query;
mod rates;
mod render;
pub(in crate::api) mod request_id;
pub(crate) mod router;
pub(in crate::api) mod tickets;
mod trace;
pub(in crate::api) mod unpacking;
