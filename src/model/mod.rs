//! What clients ask for: its JSON is what serde makes of these types, and protobuf messages are read into
//! them.
//!
//! - [`job`]: a job, with its [`shape`] ([`points`], [`basis`], [`ends`], [`scattered`] points), its [`weights`], its
//!   [`method`] with [`settings`], and when it ends ([`stop`]); [`edit`]: changes of one, from an [`iteration`];
//! - [`stream`]: what the event streams of a job are like;
//! - [`mistakes`]: all that is wrong with a request, each at a part of the model; `mathematics`: what is
//!   wrong with the fitting problem;
//! - [`either`]: readers of what has several forms; [`per_direction`]: one value for both directions of a surface, or
//!   one for each; [`lists`]: numbers in lists; [`named`]: enumerations whose values have names; [`short`]:
//!   texts of clients, cut;
//! - [`schema`], [`numbers`]: schemas that are not derived.

pub mod basis;
pub mod edit;
pub mod either;
pub mod ends;
pub mod iteration;
pub mod job;
pub mod lists;
mod mathematics;
pub mod method;
pub mod mistakes;
pub mod named;
pub mod numbers;
pub mod per_direction;
pub mod points;
pub mod scattered;
pub mod schema;
pub mod settings;
pub mod shape;
pub mod short;
pub mod stop;
pub mod stream;
pub mod weights;
