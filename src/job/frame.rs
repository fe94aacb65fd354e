//! The geometry of one level, shared by everyone who reads it.

use std::sync::Arc;

use super::content::Content;
use super::forms::Forms;
use super::memory::{Cache, Charge};
use super::store::StoreError;
use crate::fit::iteration::{Iteration, Level};
use crate::fit::points::Points;

/// One level of a fit.
#[derive(Debug)]
pub struct Frame {
    /// The level and its errors.
    pub level: Level,
    /// The free control points.
    pub control_points: Arc<Points>,
    /// Those that have moved since the level before; `None` if all may have.
    pub moved: Option<Arc<[usize]>>,
    /// The fit has ended at this level.
    pub is_last: bool,
    /// What was made of it.
    encoded: Forms,
    /// What it takes while it is kept.
    _charge: Option<Charge>,
}

impl Frame {
    /// Bytes that a number of a frame takes: itself, and its decimal digits once somebody reads it.
    const BYTES_PER_NUMBER: usize = 8 + 28;

    /// The current level of a fit, which is kept in the cache.
    pub(super) fn of(iteration: &Iteration, cache: &Arc<Cache>) -> Self {
        let points = iteration.shared_control_points();
        let bytes = 8 * points.len() * points.dimension() + size_of::<Self>();
        Self {
            moved: iteration.moved().map(Arc::from),
            is_last: iteration.outcome().is_some(),
            _charge: Some(cache.charge(bytes)),
            ..Self::last(iteration.level(), points)
        }
    }

    /// The level at which a fit has ended, with control points that may be kept elsewhere.
    pub fn last(level: Level, control_points: Arc<Points>) -> Self {
        Self {
            level,
            control_points,
            moved: None,
            is_last: true,
            encoded: Forms::default(),
            _charge: None,
        }
    }

    /// Bytes that a frame of `count` points takes in memory.
    pub(super) fn weight(dimension: usize, count: usize) -> usize {
        dimension * count * Self::BYTES_PER_NUMBER + size_of::<Self>()
    }

    /// The frame in a form on the wire: made by its first reader and shared by the others.
    pub async fn encoded<F: Future<Output = Result<Content, StoreError>> + Send + 'static>(
        &self,
        form: &Arc<str>,
        cache: &Arc<Cache>,
        encode: impl FnOnce() -> F,
    ) -> Result<Content, StoreError> {
        self.encoded.get(form, cache, encode).await
    }
}
