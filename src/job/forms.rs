//! Things on the wire: each is made once in each form, and shared by all who want it.

use std::collections::VecDeque;
use std::sync::Arc;

use futures_util::FutureExt;
use futures_util::future::{BoxFuture, Shared};
use parking_lot::Mutex;

use super::content::Content;
use super::memory::Cache;
use super::store::StoreError;

/// So many forms are kept of a thing: clients ask for as many as there are numbers of samples.
const MOST: usize = 4;

/// What was made of something, by the name of the form; the oldest first.
#[derive(Debug, Default)]
pub struct Forms(Mutex<VecDeque<(Arc<str>, State)>>);

type Made = Result<Content, StoreError>;

/// A content that was made, or is being made by a task of its own: a reader that nobody asks for more,
/// as its client does not take what there is, holds up no other one.
#[derive(Clone, Debug)]
enum State {
    Made(Content),
    Making(Shared<BoxFuture<'static, Made>>),
}

impl Forms {
    /// The content in this form: what was made before, or what `encode` makes now. It is kept while
    /// there is room in the cache.
    pub async fn get<F: Future<Output = Made> + Send + 'static>(
        &self,
        form: &Arc<str>,
        cache: &Arc<Cache>,
        encode: impl FnOnce() -> F,
    ) -> Made {
        let (content, making) = match self.begin(form, cache, encode)? {
            State::Made(content) => (Ok(content), false),
            State::Making(making) => (making.await, true),
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
    ) -> Result<State, StoreError> {
        let mut forms = self.0.lock();
        if let Some((_, known)) = forms.iter().find(|(name, _)| name == form) {
            return Ok(known.clone());
        }
        let charged = Arc::clone(cache);
        let mut encoding = Box::pin(encode().map(move |made| Ok(made?.kept_in(&charged))));
        // What is little is made at once.
        let state = match encoding.as_mut().now_or_never() {
            Some(made) => State::Made(made?),
            None => {
                let task = tokio::spawn(encoding);
                let broken = |_| Err(StoreError::Failed("an encoding broke down".to_owned()));
                let made = task.map(move |made| made.unwrap_or_else(broken));
                State::Making(made.boxed().shared())
            }
        };
        if forms.len() == MOST {
            forms.pop_front();
        }
        forms.push_back((Arc::clone(form), state.clone()));
        Ok(state)
    }
}
