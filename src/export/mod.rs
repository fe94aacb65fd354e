//! Fitted curves and surfaces as files: for CAD systems, viewers, people and spreadsheets.
//!
//! - [`format`](mod@format): the formats and their names; [`error`]: why something cannot be written;
//! - [`nurbs`]: the curve or surface as CAD kernels store it;
//!   `ball`: how polynomials of the Ball bases get there.

mod ball;
pub mod error;
pub mod format;
pub mod nurbs;

pub use error::ExportError;
pub use format::{Format, UnknownFormat};
pub use nurbs::Nurbs;
