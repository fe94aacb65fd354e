//! Caches the encodings of a frame or a job. Each encoding is computed once and shared by all readers.

use std::collections::VecDeque;
use std::sync::Arc;

use futures_util::FutureExt;
use futures_util::future::{BoxFuture, Shared};
use parking_lot::Mutex;

use super::content::Content;
use super::deltas::Step;
use super::memory::Cache;
use super::peer;
use super::store::StoreError;

/// The most encodings that are kept. Clients could request one for each number of samples.
const MAX_ENCODINGS: usize = 4;

/// The encodings by the names of their forms, the oldest first.
#[derive(Debug)]
pub(crate) struct EncodingCache<T = Content>(Mutex<VecDeque<(Arc<str>, Encoding<T>)>>);

type Made<T> = Result<T, StoreError>;

/// A content that was made, or is being made by a task of its own: so a reader that is not polled, as
/// its client takes nothing, does not hold up the others.
#[derive(Clone, Debug)]
enum Encoding<T> {
    Done(T),
    Pending(Shared<BoxFuture<'static, Made<T>>>),
}

/// Cached contents.
pub(crate) trait Kept: Clone + Send + Sync + 'static {
    /// The same, counted in the cache from now on.
    fn kept_in(self, cache: &Arc<Cache>) -> Self;
}

impl Kept for Content {
    fn kept_in(self, cache: &Arc<Cache>) -> Self {
        Self::kept_in(self, cache)
    }
}

/// The result is also cached for steps that cannot be made.
impl Kept for Option<Step> {
    fn kept_in(self, cache: &Arc<Cache>) -> Self {
        self.map(|step| step.kept_in(cache))
    }
}

impl<T> Default for EncodingCache<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T: Kept> EncodingCache<T> {
    /// The content in this form, made by `encode` if it is not cached. It is kept while there is room in the cache.
    pub(crate) async fn get<F: Future<Output = Made<T>> + Send + 'static>(
        &self,
        form: &Arc<str>,
        cache: &Arc<Cache>,
        encode: impl FnOnce() -> F,
    ) -> Made<T> {
        let (content, pending) = match self.begin(form, cache, encode)? {
            Encoding::Done(content) => (Ok(content), false),
            Encoding::Pending(encoding) => (encoding.await, true),
        };
        if cache.is_full() || (pending && content.is_err()) {
            self.0.lock().retain(|(name, _)| name != form);
        }
        content
    }

    fn begin<F: Future<Output = Made<T>> + Send + 'static>(
        &self,
        form: &Arc<str>,
        cache: &Arc<Cache>,
        encode: impl FnOnce() -> F,
    ) -> Result<Encoding<T>, StoreError> {
        let mut encodings = self.0.lock();
        if let Some((_, known)) = encodings.iter().find(|(name, _)| name == form) {
            return Ok(known.clone());
        }
        let charged = Arc::clone(cache);
        let mut encoding = Box::pin(encode().map(move |made| Ok(made?.kept_in(&charged))));
        // Small contents are complete after one poll.
        let state = match encoding.as_mut().now_or_never() {
            Some(made) => Encoding::Done(made?),
            None => {
                let task = peer::spawn(encoding);
                let broken = |_| Err(StoreError::Failed("an encoding panicked".to_owned()));
                let made = task.map(move |made| made.unwrap_or_else(broken));
                Encoding::Pending(made.boxed().shared())
            }
        };
        if encodings.len() == MAX_ENCODINGS {
            encodings.pop_front();
        }
        encodings.push_back((Arc::clone(form), state.clone()));
        Ok(state)
    }
}
