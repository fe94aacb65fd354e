//! The HTTP resources.
//!
//! - [`router`]: the resources and their addresses;
//! - [`create`]: posting jobs and edits; [`jobs`]: list, get, cancel, delete; [`events`]: streams;
//! - [`fit`]: one request, one answer, and nothing is kept;
//! - [`geometry`]: inputs, single iterations and results; [`export`]: as files; [`file_name`]: what these are called;
//! - [`points`]: files of points as bodies;
//! - [`capabilities`]: what the server can do; [`info`]: what it is, health, metrics, the catalogue of problems; [`measure`]: how long requests take; [`trace`]: their spans;
//! - [`page`]: the page for people; [`assets`]: files for browsers that are part of the program;
//! - [`path`]: the names in a path; [`query`]: the query of streams, iterations and results; [`negotiate`]: `Accept`, `Prefer` and the other headers that choose an answer;
//! - [`body`]: a request body by its media type; [`body_limits`]: how it arrives, with limits of size, memory and time; [`unpacking`]: what comes compressed;
//! - [`answer`]: answers, small and large; [`render`]: problems as answers; [`newline`]: how JSON ends; [`compression`]: what goes compressed; [`coding`]: how bodies are;
//! - [`cors`]: what browsers let pages of other origins do; [`host`]: for whom a request is meant;
//!   [`request_id`]: what it is called; [`overload`]: what is answered on connections beyond the limits.

mod answer;
pub(crate) mod assets;
mod base_path;
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
mod overload;
mod page;
pub(crate) mod path;
mod points;
mod query;
mod rates;
mod render;
mod request_id;
pub(crate) mod router;
mod trace;
mod unpacking;
