//! The resources of the API, each of which is described in `api.json`.

use std::collections::BTreeMap;

use axum::Router;
use axum::handler::Handler;
use axum::routing::{MethodRouter, delete, get, post};

use crate::api::app::App;

/// The resources of the API.
#[derive(Default)]
pub(crate) struct Resources {
    router: Router<App>,
    /// The methods of each path.
    methods: BTreeMap<&'static str, Vec<&'static str>>,
}

impl Resources {
    /// Serves GET.
    pub(crate) fn get<H: Handler<T, App>, T: 'static>(
        self,
        path: &'static str,
        handler: H,
    ) -> Self {
        self.add(path, "get", get(handler))
    }

    /// Serves POST.
    pub(crate) fn post<H: Handler<T, App>, T: 'static>(
        self,
        path: &'static str,
        handler: H,
    ) -> Self {
        self.add(path, "post", post(handler))
    }

    /// Serves DELETE.
    pub(crate) fn delete<H: Handler<T, App>, T: 'static>(
        self,
        path: &'static str,
        handler: H,
    ) -> Self {
        self.add(path, "delete", delete(handler))
    }

    fn add(mut self, path: &'static str, verb: &'static str, handler: MethodRouter<App>) -> Self {
        self.router = self.router.route(path, handler);
        self.methods.entry(path).or_default().push(verb);
        self
    }

    /// The routes, and the methods of each path.
    pub(crate) fn parts(self) -> (Router<App>, BTreeMap<&'static str, Vec<&'static str>>) {
        (self.router, self.methods)
    }
}
