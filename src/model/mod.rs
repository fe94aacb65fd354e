//! What clients ask for, typed and without a wire: JSON and protobuf messages are read into this model
//! and written from it.
//!
//! - [`job`]: a job, with its [`shape`] ([`scattered`] points), its [`weights`], its [`method`] and when it ends ([`stop`]); [`edit`]: changes of one;
//! - [`stream`]: what the event streams of a job are like;
//! - [`mistakes`]: all that is wrong with a request, each at a part of the model; `mathematics`: what is
//!   wrong with the fitting problem;
//! - [`either`]: readers of what has several forms; [`named`]: enumerations whose values have names; [`short`]: texts of clients, cut.

pub mod edit;
pub mod either;
pub mod job;
mod mathematics;
pub mod method;
pub mod mistakes;
pub mod named;
pub mod scattered;
pub mod shape;
pub mod short;
pub mod stop;
pub mod stream;
pub mod weights;
