//! Requests of clients: serde reads and writes their JSON, and protobuf messages are converted to these types.
//!
//! - [`job`]: a job, with its `shape`, of a `surface` (`points`, `heights`, `basis`, `corners`, `ends`, [`scattered`]
//!   points), its `weights`, its `method` with `settings`, and its end (`stop`); `edit`: changes of one, from an
//!   `iteration`;
//! - `stream`: options of the event streams of a job;
//! - `errors`: all errors of a request, each at a part of the model; `validate_fit`: validation of the fitting
//!   problem;
//! - `serde_helpers`: readers of values with several forms; `per_direction`: one value for both directions of a surface, or
//!   one for each; `lists`: numbers in lists, and `list_limits`: their lengths; `named`: enumerations whose values have
//!   names; `files`: those of choices about files;
//! - `schema`, `numbers`: schemas that are not derived.

pub(crate) mod basis;
pub(crate) mod corners;
pub(crate) mod edit;
pub(crate) mod ends;
pub(crate) mod errors;
mod files;
mod heights;
pub(crate) mod iteration;
pub mod job;
pub(crate) mod list_limits;
pub(crate) mod lists;
pub(crate) mod method;
pub(crate) mod named;
pub(crate) mod numbers;
pub(crate) mod per_direction;
pub(crate) mod points;
pub mod scattered;
pub(crate) mod schema;
pub(crate) mod serde_helpers;
pub(crate) mod settings;
pub(crate) mod shape;
pub(crate) mod stop;
pub(crate) mod stream;
pub(crate) mod surface;
pub(crate) mod trim;
mod validate_fit;
pub(crate) mod weights;
