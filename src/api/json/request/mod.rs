//! The JSON of jobs and edits, and their way to a fitting problem.
//!
//! - [`job`]: a job; [`edit`]: changes of another one;
//! - [`shape`]: a curve or a surface; [`basis`]: its basis, knots and parameters; [`weights`]: its weights;
//! - [`method`]: the method and its [`settings`]; [`iteration`]: the one that an edit starts from; [`stop`]: when the iteration ends;
//! - [`mistakes`]: all that is wrong, as far as one mistake does not follow from another; [`places`]: where
//!   that is; `invalid`: how it is told;
//! - `schema`: what is not derived of the schemas.

pub mod basis;
pub mod edit;
mod invalid;
pub mod iteration;
pub mod job;
pub mod method;
pub mod mistakes;
pub mod places;
pub(in crate::api) mod schema;
pub mod settings;
pub mod shape;
pub mod stop;
pub mod weights;
