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
    /// The indices of those that have moved since the level before; `None` if all may have.
    pub moved: Option<Arc<[usize]>>,
    /// The fit has ended at this level.
    pub is_last: bool,
    encoded: Forms,
    /// The bytes of the control points in the cache.
    _charge: Option<Charge>,
}

impl Frame {
    /// Bytes for each coordinate of a frame: the number itself, and its decimal digits once it is read.
    const BYTES_PER_NUMBER: usize = 8 + 28;

    /// The current level of a fit, counted in the cache.
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

    /// The last level of a fit, with control points that are not counted in the cache.
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

    /// Bytes of memory for a frame of `count` points.
    pub(super) fn weight(dimension: usize, count: usize) -> usize {
        dimension * count * Self::BYTES_PER_NUMBER + size_of::<Self>()
    }

    /// The frame in one of its forms, made by its first reader and shared with the others.
    pub async fn encoded<F: Future<Output = Result<Content, StoreError>> + Send + 'static>(
        &self,
        form: &Arc<str>,
        cache: &Arc<Cache>,
        encode: impl FnOnce() -> F,
    ) -> Result<Content, StoreError> {
        self.encoded.get(form, cache, encode).await
    }
}
