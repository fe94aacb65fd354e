//! A method as it is asked for.

use std::sync::Arc;

use crate::fit::method::Method;

/// A method as it is asked for.
#[derive(Clone, Debug)]
pub struct MethodSpec {
    /// The method with its settings.
    pub method: Method,
    /// Local fits: the indices of the points that are adjusted, if not all.
    pub selected: Option<Arc<[usize]>>,
}

impl From<Method> for MethodSpec {
    fn from(method: Method) -> Self {
        let selected = None;
        Self { method, selected }
    }
}
