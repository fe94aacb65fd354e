//! The geometry of one level, shared by all readers.

use std::sync::Arc;

use super::content::Content;
use super::deltas::Step;
use super::encoding_cache::EncodingCache;
use super::memory::{Cache, Charge};
use super::store::StoreError;
use piad_fit::data::Points;
use piad_fit::engine::{Geometry, Iteration, Level, Problem};

/// One level of a fit.
#[derive(Debug)]
pub(crate) struct Frame {
    /// The level and its errors.
    pub level: Level,
    /// The setup of the fit, with the bases of this level.
    pub problem: Arc<Problem>,
    /// The level from which on the bases are what they are at this one.
    pub knots_since: usize,
    /// The free control points.
    pub control_points: Arc<Points>,
    /// The indices of those that have moved since the level before; `None` if all may have.
    pub moved: Option<Arc<[usize]>>,
    /// The fit has ended at this level.
    pub is_last: bool,
    encoded: EncodingCache,
    steps: EncodingCache<Option<Step>>,
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
            knots_since: iteration.knots_since(),
            moved: iteration.moved().map(Arc::from),
            is_last: iteration.outcome().is_some(),
            _charge: Some(cache.charge(bytes)),
            ..Self::last(iteration.level(), Arc::clone(iteration.problem()), points)
        }
    }

    /// The last level of a fit, with control points that are not counted in the cache.
    pub(crate) fn last(level: Level, problem: Arc<Problem>, control_points: Arc<Points>) -> Self {
        let known = !problem.is_automatic();
        Self {
            level,
            problem,
            // Where it is unknown it is repeated.
            knots_since: if known { 0 } else { level.iteration },
            control_points,
            moved: None,
            is_last: true,
            encoded: EncodingCache::default(),
            steps: EncodingCache::default(),
            _charge: None,
        }
    }

    /// The same level, where control points that differ from another fit with these bases count as moved; all of them,
    /// if the other one has other control points.
    pub(crate) fn since(&self, before: &Self) -> Self {
        let old = Geometry::new(&before.problem, &before.control_points);
        let new = Geometry::new(&self.problem, &self.control_points);
        Self {
            knots_since: self.knots_since,
            moved: new.differences(&old).map(Arc::from),
            is_last: self.is_last,
            ..Self::last(
                self.level,
                Arc::clone(&self.problem),
                Arc::clone(&self.control_points),
            )
        }
    }

    /// Bytes of memory for a frame of `count` points.
    pub(super) fn weight(dimension: usize, count: usize) -> usize {
        dimension * count * Self::BYTES_PER_NUMBER + size_of::<Self>()
    }

    /// The frame in one of its forms, made by its first reader and shared with the others.
    pub(crate) async fn encoded<
        F: Future<Output = Result<Content, StoreError>> + Send + 'static,
    >(
        &self,
        form: &Arc<str>,
        cache: &Arc<Cache>,
        encode: impl FnOnce() -> F,
    ) -> Result<Content, StoreError> {
        self.encoded.get(form, cache, encode).await
    }

    /// The step to the frame for readers with this key, which have the same numbers; `None` if they are too far away.
    pub(crate) async fn step<
        F: Future<Output = Result<Option<Step>, StoreError>> + Send + 'static,
    >(
        &self,
        readers: &Arc<str>,
        cache: &Arc<Cache>,
        make: impl FnOnce() -> F,
    ) -> Result<Option<Step>, StoreError> {
        self.steps.get(readers, cache, make).await
    }
}
