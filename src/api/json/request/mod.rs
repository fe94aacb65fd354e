//! The JSON of jobs and edits: how it becomes the model.
//!
//! - [`job`]: a job; [`edit`]: changes of another one;
//! - [`shape`]: a curve or a surface; [`basis`]: its basis, knots and parameters; [`ends`]: how it ends;
//! - [`method`]: the method and its [`settings`]; [`iteration`]: the one that an edit starts from; [`stop`]: when the iteration ends;
//! - [`file`]: a job whose points are in a file;
//! - [`places`]: where a part of the model stands;
//! - [`scattered`]: the parameters of a surface, also of scattered points;
//! - `schema`: what is not derived of the schemas.

pub mod basis;
pub mod edit;
pub mod ends;
pub mod file;
pub mod iteration;
pub mod job;
pub mod method;
pub mod path;
pub mod places;
pub(in crate::api) mod scattered;
pub(in crate::api) mod schema;
pub mod settings;
pub mod shape;
pub mod stop;
