//! Encoded forms of a frame or a job: each form is made once and shared by all readers.

use std::collections::VecDeque;
use std::sync::Arc;

use futures_util::FutureExt;
use futures_util::future::{BoxFuture, Shared};
use parking_lot::Mutex;

use super::content::Content;
use super::memory::Cache;
use super::peer;
use super::store::StoreError;

/// How many forms are kept at most. Clients could ask for a form for each number of samples.
const MOST: usize = 4;

/// The forms that were made, by name; the oldest first.
#[derive(Debug, Default)]
pub struct Forms(Mutex<VecDeque<(Arc<str>, FormState)>>);

type Made = Result<Content, StoreError>;

/// A content that was made, or is being made by a task of its own: so a reader that is not polled, as
/// its client takes nothing, does not hold up the others.
#[derive(Clone, Debug)]
enum FormState {
    Made(Content),
    Making(Shared<BoxFuture<'static, Made>>),
}

impl Forms {
    /// The content in this form, which `encode` makes if nobody has before. It is kept while there is
    /// room in the cache.
    pub async fn get<F: Future<Output = Made> + Send + 'static>(
        &self,
        form: &Arc<str>,
        cache: &Arc<Cache>,
        encode: impl FnOnce() -> F,
    ) -> Made {
        let (content, making) = match self.begin(form, cache, encode)? {
            FormState::Made(content) => (Ok(content), false),
            FormState::Making(making) => (making.await, true),
        };
        if cache.is_full() || (making && content.is_err()) {
            self.0.lock().retain(|(name, _)| name != form);
        }
        content
    }

    fn begin<F: Future<Output = Made> + Send + 'static>(
        &self,
        form: &Arc<str>,
        cache: &Arc<Cache>,
        encode: impl FnOnce() -> F,
    ) -> Result<FormState, StoreError> {
        let mut forms = self.0.lock();
        if let Some((_, known)) = forms.iter().find(|(name, _)| name == form) {
            return Ok(known.clone());
        }
        let charged = Arc::clone(cache);
        let mut encoding = Box::pin(encode().map(move |made| Ok(made?.kept_in(&charged))));
        // Small contents are complete after one poll.
        let state = match encoding.as_mut().now_or_never() {
            Some(made) => FormState::Made(made?),
            None => {
                let task = peer::spawn(encoding);
                let broken = |_| Err(StoreError::Failed("an encoding broke down".to_owned()));
                let made = task.map(move |made| made.unwrap_or_else(broken));
                FormState::Making(made.boxed().shared())
            }
        };
        if forms.len() == MOST {
            forms.pop_front();
        }
        forms.push_back((Arc::clone(form), state.clone()));
        Ok(state)
    }
}
