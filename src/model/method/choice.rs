//! A method with the points that it selects, as a fit has them.

use std::sync::Arc;

use piad_fit::method::Method;

/// A method, and the points that it selects.
#[derive(Clone, Debug)]
pub(crate) struct MethodChoice {
    /// The method with its settings.
    pub method: Method,
    /// Local fits: the indices of the points that are adjusted, if not all.
    pub selected: Option<Arc<[usize]>>,
}

impl From<Method> for MethodChoice {
    fn from(method: Method) -> Self {
        let selected = None;
        Self { method, selected }
    }
}
